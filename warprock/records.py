"""Sampled strong-motion records: shipped ones by name, others from a CSV file.

A CSV file has a header of `# key: value` lines, then one sample a line:

    # unit: cm/s^2
    # interval: 0.01 s
    0.0213
    ...

`unit` says what the samples are: a unit of acceleration, velocity or displacement; `g` is the
acceleration of gravity of `warprock.units`. `name`, `source` and `licence` are optional, other
keys are left alone. A bare number without a unit is refused.

The record says which quantity of the base follows its samples. Between two samples

- an acceleration record is piecewise linear in acceleration,
- a velocity record is piecewise linear in velocity,
- a displacement record is a cubic spline of the displacement, twice continuously differentiable
  (not-a-knot ends).

The base rests before the first sample. After the last one it keeps its velocity under
acceleration control and stops otherwise; what the base velocity jumps by at the two ends are
velocity steps.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import hashlib
import importlib.resources
import math
import pathlib
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.case_keys import NOTHING, Said
from warprock.errors import InputError
from warprock.motion import Control, RecordMotions
from warprock.units import Dimension, parse_any, parse_quantity

Array = npt.NDArray[np.float64]

_CONTROL = {
    Dimension.ACCELERATION: Control.ACCELERATION,
    Dimension.VELOCITY: Control.VELOCITY,
    Dimension.LENGTH: Control.DISPLACEMENT,
}


@dataclasses.dataclass(frozen=True)
class _Pieces:
    """A record as pieces of linear acceleration, the layout of `RecordMotions`.

    Attributes:
        acceleration: Just after each sample [m/s^2], shape [sample]; zero at the last one.
        slope: Just after each sample [m/s^3], shape [sample]; zero at the last one.
        velocity: Just after each sample [m/s], shape [sample].
        step_start: Velocity step at the first sample [m/s].
        step_stop: Velocity step at the last sample [m/s].
    """

    acceleration: Array
    slope: Array
    velocity: Array
    step_start: float
    step_stop: float


@dataclasses.dataclass(frozen=True, eq=False)
class Record:
    """A sampled motion of the base in one direction.

    Attributes:
        name: Name of a shipped record, or of the file.
        file: File that it was read from.
        quantity: What the samples are.
        interval: Time between samples [s].
        samples: [m/s^2, m/s or m], shape [sample].
        sha256: Hash of the file's bytes.
        source: Where the record is from, as its file says.
        licence: As its file says.
    """

    name: str
    file: str
    quantity: Control
    interval: float
    samples: Array
    sha256: str
    source: str = ""
    licence: str = ""

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return self.interval * (len(self.samples) - 1)

    @property
    def acceleration(self) -> Array:
        """Acceleration of the base at the samples [m/s^2], shape [sample].

        Of a velocity or displacement record it is the one just after each sample, zero at the
        last sample, and leaves out the velocity steps at the ends.
        """
        if self.quantity is Control.ACCELERATION:
            return self.samples
        return self.pieces.acceleration

    @property
    def peak_acceleration(self) -> float:
        """Largest |acceleration| [m/s^2], velocity steps left out.

        The acceleration is linear between samples, so it is found at one end of a piece.
        """
        pieces = self.pieces
        ends = pieces.acceleration + pieces.slope * self.interval
        return float(max(np.max(np.abs(pieces.acceleration)), np.max(np.abs(ends))))

    @property
    def peak_velocity(self) -> float:
        """Largest |velocity| of the base at a sample [m/s]."""
        return float(np.max(np.abs(self.pieces.velocity)))

    @functools.cached_property
    def pieces(self) -> _Pieces:
        """The record as pieces of linear acceleration."""
        split = {
            Control.ACCELERATION: _acceleration_pieces,
            Control.VELOCITY: _velocity_pieces,
            Control.DISPLACEMENT: _displacement_pieces,
        }
        return split[self.quantity](self.samples, self.interval)


def _acceleration_pieces(samples: Array, interval: float) -> _Pieces:
    gained = 0.5 * interval * (samples[1:] + samples[:-1])
    return _Pieces(
        acceleration=np.append(samples[:-1], 0.0),
        slope=np.append(np.diff(samples) / interval, 0.0),
        velocity=np.append(0.0, np.cumsum(gained)),
        step_start=0.0,
        step_stop=0.0,
    )


def _velocity_pieces(samples: Array, interval: float) -> _Pieces:
    return _Pieces(
        acceleration=np.append(np.diff(samples) / interval, 0.0),
        slope=np.zeros_like(samples),
        velocity=np.append(samples[:-1], 0.0),
        step_start=float(samples[0]),
        step_stop=-float(samples[-1]),
    )


def _displacement_pieces(samples: Array, interval: float) -> _Pieces:
    from scipy.interpolate import CubicSpline

    times = interval * np.arange(len(samples))
    spline = CubicSpline(times, samples)
    velocity = np.asarray(spline(times, 1))
    return _Pieces(
        acceleration=np.append(2.0 * spline.c[1], 0.0),
        slope=np.append(6.0 * spline.c[0], 0.0),
        velocity=np.append(velocity[:-1], 0.0),
        step_start=float(velocity[0]),
        step_stop=-float(velocity[-1]),
    )


def _shipped() -> dict[str, pathlib.Path]:
    folder = importlib.resources.files("warprock.cases").joinpath("ground-motions")
    found = [pathlib.Path(str(file)) for file in folder.iterdir() if file.name.endswith(".csv")]
    return {file.stem: file for file in sorted(found)}


def record_names() -> list[str]:
    """Names of the shipped records."""
    return list(_shipped())


def load_record(name_or_path: str, relative_to: pathlib.Path | None = None) -> Record:
    """Reads a shipped record by its name, or any record from a CSV file.

    Args:
        name_or_path: Name of a shipped record or path of a CSV file.
        relative_to: Folder that a relative path starts from; the working folder by default.

    Raises:
        InputError: No such file; a missing or unknown unit or interval; a sample that is not a
            finite number; fewer than 2 samples.
    """
    shipped = _shipped()
    path = shipped.get(name_or_path)
    if path is None:
        path = pathlib.Path(name_or_path)
        path = path if relative_to is None else relative_to / path
    try:
        content = path.read_bytes()
    except OSError as error:
        near = difflib.get_close_matches(name_or_path, shipped, 1)
        hint = f"; did you mean {near[0]}?" if near else ""
        allowed = f"must be a CSV file or the name of a shipped record ({', '.join(shipped)}){hint}"
        reason = error.strerror or type(error).__name__
        raise InputError(str(path), "record", Said(reason.lower()), allowed) from None
    return _read(str(path), path.stem, content)


def _read(file: str, stem: str, content: bytes) -> Record:
    """A record from the bytes of its file."""
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        got = Said(f"byte {error.start}: not UTF-8")
        raise InputError(file, "", got, "must be a text file, one sample a line") from None
    first = next((at for at, line in enumerate(lines) if not line.startswith("#")), len(lines))
    entries = [line[1:].partition(":") for line in lines[:first] if ":" in line]
    head = {key.strip().lower(): value.strip() for key, _, value in entries}
    quantity, size = _unit(file, head)
    interval = _interval(file, head)
    samples = size * _samples(file, lines, first)
    samples.flags.writeable = False
    return Record(
        name=head.get("name", stem),
        file=file,
        quantity=quantity,
        interval=interval,
        samples=samples,
        sha256=hashlib.sha256(content).hexdigest(),
        source=head.get("source", ""),
        licence=head.get("licence", ""),
    )


def _unit(file: str, head: dict[str, str]) -> tuple[Control, float]:
    """What the samples are, and the size of their unit in SI units."""
    unit = head.get("unit", "")
    try:
        size, dimension = parse_any(f"1 {unit}", _CONTROL)
    except ValueError:
        examples = "m/s^2, cm/s^2, gal, g, m/s, cm/s, m, cm, mm"
        allowed = f"must be a line '# unit: UNIT' with UNIT such as {examples}"
        raise InputError(file, "unit", unit or NOTHING, allowed) from None
    return _CONTROL[dimension], size


def _interval(file: str, head: dict[str, str]) -> float:
    text = head.get("interval", "")
    allowed = "must be a line '# interval: TIME' with a TIME > 0 s and its unit, such as 0.01 s"
    try:
        interval = parse_quantity(text, Dimension.TIME)
    except ValueError:
        raise InputError(file, "interval", text or NOTHING, allowed) from None
    if interval <= 0.0:
        raise InputError(file, "interval", text, allowed)
    return interval


def _samples(file: str, lines: Sequence[str], first: int) -> Array:
    values = []
    for number, line in enumerate(lines[first:], first + 1):
        text = line.strip()
        if not text:
            continue
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(file, f"line {number}", text, "must be one finite number a line")
        values.append(value)
    if len(values) < 2:
        got = Said(f"{len(values)} samples")
        raise InputError(file, "samples", got, "must be at least 2 samples")
    return np.array(values)


def record_motions(
    records: Sequence[Record], *, index: npt.ArrayLike, scale: npt.ArrayLike, start: npt.ArrayLike
) -> RecordMotions:
    """Motions of lanes that follow records, each under the control of its own quantity.

    Args:
        records: The records; every one is stored once, however many lanes follow it.
        index: Record of each lane, shape [lane].
        scale: Factor on the motion, shape [lane] or one for all.
        start: Time at which the record starts [s], shape [lane] or one for all.
    """
    which = np.asarray(index, dtype=np.intp)
    pieces = [record.pieces for record in records]
    counts = np.array([len(piece.velocity) for piece in pieces])
    offsets = np.concatenate([[0], np.cumsum(counts)[:-1]])

    def lanes(values: npt.ArrayLike) -> Array:
        return np.broadcast_to(np.asarray(values, dtype=np.float64), which.shape).copy()

    return RecordMotions(
        start=lanes(start),
        scale=lanes(scale),
        offset=offsets[which].astype(np.int32),
        count=counts[which].astype(np.int32),
        interval=np.array([record.interval for record in records])[which],
        velocity_step_start=np.array([piece.step_start for piece in pieces])[which],
        velocity_step_stop=np.array([piece.step_stop for piece in pieces])[which],
        pool_acceleration=np.concatenate([piece.acceleration for piece in pieces]),
        pool_slope=np.concatenate([piece.slope for piece in pieces]),
        pool_velocity=np.concatenate([piece.velocity for piece in pieces]),
    )
