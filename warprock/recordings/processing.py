"""Processing of accelerations, step by step in the order given, and what its provenance says.

A step is a name and values with units, `bandpass 0.1 Hz, 25 Hz, 4`:

| step | does |
| --- | --- |
| `differentiate` | makes a displacement or a velocity an acceleration (see `merging`) |
| `merge CROSSOVER` | takes frequencies below CROSSOVER from a displacement beside it (see there) |
| `mean TIME` | subtracts the mean of the first TIME, the seconds before the event |
| `baseline DEGREE` | subtracts the slope of a polynomial fitted to the velocity, zero at first |
| `bandpass LOW, HIGH[, ORDER]` | Butterworth, forwards and backwards, no shift in time |
| `trim START, STOP` | keeps the samples from START to STOP |
| `taper RISE, FALL` | brings the displacement smoothly to zero at both ends |
| `resample INTERVAL` | another time between samples, with a filter below the lower Nyquist rate |

Cutting a record in its midst leaves the base moving there. A motion therefore carries the velocity
and the displacement of its first sample, and the taper acts on the displacement d with a window
w: the acceleration w a + 2 w' v + w'' d equals a where w is 1, and velocity and displacement are
zero at both ends.

References:
    D. M. Boore and J. J. Bommer (2005), Processing of strong-motion accelerograms, Soil Dynamics
    and Earthquake Engineering 25 (acausal filters, pads).
    V. M. Graizer (1979), Determination of the true ground displacement by using strong motion
    records, Izvestiya, Physics of the Solid Earth 15 (polynomial fitted to the velocity).
"""

from __future__ import annotations

import dataclasses
import fractions
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.errors import NOTHING, InputError, Said, did_you_mean
from warprock.model.motion import Control
from warprock.recordings.merging import DIFFERENTIATE, differentiate, merge
from warprock.recordings.merging import ORDER as MERGE_ORDER
from warprock.recordings.record import Record
from warprock.recordings.sampled import Sampled, pad_length, part, require_corners
from warprock.units import Dimension, format_quantity, parse_quantity

Array = npt.NDArray[np.float64]

ORDER = 4
"""Order of the band-pass in each of its two passes, where none is given."""

HIGHEST_ORDER = 10
"""Highest order of a band-pass, beyond which a narrow one loses its digits."""

HIGHEST_DEGREE = 20
"""Highest degree of a baseline, beyond which powers of the time are alike to round-off."""

LARGEST_RATIO = 1000
"""Largest whole number in the ratio of two times between samples."""


class Argument(NamedTuple):
    """A value of a step.

    Attributes:
        name: What it is.
        dimension: What it measures.
        default: Value without one; None if it must be given.
        whole: Whether it counts something.
        zero: Whether it may be zero.
    """

    name: str
    dimension: Dimension
    default: float | None = None
    whole: bool = False
    zero: bool = False


@dataclasses.dataclass(frozen=True)
class Step:
    """A step of processing, with its values.

    Attributes:
        name: Key of `STEPS`.
        values: In the order of the step's arguments, SI units.
    """

    name: str
    values: tuple[float, ...]

    @property
    def text(self) -> str:
        """The step as it is stated in the provenance."""
        arguments = STEPS[self.name].arguments
        shown = [
            format_quantity(value, argument.dimension)
            for value, argument in zip(self.values, arguments, strict=True)
        ]
        return STEPS[self.name].text.format(*shown)


class Kind(NamedTuple):
    """What a step does.

    Attributes:
        arguments: Its values.
        text: How it is stated, with a place for each value.
        apply: The motion after it.
    """

    arguments: tuple[Argument, ...]
    text: str
    apply: Callable[..., Sampled]


OPTION = "--step"


def parse_step(text: str) -> Step:
    """Reads a step such as "bandpass 0.1 Hz, 25 Hz, 4".

    Raises:
        InputError: No such step, or a value that is missing, too many, or not allowed.
    """
    name, _, rest = text.strip().partition(" ")
    if name not in STEPS:
        allowed = f"must be one of {', '.join(STEPS)}{did_you_mean(name, STEPS)}"
        raise InputError(OPTION, "", name or NOTHING, allowed)
    arguments = STEPS[name].arguments
    given = [part.strip() for part in rest.split(",")] if rest.strip() else []
    needed = sum(argument.default is None for argument in arguments)
    if not needed <= len(given) <= len(arguments):
        names = ", ".join(argument.name for argument in arguments)
        count = f"{needed}" if needed == len(arguments) else f"{needed} or {len(arguments)}"
        raise InputError(
            OPTION, name, rest.strip() or NOTHING, f"must have {count} values: {names}"
        )
    values = [
        _value(name, argument, part) for argument, part in zip(arguments, given, strict=False)
    ]
    values += [argument.default or 0.0 for argument in arguments[len(given) :]]
    return Step(name, tuple(values))


