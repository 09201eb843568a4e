"""Files of GeoNet, New Zealand: V1A (raw) and V2A (corrected), three components in a file.

Of each component: 16 lines of text, 4 lines of 10 whole numbers (10I8), 6 lines of 10 real
numbers (10F8.0), then the accelerations in mm/s^2, ten fields of eight characters a line; in V2A
velocities and displacements follow in the same way. Whole numbers 34 to 36 say how many there are
of each, real number 26 is the time between them.

References:
    GNS Science, Accelerogram data filenames and formats,
    https://www.geonet.org.nz/data/supplementary/strong_motion_file_formats.
"""

from __future__ import annotations

import re

from warprock.model.motion import Control
from warprock.recordings.text_file import Channel, TextFile

TEXT_LINES, WHOLE_LINES, REAL_LINES = 16, 4, 6
HEADER_LINES = TEXT_LINES + WHOLE_LINES + REAL_LINES
WIDTH, PER_LINE = 8, 10

_MM = 0.001
_COUNTS = slice(33, 36)
"""Place of the numbers of accelerations, velocities and displacements among the whole numbers."""
_INTERVAL = 25
"""Place of the time between samples among the real numbers."""
_TITLE = re.compile(r"\s*(uncorrected|corrected) accelerogram\b.*GNS", re.IGNORECASE)


def recognises(text: TextFile) -> bool:
    """Whether a file says that it is one of these."""
    return bool(text.lines) and bool(_TITLE.match(text.lines[0]))


def read(text: TextFile) -> list[Channel]:
    """The accelerations of every component.

    Raises:
        InputError: A header line or a sample that is none, or too few samples.
    """
    channels, begin = [], 0
    while begin < len(text.lines) and text.lines[begin].strip():
        allowed = "must start a component: Corrected or Uncorrected accelerogram ... GNS Science"
        kind = text.match(begin, _TITLE.pattern, allowed)[1].lower()
        counts = _counts(text, begin)
        at = begin + TEXT_LINES + WHOLE_LINES + _INTERVAL // PER_LINE
        field = _INTERVAL % PER_LINE * WIDTH
        line = text.match(at, r".*", "must be a line of real numbers")[0]
        interval = text.interval(at, line[field : field + WIDTH])
        first = begin + HEADER_LINES
        head = text.lines[begin:first]
        direction = text.match(begin + 12, r"Component\s+(\S+)", "must name the component")[1]
        name = " ".join(head[0].split()[2:3])
        site = text.match(begin + 1, r"Site\s+(\S+)", "must name the site")[1]
        channels.append(
            Channel(
                label=direction,
                quantity=Control.ACCELERATION,
                interval=interval,
                samples=_MM * text.fixed(first, counts[0], WIDTH, PER_LINE),
                source=f"GeoNet (GNS Science): {name}, site {site}, event of "
                f"{' '.join(head[7].split())}, component {direction}",
                processing="raw (V1A)"
                if kind == "uncorrected"
                else f"by the network (V2A): {head[11].strip().lower()}",
            )
        )
        begin = first + sum(-(-count // PER_LINE) for count in counts)
    return channels


def _counts(text: TextFile, begin: int) -> tuple[int, ...]:
    """How many accelerations, velocities and displacements a component has."""
    first = begin + TEXT_LINES
    whole = text.fixed(first, WHOLE_LINES * PER_LINE, WIDTH, PER_LINE)
    counts = tuple(int(value) for value in whole[_COUNTS])
    at = first + _COUNTS.start // PER_LINE
    if counts[0] < 2 or min(counts) < 0:
        raise text.refusal(at, "must have the numbers of samples, of accelerations at least 2")
    return counts
