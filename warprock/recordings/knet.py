"""ASCII files of K-NET and KiK-net: one direction a file, counts of the digitiser.

17 header lines of a name and, from column 19, a value; then whole numbers, eight a line.
acceleration [gal] = counts x scale factor, the factor written as a fraction "7845(gal)/6182761".
The counts keep the offset of the instrument, which the network's peak value does not: take off
the mean of the seconds before the event before such a record drives a block.

References:
    NIED, K-NET ASCII format, https://www.kyoshin.bosai.go.jp.
"""

from __future__ import annotations

from warprock.model.motion import Control
from warprock.recordings.text_file import Channel, TextFile

HEADER_LINES = 17
_VALUE = 18
"""Column at which the value of a header line starts."""
_GAL = 0.01
MOST_SAMPLES = 10**9
"""Samples that no file of this kind has."""
_NAMES = ("Origin Time", "Station Code", "Sampling Freq", "Duration Time", "Dir.", "Scale Factor")


def recognises(text: TextFile) -> bool:
    """Whether a file says that it is one of these."""
    return bool(text.lines) and text.lines[0].startswith("Origin Time  ")


def read(text: TextFile) -> list[Channel]:
    """The motion of a file.

    Raises:
        InputError: A header line is missing, a value or a count is none, or there are too few.
    """
    head = text.lines[:HEADER_LINES]
    at = {}
    for name in _NAMES:
        found = [index for index, line in enumerate(head) if line.startswith(name)]
        if not found:
            allowed = f"must begin a header of {HEADER_LINES} lines with {name} in it"
            raise text.refusal(0, allowed)
        at[name] = found[0]
    value = {name: head[index][_VALUE:].strip() for name, index in at.items()}
    rate_text, factor_text = "must have a rate such as 100Hz", "must be such as 3920(gal)/6182761"
    at_rate, at_factor = at["Sampling Freq"], at["Scale Factor"]
    rate_found = text.match(at_rate, r"(\d+(?:\.\d+)?)\s*Hz", rate_text)
    factor = text.match(at_factor, r"([\d.]+)\s*\(gal\)\s*/\s*([\d.]+)", factor_text)
    gal, counts_a_gal = (text.positive(at_factor, part, factor_text) for part in factor.groups())
    text.match(HEADER_LINES - 1, r"Memo", f"must be the last line of {HEADER_LINES}, Memo.")
    first = HEADER_LINES
    at_duration, duration_text = at["Duration Time"], "must have seconds > 0"
    duration = text.positive(at_duration, value["Duration Time"], duration_text)
    rate = text.positive(at_rate, rate_found[1], rate_text)
    if duration * rate > MOST_SAMPLES:
        raise text.refusal(at_duration, f"must be at most {MOST_SAMPLES / rate:g} s")
    counts = text.free(first, round(duration * rate))
    direction = value["Dir."]
    return [
        Channel(
            label=direction,
            quantity=Control.ACCELERATION,
            interval=1.0 / rate,
            samples=_GAL * gal / counts_a_gal * counts,
            source=f"K-NET / KiK-net (NIED): event of {value['Origin Time']}, station "
            f"{value['Station Code']}, direction {direction}",
            processing="raw counts, with the offset of the instrument",
        )
    ]
