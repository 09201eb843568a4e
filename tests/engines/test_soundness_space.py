"""Energy from nowhere in space, on bases that move: bounds known before a run, and runs."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest

from tests.engines.test_soundness_moving import beyond_the_base, shaken
from tests.shared.blocks import sines
from tests.shared.marks import first
from tests.shared.spatial_blocks import (
    along,
    in_space,
    spatial_lanes,
    spatial_stack,
    unmoved,
)
from warprock.engines.energy import energy_at_start, energy_to_tilt, most_energy
from warprock.engines.soundness import (
    BARRIER_SHARE,
    account_in_space,
    find_moved_by_nothing,
    pull_in_space,
    unstable,
)
from warprock.measure.atlas_maps import at_step
from warprock.model.lanes import Lanes
from warprock.model.motion import (
    Control,
    PlanarMotions,
    SpatialMotions,
    StillBase,
    mavroeidis_papageorgiou_motions,
    ricker_motions,
)
from warprock.model.pose import bottom_corners, start_poses
from warprock.model.response import USABLE, SampleTimes, Status
from warprock.model.turning import rotate
from warprock.recordings import load_record, record_motions
from warprock.running.batch import run_batch
from warprock.settings.engines import build_settings
from warprock.units import GRAVITY

CONTROLS = list(Control)
AMPLITUDES = np.array([0.02, 0.4, 3.0])
"""Of a displacement [m], a velocity [m/s], an acceleration [m/s^2]."""


def motions_of(kind: str) -> PlanarMotions:
    """One motion under each control, or one record at three scales."""
    frequency, start = np.array([1.0, 2.5, 4.0]), np.array([0.0, 0.1, 0.3])
    if kind == "sine":
        parts = [
            sines(c, a, f, 1.75) for c, a, f in zip(CONTROLS, AMPLITUDES, frequency, strict=True)
        ]
        whole = {
            field.name: np.concatenate([getattr(part, field.name) for part in parts])
            for field in dataclasses.fields(parts[0])
        }
        return dataclasses.replace(parts[0], **whole)
    if kind == "ricker":
        return ricker_motions(CONTROLS, AMPLITUDES, frequency, start)
    if kind == "pulse":
        return mavroeidis_papageorgiou_motions(
            CONTROLS, AMPLITUDES, frequency, start,
            cycles=np.array([1.5, 2.0, 3.0]), phase=np.array([0.0, 1.0, 2.5]),
        )  # fmt: skip
    record = load_record("ridgecrest-2019-ccc-090")
    return record_motions([record], index=np.zeros(3, int), scale=AMPLITUDES, start=start)


# How far bounds may lie above: half cycles that were begun, parts of sums that peak apart.
@pytest.mark.parametrize(
    ("kind", "variation", "pull"),
    [("sine", 1.2, 1.0), ("ricker", 1.8, 1.5), ("pulse", 2.1, 1.1), ("record", 1.05, 1.0)],
)
@pytest.mark.parametrize("duration", [1.0, 60.0])
def test_no_base_does_more_than_its_bounds_say(
    kind: str, variation: float, pull: float, duration: float
):
    motions = motions_of(kind)
    times = np.linspace(0.0, duration, 120_001)
    bound, strongest = motions.velocity_variation(duration), motions.largest_acceleration()
    for lane in range(3):
        size = np.abs(motions.acceleration(times, lane))
        stepped = [s for s in motions.segments(lane) if s.velocity_step and s.start < duration]
        swept = size.mean() * duration + sum(abs(s.velocity_step) for s in stepped)
        # The mean misses knots by a part of the steps between the samples.
        assert bound[lane] >= swept * (1.0 - 2e-3)
        assert (strongest[lane] == np.inf) == any(s.velocity_step for s in motions.segments(lane))
        # Peaks of Ricker's humps are found on a grid, to 1e-6.
        assert strongest[lane] >= size.max() * (1.0 - 1e-6)
        if duration > 50.0:
            assert bound[lane] <= variation * swept
            assert strongest[lane] == np.inf or strongest[lane] <= pull * size.max() * (1.0 + 2e-3)


def test_a_base_that_stands_still_does_nothing():
    np.testing.assert_array_equal(StillBase(2).velocity_variation(5.0), 0.0)
    np.testing.assert_array_equal(StillBase(2).largest_acceleration(), 0.0)


def test_no_way_to_lean_takes_less_energy():
    count = 721
    way = np.linspace(-np.pi, np.pi, count)
    for tilt in (0.02, 0.1, 0.15):
        lanes = spatial_lanes(
            np.full(count, 0.6), 1.0, centre_offset_x=0.05, centre_offset_y=-0.1, depth=0.5,
            rotation_start=tilt * np.cos(way), rotation_across_start=tilt * np.sin(way),
        )  # fmt: skip
        _at, attitude = start_poses(lanes)
        axis = rotate(attitude, np.array([0.0, 0.0, 1.0]))
        low = rotate(attitude[:, None, :], bottom_corners(lanes))[..., 2].min(axis=1)
        held = GRAVITY * lanes.mass * (-low - 0.5 * lanes.height)
        least = energy_to_tilt(lanes, np.arccos(axis[:, 2]))
        assert np.all(held >= least - 1e-9 * held.max())
        # About the nearest edge it takes just that.
        assert np.min(held / least) < 1.0 + 1e-3


def unstable_in_space(
    lanes: Lanes, motions: SpatialMotions, duration: float = 1.0, *, rigid: bool = True,
    energy_lost: npt.ArrayLike = 0.0, peak_tilt: npt.ArrayLike = 0.0, deepest: npt.ArrayLike = 0.0,
) -> npt.NDArray[np.bool_]:  # fmt: skip
    """What is judged of lanes of which an engine tells nothing else."""
    rows = np.zeros(lanes.lane_count, [("loss", float), ("deepest", float)])
    rows["loss"], rows["deepest"] = energy_lost, deepest
    account = account_in_space(lanes, motions, duration, rows)
    return unstable(lanes, account, np.broadcast_to(peak_tilt, lanes.width.shape), rigid=rigid)


def test_contacts_give_no_more_than_was_held_and_supplied():
    lanes = spatial_lanes(np.full(4, 0.2), 1.0, gap_start=[0.0, 0.1, 0.0, 0.0])
    motions = along(sines(Control.ACCELERATION, [0.0, 0.0, 4.0, 4.0], np.full(4, 2.0), 1.0))
    most = most_energy(lanes, energy_at_start(lanes), motions, 1.0)
    # A cycle of a sine: two swings of 2 A / w. Both ends of a fall.
    swept = 2.0 * 2.0 * 4.0 / (2.0 * np.pi * 2.0)
    expected = np.array([0.0, GRAVITY * 0.1, 0.5 * swept**2, 0.5 * swept**2]) * lanes.mass
    np.testing.assert_allclose(most, expected, rtol=1e-12, atol=1e-12)
    barrier = 0.5 * GRAVITY * lanes.mass * (np.hypot(0.2, 1.0) - 1.0)
    given = np.array([0.2 * barrier[0], 0.9 * most[1], 0.9 * most[2], 1.1 * most[3]])
    found = unstable_in_space(lanes, motions, energy_lost=-given)
    np.testing.assert_array_equal(found, [True, False, False, True])


def test_soft_contacts_are_judged_by_lean_less_depth_and_rigid_ones_by_both():
    lanes = spatial_lanes(np.full(4, 0.2), 1.0, rotation_start=[0.02, 0.02, 0.0, 0.0])
    told = {"peak_tilt": [0.02, 1.5, 0.0, 0.0], "deepest": [0.0, 0.0, 0.05, 0.15]}
    motions = unmoved(4)
    found = unstable_in_space(lanes, motions, **told)
    np.testing.assert_array_equal(found, [False, True, False, True])
    # Springs let a centre sink by as much as a corner goes in, and a block lean that far for free;
    # on springs that gave by nothing a lean takes what it takes on rigid ground.
    soft = unstable_in_space(lanes, motions, **told, rigid=False)
    np.testing.assert_array_equal(soft, [False, True, False, False])
    sunk = told | {"deepest": np.full(4, 0.05)}
    assert not unstable_in_space(lanes, motions, **sunk, rigid=False).any()
    stack = spatial_stack([0.3, 0.2], [1.0, 0.5])
    assert unstable_in_space(stack, unmoved(1), peak_tilt=1.5, deepest=0.11)[0]
    assert not unstable_in_space(stack, unmoved(1), peak_tilt=1.5, deepest=0.09)[0]


def test_a_base_too_weak_to_lift_an_edge_tilts_no_block():
    count = 6
    lanes = spatial_lanes(np.full(count, 0.4), 1.0, depth=0.2)
    start = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.05])
    lanes = dataclasses.replace(lanes, rotation_across_start=start)
    limit = 0.2 * GRAVITY
    # Along both ways at once, a part of it; with a base that falls away; from a start that leans.
    along_x = np.array([0.6, 0.6, 0.68, 0.5, 0.0, 0.6]) * limit
    upwards = np.array([0.0, 0.0, 0.0, 0.3, 0.2, 0.0]) * GRAVITY
    frequency = np.full(count, 2.0)
    x, z = (sines(Control.ACCELERATION, each, frequency, 1.0) for each in (along_x, upwards))
    tilt = np.array([0.06, 0.04, 0.06, 0.06, 0.06, 0.06]) * np.arctan2(0.2, 1.0)
    found = find_moved_by_nothing(lanes, pull_in_space(SpatialMotions(x, x, z)), tilt)
    assert (1.0 - BARRIER_SHARE) / np.sqrt(2.0) < 0.68
    np.testing.assert_array_equal(found, [True, False, False, False, True, False])


@pytest.mark.parametrize(
    ("engine", "step", "least"),
    [("impulse", 0.1, 60), ("impulse", 0.02, 40), ("impulse", 0.005, 10), ("xpbd", 0.1, 30)],
)
def test_what_no_base_can_do_is_seen_in_space(engine: str, step: float, least: int):
    lanes, motions = shaken()
    settings = at_step(build_settings(engine, {}, "test"), step)
    # In the plane steps this long go astray; what came of it is judged as a run in space.
    response = run_batch(engine, lanes, motions, SampleTimes(5.0), settings=settings)
    absurd = beyond_the_base(lanes, response, 5.0)
    assert absurd.sum() >= least
    found = unstable_in_space(
        in_space(lanes), along(motions), 5.0, energy_lost=response["energy_lost"],
        peak_tilt=np.abs(response["peak_rotation"]), deepest=response["peak_penetration"],
    )  # fmt: skip
    assert np.all(found[absurd])


def test_a_step_of_a_tenth_of_a_second_goes_astray_in_space_and_says_so():
    lanes, motions = shaken()
    settings = at_step(build_settings("impulse", {}, "test"), 0.1)
    blocks, base = in_space(lanes), along(motions)
    response = run_batch("impulse", blocks, base, SampleTimes(5.0), settings=settings)
    usable = np.isin(response["status"], USABLE)
    assert np.any(response["status"] == Status.UNSTABLE)
    assert not np.any(usable & beyond_the_base(lanes, response, 5.0))


@pytest.mark.parametrize("engine", first(2, ["event", "impulse", "dem"]))
def test_no_sound_lane_on_a_base_that_moves_every_way_is_called_unstable(engine: str):
    lanes, motions = shaken()
    half = dataclasses.replace(
        motions, acceleration_amplitude=0.5 * motions.acceleration_amplitude,
        velocity_offset=0.5 * motions.velocity_offset,
        velocity_final=0.5 * motions.velocity_final,
    )  # fmt: skip
    base = SpatialMotions(motions, half, half)
    blocks = in_space(lanes, yaw_start=np.linspace(-1.0, 1.0, lanes.lane_count))
    response = run_batch(engine, blocks, base, SampleTimes(0.5 if engine == "dem" else 2.0))
    assert not np.any(response["status"] == Status.UNSTABLE)
