"""What every motion of a base says of itself: whether it moves, until when, how fast, how far."""

import itertools

import numpy as np
import pytest

from tests.shared.blocks import sines
from tests.shared.kinds import record
from warprock.model.motion import (
    Control,
    PlanarMotions,
    SpatialMotions,
    StillBase,
    mavroeidis_papageorgiou_motions,
    no_motion,
    ricker_motions,
)

AMPLITUDE = np.array([0.3, -0.2, 0.0])
WAVEFORMS = ("sine", "ricker", "mavroeidis-papageorgiou", "record")


def motions_of(waveform: str, control: Control) -> PlanarMotions:
    """Three lanes: one way, the other way, and an amplitude of zero."""
    ones = np.ones(3)
    if waveform == "sine":
        return sines(control, AMPLITUDE, 2.0, cycles=1.5)
    if waveform == "ricker":
        return ricker_motions([control] * 3, AMPLITUDE, 2.0 * ones, 0.1 * ones)
    if waveform == "record":
        return record(AMPLITUDE)
    return mavroeidis_papageorgiou_motions(
        [control] * 3, AMPLITUDE, 2.0 * ones, 0.1 * ones, cycles=2.0 * ones, phase=0.3 * ones
    )


ALL = [
    pytest.param(motions_of(waveform, control), id=f"{waveform}-{control}")
    for waveform, control in itertools.product(WAVEFORMS, Control)
    if waveform != "record" or control is Control.ACCELERATION
]


@pytest.mark.parametrize("motions", ALL)
def test_a_base_moves_where_its_amplitude_is_not_zero(motions: PlanarMotions):
    # `dem` in space leaves out directions that do not move.
    np.testing.assert_array_equal(motions.moves, [True, True, False])
    np.testing.assert_array_equal(motions.end > 0.0, [True, True, False])
    assert not no_motion(motions).moves.any()
    np.testing.assert_array_equal(no_motion(motions).acceleration_bound(), 0.0)


@pytest.mark.parametrize("motions", ALL)
def test_bounds_hold_on_samples(motions: PlanarMotions):
    times = np.linspace(0.0, 3.0, 40_001)
    bound = motions.acceleration_bound()
    for lane in range(3):
        size = np.abs(motions.acceleration(times, lane))
        # The peaks of Ricker's humps are found on a grid, to 1e-6.
        assert size.max() <= bound[lane] * (1.0 + 1e-6)
        after = size[times > 0.3].max(initial=0.0)
        assert after <= motions.later_acceleration(0.3)[lane] * (1.0 + 1e-6)
    assert np.all(motions.later_acceleration(motions.end.max()) == 0.0)


@pytest.mark.parametrize("motions", ALL)
def test_twice_the_motion_is_twice_as_strong(motions: PlanarMotions):
    twice = motions.scaled(np.full(3, 2.0))
    for each in (lambda m: m.acceleration_bound(), lambda m: m.velocity_variation(1.0)):
        np.testing.assert_allclose(each(twice), 2.0 * each(motions), rtol=1e-14)
    for steps, doubled in zip(motions.velocity_steps, twice.velocity_steps, strict=True):
        np.testing.assert_allclose(doubled, 2.0 * steps, rtol=1e-14)


def test_all_directions_together():
    x, still = record(AMPLITUDE), StillBase(3)
    both = SpatialMotions(x, record(2.0 * AMPLITUDE, interval=0.01), no_motion(x))
    assert both.knot_count.tolist() == [163, 163, 163]
    np.testing.assert_array_equal(both.knot_interval, 0.01)
    np.testing.assert_array_equal(both.end > 0.0, [True, True, False])
    none = SpatialMotions(still, still, still)
    assert none.knot_count == 0
    assert np.isinf(none.knot_interval)
