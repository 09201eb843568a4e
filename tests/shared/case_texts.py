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


def refusal(file: pathlib.Path | str, *overrides: str) -> InputError:
    """The error, of one line, with which a case is refused."""
    with pytest.raises(InputError) as caught:
        load_case(file, overrides)
    assert "\n" not in str(caught.value)
    return caught.value
