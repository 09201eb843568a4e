"""Records: shipped ones, what a file holds, and numbers of one's own made a record."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Sequence
from typing import Any, TypedDict, Unpack

import numpy as np
import numpy.typing as npt

from warprock.api.looked_up import LookedUp
from warprock.api.names import python_names
from warprock.api.values import Length, Time
from warprock.arguments import at_the_door, listing, several
from warprock.errors import InputError, Said
from warprock.findings.records import find_record, find_records
from warprock.recordings.column_file import Reading
from warprock.recordings.intensity import PERIODS
from warprock.recordings.loading import load_record
from warprock.recordings.sample_file import csv_text
from warprock.recordings.summary import record_facts, record_rows
from warprock.recordings.writing import NOT_STATED
from warprock.running.files import replacing, require_writable_file
from warprock.tables.records import print_facts, print_records
from warprock.units import parse_quantity


class ReadingAsked(TypedDict, total=False):
    """What is said of a table with named columns; see `reading_of`."""

    column: str | None
    unit: str | None
    interval: Time | None


@at_the_door
def reading_of(
    *, column: str | None = None, unit: str | None = None, interval: Time | None = None
) -> Reading:
    """What is said of a table with named columns.

    Args:
        column: Of a table: name or number of the column of the motion.
        unit: Of a table: unit of the motion where the header has none, such as g or cm/s^2, or a
            number of them, such as "-1 g".
        interval: Of a table without a column of time: time between samples, such as 0.01 s.
    """
    return Reading(column, unit, interval)


@listing(reading_of)
@at_the_door
def records(
    file: str | os.PathLike[str] | None = None,
    *,
    fema_p695: bool = False,
    period: Time | Sequence[Time] = (),
    damping: float = 0.05,
    width: Length | None = None,
    height: Length | None = None,
    **asked: Unpack[ReadingAsked],
) -> LookedUp:
    """Strong-motion records: the shipped ones, or what one of them or a file holds.

    Args:
        file: A shipped record, fema-p695/SET-NUMBER-COMPONENT (extra [records]), or a file, with
            #CHANNEL or #COLUMN behind it of several; without, the shipped records are listed.
        fema_p695: The 100 components of FEMA P-695.
        period: Of Sa; or several [default: 0.1 to 5 s].
        damping: Of Sa.
        width: Of a block, for PGA / (g tan alpha).
        height: Of a block, for p PGV / (g tan alpha).
        **asked: column, unit and interval: what is said of a table with named columns.

    Returns:
        A `Found` whose table has one row a record; of a file one a channel, with its intensity
        measures, and a table `spectrum` of Sa.

    Raises:
        InputError: There is no such record, the file cannot be read, or what is asked of it does
            not fit.

    Example:
        >>> import warprock as wr
        >>> found = wr.records("ridgecrest-2019-ccc-090", period="1 s")
        >>> found.table["pga_m_s2"].round(2).tolist(), len(found.tables["spectrum"])
        ([5.15], 1)
    """
    with python_names():
        if file is None:
            for name, given in (("--period", period), ("--width", width), ("--height", height)):
                if given:
                    raise InputError(name, "", given, "must be left out where no file is named")
            rows = record_rows(fema=fema_p695)
            find = functools.partial(find_records, rows, print_records)
            return LookedUp("records", rows, find)
        if fema_p695:
            raise InputError("--fema-p695", "", "True", "must be left out where a file is named")
        if not 0.0 <= damping < 1.0:
            raise InputError("--damping", "", damping, "must be from 0 to below 1")
        if (width is None) != (height is None):
            raise InputError("--width", "", width or "nothing", "must be given with --height")
        block = None
        if width is not None and height is not None:
            block = (
                require_positive("--width", width, "length"),
                require_positive("--height", height, "length"),
            )
        times = (
            tuple(require_positive("--period", text, "time") for text in several(period)) or PERIODS
        )
        reading = reading_of(**asked)
        facts = record_facts(
            os.fspath(file), periods=times, damping=damping, block=block, asked=reading
        )
        find = functools.partial(find_record, facts, print_facts)
        return LookedUp(os.fspath(file), facts, find)


def require_positive(option: str, text: str, dimension: str) -> float:
    """A quantity above zero that an option gives.

    Args:
        option: The option.
        text: The quantity with its unit.
        dimension: What it measures.

    Raises:
        InputError: It is none, or not above zero.
    """
    try:
        value = parse_quantity(text, dimension)
    except ValueError as error:
        raise InputError(option, "", text, str(error)) from None
    if value <= 0.0:
        raise InputError(option, "", text, f"must be a {dimension} above 0")
    return value


@at_the_door
def save_record(
    file: str | os.PathLike[str],
    samples: Any,
    *,
    interval: str,
    unit: str,
    source: str = NOT_STATED,
    licence: str = NOT_STATED,
) -> str:
    """Writes samples of a ground motion as a record, a CSV file with its unit in the header.

    Args:
        file: File to write, whose name ends in .csv; its folder is made if it does not exist.
        samples: The motion, shape [sample]: an array, a list, a series; eight digits are kept.
        interval: Time between samples, such as "0.01 s".
        unit: Their unit: of an acceleration ("g", "m/s^2", "gal"), a velocity or a displacement.
        source: Where the motion is from.
        licence: Its licence.

    Returns:
        The path, for `Motion(waveform="record", record=...)`.

    Raises:
        InputError: The file cannot be written, or the samples are no record: of another shape, no
            such unit, fewer than 2 of them, or one that is not finite.

    Example:
        >>> import tempfile
        >>> import numpy as np
        >>> import warprock as wr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     pulse = 0.3 * np.sin(np.linspace(0.0, 2.0 * np.pi, 101))
        ...     record = wr.save_record(f"{folder}/mine.csv", pulse, interval="10 ms", unit="g")
        ...     case = wr.load_case("record-ridgecrest", {"motion.record": record, "check": []})
        ...     case.lanes()["peak_acceleration_m_s2"].max().round(2)
        np.float64(2.94)
    """
    path = pathlib.Path(file)
    values = _samples(samples)
    header = {"name": path.stem, "unit": unit, "interval": interval}
    text = csv_text({**header, "source": source, "licence": licence}, values)
    with python_names():
        require_writable_file(path, "file")
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
            try:
                load_record(str(temporary))
            except InputError as error:
                raise InputError(str(path), error.key, error.got, error.allowed) from None
    return str(path)


def _samples(samples: Any) -> npt.NDArray[np.float64]:
    """Samples as real numbers, shape [sample].

    Raises:
        InputError: They are none, or of another shape: a column of times is no part of a motion.
    """
    allowed = "must be real numbers of one motion, shape [sample]"
    try:
        found = np.asarray(samples)
        if np.iscomplexobj(found):
            raise InputError("samples", "", Said(f"an array of {found.dtype}"), allowed)
        values = found.astype(np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("samples", "", samples, f"{allowed} ({error})") from None
    if values.ndim != 1:
        many = "; of several columns name one, such as samples[:, 1]" * (values.ndim == 2)
        raise InputError(
            "samples", "", Said(f"an array of shape {list(values.shape)}"), allowed + many
        )
    return values
