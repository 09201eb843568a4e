"""A block is the same block alone, as a stack of one, and in space: every field of every engine."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import as_stacks, at_rest, make_lanes, sines
from tests.shared.kinds import in_every_kind, lanes_of, motions_of
from tests.shared.spatial_blocks import along, in_space
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, MotionKind, StillBase
from warprock.model.response import LANE_FIELDS, Response, SampleTimes
from warprock.running.batch import run_batch
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

TIMES = SampleTimes(1.2, 0.02, places=True)


@dataclasses.dataclass(frozen=True)
class Bounds:
    """How far two kernels of an engine may lie apart.

    Attributes:
        rotation: Of rotations, over the slenderness angle.
        slide: Of slides and penetrations, over the width.
        energy: Of the energy lost, over that which topples the block.
        time: Of times of events and of peaks [s].
        impacts: Of the number of impacts.
        reason: Why.
    """

    rotation: float
    slide: float
    energy: float
    time: float
    impacts: int
    reason: str


ONE_TEXT = Bounds(0.0, 0.0, 0.0, 0.0, 0, "one text: a single block runs as a stack of one")
SECOND_ORDER = Bounds(
    2e-3, 5e-4, 5e-3, 5e-3, 0, "a few (p dt)^2 = 4e-4 at the step of 5 ms; an event within a step"
)
FIRST_ORDER = Bounds(
    1e-2,
    1e-3,
    2e-2,
    1e-2,
    1,
    "a few g dt / velocity = 1e-3 at the step of 0.2 ms; a last hop; a slow uplift is seen once "
    "the gap is what falls in a step, (6 g dt^2 / width / (p^2 x rate of a / g))^(1/3) = 7 ms late",
)
SAME_RULE = dataclasses.replace(
    FIRST_ORDER, time=1e-3, impacts=0, reason="the same rule of what parts and lands; a few steps"
)
SPRINGS = Bounds(1e-3, 1e-3, 1e-2, 5e-3, 1, "the same springs; what chatters at rest is round-off")
BOUNDS = {
    ("event", "stack of one"): SECOND_ORDER,
    ("event", "block in space"): SECOND_ORDER,
    ("impulse", "stack of one"): FIRST_ORDER,
    ("impulse", "block in space"): SAME_RULE,
    ("direct", "stack of one"): FIRST_ORDER,
    ("xpbd", "stack of one"): ONE_TEXT,
    ("dem", "stack of one"): ONE_TEXT,
    ("dem", "block in space"): SPRINGS,
}
"""By engine and the scene that its planar single block is held against."""

THOROUGH = {(name, "stack of one") for name in ("event", "direct", "impulse")}
"""Kernels that nothing else asks for; the ordinary run holds `xpbd` and `dem` to the same."""

HISTORIES = ("rotation", "slide", "x", "z")
"""What is sampled of a block in the plane and in space alike."""

LEFT_OUT = {"step_count"}
"""Fields that belong to the kernel, not to the block."""
SEEN = 1e-4
"""Peak over the slenderness angle from which its time means something."""


@functools.cache
def run(engine: str, scene: str, kind: MotionKind) -> Response:
    """The response of the four lanes in a scene, its fields as those of single blocks."""
    lanes = lanes_of(scene, started=kind is MotionKind.STILL)
    response = run_batch(engine, lanes, motions_of(kind, lanes), TIMES, workers=1)
    fields = {name: response[name] for name in (*LANE_FIELDS, *HISTORIES)}
    shape = {1: (4,), 2: (4, -1)}
    plain = {
        name: values.reshape(shape[2 if name in HISTORIES else 1])
        for name, values in fields.items()
    }
    return Response(response.engine, plain, response.times)


def scales(lanes: Lanes, bounds: Bounds) -> dict[str, Array]:
    """The largest difference of every field, by name, shape [lane]."""
    angle = lanes.slenderness_angle
    rise = 0.5 * np.hypot(lanes.width, lanes.height) - 0.5 * lanes.height
    energy = bounds.energy * lanes.mass * GRAVITY * rise
    rotation, slide = bounds.rotation * angle, bounds.slide * lanes.width
    time = np.full(lanes.lane_count, bounds.time)
    none = np.zeros(lanes.lane_count)
    return {
        "rotation": rotation,
        "slide": slide,
        "x": slide + lanes.height * rotation,
        "z": slide + lanes.height * rotation,
        "peak_rotation": rotation,
        "peak_time": time,
        "outcome": none,
        "status": none,
        "impact_count": none + bounds.impacts,
        "uplift_time": time,
        "rest_time": time,
        "residual_slide": slide,
        "peak_slide": slide,
        "peak_penetration": slide,
        "energy_lost": energy,
    }


def test_every_field_is_compared():
    compared = scales(lanes_of("block"), SECOND_ORDER)
    assert set(compared) == {*LANE_FIELDS, *HISTORIES} - LEFT_OUT


@pytest.mark.parametrize(
    ("engine", "scene", "kind"),
    [
        pytest.param(*each.values, marks=pytest.mark.thorough)
        if each.values[:2] in THOROUGH
        else each
        for each in in_every_kind(BOUNDS)
    ],
)
def test_a_block_is_the_same_block_in_every_scene(engine: str, scene: str, kind: MotionKind):
    bounds = BOUNDS[engine, scene]
    lanes = lanes_of("block")
    one, other = run(engine, "block", kind), run(engine, scene, kind)
    low = np.maximum(one["peak_rotation"], other["peak_rotation"]) < SEEN * lanes.slenderness_angle
    wrong = []
    for name, allowed in scales(lanes, bounds).items():
        ours, theirs = (each[name].astype(np.float64).reshape(4, -1) for each in (one, other))
        both_never = np.isnan(ours) & np.isnan(theirs)
        apart = np.where(both_never, 0.0, np.abs(ours - theirs)).max(axis=1)
        apart[low] = 0.0 if name == "peak_time" else apart[low]
        if not np.all(apart <= allowed):
            wrong.append(
                f"{name}: {ours[:, 0]} and {theirs[:, 0]}, {apart} apart, {allowed} allowed"
            )
    assert not wrong, "\n".join([bounds.reason, *wrong])


@pytest.mark.parametrize(
    ("engine", "scene"),
    [
        pytest.param(
            *each,
            marks=()
            if each[1] == "stack of one" and each not in THOROUGH
            else pytest.mark.thorough,
        )
        for each in sorted(BOUNDS)
    ],
)
def test_the_last_slide_is_that_of_the_lane(engine: str, scene: str):
    for name in ("block", scene):
        response = run(engine, name, MotionKind.HARMONIC)
        assert np.max(np.abs(response["residual_slide"])) > 1e-3
        # `dem` tells the slide from which the forces of its last step come; the others the same.
        most = 1e-6 if engine == "dem" else 1e-12
        np.testing.assert_allclose(response["slide"][:, -1], response["residual_slide"], 0.0, most)


def stepped(engine: str, scene: str, end: float) -> tuple[Lanes, Array]:
    """Energy lost up to a time [s] where the base sets out and stops at once, by lane [J]."""
    friction = np.array([2.0, 0.9, 0.3, 0.7, 0.6])
    block = make_lanes(np.array([0.25, 0.25, 0.25, 0.2, 0.3]), 1.0, friction=friction)
    scenes = {"block": block, "stack of one": as_stacks(block), "block in space": in_space(block)}
    motions = sines(Control.DISPLACEMENT, 0.024 * np.ones(5), 2.0, cycles=1.0)
    lanes = scenes[scene]
    moves = along(motions) if lanes.spatial else motions
    response = run_batch(engine, lanes, moves, SampleTimes(end, end), workers=1)
    return block, response["energy_lost"].ravel()


EXACT = [
    ("event", "block"),
    pytest.param("event", "stack of one", marks=pytest.mark.thorough),
    ("event", "block in space"),
]


@pytest.mark.parametrize(("engine", "scene"), [*EXACT, ("direct", "block")])
def test_a_velocity_step_takes_nothing_from_a_block_that_sticks(engine: str, scene: str):
    # The first corner of the first lane sticks. In the others it slides, which does take energy.
    block, lost = stepped(engine, scene, 0.01)
    speed = 2.0 * np.pi * 2.0 * 0.024
    kinetic = 0.5 * block.mass * speed**2
    assert abs(lost[0]) <= 1e-3 * kinetic[0]
    assert np.all(lost[1:] >= 0.01 * kinetic[1:])


@pytest.mark.parametrize(("engine", "scene"), EXACT)
def test_what_velocity_steps_take_is_counted_alike(engine: str, scene: str):
    # `direct` is of first order in its step, where slides begin and end.
    _block, expected = stepped("direct", "block", 1.2)
    _block, lost = stepped(engine, scene, 1.2)
    np.testing.assert_allclose(lost, expected, rtol=2e-2)


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["event", "impulse", "dem"])
def test_a_pulse_of_no_size_is_a_still_base(engine: str):
    # The ordinary run has stacks on such a pulse alone: a kernel less each.
    lanes = lanes_of("stack", started=True)
    still, pulsed = (
        run_batch(engine, lanes, motions, TIMES, workers=1)
        for motions in (StillBase(4), at_rest(4))
    )
    # Without a motion a step may be longer, where nothing changes that a step depends on.
    for name in set(still.fields) - LEFT_OUT:
        # The compiler may fuse what it knows to be zero; round-off, magnified by impacts.
        np.testing.assert_allclose(still[name], pulsed[name], 1e-8, 1e-9, err_msg=name)