def _value(name: str, argument: Argument, part: str) -> float:
    """A value of a step."""
    key = f"{name}, {argument.name}"
    number: float | str = part
    if argument.dimension is Dimension.DIMENSIONLESS:
        try:
            number = float(part)
        except ValueError:
            number = math.nan
    try:
        value = parse_quantity(number, argument.dimension)
    except ValueError as error:
        raise InputError(OPTION, key, part or NOTHING, str(error)) from None
    if value < 0.0 or (value == 0.0 and not argument.zero):
        raise InputError(OPTION, key, part, f"must be {'>=' if argument.zero else '>'} 0")
    if argument.whole and value != round(value):
        raise InputError(OPTION, key, part, "must be a whole number")
    return value


def process(
    record: Record,
    steps: Sequence[Step],
    displacement: Record | None = None,
) -> tuple[Sampled, str]:
    """A record after some steps.

    Args:
        record: An acceleration record, or one whose first step is to differentiate it.
        steps: In order.
        displacement: What another instrument measured beside it, for the step `merge`.

    Returns:
        The motion, and what its provenance says: what the record's own said, and the steps.

    Raises:
        InputError: Not an acceleration, or a step that this record has no room for.
    """
    beside = None if displacement is None else _beside(record, displacement)
    motion = Sampled(record.samples, record.interval, quantity=record.quantity, beside=beside)
    if displacement is not None and not any(step.name == "merge" for step in steps):
        allowed = 'must be used by a step, such as "merge 1 Hz"'
        raise InputError("--displacement", "", displacement.name, allowed)
    for step in steps:
        given, wanted = motion.quantity is Control.ACCELERATION, step.name != DIFFERENTIATE
        if given is not wanted:
            allowed = f"must be used on an acceleration: {DIFFERENTIATE} it first"
            if not wanted:
                allowed = "must be used on a displacement or a velocity"
            raise InputError(OPTION, step.name, Said(f"a {motion.quantity} record"), allowed)
        try:
            motion = STEPS[step.name].apply(motion, *step.values)
        except ValueError as error:
            raise InputError(OPTION, step.name, step.text, str(error)) from None
    said = [record.processing, *(step.text for step in steps)]
    return motion, "; ".join(part for part in said if part)


def _beside(record: Record, displacement: Record) -> Array:
    """The samples of a displacement that was measured beside a record.

    Raises:
        InputError: It is no displacement.
    """
    if displacement.quantity is not Control.DISPLACEMENT:
        got = f"a {displacement.quantity} record"
        raise InputError("--displacement", "", got, "must be a displacement")
    return displacement.samples


def _mean(motion: Sampled, quiet: float) -> Sampled:
    count = round(quiet / motion.interval)
    if not 1 <= count <= len(motion.samples):
        raise ValueError(_inside(motion, "the time before the event"))
    return Sampled(motion.samples - np.mean(motion.samples[:count]), motion.interval)


def _baseline(motion: Sampled, degree: float) -> Sampled:
    if degree > HIGHEST_DEGREE:
        raise ValueError(f"must be of a degree up to {HIGHEST_DEGREE}")
    # Degree n of the velocity is degree n - 1 of the acceleration: of n = 1 a constant.
    velocity, _ = motion.integrals()
    x = np.linspace(0.0, 1.0, len(velocity))
    powers = np.arange(1, round(degree) + 1)
    fitted, *_ = np.linalg.lstsq(x[:, None] ** powers, velocity, rcond=None)
    length = motion.interval * (len(velocity) - 1)
    slope = (x[:, None] ** (powers - 1)) @ (fitted * powers) / length
    return Sampled(motion.samples - slope, motion.interval)


