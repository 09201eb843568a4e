"""Records by name, or from a file in any of the formats that are understood.

What a file begins with decides its format, not its name. A file with several channels needs one of
them named: `FILE#2`, or `FILE#N-S` by what the file calls its direction; of a table with
named columns, each column with a unit of motion is a channel.
"""

from __future__ import annotations

import difflib
import functools
import hashlib
import importlib.resources
import itertools
import os
import pathlib
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from warprock.errors import InputError, Said, list_allowed
from warprock.quantity import AMPLITUDE
from warprock.reading import read_bytes, reason
from warprock.recordings import column_file, csmip, esm, fema_p695, geonet, knet, peer, sample_file
from warprock.recordings.column_file import Reading
from warprock.recordings.record import CONTROL_OF, Record
from warprock.recordings.text_file import Channel, TextFile
from warprock.units import Dimension, parse_quantity


class Format(NamedTuple):
    """A format of files.

    Attributes:
        text: What it is called.
        recognises: Whether a file says that it is of this format.
        read: Its motions.
    """

    text: str
    recognises: Callable[[TextFile], bool]
    read: Callable[[TextFile], list[Channel]]


AS_WRITTEN = Reading()
"""A table read by what its header says alone."""

COLUMNS = "columns"
"""Name of the format of tables with named columns."""

FORMATS: dict[str, Format] = {
    "peer": Format("PEER .AT2, .VT2 and .DT2", peer.recognises, peer.read),
    "esm": Format("ESM, header DYNA 1.2", esm.recognises, esm.read),
    "knet": Format("K-NET and KiK-net ASCII", knet.recognises, knet.read),
    "geonet": Format("GeoNet V1A and V2A", geonet.recognises, geonet.read),
    "csmip": Format("CSMIP Volume 1 and 2", csmip.recognises, csmip.read),
    COLUMNS: Format(
        "a table with named columns such as time,acceleration_g",
        column_file.recognises,
        lambda text: column_file.read(text, [AS_WRITTEN])[0],
    ),
    "csv": Format("CSV with # unit and # interval", sample_file.recognises, sample_file.read),
}
"""Formats by name, in the order in which a file is tried."""

CHANNEL = "#"
"""What stands between a file and its channel."""

INTERVALS = ("1e-6 s", "1e5 s")
"""Least and greatest time between samples; a run is no longer than the greatest."""

SAMPLES_KEPT = 2**27
"""Samples that stay in memory, 1 GB, so that a sweep reads its records once and not for every
chunk: some 5,000 records of 30 s at 800 Hz. Beyond that the oldest files go."""


@functools.cache
def _shipped_files() -> dict[str, pathlib.Path]:
    folder = importlib.resources.files("warprock.cases").joinpath("ground-motions")
    found = [pathlib.Path(str(file)) for file in folder.iterdir() if file.name.endswith(".csv")]
    return {file.stem: file for file in sorted(found)}


def record_names() -> list[str]:
    """Names of the shipped records."""
    return list(_shipped_files())


def load_record(
    name_or_path: str, relative_to: pathlib.Path | None = None, asked: Reading = AS_WRITTEN
) -> Record:
    """Reads a record.

    Args:
        name_or_path: Name of a shipped record, `fema-p695/SET-NUMBER-COMPONENT`, or the path of a
            file, with `#CHANNEL` behind it where the file has several.
        relative_to: Folder that a relative path starts from; the working folder by default.
        asked: What is said of a table with named columns besides its header.

    Raises:
        InputError: No such file or channel; a header or a sample that cannot be used, named by
            its line; fewer than 2 samples.
    """
    return load_readings(name_or_path, [asked], relative_to)[0]


