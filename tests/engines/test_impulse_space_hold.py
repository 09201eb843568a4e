"""`impulse` in space where contacts hold: stopped together, whatever the number of sweeps."""

from __future__ import annotations

import time

import numpy as np
import pytest

from tests.shared.blocks import free_lanes, make_lanes, sines
from tests.shared.spatial_blocks import along, in_space, spatial_lanes, unmoved
from tests.shared.speed import require_gain
from warprock.engines.launching import Form
from warprock.model.lanes import SpatialLanes
from warprock.model.motion import Control, SpatialMotions
from warprock.model.response import Response, SampleTimes
from warprock.running.batch import run_batch
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY

FEW = ImpulseSettings()

LEAST_SHARE = 0.5
"""Rate with a hundred sweeps over that with ten, of blocks that need none: 0.9, else 0.15."""


def slender(friction: float) -> tuple[SpatialLanes, SpatialMotions]:
    """The paper's block under its six continuous sines."""
    frequency = np.array([3.0, 3.3, 3.3, 5.0, 5.0, 5.0])
    amplitude = 1e-3 * np.array([8.0, 6.0, 8.0, 4.0, 5.0, 6.0])
    lanes = in_space(make_lanes(np.full(6, 0.17), 1.0, friction=friction), depth=0.502)
    return lanes, along(sines(Control.DISPLACEMENT, amplitude, frequency, cycles=300))


def out_of_plane(found: Response, lanes: SpatialLanes) -> float:
    """Largest yaw and rotation across over the slenderness angle."""
    most = np.maximum(found["peak_yaw"], found["peak_rotation_across"])
    return float(np.max(most / lanes.slenderness_angle))


def test_planar_blocks_do_not_turn_about_the_vertical() -> None:
    # The thinner a block, the closer to each other are the corners that it rocks on, and the more
    # sweeps the couple of their friction would take.
    for depth in (0.5, 0.2):
        lanes = in_space(free_lanes(), depth=depth)
        found = run_batch("impulse", lanes, unmoved(9), SampleTimes(5.0), settings=FEW)
        # Next to nothing, but for a step in which corners slide or leave, which sweeps solve.
        assert out_of_plane(found, lanes) <= 1e-6
    for friction, bound in ((5.0, 1e-12), (1.0, 1e-6)):
        lanes, motions = slender(friction)
        found = run_batch("impulse", lanes, motions, SampleTimes(5.0), settings=FEW)
        assert np.all(found["impact_count"] > 10)
        assert out_of_plane(found, lanes) <= bound


def test_blocks_that_stick_need_no_sweeps() -> None:
    # On corners, edges and faces, with yaws and eccentric centres, under friction that holds.
    lanes = spatial_lanes(
        np.full(4, 0.3), 1.0, friction=10.0, depth=0.4,
        rotation_start=np.array([0.1, 0.1, 0.0, 0.12]),
        rotation_across_start=np.array([0.0, 0.05, 0.1, -0.02]),
        yaw_start=np.array([0.0, 0.3, 0.1, -0.2]),
        centre_offset_x=np.array([0.0, 0.01, 0.0, 0.0]),
    )  # fmt: skip
    times = SampleTimes(0.09, 0.005)
    one, many = (
        run_batch(
            "impulse",
            lanes,
            unmoved(4),
            times,
            settings=ImpulseSettings(iterations=sweeps),
        )
        for sweeps in (1, 200)
    )
    # Up to the first impacts, in which corners leave: to round-off.
    for name in ("rotation", "rotation_across", "yaw"):
        np.testing.assert_allclose(one[name], many[name], rtol=0.0, atol=1e-12, err_msg=name)
    assert np.max(np.abs(many["yaw"] - many["yaw"][:, :1])) > 1e-3


def test_a_block_that_is_held_does_not_depend_on_neighbours_that_slide() -> None:
    # Among 32 lanes of a pack all but two slide in every direction; their sweeps visit the pack.
    direction = np.linspace(0.0, 6.0, 32)
    held = np.isin(np.arange(32), (5, 17))
    lanes = spatial_lanes(
        np.full(32, 0.3), 1.0, friction=np.where(held, 10.0, 0.15),
        rotation_start=np.where(held, 0.1, 0.0), yaw_start=np.where(held, 0.2, 0.0),
    )  # fmt: skip
    one = np.ones(32)
    motions = along(
        sines(Control.ACCELERATION, 0.5 * GRAVITY * np.cos(direction), 2.0 * one, 2.0),
        sines(Control.ACCELERATION, 0.5 * GRAVITY * np.sin(direction), 2.0 * one, 2.0),
    )
    times = SampleTimes(0.5, 0.05)
    whole = run_batch("impulse", lanes, motions, times)
    assert np.all(whole["peak_slide"][~held] > 1e-2)
    assert np.all(whole["peak_slide"][held] < 1e-4)
    some = np.flatnonzero(held)
    part = run_batch("impulse", lanes.take(some), motions.take(some), times)
    for name, values in part.fields.items():
        # Byte by byte, zeros with their signs.
        assert values.tobytes() == whole[name][some].tobytes(), name


@pytest.mark.speed
def test_sweeps_that_no_block_needs_cost_nothing() -> None:
    lanes = in_space(free_lanes()).take(np.arange(576) % 9)

    def cost(sweeps: int) -> float:
        settings = ImpulseSettings(iterations=sweeps)
        started = time.process_time()
        found = run_batch(
            "impulse", lanes, unmoved(576), SampleTimes(0.25), settings=settings,
            form=Form.PACKED, workers=1,
        )  # fmt: skip
        return (time.process_time() - started) / float(found["step_count"].sum())

    cost(10)
    require_gain(lambda: cost(10), lambda: cost(100), LEAST_SHARE)
