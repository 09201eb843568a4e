"""Files of the PEER strong-motion databases: .AT2 (acceleration), .VT2 and .DT2.

Four header lines, then the samples, five or eight a line. The fourth line changed over the years:

    NPTS=   5372, DT=   .0100 SEC,
    NPTS=  4000, DT= .01000 SEC
     4000    .0100    NPTS, DT

The third line names the quantity and its unit. The second, free text, names event, station and
component; the networks' files have no licence in them.

References:
    PEER strong motion database, https://peer.berkeley.edu/smcat/data.html.
"""

from __future__ import annotations

import re

from warprock.model.motion import Control
from warprock.recordings.text_file import NETWORK_GRAVITY, Channel, TextFile

HEADER_LINES = 4

_TITLE = re.compile(r"PEER|PACIFIC ENGINEERING|STRONG.?MOTION DATA", re.IGNORECASE)
_UNITS: dict[str, tuple[Control, float, str]] = {
    "ACCELERATION": (Control.ACCELERATION, NETWORK_GRAVITY, r"\(?\bG\b\)?"),
    "VELOCITY": (Control.VELOCITY, 0.01, r"\bCM/S"),
    "DISPLACEMENT": (Control.DISPLACEMENT, 0.01, r"\bCM\b"),
}
"""Word of the third line -> quantity, its unit in SI units, and how the unit is written."""

_NUMBER = r"([-+]?\d*\.?\d+(?:E[-+]?\d+)?)"


def recognises(text: TextFile) -> bool:
    """Whether a file says that it is one of these."""
    head = text.lines[:HEADER_LINES]
    if len(head) < HEADER_LINES:
        return False
    return bool(_TITLE.search(head[0])) or ("NPTS" in head[3].upper() and "DT" in head[3].upper())


def read(text: TextFile) -> list[Channel]:
    """The motion of a file.

    Raises:
        InputError: A header line or a sample that is none, or too few samples.
    """
    word = text.match(
        2,
        "|".join(_UNITS),
        "must name the quantity and its unit, such as ACCELERATION TIME SERIES IN UNITS OF G",
    )[0].upper()
    quantity, size, unit = _UNITS[word]
    known = {"ACCELERATION": "G", "VELOCITY": "CM/S", "DISPLACEMENT": "CM"}[word]
    text.match(2, unit, f"must be in units of {known} for {word}")
    count, interval = _count_and_interval(text)
    note = "as the database has it"
    if quantity is Control.ACCELERATION:
        note += f"; g = {NETWORK_GRAVITY} m/s^2"
    name = text.lines[1].strip()
    return [
        Channel(
            label=name.rpartition(",")[2].strip(),
            quantity=quantity,
            interval=interval,
            samples=size * text.free(HEADER_LINES, count),
            source=f"{text.lines[0].strip()}: {name}",
            processing=note,
        )
    ]


def _count_and_interval(text: TextFile) -> tuple[int, float]:
    """Number of samples and the time between them [s], from the fourth line."""
    at = HEADER_LINES - 1
    line = text.lines[at].upper()
    named = re.search(rf"NPTS\s*=?\s*(\d{{1,9}})\b\D*?\bDT\s*=?\s*{_NUMBER}", line)
    bare = re.match(rf"\s*(\d{{1,9}})\s*,?\s+{_NUMBER}\s", line + " ")
    found = named or bare
    if found is None:
        allowed = "must have NPTS and DT, such as NPTS=  4000, DT= .0100 SEC"
        raise text.refusal(at, allowed)
    return int(found[1]), text.interval(at, found[2])
