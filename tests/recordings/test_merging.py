"""Differentiated records, and two instruments made one, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.errors import InputError
from warprock.model.motion import Control
from warprock.recordings import Record
from warprock.recordings.merging import ORDER
from warprock.recordings.processing import parse_step, process

INTERVAL = 0.005
TIME = INTERVAL * np.arange(12001)
CROSSOVER = 2.0


def record(samples, quantity):
    return Record("made", "made", quantity, INTERVAL, np.asarray(samples), "0")


def after(samples, *steps, quantity=Control.ACCELERATION, beside=None):
    displacement = None if beside is None else record(beside, Control.DISPLACEMENT)
    done = tuple(map(parse_step, steps))
    return process(record(samples, quantity), done, displacement=displacement)


def share_below(frequency):
    """What the digital filters take of the displacement: the tangent warps their frequencies."""
    of, corner = (np.tan(np.pi * f * INTERVAL) for f in (frequency, CROSSOVER))
    return 1.0 / (1.0 + (of / corner) ** (2 * ORDER))


@pytest.mark.parametrize("frequency", [0.5, 1.5, 2.0, 2.5, 8.0])
def test_each_instrument_has_its_share_and_neither_shifts_in_time(frequency):
    rate = 2.0 * np.pi * frequency
    # Two instruments that disagree: the acceleration reads 1.3 times, with a drift.
    wave = np.sin(rate * TIME)
    motion, _ = after(1.3 * wave + 0.2, f"merge {CROSSOVER} Hz", beside=-wave / rate**2 + 0.05)
    below = share_below(frequency)
    middle = slice(3000, 9001)
    # The spline's second derivative of a sine is (rate h)^2 / 12 off; the filter has long settled.
    expected = (1.3 * (1.0 - below) + below) * wave
    bound = below * (rate * INTERVAL) ** 2 / 10.0 + 1e-6
    assert motion.samples[middle] == pytest.approx(expected[middle], abs=bound)


def test_two_instruments_that_agree_pass_unchanged():
    bell = np.exp(-(((TIME - 30.0) / 5.0) ** 2))
    place = 0.1 * bell * np.sin(2.0 * np.pi * TIME)
    acceleration = after(place, "differentiate", quantity=Control.DISPLACEMENT)[0].samples
    merged, said = after(acceleration, f"merge {CROSSOVER} Hz", beside=place)
    # Round-off of the filtered displacement, some 1e-14 m, times 4 / h^2 = 1.6e5 / s^2.
    assert merged.samples == pytest.approx(acceleration, abs=2e-9)
    assert said.startswith("below 2 Hz from the displacement")


@pytest.mark.parametrize(
    ("quantity", "of", "order"),
    [(Control.DISPLACEMENT, -1.0 / 9.0, 2), (Control.VELOCITY, 1.0 / 3.0, 4)],
)
def test_differentiation_has_the_order_of_a_spline(quantity, of, order):
    errors = []
    for factor in (1, 2):
        times = TIME[::factor]
        wave = np.sin if quantity is Control.DISPLACEMENT else lambda x: -np.cos(x)
        samples = Record("", "", quantity, factor * INTERVAL, of * wave(3.0 * times), "0")
        motion, said = process(samples, [parse_step("differentiate")])
        assert said == "differentiated as a cubic spline"
        wrong = motion.samples - np.sin(3.0 * times)
        errors.append(np.max(np.abs(wrong[20:-20])))
        assert motion.velocity == pytest.approx(-1.0 / 3.0, rel=1e-4)
    # Of a velocity the first derivative of a spline is of order 4 at evenly spaced knots.
    assert errors[1] / errors[0] >= 0.9 * 2.0**order


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((TIME, "merge 2 Hz"), "merge: got .* must be the first step, with --displacement"),
        ((TIME, "mean 1 s", "merge 2 Hz"), "must be the first step"),
        ((TIME, "differentiate"), "must be used on a displacement or a velocity"),
    ],
)
def test_a_step_out_of_place_is_refused(arguments, said):
    with pytest.raises(InputError, match=said):
        after(*arguments)


def test_what_stands_beside_is_used_and_is_a_displacement():
    with pytest.raises(InputError, match=r'--displacement: .* must be used by a step, such as "'):
        after(TIME, "mean 1 s", beside=TIME)
    with pytest.raises(InputError, match=r"merge: .* must have its corners in order between"):
        after(TIME, "merge 100 Hz", beside=TIME)
    with pytest.raises(InputError, match="must be used on an acceleration: differentiate it first"):
        after(TIME, "mean 1 s", quantity=Control.VELOCITY)
    wrong = record(TIME, Control.VELOCITY)
    with pytest.raises(InputError, match="got 'a velocity record', must be a displacement"):
        process(record(TIME, Control.ACCELERATION), [parse_step("merge 1 Hz")], displacement=wrong)
