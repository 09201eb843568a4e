"""Bonded joints of assemblies in space: when they tear, slide and twist off, in closed form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from tests.engines.test_assembly_space import box, extruded, lanes_of
from tests.shared.assemblies import pushes
from warprock.model import patterns
from warprock.model.assembly import Piece
from warprock.model.motion import SpatialMotions, no_motion
from warprock.model.response import JointState, Outcome, Response, SampleTimes, Status
from warprock.model.solids import SpatialAssembly, assemble_solids
from warprock.running.batch import run_batch
from warprock.settings.engines import AssemblySettings
from warprock.units import GRAVITY

DENSITY, FRICTION = 2000.0, 0.5
CLOSE = 0.002
"""Part of a strength below and above which a joint holds and breaks: forces are solved to a
hundred thousandth of the weight."""
STRONG = 1e9
"""A strength that nothing here reaches [Pa]."""


def bonded(pieces: list[Piece], tension: float, cohesion: float) -> SpatialAssembly:
    return assemble_solids(
        pieces, density=DENSITY, friction=FRICTION, tension=tension, cohesion=cohesion
    )


def run(
    kinds: list[SpatialAssembly], loads: Sequence[float], angles: Sequence[float], end: float
) -> Response:
    """Loads towards angles from +x rise for 0.5 s."""
    push, angle = pushes(list(loads), 0.5, end), np.asarray(angles)
    motions = SpatialMotions(
        push.scaled(np.cos(angle)), push.scaled(np.sin(angle)), no_motion(push)
    )
    asked = AssemblySettings(settled=1e-5)
    return run_batch("assembly", lanes_of(kinds), motions, SampleTimes(end), settings=asked)


def hanging(x: float, y: float, tension: float) -> SpatialAssembly:
    """A block of .4 x .3 x .5 m that hangs by a joint of .2 x .1 m, at x, y from its middle."""
    pieces = [
        box("block", (-0.2, -0.15, 0.0), (0.2, 0.15, 0.5)),
        box("above", (x - 0.1, y - 0.05, 0.5), (x + 0.1, y + 0.05, 0.7), fixed=True),
        box("plinth", (-1.0, -1.0, -3.0), (1.0, 1.0, -2.0), fixed=True),
    ]
    return bonded(pieces, tension, STRONG)


def bracket(cohesion: float) -> SpatialAssembly:
    """A block that is held at one side of a wall by a joint of .2 x .2 m, .1 m from its middle."""
    pieces = [
        box("block", (-0.2, 0.0, 0.0), (0.4, 0.2, 0.2)),
        box("wall", (-0.1, -0.5, 0.0), (0.1, 0.0, 0.2), fixed=True),
        box("plinth", (-1.0, -1.0, -3.0), (1.0, 1.0, -2.0), fixed=True),
    ]
    return bonded(pieces, STRONG, cohesion)


@pytest.mark.thorough
def test_what_hangs_tears_off_by_the_stress_at_a_corner() -> None:
    # N = f_t A / (1 + 6 x / d + 6 y / b): what hangs at x, y from the middle of the joint.
    weight, area = DENSITY * 0.06 * GRAVITY, 0.02
    kinds = []
    for x, y in ((0.0, 0.0), (0.05, 0.0), (0.05, -0.04)):
        strength = weight / area * (1.0 + 6.0 * abs(x) / 0.2 + 6.0 * abs(y) / 0.1)
        kinds += [hanging(x, y, part * strength) for part in (1.0 + CLOSE, 1.0 - CLOSE)]
    found = run(kinds, [0.0] * 6, [0.0] * 6, 0.2)
    assert found["broken_joints"].tolist() == [0, 1] * 3
    assert (found["joint_break_time"][1::2] < 0.01).all()
    assert (found["peak_displacement"][::2] < 1e-5).all()
    assert (found["joint_state"][1::2, 0] & JointState.BROKEN).all()
    # What has torn off falls freely.
    assert found["collapse_time"][1::2] == pytest.approx(np.sqrt(2.0 * 0.05 / GRAVITY), abs=0.003)


@pytest.mark.thorough
def test_a_bracket_twists_off_by_the_shear_at_a_corner() -> None:
    # W at .1 m from the middle of a square of side a: the shear at the corner that is farthest on
    # the side of the weight is W / A + M a / 2 / I_p upwards and M a / 2 / I_p across, with
    # I_p = a^4 / 6.
    side, lever = 0.2, 0.1
    weight = DENSITY * 0.6 * 0.2 * 0.2 * GRAVITY
    twist = weight * lever * 0.5 * side / (side**4 / 6.0)
    shear = np.hypot(weight / side**2 + twist, twist)
    # The weight bends the joint by .1 m W, too, without a normal force.
    found = run(
        [bracket(shear * part) for part in (1.0 + CLOSE, 1.0 - CLOSE)], [0.0] * 2, [0.0] * 2, 0.1
    )
    assert found["broken_joints"].tolist() == [0, 1]


@pytest.mark.thorough
def test_a_bonded_column_stands_until_its_lowest_joint_tears_at_a_corner() -> None:
    # Three drums of .4 x .3 m, 1.2 m high, pushed askew and along their sides. At the corner that
    # tears -W / A + load W (h / 2) (cos / (A d / 6) + sin / (A b / 6)) is f_t.
    d, b, height, tension = 0.4, 0.3, 1.2, 1e5
    area = d * b
    weight = DENSITY * area * height * GRAVITY
    angles = [0.0, 0.5 * np.pi, 0.6]
    pieces = [box("ground", (-1.0, -1.0, -0.2), (1.0, 1.0, 0.0), fixed=True)]
    pieces += [box(f"{k}", (0.0, 0.0, 0.4 * k), (d, b, 0.4 * (k + 1))) for k in range(3)]
    column = bonded(pieces, tension, STRONG)
    tears = [
        (tension * area / weight + 1.0) / (3.0 * height * (np.cos(t) / d + np.sin(t) / b))
        for t in angles
    ]
    loads = [part * load for load in tears for part in (1.0 - CLOSE, 1.0 + CLOSE)]
    found = run([column] * 6, loads, np.repeat(angles, 2), 1.2)
    assert (found["status"] == Status.OK).all()
    assert found["broken_joints"].tolist() == [0, 1] * 3
    # Dry it falls at d / h and at b / h along its sides. Askew it stands dry up to .404, and tears
    # at .370.
    fell = [False, True, False, True, False, False]
    assert (found["outcome"] == Outcome.OVERTURNED).tolist() == fell
    assert not (found["joint_state"][:, 1:3] & JointState.BROKEN).any()


@pytest.mark.thorough
def test_what_is_extruded_slides_and_tears_as_in_the_plane() -> None:
    # As in the plane: at c A + friction N, and at f_t = 6 M / (A d) - W / A (load at half height).
    piece = [
        Piece("block", patterns.rectangle(0.0, 0.0, 0.4, 0.2)),
        Piece("ground", patterns.rectangle(-1.0, -0.1, 1.4, 0.0), fixed=True),
    ]
    solid = extruded(piece, 1.0)
    weight, area = DENSITY * 0.08 * GRAVITY, 0.4
    cohesion, load = 2000.0, 0.8
    slides = (cohesion * area + FRICTION * weight) / weight
    tension = (-1.0 + 6.0 * load * 0.1 / 0.4) * weight / area
    kinds = [bonded(solid, STRONG, cohesion)] * 2
    kinds += [bonded(solid, tension * part, STRONG) for part in (1.0 + CLOSE, 1.0 - CLOSE)]
    loads = [slides * (1.0 - CLOSE), slides * (1.0 + CLOSE), load, load]
    found = run(kinds, loads, [0.0] * 4, 0.7)
    assert found["broken_joints"].tolist() == [0, 1, 0, 1]
    assert found["joint_break_time"][[1, 3]] == pytest.approx([0.5, 0.5], abs=0.005)
    # A joint that has broken is dry: there the block slides on at friction alone.
    way = 0.5 * GRAVITY * (slides - FRICTION) * 0.2**2
    assert found["peak_slide"][1] == pytest.approx(way, rel=0.03)
