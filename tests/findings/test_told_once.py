"""A result is told once: the terminal, the page, the figure and JSON say the same of it."""

from __future__ import annotations

import html
import inspect
import json
import pathlib

import pandas as pd
import PIL.Image
import pytest

import warprock as wr
from tests.shared.commands import invoke, succeed
from tests.shared.meshes import l_profile, write
from warprock.api.found import Found
from warprock.figures.drawing import Drawing
from warprock.findings.kinds import kinds
from warprock.report.folder import ResultFolder

SHORT = ["-s", "run.duration=4 s"]
GRID = ["-s", "motion.frequency=1 Hz, 2 Hz", "-s", "motion.amplitude=0.01 g to 1 g, 8"]
SPECTRUM = ["-s", 'spectrum.period=["1 s", "4 s"]', "-s", 'spectrum.slenderness=["10 deg"]']
ASKED: dict[str, list[str]] = {
    "run": ["run", "free-b0"],
    "map": ["map", "overturning-map", *GRID],
    "spectrum": ["spectrum", "rocking-spectrum", *SPECTRUM, *SHORT],
    "ida": [
        *("ida", "record-ridgecrest", "--from", "0.2", "--to", "2", "--count", "4"),
        *("--accuracy", "0.1", *SHORT),
    ],
    "sensitivity": ["sensitivity", "sobol-single-block", "-s", "sample.lanes=16"],
    "validate": ["validate", "record-ridgecrest", *SHORT, "--observed", "SEEN"],
    "fragility": ["fragility", "RUN", "--max-doubt", "1"],
    "predictors": ["predictors", "RUN", "--max-doubt", "1", "--limit", "0.39"],
    "risk": ["risk", "RUN", "--max-doubt", "1", "--k0", "1e-4", "--k", "2"],
    "measures": [
        *("measures", "fragility-five-blocks", "-e", "housner", "-s", "motion.scale=1"),
        *("-s", "block.width=0.5 m", "-s", "run.duration=30 s", "--k0", "1e-3", "--k", "2"),
        *("--count", "5", "--accuracy", "0.2", "--measure", "block.width=0.6 m"),
    ],
    "brief": [
        *("brief", "fragility-five-blocks", "-e", "housner", "-s", "motion.scale=1"),
        *("-s", "block.width=0.5 m", "-s", "run.duration=30 s", "--k0", "1e-3", "--k", "2"),
        *("--count", "5", "--accuracy", "0.2", "--measure", "block.width=0.6 m"),
    ],
    "verdict": [
        *("verdict", "record-ridgecrest", "-e", "housner", "-s", "motion.scale=0.5"),
        *("--neighbours", "16", *SHORT),
    ],
    "compare": ["compare", "free-b0", "-e", "housner", "-e", "event"],
    "study": [
        *("run", "sensitivity-b0", "-s", "run.duration=1 s", "-s", "study.engines=['impulse']"),
        *("-s", "study.vary={substeps=[10, 20]}", "-s", "engines.impulse.substeps=10"),
    ],
    "limit": ["limit", "ARCH", "-s", "assembly.voussoirs=7"],
    "capacity": ["capacity", "free-b0"],
    "identify": ["identify", "HISTORY", "--width", "1 m", "--height", "5 m"],
    "body": ["body", "MESH", "--density", "2700 kg/m^3"],
    "trade": ["trade", "--scene", "free", "-e", "housner"],
    "stability": [
        *("stability", "-e", "housner", "--map", "step", "--points", "2", "--steps", "50"),
    ],
}
"""Public function -> its command, which gives a finding."""
IN_PARTS = ("sweep",)
"""Functions whose command is several."""
MEASURED = ("bench",)
"""Functions that take minutes: `tests/measure/test_peers.py` cuts them short and holds them."""
OFTEN = ("capacity", "compare", "spectrum", "sweep")
"""Functions that the ordinary run holds; the others, which take longer: `thorough`."""
OWN_TITLES = ("run", "compare", "stability")
"""Functions whose figures each say something else than the finding."""


