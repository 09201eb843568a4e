"""Assemblies on springs: `dem` at the contacts of `assembly`.

Most tests share one batch, hence one kernel: arches, columns of drums and walls, pushed sideways.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest

from tests.engines.test_assembly import assert_same
from tests.shared.assemblies import assembly_lanes, built, oppenheim, pushes
from tests.shared.blocks import make_stacks
from warprock.engines.dem import Dem
from warprock.engines.dem_assembly import springs_of
from warprock.engines.launching import Form, Target
from warprock.model import patterns
from warprock.model.motion import Control, Waveform, harmonic_motions
from warprock.model.response import Response, SampleTimes, Status, take_lanes
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

pytestmark = pytest.mark.usefixtures("two_rooms")

ARCH, DRUMS = oppenheim(7), built(patterns.column(1.0, 0.5, 5), 0.7)
WALL = built(patterns.wall(0.4, 0.175, 2, 3, whole_first=False), 0.3)
LIMITS = np.array([0.3736, 0.3736, 0.4, 0.4, 0.6])
"""Oppenheim's arch; a column tips at its width over its height; the wall slides at its friction."""
LANES = assembly_lanes([ARCH, ARCH, DRUMS, DRUMS, WALL])
END = 2.5


def stiff(stiffness: float, **others: float) -> DemSettings:
    return DemSettings(normal_stiffness=stiffness, shear_stiffness=stiffness, **others)


@functools.cache
def pushed(stiffness: float, below: float, above: float) -> Response:
    motions = pushes(LIMITS * np.array([below, above, below, above, above]), 1.0, END)
    return run_batch("dem", LANES, motions, SampleTimes(END), settings=stiff(stiffness))


@pytest.mark.thorough
def test_collapse_loads_come_to_those_of_rigid_joints_as_springs_stiffen():
    """At 3e9 N/m^3 within 1 %; at 1e8, sinking by millimetres, the arch falls 3 % below."""
    found = pushed(3e9, 0.99, 1.01)
    assert (found["status"] == Status.OK).all()
    stands, falls = found["peak_displacement"][[0, 2]], found["peak_displacement"][[1, 3]]
    assert (stands < 0.01).all()
    assert (falls > 0.1).all()
    soft = pushed(1e8, 0.9, 0.97)["peak_displacement"]
    assert soft[0] < 0.1 < soft[1]


@pytest.mark.thorough
def test_the_account_knows_what_springs_hold():
    """Dashpots and sliders take; what springs give back is what they held."""
    found = pushed(3e9, 0.99, 1.01)
    assert (found["energy_lost"] > 0.0).all()
    assert found["slid_joints"][4] > 0
    # Friction takes its force times the way.
    wall = WALL.mass[~WALL.fixed].sum()
    taken = found["energy_lost"][4] / (0.3 * wall * GRAVITY * found["peak_slide"][4])
    assert 0.3 < taken < 1.1


@pytest.mark.thorough
def test_a_step_beyond_stability_is_told():
    """Twice the longest stable step: springs make energy."""
    motions = pushes(0.5 * LIMITS, 1.0, END)
    found = run_batch(
        "dem", LANES, motions, SampleTimes(0.2), settings=stiff(1e9, step_safety=2.0, time_step=0.1)
    )
    # The wall slides away before it has gained that much.
    assert np.isin(found["status"][:4], [Status.UNSTABLE, Status.NONFINITE]).all()


@pytest.mark.thorough
def test_no_lane_depends_on_its_neighbours_and_each_has_its_own_step():
    motions = pushes(LIMITS * 1.01, 1.0, END)
    engine = Dem(settings=stiff(1e8))
    steps = engine.longest_step(LANES, motions)
    assert len(np.unique(steps)) > 1
    together = engine.run(LANES, motions, SampleTimes(0.5))
    for lane in (0, 4):
        places = np.array([lane])
        alone = engine.run(LANES.take(places), motions.take(places), SampleTimes(0.5))
        assert_same(alone, take_lanes(together, places))


