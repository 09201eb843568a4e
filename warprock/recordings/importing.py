"""Many files made ready for cases at once: globs and whole folders."""

from __future__ import annotations

import functools
import glob
import os
import pathlib
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from warprock.errors import NOTHING, InputError, Said
from warprock.processes import worker_processes
from warprock.recordings.column_file import Reading
from warprock.recordings.loading import AS_WRITTEN, CHANNEL, load_readings, record_of
from warprock.recordings.processing import Step
from warprock.recordings.summary import record_row
from warprock.recordings.writing import format_imported

FEW = 16
"""Files up to which one process is as fast as several that must be started."""


class Importing(NamedTuple):
    """How files are made ready.

    Attributes:
        asked: What is said of a table besides its header.
        displacement: The same of a column of displacement beside it, for the step `merge`.
        steps: Processing, in order.
        source: Where they are from, where their files do not say it.
        licence: Their licence, likewise.
    """

    asked: Reading = AS_WRITTEN
    displacement: Reading | None = None
    steps: tuple[Step, ...] = ()
    source: str = ""
    licence: str = ""


def found_files(names: Sequence[str]) -> list[str]:
    """The files that are meant by files, patterns such as `raw/*.txt`, and folders.

    Of a folder they are its files, but for hidden ones and those in folders inside.

    Raises:
        InputError: A pattern or a folder without a file.
    """
    found: list[str] = []
    for name in names:
        path = pathlib.Path(name)
        if path.is_dir():
            inside = [each for each in path.iterdir() if each.is_file()]
            several = sorted(str(each) for each in inside if not each.name.startswith("."))
        elif glob.has_magic(name) and not os.path.lexists(name):
            several = sorted(each for each in glob.glob(name) if os.path.isfile(each))
        else:
            several = [name]
        if not several:
            raise InputError("FILE", "", name, "must have at least one file")
        found += several
    return list(dict.fromkeys(found))


def convert_file(name: str, how: Importing, record_name: str) -> bytes:
    """The CSV file of one record.

    Args:
        name: As `load_record`.
        how: How it is made ready.
        record_name: Name of the new record.

    Raises:
        InputError: It cannot be read, or a step cannot be done.
    """
    asked = [how.asked] if how.displacement is None else [how.asked, how.displacement]
    record, *others = load_readings(name, asked)
    return format_imported(
        record,
        how.steps,
        name=record_name,
        source=how.source,
        licence=how.licence,
        displacement=others[0] if others else None,
    )


def import_files(
    files: Sequence[str], how: Importing, folder: pathlib.Path, workers: int
) -> list[dict[str, Any]]:
    """Makes files ready in a folder, NAME.csv of each; all of them or none.

    Args:
        files: The files.
        how: How they are made ready.
        folder: Where to; made if it is not there.
        workers: Processes that share them.

    Returns:
        One row a record, as `summary.record_rows`, with its `file`.

    Raises:
        InputError: One that cannot be read, a step that cannot be done, or two of one name.
    """
    targets = _targets(files, folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".import-", dir=folder.parent) as place:
        work = functools.partial(_import_one, how, pathlib.Path(place))
        if len(files) <= FEW or workers == 1:
            rows = list(map(work, files, targets))
        else:
            with worker_processes(workers) as pool:
                rows = list(pool.map(work, files, targets, chunksize=4))
        folder.mkdir(exist_ok=True)
        for target in targets:
            shutil.move(pathlib.Path(place) / target, folder / target)
    return [{**row, "file": str(folder / at)} for row, at in zip(rows, targets, strict=True)]


def weighted_table(rows: Sequence[Mapping[str, Any]], weights: Sequence[float]) -> str:
    """The table of a sweep over some records with their weights, as CSV.

    Args:
        rows: What `import_files` returned.
        weights: Weight of each.
    """
    lines = ["record,label.weight"]
    for row, weight in zip(rows, weights, strict=True):
        path = pathlib.PurePath(row["file"])
        lines.append(f"{path.parent.name}/{path.name},{weight!r}")
    return "\n".join(lines) + "\n"


def _targets(files: Sequence[str], folder: pathlib.Path) -> list[str]:
    """Names of the files to write."""
    targets: dict[str, str] = {}
    for file in files:
        path, _, channel = file.rpartition(CHANNEL) if not os.path.exists(file) else (file, "", "")
        stem = pathlib.Path(path or file).stem + (f"-{channel}" if path and channel else "")
        target = f"{stem}.csv"
        if target in targets:
            allowed = f"must be the only {stem}: {targets[target]} has that name, too"
            raise InputError("FILE", "", file, allowed)
        if pathlib.Path(file).resolve() == (folder / target).resolve():
            allowed = f"must not be written over: name another folder than {folder}"
            raise InputError("--output", "", file, allowed)
        targets[target] = file
    return list(targets)


def _import_one(how: Importing, place: pathlib.Path, file: str, target: str) -> dict[str, Any]:
    """Makes one file ready, and says what is in it."""
    path = place / target
    content = convert_file(file, how, path.stem)
    path.write_bytes(content)
    return record_row(record_of(str(path), content))


def displacement_reading(text: str, asked: Reading) -> Reading:
    """The column of a displacement from "COLUMN, UNIT", such as "6, 5.98e-4 in".

    Args:
        text: The column and its unit, or a number of them.
        asked: What is said of the acceleration beside it.

    Raises:
        InputError: It is not of that form.
    """
    column, comma, unit = (part.strip() for part in text.rpartition(","))
    if not (comma and column and unit):
        allowed = 'must be a column and its unit, or a number of them: "6, 5.98e-4 in"'
        raise InputError("--displacement", "", text or NOTHING, allowed)
    return asked._replace(column=column, unit=unit)


def require_one_name(name: str | None, count: int) -> None:
    """Refuses one name for several records.

    Raises:
        InputError: There are several.
    """
    if name is not None and count != 1:
        allowed = f"must be left out for {count} records: each has the name of its file"
        raise InputError("--name", "", Said(name), allowed)