def load_readings(
    name_or_path: str, readings: Sequence[Reading], relative_to: pathlib.Path | None = None
) -> list[Record]:
    """Reads a record several ways, such as two columns of one table, whose text is parsed once.

    Args:
        name_or_path: As `load_record`.
        readings: What is said of it, a record each.
        relative_to: As `load_record`.

    Raises:
        InputError: As `load_record`.
    """
    if fema_p695.is_name(name_or_path):
        return [fema_p695.load(name_or_path)] * len(readings)
    path, channel = _place(name_or_path, relative_to)
    found = _records(path, name_or_path, readings)
    return [_choose(records, str(path), channel) for records in found]


def load_channels(name_or_path: str, asked: Reading = AS_WRITTEN) -> list[Record]:
    """Reads every channel of a file, or the one record of a name; arguments as of `load_record`.

    Raises:
        InputError: As `load_record`.
    """
    path, channel = _place(name_or_path, None)
    if channel or fema_p695.is_name(name_or_path) or not os.path.isfile(path):
        return [load_record(name_or_path, asked=asked)]
    return list(_records(path, name_or_path, [asked])[0])


def _place(name_or_path: str, relative_to: pathlib.Path | None) -> tuple[pathlib.Path, str]:
    """The file of a record, and the channel asked for; empty if none is."""
    shipped = _shipped_files().get(name_or_path)
    if shipped is not None:
        return shipped, ""
    folder = pathlib.Path() if relative_to is None else relative_to
    path = folder / name_or_path
    name, mark, channel = name_or_path.rpartition(CHANNEL)
    if mark and name and not os.path.exists(path):
        return folder / name, channel
    return path, ""


def _missing(path: pathlib.Path, name: str, error: OSError) -> InputError:
    if not isinstance(error, (FileNotFoundError, NotADirectoryError)):
        return InputError(str(path), "record", name, f"must be a file to read ({reason(error)})")
    shipped = _shipped_files()
    near = difflib.get_close_matches(name, shipped, 1)
    hint = f"; did you mean {near[0]}?" if near else ""
    allowed = (
        f"must be a file or the name of a shipped record ({list_allowed(name, shipped)}){hint}"
    )
    return InputError(str(path), "record", Said(reason(error)), allowed)


def record_of(file: str, content: bytes) -> Record:
    """The one record in the bytes of a file, as `load_record` of it gives.

    Raises:
        InputError: As `load_record`.
    """
    digest = hashlib.sha256(content).hexdigest()
    return _choose(_parse(file, digest, [AS_WRITTEN], content)[0], file, "")


def _records(
    path: pathlib.Path, name: str, readings: Sequence[Reading]
) -> list[tuple[Record, ...]]:
    """Every channel of a file by each reading; parsed again only if its bytes have changed."""
    try:
        content = read_bytes(path)
    except OSError as error:
        raise _missing(path, name, error) from None
    file, digest = str(path), hashlib.sha256(content).hexdigest()
    known = ((asked, (file, digest, asked)) for asked in readings)
    found = {asked: _kept[key] for asked, key in known if key in _kept}
    new = [asked for asked in readings if asked not in found]
    if new:
        for asked, records in zip(new, _parse(file, digest, new, content), strict=True):
            room = SAMPLES_KEPT - _sample_count(records)
            while _kept and sum(map(_sample_count, _kept.values())) > room:
                _kept.pop(next(iter(_kept)), None)
            found[asked] = _kept[file, digest, asked] = records
    return [found[asked] for asked in readings]


def _sample_count(records: Sequence[Record]) -> int:
    return sum(len(record.samples) for record in records)


_kept: dict[tuple[str, str, Reading], tuple[Record, ...]] = {}
"""Path and hash of a file, and what was said of it -> its records."""


def _parse(
    file: str, digest: str, readings: Sequence[Reading], content: bytes
) -> list[tuple[Record, ...]]:
    return [
        tuple(_make_records(file, digest, channels))
        for channels in read_channels(file, content, readings)
    ]