def _bandpass(motion: Sampled, low: float, high: float, order: float) -> Sampled:
    from scipy import signal

    require_corners(motion, low, high)
    if order > HIGHEST_ORDER:
        raise ValueError(f"must be of an order up to {HIGHEST_ORDER}")
    sections = signal.butter(
        round(order), [low, high], "bandpass", fs=1.0 / motion.interval, output="sos"
    )
    pad = np.zeros(pad_length(motion, low))
    filtered = signal.sosfiltfilt(sections, np.concatenate([pad, motion.samples, pad]))
    whole = Sampled(np.asarray(filtered), motion.interval)
    return part(whole, len(pad), len(pad) + len(motion.samples))


def _trim(motion: Sampled, start: float, stop: float) -> Sampled:
    first, last = round(start / motion.interval), round(stop / motion.interval)
    if not first < last < len(motion.samples):
        raise ValueError(_inside(motion, "its stop") + " and after its start")
    return part(motion, first, last + 1)


def _taper(motion: Sampled, rise: float, fall: float) -> Sampled:
    length = motion.interval * (len(motion.samples) - 1)
    if rise + fall > length:
        raise ValueError(f"must be at most {length:g} s long in all")
    velocity, displacement = motion.integrals()
    time = motion.interval * np.arange(len(motion.samples))
    window, slope, bend = np.ones_like(time), np.zeros_like(time), np.zeros_like(time)
    for distance, span, sign in ((time, rise, 1.0), (time[-1] - time, fall, -1.0)):
        inside = distance < span
        x = distance[inside] / span
        window[inside] = x**3 * (10.0 - 15.0 * x + 6.0 * x * x)
        slope[inside] = sign * 30.0 * x * x * (1.0 - x) ** 2 / span
        bend[inside] = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / span**2
    tapered = window * motion.samples + 2.0 * slope * velocity + bend * displacement
    return Sampled(tapered, motion.interval)


def _resample(motion: Sampled, interval: float) -> Sampled:
    from scipy import signal

    ratio = fractions.Fraction(motion.interval / interval).limit_denominator(LARGEST_RATIO)
    if ratio.numerator > LARGEST_RATIO or abs(float(ratio) * interval / motion.interval - 1) > 1e-9:
        allowed = f"must be to {motion.interval:g} s as whole numbers up to {LARGEST_RATIO}"
        raise ValueError(allowed)
    samples = signal.resample_poly(motion.samples, ratio.numerator, ratio.denominator)
    if len(samples) < 2:
        raise ValueError(_inside(motion, "the time between samples"))
    return dataclasses.replace(motion, samples=np.asarray(samples), interval=interval, beside=None)


def _inside(motion: Sampled, what: str) -> str:
    length = motion.interval * (len(motion.samples) - 1)
    return f"must have {what} within the record, {motion.interval:g} to {length:g} s"


_TIME, _RATE = Dimension.TIME, Dimension.FREQUENCY
STEPS: dict[str, Kind] = {
    "mean": Kind((Argument("TIME", _TIME),), "mean of the first {0} subtracted", _mean),
    "baseline": Kind(
        (Argument("DEGREE", Dimension.DIMENSIONLESS, whole=True),),
        "baseline: polynomial of degree {0} fitted to the velocity, its slope subtracted",
        _baseline,
    ),
    "bandpass": Kind(
        (
            Argument("LOW", _RATE),
            Argument("HIGH", _RATE),
            Argument("ORDER", Dimension.DIMENSIONLESS, default=float(ORDER), whole=True),
        ),
        "acausal Butterworth band-pass {0} to {1} (order {2}, forwards and backwards)",
        _bandpass,
    ),
    "trim": Kind(
        (Argument("START", _TIME, zero=True), Argument("STOP", _TIME)),
        "cut out from {0} to {1}",
        _trim,
    ),
    "taper": Kind(
        (Argument("RISE", _TIME, zero=True), Argument("FALL", _TIME, zero=True)),
        "displacement tapered over {0} and {1} at the ends",
        _taper,
    ),
    "resample": Kind((Argument("INTERVAL", _TIME),), "resampled to {0}", _resample),
    DIFFERENTIATE: Kind((), "differentiated as a cubic spline", differentiate),
    "merge": Kind(
        (Argument("CROSSOVER", _RATE),),
        "below {0} from the displacement (spline, differentiated twice), above from the "
        f"acceleration (acausal Butterworth low-pass of order {MERGE_ORDER} and its complement)",
        merge,
    ),
}
"""Steps by name."""
