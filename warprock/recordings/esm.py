"""ASCII files of the Engineering Strong Motion database, header format DYNA 1.2.

64 lines `KEY: value`, then one sample a line. The unit stands in the header.

References:
    Engineering Strong-Motion database, ASCII header DYNA 1.2, https://esm-db.eu.
"""

from __future__ import annotations

from warprock.errors import NOTHING
from warprock.recordings.record import CONTROL_OF
from warprock.recordings.text_file import Channel, TextFile
from warprock.units import parse_any

HEADER_LINES = 64


def recognises(text: TextFile) -> bool:
    """Whether a file says that it is one of these."""
    return bool(text.lines) and text.lines[0].startswith("EVENT_NAME:")


def read(text: TextFile) -> list[Channel]:
    """The motion of a file.

    Raises:
        InputError: Another version of the header, a value or a sample that is none, or too few
            samples.
    """
    at = {
        line.partition(":")[0].strip(): index
        for index, line in enumerate(text.lines[:HEADER_LINES])
    }

    def place(key: str) -> int:
        if key not in at:
            allowed = f"must begin a header of {HEADER_LINES} lines with {key}: in it"
            raise text.refusal(0, allowed)
        return at[key]

    def value(key: str) -> str:
        return text.lines[place(key)].partition(":")[2].strip()

    if value("HEADER_FORMAT") != "DYNA 1.2":
        raise text.refusal(place("HEADER_FORMAT"), "must be HEADER_FORMAT: DYNA 1.2")
    try:
        size, dimension = parse_any(f"1 {value('UNITS')}", CONTROL_OF)
    except ValueError:
        allowed = "must be a unit of acceleration, velocity or displacement, such as cm/s^2"
        raise text.refusal(place("UNITS"), allowed, value("UNITS") or NOTHING) from None
    interval = text.interval(place("SAMPLING_INTERVAL_S"), value("SAMPLING_INTERVAL_S"))
    count = int(
        text.match(place("NDATA"), r":\s*(\d{1,9})\s*$", "must have the number of samples")[1]
    )
    stream = value("STREAM")
    station = f"{value('NETWORK')}.{value('STATION_CODE')}"
    event = f"{value('EVENT_NAME')} {value('EVENT_DATE_YYYYMMDD')} ({value('EVENT_ID')})"
    filtered = (
        f"{value('BASELINE_CORRECTION').lower()}; {value('FILTER_TYPE').lower()} "
        f"{value('LOW_CUT_FREQUENCY_HZ')}-{value('HIGH_CUT_FREQUENCY_HZ')} Hz, "
        f"order {value('FILTER_ORDER')}"
    )
    # Only newer files have the line, so its lack is no error.
    licence = value("DATA_LICENSE") if "DATA_LICENSE" in at else ""
    return [
        Channel(
            label=stream,
            quantity=CONTROL_OF[dimension],
            interval=interval,
            samples=size * text.free(HEADER_LINES, count),
            source=f"Engineering Strong-Motion database: {event}, {station}, {stream}",
            processing=f"by the database: {value('PROCESSING')}; {filtered}",
            licence=licence,
        )
    ]
