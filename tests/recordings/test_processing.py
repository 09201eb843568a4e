"""Processing of records: every step does what it says and says what it did."""

import numpy as np
import pytest

from warprock.errors import InputError
from warprock.model.motion import Control
from warprock.recordings import Record
from warprock.recordings.processing import Step, parse_step, process
from warprock.recordings.sampled import Sampled
from warprock.recordings.stochastic import (
    GroundNoise,
    envelope,
    spectrum,
    stationary,
    stochastic_motion,
)

INTERVAL = 0.01
TIME = INTERVAL * np.arange(4001)


def record(samples: np.ndarray, quantity: Control = Control.ACCELERATION) -> Record:
    return Record("made", "made", quantity, INTERVAL, samples, "", processing="raw")


def after(samples: np.ndarray, *steps: str) -> Sampled:
    return process(record(samples), [parse_step(step) for step in steps])[0]


def test_steps_are_done_and_stated_in_the_order_given() -> None:
    steps = ["mean 5 s", "bandpass 0.1 Hz, 20 Hz, 2", "trim 0.5 s, 30 s", "resample 20 ms"]
    motion, said = process(record(np.sin(TIME)), [parse_step(step) for step in steps])
    assert said == (
        "raw; mean of the first 5 s subtracted; acausal Butterworth band-pass 0.1 Hz to 20 Hz "
        "(order 2, forwards and backwards); cut out from 0.5 s to 30 s; resampled to 0.02 s"
    )
    assert motion.interval == 0.02
    assert len(motion.samples) == 1476
    # The mean of a sine that was trimmed first is another one.
    one, other = (
        after(np.sin(TIME), "mean 1 s", "trim 2 s, 9 s"),
        after(np.sin(TIME), "trim 2 s, 9 s", "mean 1 s"),
    )
    assert one.samples[0] - other.samples[0] == pytest.approx(
        np.mean(np.sin(TIME[200:300])) - np.mean(np.sin(TIME[:100]))
    )


def test_the_mean_before_the_event_is_taken_off() -> None:
    samples = 0.3 + np.where(TIME < 10.0, 0.0, np.sin(TIME))
    assert after(samples, "mean 10 s").samples == pytest.approx(samples - 0.3, abs=1e-14)


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_the_baseline_of_a_polynomial_is_all_of_it(degree: int) -> None:
    """The trapezoidal rule adds step^2 t / 2 to the integral of 3 t^2, and less below that."""
    samples = degree * TIME ** (degree - 1)
    left = after(samples, f"baseline {degree}").samples
    assert np.max(np.abs(left)) < 0.51 * INTERVAL**2


def test_the_band_pass_keeps_the_band_and_shifts_nothing() -> None:
    bell = np.exp(-(((TIME - 20.0) / 5.0) ** 2))
    for frequency in (0.5, 2.0, 5.0):
        wave = bell * np.sin(2.0 * np.pi * frequency * TIME)
        # 1 / (1 + (0.1 / 0.35)^8) = 1 - 5e-5 at the lower edge of what a bell of 5 s spreads to;
        # (5 / 25)^8 at the upper corner is less.
        assert after(wave, "bandpass 0.1 Hz, 25 Hz").samples == pytest.approx(wave, abs=1e-4)
    for frequency in (0.02, 40.0):
        wave = bell * np.sin(2.0 * np.pi * frequency * TIME)
        # (0.11 / 0.4)^8 at the upper edge, and (20 / 40)^8 = 4e-3 without the warp that adds to it.
        kept = after(wave, "bandpass 0.4 Hz, 20 Hz").samples
        assert np.max(np.abs(kept)) < 5e-3


def test_a_cut_motion_goes_on_as_it_was_and_a_taper_brings_it_to_rest() -> None:
    samples = np.sin(0.7 * TIME) * np.exp(-(((TIME - 20.0) / 6.0) ** 2))
    velocity, displacement = Sampled(samples, INTERVAL).integrals()
    cut = after(samples, "trim 15 s, 28 s")
    assert cut.samples == pytest.approx(samples[1500:2801])
    assert cut.velocity == velocity[1500]
    later, further = cut.integrals()
    assert later == pytest.approx(velocity[1500:2801])
    assert further == pytest.approx(displacement[1500:2801])
    tapered = after(samples, "trim 15 s, 28 s", "taper 2 s, 3 s")
    middle = slice(201, 1000)
    assert tapered.samples[middle] == pytest.approx(cut.samples[middle], abs=1e-15)
    stopped, place = tapered.integrals()
    # The trapezoidal rule, step^2 / 12 x the largest second derivative of the taper (60 d / s^4).
    assert abs(stopped[-1]) < 1e-4 * np.max(np.abs(stopped))
    assert abs(place[-1]) < 1e-3 * np.max(np.abs(place))
    # In between, the displacement is what it was, but for round-off and the same rule.
    assert place[middle] == pytest.approx(further[middle], abs=1e-3 * np.max(np.abs(further)))


@pytest.mark.parametrize("interval", ["5 ms", "20 ms", "12.5 ms"])
def test_a_slow_wave_is_the_same_at_another_interval(interval: str) -> None:
    wave = np.sin(2.0 * np.pi * TIME) * np.exp(-(((TIME - 20.0) / 6.0) ** 2))
    motion = after(wave, f"resample {interval}")
    time = motion.interval * np.arange(len(motion.samples))
    wanted = np.sin(2.0 * np.pi * time) * np.exp(-(((time - 20.0) / 6.0) ** 2))
    # The ripple of the filter's pass band.
    assert motion.samples == pytest.approx(wanted, abs=2e-3)


