"""Assemblies in programs of others: they stand and fall about where limit analysis says."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.assemblies import assembly_lanes, built, oppenheim, pushes
from tests.shared.commands import succeed
from tests.shared.programs import in_newton_xpbd
from warprock.errors import DeclinedError
from warprock.measure.bench import in_space
from warprock.model import patterns
from warprock.model.assembly import assemble
from warprock.model.motion import SpatialMotions, StillBase, no_motion
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.model.solids import SpatialAssembly, assemble_solids
from warprock.model.turning import rotate
from warprock.programs.assembly_scene import solids, touching
from warprock.programs.table import require_scenes, run_program
from warprock.settings.programs import BulletSettings, MujocoSettings, NewtonXpbdSettings

DRUMS = built(patterns.column(1.0, 0.5, 4), 0.8)
PROGRAMS = {
    "mujoco": ("mujoco", MujocoSettings(steps_per_second=500, impedance=0.99, damping_ratio=8.0)),
    "bullet": ("pybullet", BulletSettings(steps_per_second=500)),
}


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize(
    ("kind", "load"), [(DRUMS, 0.5), (oppenheim(7), 0.3736)], ids=["drums", "arch"]
)
def test_it_stands_below_its_limit_load_and_moves_away_above(name: str, kind, load: float):
    """Soft or unfinished contacts give by millimetres, and the limit is met within a tenth."""
    package, settings = PROGRAMS[name]
    pytest.importorskip(package)
    lanes = assembly_lanes([kind] * 2)
    motions = pushes(load * np.array([0.9, 1.1]), 0.5, 1.5)
    found = run_program(name, lanes, motions, SampleTimes(1.5, 0.1), settings).response
    assert (found["status"] == Status.OK).all()
    assert found["peak_displacement"][0] < 5e-3
    assert found["peak_displacement"][1] > 0.05
    assert found["rotation"][1, -1] > found["rotation"][0, -1]


def test_what_falls_is_told_when():
    """A column pushed by its own weight has a drum on its side within 1.5 s."""
    pytest.importorskip("mujoco")
    lanes, settings = assembly_lanes([DRUMS]), PROGRAMS["mujoco"][1]
    found = run_program("mujoco", lanes, pushes([1.0], 0.1, 2.0), SampleTimes(2.0), settings)
    assert found.response["outcome"][0] == Outcome.OVERTURNED
    assert 0.5 < found.response["collapse_time"][0] < 2.0


@in_newton_xpbd
def test_newton_is_given_the_same_blocks():
    """XPBD lets columns lean below their limit load; well above it they fall away."""
    lanes, settings = assembly_lanes([DRUMS] * 2), NewtonXpbdSettings(steps_per_second=500)
    motions = pushes([0.0, 1.0], 0.2, 0.8)
    found = run_program("newton-xpbd", lanes, motions, SampleTimes(0.8), settings).response
    assert (found["status"] == Status.OK).all()
    still, pushed = found["peak_displacement"]
    assert still < 0.02
    assert pushed > 0.1


def test_a_block_is_the_prism_of_its_polygon():
    kind = oppenheim(7)
    for prism, mass in zip(solids(kind), kind.mass, strict=True):
        hull = prism.hull
        assert np.ptp(hull[:, 1]) == pytest.approx(kind.depth)
        assert prism.mass == mass
        assert not (prism.box and not prism.fixed)
    assert all(prism.box for prism in solids(DRUMS))
    assert len(touching(kind)) == kind.joints.count


def test_one_friction_for_all_is_asked_for_by_programs_that_multiply_those_of_bodies():
    joints = dataclasses.replace(DRUMS.joints, friction=np.array([0.5, 0.6, 0.6, 0.6]))
    lanes = assembly_lanes([dataclasses.replace(DRUMS, joints=joints)])
    pytest.importorskip("pybullet")
    with pytest.raises(DeclinedError, match="one friction coefficient"):
        require_scenes("bullet", lanes, pushes([0.1], 1.0, 1.0), SampleTimes(1.0), BulletSettings())
    with pytest.raises(DeclinedError, match="assembly"):
        require_scenes("blender", lanes, pushes([0.1], 1.0, 1.0), SampleTimes(1.0), None)


CASE = """
title = "Drums"
source = "Four drums."
[assembly]
pattern = "column"
drum_width = "1 m"
drum_height = "0.5 m"
drums = 4
density = "2000 kg/m^3"
depth = "1 m"
[contact]
friction = 0.8
[motion]
waveform = "sine"
control = "acceleration"
frequency = "1 Hz"
amplitude = "0.9 g"
cycles = 1
[run]
duration = "0.6 s"
sample_interval = "0.02 s"
"""


@pytest.mark.thorough
@pytest.mark.usefixtures("two_rooms")
def test_compare_holds_engines_and_programs_against_the_first(tmp_path):
    pytest.importorskip("mujoco")
    (tmp_path / "case.toml").write_text(CASE)
    program = "mujoco@impedance=0.99,damping_ratio=8,steps_per_second=1000"
    engines = ("assembly", "assembly@time_step=5e-4", program)
    asked = [part for engine in engines for part in ("-e", engine)]
    found = succeed("compare", tmp_path / "case.toml", *asked).stdout
    assert "engines against assembly" in found
    assert f"{program} has the outcome of assembly in 1 of 1" in " ".join(found.split())


TURN = 0.7


def upright(height: float) -> SpatialAssembly:
    """Three slabs of 0.6 x 0.2 m and some height on one another, turned about the vertical.

    If they are as high as thick, two axes of their inertia may lie anyhow.
    """
    pieces = patterns.extruded(patterns.column(0.2, height, 3), 0.6)
    attitude = np.array([0.0, 0.0, np.sin(0.5 * TURN), np.cos(0.5 * TURN)])
    turned = [each._replace(corners=rotate(attitude, each.corners)) for each in pieces]
    return assemble_solids(turned, density=2000.0, friction=0.7)


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize("height", [0.15, 0.2], ids=["boxes", "square"])
def test_in_space_it_falls_over_an_edge_at_its_width_over_its_height(name: str, height: float):
    package, settings = PROGRAMS[name]
    pytest.importorskip(package)
    lanes = in_space(assembly_lanes([upright(height)] * 2))
    push = pushes(0.2 / (3.0 * height) * np.array([0.9, 1.1]), 0.5, 1.5)
    ways = [push.scaled(np.full(2, part)) for part in (np.cos(TURN), np.sin(TURN))]
    motions = SpatialMotions(*ways, no_motion(push))
    found = run_program(name, lanes, motions, SampleTimes(1.5, 0.1), settings).response
    assert (found["status"] == Status.OK).all()
    assert found["peak_displacement"][0] < 5e-3
    assert found["peak_displacement"][1] > 0.05
    assert found["outcome"][1] == Outcome.OVERTURNED


def test_blocks_in_space_have_their_own_axes():
    kind = upright(0.15)
    slabs = solids(kind)
    assert all(slab.box for slab in slabs)
    for slab, corners in zip(slabs, kind.corners, strict=True):
        back = slab.place + rotate(slab.attitude, slab.hull)
        np.testing.assert_allclose(back, corners[: len(back)], atol=1e-12)
    size = 2.0 * np.array([slabs[-1].half])
    np.testing.assert_allclose(np.sort(size), [[0.15, 0.2, 0.6]])


def test_programs_decline_bonded_joints():
    pieces = patterns.column(1.0, 0.5, 2)
    bonded = assemble(pieces, depth=1.0, density=2000.0, friction=0.8, tension=1e5, cohesion=1e5)
    settings = PROGRAMS["mujoco"][1]
    with pytest.raises(DeclinedError, match="dry joints only"):
        require_scenes("mujoco", assembly_lanes([bonded]), StillBase(1), SampleTimes(1.0), settings)


def test_programs_decline_assemblies_in_space_by_name():
    lanes, still = assembly_lanes([upright(0.15)]), StillBase(1)
    with pytest.raises(DeclinedError, match="assemblies in the plane only; the case's lies in"):
        require_scenes("newton-xpbd", lanes, still, SampleTimes(1.0), NewtonXpbdSettings())
