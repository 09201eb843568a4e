"""Small cases that several test files edit, and how a case is refused."""

from __future__ import annotations

import pathlib

import pytest

from warprock.case.load import load_case
from warprock.errors import InputError

FREE = """
title = "t"
source = "s"
[block]
width = "0.5 m"
height = "1 m"
depth = "20 cm"
density = "2670 kg/m^3"
[contact]
friction = 1.0
[run]
duration = "5 s"
"""

PULSE = (
    FREE
    + """
[motion]
waveform = "sine"
control = "displacement"
frequency = "3 Hz"
amplitude = "8 mm"
cycles = 1
"""
)


def pulse_text(
    *,
    title: str = "A block under pulses",
    width: str = "0.2 m",
    height: str = "1 m",
    friction: float = 1.0,
    amplitude: str = "0.3 g",
    frequency: str = "2 Hz",
    duration: str = "3 s",
) -> str:
    """A block under one cycle of sine; more keys of its last table, [run], may follow."""
    return f"""
title = "{title}"
source = "Made for this test."
[block]
width = "{width}"
height = "{height}"
depth = "0.5 m"
density = "2400 kg/m^3"
[contact]
friction = {friction}
[motion]
waveform = "sine"
control = "acceleration"
amplitude = "{amplitude}"
frequency = "{frequency}"
cycles = 1
[run]
duration = "{duration}"
"""


def refusal(file: pathlib.Path | str, *overrides: str) -> InputError:
    """The error, of one line, with which a case is refused."""
    with pytest.raises(InputError) as caught:
        load_case(file, overrides)
    assert "\n" not in str(caught.value)
    return caught.value
