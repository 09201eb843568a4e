"""The command `identify` as a function."""

from __future__ import annotations

import functools
import os
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from warprock.analysis.identification import FITS, FREQUENCY, SLENDERNESS, identify_block
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Angle, Column, Frequency, Length
from warprock.arguments import at_the_door, several
from warprock.errors import NOTHING, InputError, Said, list_allowed
from warprock.figures.identification import draw_identified
from warprock.findings.identification import find_identify
from warprock.model import rocking
from warprock.quantity import NumberKey
from warprock.recordings.rotation_file import Rotations, read_rotations

_READ = {
    "width": NumberKey("the width of the block", "1 mm to 1 km"),
    "height": NumberKey("the height of the block", "1 mm to 1 km"),
    "slenderness": NumberKey("the slenderness angle of the block", "0.01 deg to 89 deg"),
    "frequency-parameter": NumberKey("the frequency parameter p", "1e-3 rad/s to 1e3 rad/s"),
}
"""Options that are quantities."""

FRAME_COLUMNS = ("time_s", "rotation_rad")
"""Columns of a history in a DataFrame, as `Run.history` gives it."""


@at_the_door
def identify(
    history: pd.DataFrame | str | os.PathLike[str],
    *,
    width: Length | None = None,
    height: Length | None = None,
    slenderness: Angle | None = None,
    frequency_parameter: Frequency | None = None,
    fit: str | Sequence[str] = (),
    column: Column | None = None,
    unit: str | None = None,
) -> Found:
    """What a test of free rocking tells of a block: what it keeps at an impact, with its error.

    Peaks of the rotation in succession give what each impact leaves. How long swings last gives the
    slenderness angle and the frequency parameter, where these are asked for. The history is of a
    block that was let go on a base at rest; it counts from the first impact on.

    Args:
        history: A table with a column of time and one of an angle, `time_s,rotation_deg`; or a
            DataFrame with `time_s` and `rotation_rad`. The rotation is 0 at rest.
        width: Of a rectangular block, such as "0.5 m"; with `height`.
        height: Of a rectangular block.
        slenderness: Slenderness angle, such as "14 deg", of a block that is no rectangle.
        frequency_parameter: p = sqrt(m g R / I), such as "2.7 rad/s", of a block that is no
            rectangle.
        fit: slenderness, frequency-parameter: find it from how long swings last; or several.
        column: Name of the column of the rotation; not needed where one alone is an angle.
        unit: Unit of this column, where its header has none: rad, mrad or deg.

    Returns:
        A `Found` whose facts have values and errors, and whose table has one row a swing.

    Raises:
        InputError: The file or an argument cannot be used, or the history has fewer than three
            whole swings.

    Example:
        >>> import warprock as wr
        >>> run = wr.run("free-b0", "housner", progress=False)
        >>> found = wr.identify(run.history(0, "10 ms"), width="1 m", height="5 m")
        >>> round(found.facts["identified"]["angular_restitution"], 6)
        0.942308
    """
    with python_names():
        texts = {
            "width": width,
            "height": height,
            "slenderness": slenderness,
            "frequency-parameter": frequency_parameter,
        }
        for name in several(fit):
            if name not in FITS:
                raise InputError("--fit", "", name, f"must be one of {list_allowed(name, FITS)}")
        asked = tuple(dict.fromkeys(several(fit)))
        angle, rate = _block(texts, asked)
        if isinstance(history, pd.DataFrame):
            source, read = "history", _of_frame(history, column, unit)
        else:
            source, read = str(history), read_rotations(history, column, unit)
        found = identify_block(read.times, read.rotations, angle, rate, asked, source)
        return Found(
            f"{os.path.basename(source)}: a block from its free rocking",
            found,
            functools.partial(find_identify, found, source, read.column),
            functools.partial(draw_identified, found, read.times, read.rotations),
        )


def _block(
    texts: Mapping[str, str | None], fits: Sequence[str]
) -> tuple[float | None, float | None]:
    """Slenderness angle [rad] and frequency parameter [rad/s] as they are given."""
    read = {name: _READ[name].read_option(f"--{name}", text) for name, text in texts.items()}
    width, height = read["width"], read["height"]
    if (width is None) != (height is None):
        lacks = "--height" if height is None else "--width"
        raise InputError(lacks, "", NOTHING, "must be given beside the other size of the block")
    angle, rate = read[SLENDERNESS], read[FREQUENCY]
    if width is not None and height is not None:
        for name, value in ((SLENDERNESS, angle), (FREQUENCY, rate)):
            if value is not None:
                allowed = "must be left out: --width and --height say it"
                raise InputError(f"--{name}", "", texts[name], allowed)
        angle = float(rocking.slenderness_angle(width, height))
        rate = float(rocking.frequency_parameter(width, height))
    # A frequency in Hz is angular frequency / 2 pi.
    elif rate is not None:
        rate *= 2.0 * np.pi
    if angle is None and SLENDERNESS not in fits:
        allowed = "must be given: --width and --height of the block, or its slenderness angle"
        raise InputError("--slenderness", "", NOTHING, allowed)
    if fits and rate is None and FREQUENCY not in fits:
        allowed = "must be given for --fit: --width and --height, or the frequency parameter"
        raise InputError("--frequency-parameter", "", NOTHING, allowed)
    return angle, rate


def _of_frame(table: pd.DataFrame, column: str | None, unit: str | None) -> Rotations:
    """The history in a DataFrame, whose columns have their units in their names."""
    for name, given in (("column", column), ("unit", unit)):
        if given is not None:
            allowed = f"must be left out: a DataFrame has {' and '.join(FRAME_COLUMNS)}"
            raise InputError(f"--{name}", "", given, allowed)
    arrays = []
    for name in FRAME_COLUMNS:
        if name not in table:
            raise InputError("HISTORY", name, NOTHING, "must be a column")
        try:
            values = table[name].to_numpy(dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError("HISTORY", name, Said("words"), "must hold numbers") from None
        if len(values) < 2 or not np.isfinite(values).all():
            raise InputError("HISTORY", name, Said("other"), "must be finite numbers, two or more")
        arrays.append(values)
    times, rotations = arrays
    if (np.diff(times) <= 0.0).any():
        raise InputError("HISTORY", FRAME_COLUMNS[0], Said("other"), "must grow")
    return Rotations(times, rotations, FRAME_COLUMNS[1])
