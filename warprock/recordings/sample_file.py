"""CSV files with a stated unit: a header of `# key: value` lines, then one sample a line.

    # unit: cm/s^2
    # interval: 0.01 s
    0.0213
    ...

`unit` says what the samples are: a unit of acceleration, velocity or displacement; `g` is the
acceleration of gravity of `warprock.units`. A bare number without a unit is refused. `name`,
`source`, `licence`, `processing` and `original-sha256` are optional, other keys are left alone.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from warprock.errors import NOTHING, InputError, Said
from warprock.model.motion import Control
from warprock.recordings.record import CONTROL_OF
from warprock.recordings.rows import plain_column
from warprock.recordings.text_file import Channel, TextFile
from warprock.units import Dimension, parse_any, parse_quantity

Array = npt.NDArray[np.float64]

KEYS = (
    "unit",
    "interval",
    "name",
    "source",
    "licence",
    "processing",
    "original-sha256",
    "raw-sha256",
)
"""Keys of the header that are read."""


def recognises(text: TextFile) -> bool:
    """Whether a file begins as one of these does: with a # line or with a number."""
    first = next((line.strip() for line in text.lines if line.strip()), "")
    try:
        float(first.split(",")[0] or "0")
    except ValueError:
        return first.startswith("#")
    return True


def read(text: TextFile) -> list[Channel]:
    """The motion of a file.

    Raises:
        InputError: A missing or unknown unit or interval; a sample that is not a finite number;
            fewer than 2 samples.
    """
    lines = text.lines
    first = next((at for at, line in enumerate(lines) if not line.startswith("#")), len(lines))
    head: dict[str, str] = {}
    for at, line in enumerate(lines[:first]):
        key, colon, value = line[1:].partition(":")
        key = key.strip().lower()
        if colon and key in head and key in KEYS:
            raise text.refusal(at, f"must not give {key} a second time")
        if colon:
            head[key] = value.strip()
    quantity, size = _unit(text.file, head)
    return [
        Channel(
            label="",
            quantity=quantity,
            interval=_interval(text.file, head),
            samples=size * _samples(text, first),
            source=head.get("source", ""),
            processing=head.get("processing", ""),
            name=head.get("name", ""),
            licence=head.get("licence", ""),
            original_sha256=head.get("original-sha256", head.get("raw-sha256", "")),
        )
    ]


def csv_text(entries: Mapping[str, str], samples: Array) -> str:
    """The text of a CSV file.

    Args:
        entries: The header by key; `unit` and `interval` are among them.
        samples: In that unit, shape [sample]; eight significant digits are written.
    """
    head = "".join(f"# {key}: {' '.join(value.split())}\n" for key, value in entries.items())
    # + 0.0 makes -0 a 0
    return head + ("%.8g\n" * len(samples)) % tuple((samples + 0.0).tolist())


def _unit(file: str, head: dict[str, str]) -> tuple[Control, float]:
    """What the samples are, and the size of their unit in SI units."""
    unit = head.get("unit", "")
    try:
        size, dimension = parse_any(f"1 {unit}", CONTROL_OF)
    except ValueError:
        examples = "m/s^2, cm/s^2, gal, g, m/s, cm/s, m, cm, mm"
        allowed = f"must be a line '# unit: UNIT' with UNIT such as {examples}"
        raise InputError(file, "unit", unit or NOTHING, allowed) from None
    return CONTROL_OF[dimension], size


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


def _samples(text: TextFile, first: int) -> Array:
    plain = plain_column(text.lines[first:])
    if plain is not None and len(plain) > 1:
        return plain
    values = []
    for at, line in enumerate(text.lines[first:], first):
        if line.strip():
            values.append(text.number(at, line, "must be one finite number a line"))
    if len(values) < 2:
        got = Said(f"{len(values)} samples")
        raise InputError(text.file, "samples", got, "must be at least 2 samples")
    return np.array(values)