@pytest.mark.parametrize(
    ("step", "said"),
    [
        ("", "--step: got nothing, must be one of mean, baseline"),
        ("tapir 1 s, 2 s", "did you mean taper?"),
        ("mean", "--step: mean: got nothing, must have 1 values: TIME"),
        ("trim 1 s", "--step: trim: got '1 s', must have 2 values: START, STOP"),
        ("bandpass 1 Hz", "must have 2 or 3 values: LOW, HIGH, ORDER"),
        ("mean 20", "--step: mean, TIME: got '20', must be a time with a unit"),
        ("mean -2 s", "--step: mean, TIME: got '-2 s', must be > 0"),
        ("baseline 1.5", "--step: baseline, DEGREE: got '1.5', must be a whole number"),
        ("baseline one", "--step: baseline, DEGREE: got 'one', must be a number"),
    ],
)
def test_a_step_that_is_none_is_refused(step: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_step(step)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("step", "said"),
    [
        ("mean 41 s", "must have the time before the event within the record, 0.01 to 40 s"),
        ("bandpass 2 Hz, 1 Hz", "must have its corners in order between"),
        ("bandpass 1 Hz, 50 Hz", "and 50 Hz"),
        ("bandpass 1e-6 Hz, 1 Hz", "must have its corners in order between 0.00075 and 50 Hz"),
        ("bandpass 1 Hz, 2 Hz, 11", "must be of an order up to 10"),
        ("baseline 21", "must be of a degree up to 20"),
        ("trim 5 s, 5 s", "must have its stop within the record"),
        ("trim 5 s, 41 s", "must have its stop within the record"),
        ("taper 30 s, 11 s", "must be at most 40 s long in all"),
        ("resample 10.00001 ms", "as whole numbers up to 1000"),
        ("resample 0.001 ms", "as whole numbers up to 1000"),
    ],
)
def test_a_step_without_room_is_refused(step: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        after(np.sin(TIME), step)
    assert said in str(caught.value)


def test_only_accelerations_are_processed() -> None:
    with pytest.raises(InputError, match="must be used on an acceleration"):
        process(record(np.sin(TIME), Control.VELOCITY), [Step("mean", (1.0,))])


def test_a_seed_is_a_motion_and_it_ends_at_rest() -> None:
    motion = stochastic_motion(GroundNoise(seed=7, peak=3.0))
    again = stochastic_motion(GroundNoise(seed=7, peak=3.0))
    other = stochastic_motion(GroundNoise(seed=8, peak=3.0))
    assert motion.samples.tobytes() == again.samples.tobytes()
    assert abs(np.corrcoef(motion.samples, other.samples)[0, 1]) < 0.5
    assert np.max(np.abs(motion.samples)) == pytest.approx(3.0)
    velocity, displacement = motion.integrals()
    assert abs(velocity[-1]) < 1e-12 * np.max(np.abs(velocity)) * len(velocity)
    assert abs(displacement[-1]) < 1e-12 * np.max(np.abs(displacement)) * len(displacement)


def test_noise_has_the_spectrum_of_kanai_and_tajimi() -> None:
    """The mean of 4000 lines a band errs by 1 / sqrt(4000) = 1.6 % of itself: four times that."""
    noise = GroundNoise(seed=1, peak=1.0, duration=400.0)
    count = round(noise.duration / noise.interval) + 1
    lines = np.abs(np.fft.rfft(stationary(noise, count))) ** 2
    frequency = np.fft.rfftfreq(count, noise.interval)
    bands = np.arange(1, 20001).reshape(5, 4000)
    found = lines[bands].mean(axis=1)
    wanted = 2.0 * spectrum(noise, frequency[bands]).mean(axis=1)
    assert found == pytest.approx(wanted, rel=0.064)
    # A layer of ground carries the rock's slow motion, and at its own frequency
    # (1 + 4 z^2) / (4 z^2) of it; the second filter takes off what is slower still.
    z = noise.damping
    slow, own = spectrum(noise, np.array([1e-3, noise.frequency]))
    assert slow < 1e-6
    assert own == pytest.approx((1.0 + 4.0 * z**2) / (4.0 * z**2), rel=0.02)


def test_the_envelope_rises_stays_and_falls() -> None:
    assert envelope(np.array([0.0, 0.075, 0.15, 0.3, 0.5, 1.0])) == pytest.approx(
        [0.0, 0.25, 1.0, 1.0, 1.0, 0.05]
    )


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"seed": -1}, "--seed: got -1, must be >= 0"),
        ({"peak": 0.0}, "--peak: got 0.0, must be above 0"),
        ({"damping": 0.0}, "--damping: got 0.0, must be above 0"),
        ({"duration": 0.5}, "--duration: got 0.5, must be from 100 to 1e7 times the interval"),
        ({"frequency": 60.0}, "--frequency: got 60.0, must be from 1 / duration"),
    ],
)
def test_noise_out_of_bounds_is_refused(changed: dict[str, float], said: str) -> None:
    with pytest.raises(InputError) as caught:
        GroundNoise(**({"seed": 1, "peak": 1.0} | changed))  # type: ignore[arg-type]
    assert said in str(caught.value)
