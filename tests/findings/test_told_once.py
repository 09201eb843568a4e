"""A result is told once: the terminal, the page, the figure and JSON say the same of it."""

from __future__ import annotations

import html
import json
import pathlib

import pandas as pd
import PIL.Image
import pytest

from tests.shared.commands import invoke, succeed

SHORT = ["-s", "run.duration=4 s"]
GRID = ["-s", "motion.frequency=1 Hz, 2 Hz", "-s", "motion.amplitude=0.01 g to 1 g, 8"]
SPECTRUM = ["-s", 'spectrum.period=["1 s", "4 s"]', "-s", 'spectrum.slenderness=["10 deg"]']
ASKED = {
    "map": ["map", "overturning-map", *GRID],
    "spectrum": ["spectrum", "rocking-spectrum", *SPECTRUM, *SHORT],
    "ida": [
        *("ida", "record-ridgecrest", "--from", "0.2", "--to", "2", "--count", "4"),
        *("--accuracy", "0.1", *SHORT),
    ],
    "sensitivity": ["sensitivity", "sobol-single-block", "-s", "sample.lanes=16"],
    "validation": ["validate", "record-ridgecrest", *SHORT],
    "fragility": ["fragility", "--max-doubt", "1"],
}
"""Name of a figure -> the command that draws it."""


def told(asked: list[str], out: pathlib.Path) -> list[str]:
    """What a command prints, line by line; its results are in the folder."""
    result = succeed(*asked, "-o", out)
    return result.stdout.splitlines()


@pytest.mark.parametrize("name", ASKED)
def test_terminal_page_and_figure_say_the_same_sentence(name: str, tmp_path: pathlib.Path):
    asked, out = [*ASKED[name]], tmp_path / "out"
    if name == "fragility":
        told(["run", "sobol-single-block", "-s", "sample.lanes=64"], tmp_path / "run")
        asked.insert(1, str(tmp_path / "run"))
    if name == "validation":
        seen = pd.DataFrame({"lane": range(7), "observed": [False] * 4 + [True] * 3})
        seen.to_csv(tmp_path / "seen.csv", index=False)
        asked += ["--observed", str(tmp_path / "seen.csv")]
    printed = told(asked, out)
    with PIL.Image.open(out / f"{name}.png") as image:
        title = str(image.info["Title"])
    assert f"{title}." in printed
    page = html.unescape((out / "report.html").read_text(encoding="utf-8"))
    assert f"{title}." in page


def test_the_weakest_pulse_of_a_map_is_the_same_wherever_it_is_told(tmp_path: pathlib.Path):
    """Two of three groups of this grid have none of their lanes stand: boundaries tell the rest."""
    printed = "\n".join(told(ASKED["map"], tmp_path))
    boundaries = pd.read_csv(tmp_path / "boundaries.csv")
    falls = boundaries[boundaries["above"].isin(["with impact", "without impact"])]
    weakest = falls.loc[falls["acceleration_ratio"].idxmin()]
    said = f"has {weakest['acceleration_ratio']:.3g} g tan(slenderness angle)"
    assert said in printed
    assert weakest["above"] == "with impact"
    assert "the block (one-cycle sine) has" in printed
    assert f"{weakest['frequency_hz']:g} Hz, after an impact." in printed
    modes = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))["modes"]
    counts = f"{modes['safe']} leave the block standing and {modes['without impact']} overturn it"
    assert f"Of the 48 pulses of the grid {counts} without an impact." in printed


def test_a_page_that_is_written_later_tells_what_the_command_told(tmp_path: pathlib.Path):
    printed = told(ASKED["map"], tmp_path)
    (tmp_path / "report.html").unlink()
    assert invoke("report", tmp_path).exit_code == 0
    page = html.unescape((tmp_path / "report.html").read_text(encoding="utf-8"))
    for begins in ("The weakest pulse that", "The weakest of each group", "Of the 48 pulses"):
        (sentence,) = (line for line in printed if line.startswith(begins))
        assert sentence in page
