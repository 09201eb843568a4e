"""Files of the California Strong Motion Instrumentation Program: Volume 1 and Volume 2.

Channels lie behind one another in a file, each with a header of text, whole and real numbers.
A line such as one of these starts the samples:

     35430 Accelerogram points at 100 pts/sec in units of g.       Format: (8f9.6)
     7500 points of accel data equally spaced at  .010 sec, in cm/sec2. (8f10.6)
     3251 POINTS OF ACCEL DATA EQUALLY SPACED AT  .020 SEC.  (UNITS: CM/SEC/SEC)

The fields have a fixed width and no guaranteed blank between them. Volume 2 has velocity and
displacement behind the acceleration; the acceleration is what is read. Volume 1 is raw: take off
the mean before the event and filter before such a record drives a block. The oldest Volume 1
files have pairs of time and acceleration instead, which are refused.

References:
    A. F. Shakal and M. J. Huang (1985), Standard tape format for CSMIP strong-motion data tapes,
    California Division of Mines and Geology, OSMS 85-03.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from warprock.errors import InputError
from warprock.model.motion import Control
from warprock.recordings.text_file import NETWORK_GRAVITY, Channel, TextFile

PER_LINE = 8
_WIDTH = {"uncorrected": 9, "corrected": 10}
"""Characters of a field where the line that starts the samples has no format: 8F9.6, 8F10.3."""

_KIND = re.compile(r"(uncorrected|corrected)\s+accelero(?:gram|graph)", re.IGNORECASE)
_START = re.compile(
    r"^\s*(?P<count>\d{1,9})\s+"
    r"(?:Accelerogram\s+points\s+at\s+(?P<rate>\d*\.?\d+)\s+pts/sec"
    r"|points\s+of\s+accel\s+data\s+equally\s+spaced\s+at\s+(?P<interval>\d*\.?\d+)\s+sec)"
    r"[\s.,]*(?:in\s+units\s+of|in|\(units:)\s*(?P<unit>cm/sec2|cm/sec/sec|g)\b",
    re.IGNORECASE,
)
_FORMAT = re.compile(r"\(8f(\d+)\.\d+\)", re.IGNORECASE)
_COSMOS = re.compile(r"\(Format v0?1\.\d+ with", re.IGNORECASE)


def recognises(text: TextFile) -> bool:
    """Whether a file says that it is one of these."""
    first = text.lines[0] if text.lines else ""
    return bool(_KIND.match(first.strip()) or _COSMOS.search(first)) and "GNS" not in first


def read(text: TextFile) -> list[Channel]:
    """The accelerations of every channel.

    Raises:
        InputError: No channel with equal time steps, a header line or sample that is none, or too
            few samples.
    """
    if _COSMOS.search(text.lines[0]):
        raise text.refusal(0, "must be a CSMIP Volume 1 or 2 header; COSMOS files are not read")
    starts = [(at, found) for at, line in enumerate(text.lines) if (found := _START.match(line))]
    if not starts:
        raise _no_channel(text)
    channels, begin = [], 0
    for at, found in starts:
        channels.append(_channel(text, begin, at, found))
        begin = at + 1
    return channels


def _channel(text: TextFile, begin: int, at: int, found: re.Match[str]) -> Channel:
    """The channel whose samples follow line `at`, its header after line `begin`."""
    head = text.lines[begin:at]
    kinds = [match for line in head if (match := _KIND.match(line.strip()))]
    raw = not kinds or kinds[0][1].lower() == "uncorrected"
    explicit = _FORMAT.search(text.lines[at])
    width = int(explicit[1]) if explicit else _WIDTH["uncorrected" if raw else "corrected"]
    size = NETWORK_GRAVITY if found["unit"].lower() == "g" else 0.01
    if found["rate"]:
        interval = 1.0 / text.positive(at, found["rate"], "must have samples a second > 0")
    else:
        interval = text.interval(at, found["interval"])
    chan = _last(head, r"\bCHAN\s+(\d+):\s+(.*\S)")
    direction = f"{chan[1]}: {_words(chan[2])}" if chan else ""
    count = int(found["count"])
    samples = text.fixed(at + 1, count, width, PER_LINE)
    text.require_end(at + 1, count, PER_LINE)
    note = "raw (Volume 1)" if raw else "Volume 2, as the network has it"
    unit = f"; g = {NETWORK_GRAVITY} m/s^2" if found["unit"].lower() == "g" else ""
    return Channel(
        label=direction.partition(": ")[2],
        quantity=Control.ACCELERATION,
        interval=interval,
        samples=size * samples,
        source=f"CSMIP: {_source(head)}, channel {direction}",
        processing=note + unit,
    )


def _source(head: Sequence[str]) -> str:
    """Station and time of a recording, from a header."""
    station = _last(head, r"STATION (?:NO|ID)\.\s+(\S+)\s+([\d.]+[NS],\s*[\d.]+[EW])")
    started = _last(head, r"(?:START|TRIGGER) TIME:\s+(.*\S)")
    name = f"station {station[1]} ({_words(station[2])})" if station else "station not named"
    return f"{name}, recording of {_words(started[1])}" if started else name


def _last(lines: Sequence[str], pattern: str) -> re.Match[str] | None:
    """The match of a pattern in the last line that has one."""
    found = (re.search(pattern, line, re.IGNORECASE) for line in reversed(lines))
    return next((match for match in found if match), None)


def _words(text: str) -> str:
    return " ".join(text.split())


def _no_channel(text: TextFile) -> InputError:
    """What to say of a file without a line that starts samples."""
    for at, line in enumerate(text.lines):
        if re.search(r"UNITS OF UNCOR\S* \S+ ARE SEC AND G/10", line, re.IGNORECASE):
            allowed = "must be sampled at equal time steps, not pairs of time and acceleration"
            return text.refusal(at, allowed)
    allowed = (
        "must have a line such as '7500 points of accel data equally spaced at .01 sec, in cm/sec2'"
    )
    return text.refusal(len(text.lines), allowed)