def _make_records(file: str, digest: str, channels: Sequence[Channel]) -> Iterator[Record]:
    stem = pathlib.Path(file).stem
    for number, channel in enumerate(channels, 1):
        channel.samples.flags.writeable = False
        own = stem if len(channels) == 1 else f"{stem}{CHANNEL}{number}"
        yield Record(
            name=channel.name or own,
            file=file,
            quantity=channel.quantity,
            interval=channel.interval,
            samples=channel.samples,
            sha256=digest,
            source=channel.source,
            licence=channel.licence,
            processing=channel.processing,
            original_sha256=channel.original_sha256,
            direction=channel.label,
        )


def _judge(file: str, channel: Channel) -> None:
    """Refuses what no base can do, as for a waveform: numbers beyond it would overflow in a run.

    Raises:
        InputError: Samples, or the time between them, out of bounds.
    """
    dimension = next(d for d, control in CONTROL_OF.items() if control is channel.quantity)
    least, most = (parse_quantity(end, Dimension.TIME) for end in INTERVALS)
    if not least <= channel.interval <= most:
        got = Said(f"{channel.interval:g} s")
        allowed = f"must be from {INTERVALS[0]} to {INTERVALS[1]} between samples"
        raise InputError(file, "interval", got, allowed)
    low, high = AMPLITUDE.bounds[dimension]
    bad = ~(np.abs(channel.samples) <= parse_quantity(high, dimension))
    if bad.any():
        at = int(np.argmax(bad))
        unit = high.split()[1]
        got = Said(f"{channel.samples[at]:g} {unit} (sample {at})")
        raise InputError(file, "samples", got, f"must be from {low} to {high}")


def read_channels(
    file: str, content: bytes, readings: Sequence[Reading] = (AS_WRITTEN,)
) -> list[list[Channel]]:
    """The motions in the bytes of a file, a list of them by each reading.

    Args:
        file: Its path, for errors.
        content: Its bytes.
        readings: What is said of it, as of `load_record`.

    Raises:
        InputError: Not a text file, of no format that is understood, or one that cannot be used.
    """
    try:
        lines, wrong = content.decode("utf-8-sig").splitlines(), None
    except UnicodeDecodeError as error:
        lines, wrong = content.decode("latin-1").splitlines(), error.start
    text = TextFile(file, lines)
    for name, form in FORMATS.items():
        # Networks write names in other encodings than UTF-8, and nothing else in them.
        if form.recognises(text) and (wrong is None or name not in ("csv", COLUMNS)):
            with np.errstate(over="ignore"):
                found = _read_format(name, text, readings)
            for channel in itertools.chain(*found):
                _judge(file, channel)
            return found
    if wrong is not None:
        got = Said(f"byte {wrong}: not UTF-8")
        raise InputError(file, "", got, "must be a text file, one sample a line")
    formats = "; ".join(form.text for form in FORMATS.values())
    raise text.refusal(0, f"must begin a file of a known format ({formats})")


def _read_format(name: str, text: TextFile, readings: Sequence[Reading]) -> list[list[Channel]]:
    """The motions of a file of a format, by each reading.

    Raises:
        InputError: As the format, and what only tables with named columns have was asked for.
    """
    if name == COLUMNS:
        return column_file.read(text, readings)
    for option, got in itertools.chain(*(asked._asdict().items() for asked in readings)):
        if got is not None:
            allowed = f"must be left out: {text.file} is no table with named columns and says it"
            raise InputError(f"--{option}", "", got, allowed)
    return [FORMATS[name].read(text)] * len(readings)


def _choose(records: Sequence[Record], file: str, channel: str) -> Record:
    """The channel asked for.

    Raises:
        InputError: No such channel, or none was asked for and there are several.
    """
    if not channel and len(records) == 1:
        return records[0]
    for number, record in enumerate(records, 1):
        if channel.strip().casefold() in (str(number), record.direction.casefold() or None):
            return record
    known = ", ".join(f"{number} ({record.direction})" for number, record in enumerate(records, 1))
    got = Said(f"channel {channel}" if channel else f"{len(records)} channels")
    raise InputError(file, "record", got, f"must be followed by {CHANNEL} and a channel: {known}")