def functions() -> list[str]:
    """The public functions that give a finding."""
    every = [name for name in wr.__all__ if inspect.isfunction(getattr(wr, name))]
    gives = {name: inspect.signature(getattr(wr, name)).return_annotation for name in every}
    return [name for name, kind in gives.items() if str(kind) in ("Found", "Run", "BodyFound")]


def told(asked: list[str], out: pathlib.Path) -> list[str]:
    """What a command prints, line by line; its results are in the folder."""
    result = succeed(*asked, "-o", out)
    return result.stdout.splitlines()


def made(asked: list[str], place: pathlib.Path) -> list[str]:
    """A command whose files are there."""
    files = {"SEEN": place / "seen.csv", "RUN": place / "run", "HISTORY": place / "rocking.csv"}
    if "HISTORY" in asked:
        run = wr.run("free-b0", "housner", progress=False)
        run.history(0, "10 ms").to_csv(files["HISTORY"], index=False)
    if "SEEN" in asked:
        seen = pd.DataFrame({"lane": range(7), "observed": [False] * 4 + [True] * 3})
        seen.to_csv(files["SEEN"], index=False)
    if "RUN" in asked:
        told(["run", "sobol-single-block", "-s", "sample.lanes=64"], files["RUN"])
    if "ARCH" in asked:
        files["ARCH"] = place / "arch.toml"
        succeed("init", "arch", files["ARCH"])
    if "MESH" in asked:
        files["MESH"] = write(l_profile(), place, "corbel.stl")
    return [str(files.get(text, text)) for text in asked]


@pytest.mark.usefixtures("pages_bare")
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in OFTEN else pytest.mark.thorough)
        for name in functions()
        if name not in MEASURED
    ],
)
def test_terminal_page_notebook_and_figure_say_the_same_sentence(
    name: str, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    """And so does what `run.json` and the tables alone tell."""
    if name in IN_PARTS:
        pytest.skip("its page and its function are held to one another below")
    asked, out, founds = made(ASKED[name], tmp_path), tmp_path / "out", list[Found]()
    figures = Found.figures

    def kept(self: Found) -> list[Drawing]:
        founds.append(self)
        return figures(self)

    monkeypatch.setattr(Found, "figures", kept)
    printed = told(asked, out)
    found, drawings = founds[-1], figures(founds[-1])
    sentence = found.finding.sentences[0]
    assert sentence.endswith(".")
    assert sentence in printed
    page = html.unescape((out / "report.html").read_text(encoding="utf-8"))
    assert f"<p>{sentence}</p>" in page
    assert sentence in html.unescape(found._repr_html_())
    if drawings and name not in OWN_TITLES:
        with PIL.Image.open(out / f"{drawings[0].name}.png") as image:
            assert f"{image.info['Title']}." == sentence
    kept_there = ResultFolder(out)
    kind = next((kind for key, kind in kinds().items() if key in kept_there.facts), None)
    if kind is not None:
        files = {each: each if "." in each else f"{each}.parquet" for each in kind.tables}
        tables = {each: kept_there.table(file) for each, file in files.items()}
        assert kind.tell(kept_there.facts, tables).sentences[0] == sentence


def test_a_sweep_says_on_its_page_what_its_function_says(tmp_path: pathlib.Path):
    found = wr.sweep("free-b0", tmp_path, "housner", chunk=1, progress=False)
    page = html.unescape(found.report().read_text(encoding="utf-8"))
    assert found.finding.sentences[0] == "2 of 2 lanes are done, in 2 of 2 chunks."
    for sentence in found.finding.sentences:
        assert f"<p>{sentence}</p>" in page
    assert found.finding.sentences[0] in html.unescape(found._repr_html_())


@pytest.mark.usefixtures("unrendered")
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


@pytest.mark.usefixtures("unrendered")
def test_a_page_that_is_written_later_tells_what_the_command_told(tmp_path: pathlib.Path):
    printed = told(ASKED["map"], tmp_path)
    (tmp_path / "report.html").unlink()
    assert invoke("report", tmp_path).exit_code == 0
    page = html.unescape((tmp_path / "report.html").read_text(encoding="utf-8"))
    for begins in ("The weakest pulse that", "The weakest of each group", "Of the 48 pulses"):
        (sentence,) = (line for line in printed if line.startswith(begins))
        assert sentence in page
