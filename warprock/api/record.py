"""A ground motion of one's own, as numbers, made a record that a case can follow."""

from __future__ import annotations

import os
import pathlib
from typing import Any

import numpy as np

from warprock.api.names import python_names
from warprock.arguments import at_the_door
from warprock.errors import InputError
from warprock.records.loading import load_record
from warprock.records.sample_file import csv_text
from warprock.records.writing import NOT_STATED
from warprock.run.files import replacing, require_writable_file


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
        InputError: The file cannot be written, or the samples are no record: no such unit, fewer
            than 2 of them, or one that is not finite.

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
    try:
        values = np.asarray(samples, dtype=np.float64).ravel()
    except (TypeError, ValueError):
        values = np.array([np.nan])
    if not np.isfinite(values).all():
        raise InputError("samples", "", samples, "must be finite numbers, shape [sample]")
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
