"""What rotations mean after a fall, and that a block which slides is not at rest, in space."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.blocks import make_stacks, sines, velocity_steps
from tests.shared.spatial_blocks import along, in_space, sound_run, spatial_lanes
from warprock.model.lanes import SpatialLanes
from warprock.model.motion import Control, SpatialMotions, no_motion
from warprock.model.pose import quaternion, rotations
from warprock.model.response import Outcome, Response, SampleTimes
from warprock.units import GRAVITY

ENGINES = ("event", "impulse", "dem")
RIGHT = 0.5 * np.pi


def felled() -> tuple[SpatialLanes, SpatialMotions]:
    """Blocks pushed over: to +x and -x, to +y and -y, over two corners, a yawed and another one."""
    x_push = 3.0 * np.array([1.0, -1.0, 0.0, 0.0, 1.0, -1.0, 1.0, 0.2])
    y_push = 3.0 * np.array([0.0, 0.0, 1.0, -1.0, 1.0, 1.0, 0.0, 1.0])
    zero = np.zeros(8)
    lanes = spatial_lanes(
        np.full(8, 0.2), 1.0, depth=0.2, yaw_start=np.where(np.arange(8) == 6, 0.1, zero),
        centre_offset_x=np.array([0.02, -0.02, 0.0, 0.0, 0.02, -0.02, 0.02, 0.01]),
        centre_offset_y=np.array([0.0, 0.0, 0.02, -0.02, 0.02, 0.02, 0.0, 0.02]),
    )  # fmt: skip
    x, y = (sines(Control.ACCELERATION, push, 1.0, 1.0) for push in (x_push, y_push))
    return lanes, SpatialMotions(x, y, no_motion(x))


@pytest.fixture(scope="module", params=ENGINES)
def fallen(request: pytest.FixtureRequest) -> Response:
    """What becomes of those blocks with one of the engines."""
    lanes, motions = felled()
    response = sound_run(request.param, lanes, motions, SampleTimes(2.5, 0.01))
    assert np.all(response["outcome"] == Outcome.OVERTURNED)
    return response


def test_a_fall_along_a_side_has_a_right_angle_there_and_nothing_across(fallen: Response) -> None:
    names = ("rotation", "rotation_across")
    for lanes, along_it, across_it, signs in (
        (slice(0, 2), *names, (1.0, -1.0)),
        (slice(2, 4), *names[::-1], (1.0, -1.0)),
    ):
        # `event` locates the fall to 1e-7 of its step; sweeps of `impulse` that end early leave a
        # trace of yaw.
        np.testing.assert_allclose(fallen[f"peak_{along_it}"][lanes], RIGHT, atol=1e-6)
        np.testing.assert_allclose(fallen[f"peak_{across_it}"][lanes], 0.0, atol=1e-6)
        end = fallen[along_it][lanes, -1]
        np.testing.assert_allclose(end, np.multiply(signs, RIGHT), atol=1e-6)
        assert np.all(np.abs(fallen[across_it][lanes]) <= 1e-6)


def test_a_fallen_block_lies_in_one_direction(fallen: Response) -> None:
    end, across = fallen["rotation"][:, -1], fallen["rotation_across"][:, -1]
    # atan2(x, |y|) and atan2(y, |x|) make a right angle; and the fall is located as said above.
    np.testing.assert_allclose(np.abs(end) + np.abs(across), RIGHT, atol=1e-5)
    # Square blocks pushed along the diagonal lie on it.
    np.testing.assert_allclose(end[4:6], [0.5 * RIGHT, -0.5 * RIGHT], atol=1e-5)
    np.testing.assert_allclose(across[4:6], 0.5 * RIGHT, atol=1e-5)
    assert 0.0 < np.abs(across[6]) < 0.3
    assert 0.0 < np.abs(end[7]) < RIGHT
    for name, peak in (("rotation", "peak_rotation"), ("rotation_across", "peak_rotation_across")):
        largest = np.abs(fallen[name]).max(axis=1)
        assert np.all(fallen[peak] >= largest - 1e-9)
        # Samples are 10 ms apart: a block that falls turns by less than 0.05 rad in that time.
        assert np.all(fallen[peak] <= largest + 0.05)
    np.testing.assert_allclose(fallen["peak_tilt"], RIGHT, atol=1e-6)


def test_rotations_change_smoothly_from_those_of_a_standing_block_to_those_of_a_lying_one() -> None:
    tilt, way = np.linspace(0.0, 2.0, 4001), np.array([0.0, 0.3, 0.25 * np.pi, 1.2, RIGHT])[:, None]
    turn = tilt * np.stack([-np.sin(way), np.cos(way), 0.0 * way])
    turn = np.stack(np.broadcast_arrays(*turn), axis=-1)
    rotation, across, _ = rotations(quaternion(turn))
    stands = tilt < np.pi / 3.0 - 1e-9
    expected = np.arctan(np.tan(tilt[stands]) * np.cos(way))
    np.testing.assert_allclose(rotation[:, stands], expected, atol=1e-12)
    lies = tilt > RIGHT
    for found, side in ((rotation, np.cos(way)), (across, np.sin(way))):
        np.testing.assert_allclose(found[:, lies], np.broadcast_to(
            np.arctan2(side, np.sqrt(1.0 - np.minimum(side**2, 1.0))), found[:, lies].shape
        ), atol=1e-7)  # fmt: skip
        # No jump and no kink: steps and their changes are of the order of the tilt's.
        assert np.max(np.abs(np.diff(found, axis=1))) <= 3.0 * tilt[1]
        falls = np.abs(np.diff(found[:, ~lies], 2, axis=1))
        assert np.max(falls) <= 20.0 * tilt[1] ** 2


@pytest.mark.parametrize("engine", ["impulse", "dem"])
def test_a_block_that_slides_is_not_at_rest(engine: str) -> None:
    friction = np.array([0.05, 0.05, 0.1, 0.02, 0.1, 0.3])
    speed = np.array([1.0, 1.0, 1.0, 0.2, 1.0, 0.5])
    lanes = spatial_lanes(
        np.full(6, 0.6), 0.5, friction, depth=0.6,
        yaw_start=np.array([0.0, 0.3, 0.0, 0.0, 0.5, 0.0]),
        centre_offset_x=np.array([0.0, 0.0, 0.0, 0.0, 0.05, 0.0]),
    )  # fmt: skip
    # A velocity step of the base under a squat block: it slides and stops as its friction says.
    kick = np.where(np.arange(6) == 2, 0.0, speed)
    x, y = (velocity_steps(v, 0.0 * v, np.full(6, 10.0)) for v in (kick, speed - kick))
    motions = SpatialMotions(x, y, no_motion(x))
    stops = speed / (friction * GRAVITY)
    early = sound_run(engine, lanes, motions, SampleTimes(0.5))
    late = sound_run(engine, lanes, motions, SampleTimes(2.5))
    np.testing.assert_array_equal(early["outcome"] == Outcome.AT_REST, stops < 0.5)
    np.testing.assert_array_equal(np.isnan(early["rest_time"]), stops > 0.5)
    assert np.all(late["outcome"] == Outcome.AT_REST)
    # It counts as at rest once it is slower than a part of what friction takes in a step, or than
    # springs swing: within 1e-3 s x g of speed, at the least friction 0.02 some 5 ms of sliding.
    np.testing.assert_allclose(late["rest_time"], stops, atol=6e-3)
    assert np.all(np.isnan(late["uplift_time"]))


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["impulse", "dem"])
def test_a_stack_in_which_something_slides_is_not_at_rest(engine: str) -> None:
    friction = np.array([[0.05, 0.5], [0.5, 0.05], [0.3, 0.3]])
    lanes = in_space(
        make_stacks([0.6, 0.5], [0.3, 0.3], friction=friction),
        yaw_start=np.array([[0.0, 0.0], [0.0, 0.1], [0.0, 0.0]]),
    )
    motions = along(velocity_steps(np.full(3, 0.5), np.zeros(3), np.full(3, 10.0)))
    early = sound_run(engine, lanes, motions, SampleTimes(0.3))
    late = sound_run(engine, lanes, motions, SampleTimes(1.5))
    np.testing.assert_array_equal(early["outcome"] == Outcome.AT_REST, [False, False, True])
    assert np.all(late["outcome"] == Outcome.AT_REST)
    # The least friction in the stack stops it: 0.05 of the whole, or of the upper block.
    stops = 0.5 / (np.array([0.05, 0.05, 0.3]) * GRAVITY)
    np.testing.assert_allclose(late["rest_time"], stops, atol=1.5e-2)
