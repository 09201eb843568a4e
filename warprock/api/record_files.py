"""Records that are written: files made ready for a case, and stochastic motions."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Sequence
from typing import Unpack

from warprock.analysis.groups import read_weights, weight_of
from warprock.api.looked_up import LookedUp
from warprock.api.names import python_names
from warprock.api.records import ReadingAsked, reading_of, records, require_positive
from warprock.api.values import Acceleration, Column, Frequency, Time
from warprock.arguments import at_the_door, listing, several
from warprock.errors import InputError, list_allowed
from warprock.findings.records import find_imported
from warprock.recordings.importing import (
    Importing,
    convert_file,
    displacement_reading,
    found_files,
    import_files,
    require_one_name,
    weighted_table,
)
from warprock.recordings.processing import parse_step
from warprock.recordings.stochastic import GroundNoise
from warprock.recordings.writing import format_generated
from warprock.running.files import replacing, require_writable, require_writable_file
from warprock.running.machine import core_count, require_workers
from warprock.tables.records import print_imported


@listing(reading_of)
@at_the_door
def import_records(
    files: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    steps: str | Sequence[str] = (),
    displacement: Column | None = None,
    name: str | None = None,
    source: str | None = None,
    licence: str | None = None,
    weights: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    **asked: Unpack[ReadingAsked],
) -> LookedUp:
    """Turn files of records into CSV files with stated unit, source, licence and processing.

    Several files, a pattern ("raw/T???.txt") or a folder are written to a folder, each under its
    own name; one file becomes one file.

    Args:
        files: A file, as in `records`, a pattern or a folder; or several.
        output: CSV file to write; of several, a folder.
        steps: Processing, in order: "mean TIME", "baseline DEGREE", "bandpass LOW, HIGH[, ORDER]",
            "trim START, STOP", "taper RISE, FALL", "resample INTERVAL", "differentiate" (a velocity
            or a displacement), "merge CROSSOVER".
        displacement: Of a table: column of the displacement for "merge", and its unit, or a number
            of them: "6, 0.5 mm".
        name: Name of the record; that of the output file without one.
        source: Where the record is from.
        licence: Its licence.
        weights: Weights of several: a CSV file with the columns record and weight. OUTPUT.csv is
            then a table for a sweep over them.
        workers: Processes that share several files; all cores without.
        **asked: column, unit and interval, as in `records`.

    Returns:
        A `Found` whose table has one row a record; of one file what it holds, as `records` has it.

    Raises:
        InputError: A file cannot be read or written, a step cannot be done, or a weight is missing.

    Example:
        >>> import pathlib, tempfile
        >>> import warprock as wr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     mine = pathlib.Path(folder, "mine.csv")
        ...     found = wr.import_records("ridgecrest-2019-ccc-090", mine, steps="trim 5 s, 40 s")
        >>> found.table["duration_s"].tolist()
        [35.0]
    """
    reading = reading_of(**asked)
    named = [files] if isinstance(files, str | os.PathLike) else files
    names = [os.fspath(each) for each in named]
    with python_names():
        require_workers(workers)
        beside = None if displacement is None else displacement_reading(displacement, reading)
        made = tuple(map(parse_step, several(steps)))
        how = Importing(reading, beside, made, source or "", licence or "")
        found = found_files(names)
        if found == names and len(found) == 1:
            if weights is not None:
                allowed = "must be left out for one record: weights tell several apart"
                raise InputError("--weights", "", os.fspath(weights), allowed)
            path = pathlib.Path(output)
            _write(path, convert_file(found[0], how, name or path.stem))
            return records(path)
        require_one_name(name, len(found))
        return _import_several(found, pathlib.Path(output), how, weights, workers)


def _import_several(
    files: list[str],
    folder: pathlib.Path,
    how: Importing,
    weights: str | os.PathLike[str] | None,
    workers: int | None,
) -> LookedUp:
    """Writes several records to a folder, and the table of a sweep where they have weights."""
    require_writable(folder)
    told = None if weights is None else _weights(files, pathlib.Path(weights))
    rows = import_files(files, how, folder, workers or core_count())
    table = None
    if told is not None:
        table = folder.with_name(f"{folder.name}.csv")
        with replacing(table) as place:
            place.write_text(weighted_table(rows, told), encoding="utf-8")
    find = functools.partial(find_imported, rows, folder, table, print_imported)
    return LookedUp(str(folder), rows, find)


def _weights(files: list[str], source: pathlib.Path) -> list[float]:
    """The weight of each file; refuses a file without one, and one without a file."""
    weights = read_weights(source)
    found = []
    for name in files:
        weight = weight_of(name, weights)
        if weight is None:
            known = list_allowed(name, weights)
            allowed = f"must have a weight; these have one: {known}"
            raise InputError(str(source), "record", name, allowed)
        found.append(weight)
    for name in weights:
        if weight_of(name, dict.fromkeys(files, 1.0)) is None:
            allowed = f"must be a file that is imported: {list_allowed(name, files)}"
            raise InputError(str(source), "record", name, allowed)
    return found


@at_the_door
def generate_record(
    output: str | os.PathLike[str],
    *,
    seed: int,
    peak: Acceleration,
    duration: Time = "20 s",
    frequency: Frequency = "2.5 Hz",
    damping: float = 0.6,
    interval: Time = "10 ms",
) -> LookedUp:
    """Write a stochastic motion: Kanai-Tajimi noise under an envelope, scaled to a peak.

    Args:
        output: CSV file to write.
        seed: Same seed, same motion.
        peak: Its peak acceleration.
        duration: From its first to its last sample.
        frequency: Of the ground.
        damping: Of the ground.
        interval: Time between samples.

    Returns:
        A `Found` with what the record holds, as `records` has it.

    Raises:
        InputError: A number out of bounds, or the file cannot be written.

    Example:
        >>> import pathlib, tempfile
        >>> import warprock as wr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     found = wr.generate_record(pathlib.Path(folder, "noise.csv"), seed=7, peak="0.3 g")
        >>> found.table["pga_m_s2"].round(3).tolist()
        [2.943]
    """
    path = pathlib.Path(output)
    with python_names():
        noise = GroundNoise(
            seed=seed,
            peak=require_positive("--peak", peak, "acceleration"),
            duration=require_positive("--duration", duration, "time"),
            frequency=require_positive("--frequency", frequency, "frequency"),
            damping=damping,
            interval=require_positive("--interval", interval, "time"),
        )
        _write(path, format_generated(noise, path.stem))
        return records(path)


def _write(path: pathlib.Path, content: bytes) -> None:
    """Writes a CSV file; its folder is made if it does not exist."""
    require_writable_file(path, "output")
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as temporary:
        temporary.write_bytes(content)