@pytest.mark.thorough
def test_a_lane_whose_blocks_meet_where_no_joint_has_springs_says_so():
    """Of two towers .1 m apart the slender one leans on the other; apart by 2 m it does not."""
    ground = patterns.Piece("ground", patterns.rectangle(-1.0, -0.5, 6.0, 0.0), fixed=True)
    slender = patterns.Piece("slender", patterns.rectangle(0.0, 0.0, 0.5, 2.0))
    kinds = [
        built(
            [ground, slender, patterns.Piece("broad", patterns.rectangle(x, 0.0, x + 2.0, 2.0))],
            0.7,
        )
        for x in (0.6, 2.5)
    ]
    lanes = assembly_lanes([*kinds, ARCH, DRUMS, WALL])
    motions = pushes(np.array([0.3, 0.3, 0.0, 0.0, 0.0]), 1.0, END)
    found = run_batch("dem", lanes, motions, SampleTimes(END), settings=stiff(1e8))
    assert found["status"].tolist() == [Status.OUTSIDE_MODEL, *[Status.OK] * 4]


@pytest.mark.thorough
def test_a_column_stands_on_its_springs_as_statics_says():
    """Drums sink by what stands on each joint over its stiffness, and stay there."""
    settings = stiff(1e9)
    rest = springs_of(DRUMS, settings)
    free = np.flatnonzero(~DRUMS.fixed)
    order = free[np.argsort(DRUMS.centre[free, 1])]
    weight = GRAVITY * DRUMS.mass[order]
    borne = np.cumsum(weight[::-1])[::-1]
    assert rest.shift[order, 1] == pytest.approx(-np.cumsum(borne / 1e9), rel=1e-9)
    assert np.abs(rest.shift[:, [0, 2]]).max() < 1e-15
    still = run_batch(
        "dem", LANES, pushes(0.0 * LIMITS, 1.0, END), SampleTimes(0.5), settings=settings
    )
    assert (still["status"] == Status.OK).all()
    # Blocks that are turned by what they bear are off by the square of that angle.
    assert still["peak_displacement"].max() < 1e-5
    assert still["peak_displacement"][2] < 1e-12


@pytest.mark.thorough
def test_two_drums_are_the_stack_of_dem_on_two_springs_a_face():
    """The same springs by another text: `dem` of stacks, sub-contacts at the ends alone."""
    settings = stiff(1e9, subcontacts=2, time_step=2e-5)
    motions = harmonic_motions(
        Waveform.SINE, [Control.ACCELERATION] * 2, np.array([0.45, 0.6]) * GRAVITY,
        np.full(2, 2.5), np.zeros(2), np.full(2, 0.4),
    )  # fmt: skip
    stack = make_stacks([[0.5, 0.5]] * 2, [[1.0, 1.0]] * 2, friction=0.7)
    column = built(patterns.column(0.5, 1.0, 2), 0.7)
    kind = dataclasses.replace(column, depth=stack.depth[0, 0], density=stack.density[0, 0])
    other = run_batch("dem", stack, motions, SampleTimes(1.0), settings=settings)
    found = run_batch(
        "dem", assembly_lanes([kind] * 2), motions, SampleTimes(1.0), settings=settings
    )
    assert found["peak_rotation"] == pytest.approx(other["peak_rotation"].max(axis=1), rel=1e-3)
    assert found["energy_lost"] == pytest.approx(other["energy_lost"], rel=1e-2)


@pytest.mark.thorough
def test_both_forms_of_the_kernel_give_the_same_bits():
    motions = pushes(LIMITS * 1.01, 0.3, END)
    settings, times = stiff(1e8), SampleTimes(0.4, 0.05)
    packed, plain = (
        Dem(settings=settings, target=Target(form=form)).run(LANES, motions, times) for form in Form
    )
    assert_same(plain, packed)
