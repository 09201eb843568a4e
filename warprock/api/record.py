"""A ground motion of one's own, as numbers, made a record that a case can follow."""

from __future__ import annotations

import os
import pathlib
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.api.names import python_names
from warprock.arguments import at_the_door
from warprock.errors import InputError
from warprock.recordings.loading import load_record
from warprock.recordings.sample_file import csv_text
from warprock.recordings.writing import NOT_STATED
from warprock.running.files import replacing, require_writable_file


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
            raise InputError("samples", "", f"an array of {found.dtype}", allowed)
        values = found.astype(np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("samples", "", samples, f"{allowed} ({error})") from None
    if values.ndim != 1:
        many = "; of several columns name one, such as samples[:, 1]" * (values.ndim == 2)
        raise InputError("samples", "", f"an array of shape {list(values.shape)}", allowed + many)
    return values
