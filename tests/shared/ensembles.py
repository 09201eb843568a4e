"""Cases with an ensemble to test with."""

from __future__ import annotations

import pathlib

PULSE = """
title = "A block under pulses"
source = "made up"
[block]
width = "0.17 m"
height = "1 m"
depth = "0.5 m"
density = "2000 kg/m^3"
[contact]
friction = "45 deg"
[start]
rotation = "0 deg"
[motion]
waveform = "sine"
control = "acceleration"
frequency = "3 Hz"
amplitude = "0.3 g"
cycles = 1
[run]
duration = "3 s"
sample_interval = "10 ms"
[[sweep]]
motion.amplitude = ["0.25 g", "0.3 g", "0.35 g"]
[ensemble]
members = {members}
seed = {seed}
sampling = "{sampling}"
{more}
[ensemble.spread]
{spread}
"""
SPREAD = """
"contact.friction" = "5 %"
motion.amplitude = "2 %"
block.width = "1 mm"
"""
STACK = """
title = "Two blocks"
source = "made up"
[block.1]
width = "0.2 m"
height = "0.6 m"
depth = "0.4 m"
density = "2670 kg/m^3"
chamfer = "5 mm"
[block.2]
width = "0.15 m"
height = "0.6 m"
depth = "0.5 m"
density = "2670 kg/m^3"
[contact]
friction = 0.7
[run]
duration = "1 s"
[ensemble]
members = 8
[ensemble.spread]
"""


def write_pulse(
    folder: pathlib.Path,
    spread: str = SPREAD,
    *,
    members: int = 64,
    seed: int = 1,
    sampling: str = "sobol",
    more: str = "",
) -> pathlib.Path:
    """A case of three cells, written to a folder; the file."""
    file = folder / "case.toml"
    text = PULSE.format(members=members, seed=seed, sampling=sampling, more=more, spread=spread)
    file.write_text(text, encoding="utf-8")
    return file
