"""Briefs: chances in words and digits, slides, the page, and its print where a browser is there."""

from __future__ import annotations

import html
import json
import os
import pathlib
import re
import stat

import numpy as np
import pytest

import warprock as wr
from tests.shared.commands import invoke, succeed
from warprock.findings.brief import chance_word, one_in, times
from warprock.report import brief as printing
from warprock.units import GRAVITY

pytestmark = pytest.mark.usefixtures("pages_bare")

ONE = {"motion.scale": 1.0, "block.width": "0.5 m", "run.duration": "40 s"}
LAW = {"k0": 1e-3, "k": 2.0, "im": "PGA"}
QUICK = {"from_": 0.2, "to": 10.0, "count": 9, "accuracy": 0.05, "progress": False}
CASE = "fragility-five-blocks"
OPTIONS = ("-s", "motion.scale=1", "-s", "block.width=0.5 m", "-s", "run.duration=40 s")
OPTIONS += ("--from", 0.2, "--count", 9, "--accuracy", 0.05, "--k0", 1e-3, "--k", 2)


@pytest.mark.parametrize(
    ("chance", "word", "odds"),
    [
        (0.995, "virtually certain", "10 in 10"),
        (0.95, "very likely", "10 in 10"),
        (0.7, "likely", "7 in 10"),
        (0.5, "about as likely as not", "1 in 2"),
        (0.2, "unlikely", "1 in 5"),
        (0.0345, "very unlikely", "1 in 29"),
        (7.06e-4, "exceptionally unlikely", "1 in 1,400"),
    ],
)
def test_a_chance_has_a_word_and_odds(chance: float, word: str, odds: str):
    assert (chance_word(chance), one_in(chance)) == (word, odds)


def test_a_factor_is_a_fraction_below_one():
    assert [times(each) for each in (0.0768, 0.985, 1.0, 1.02, 2.34)] == [
        *("1/13", "1", "1", "1", "2.3"),
    ]


def test_a_brief_says_what_risk_and_measures_say():
    asked = {"overrides": ONE, "measure": "block.width=0.6 m", **LAW, **QUICK}
    found = wr.brief(CASE, "housner", **asked)
    facts = found.facts["brief"]
    ida = wr.ida(CASE, "housner", overrides=ONE, **QUICK)
    risk = wr.risk(ida, **LAW).table.iloc[0]
    for name in ("rate_per_year", "rate_p05_per_year", "rate_p95_per_year", "median"):
        assert facts[name] == risk[name]
    assert facts["median_exceeded_per_year"] == pytest.approx(
        1e-3 * (risk["median"] / GRAVITY) ** -2.0, rel=1e-12
    )
    measures = wr.measures(CASE, "housner", **asked).table
    assert found.table["factor"].tolist() == measures["factor"].tolist()
    assert facts["slides"] is False
    text = " ".join(found.finding.sentences)
    chance = 1.0 - np.exp(-50.0 * risk["rate_per_year"])
    assert f"within 50 years with a chance of {100.0 * chance:.2g} %" in text
    assert "this engine leaves sliding out" in text


@pytest.mark.thorough
def test_slides_before_a_fall_are_counted_at_the_motions_below_it():
    low = {**ONE, "contact.friction": 0.15}
    asked = {"overrides": low, "measure": "block.width=0.6 m", **LAW, **QUICK}
    # With little friction the block slides and does not fall at most motions.
    with pytest.raises(wr.InputError, match="must have a rate to lower"):
        wr.brief(CASE, "event", **{**asked, "to": 1.0})
    high = {**ONE, "contact.friction": 0.28}
    quick = {**asked, "overrides": high, "count": 7}
    found = wr.brief(CASE, "event", clearance="20 mm", **quick)
    slide, facts = found.found.slide, found.facts["brief"]
    assert slide.standing > 0.02
    assert 0 < slide.before <= facts["lanes"]
    text = " ".join(found.finding.sentences)
    assert f"Under {slide.before} of " in text
    assert "it slides 20 mm before it falls" in text
    # A clearance beyond all slides at motions that it stands is not reached before a fall.
    far = wr.brief(CASE, "event", clearance=f"{2.0 * slide.standing:.6g} m", **quick)
    assert far.found.slide.before == 0
    assert far.found.slide.standing == slide.standing


def test_the_command_leaves_a_page_and_says_why_there_is_no_print(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(printing, "BROWSERS", ("chromium",))
    out = tmp_path / "out"
    asked = (CASE, "-e", "housner", *OPTIONS, "--measure", "block.width=0.6 m", "-o", out)
    done = succeed("brief", *asked, "--json")
    said = json.loads(done.stdout)
    assert said["brief"]["rate_per_year"] > 0.0
    assert [row["measure"] for row in said["rows"]] == ["block.width=0.6 m"]
    assert "no browser that prints was found: open" in done.stderr
    assert "\n" not in done.stderr.strip().splitlines()[-1]
    page = (out / "brief.html").read_text(encoding="utf-8")
    assert not (out / "brief.pdf").exists()
    assert "<script" not in page
    assert "http" not in re.sub(
        r"http://www\.w3\.org[^\"']*|http://purl\.org[^\"']*", "", page
    ).replace("http-equiv", "").replace("https://matplotlib.org", "").replace(
        "http://creativecommons.org", ""
    )
    text = html.unescape(re.sub(r"<[^>]+>", " ", page))
    for said in (
        "What it takes",
        "slide into something first",
        "How sure",
        "What helps",
        "left out",
    ):
        assert said in text
    assert page.count("<svg") == 3
    assert {"measures.csv", "run.json", "report.html", "object.png"} <= {
        path.name for path in out.iterdir()
    }
    (out / "report.html").unlink()
    succeed("report", out)


def test_a_browser_prints_the_page(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch):
    page = tmp_path / "brief.html"
    page.write_text("<p>brief</p>", encoding="utf-8")
    fake = tmp_path / "chromium"
    fake.write_text(
        '#!/bin/sh\nfor each in "$@"; do case "$each" in --print-to-pdf=*) '
        'echo "$@" > "${each#--print-to-pdf=}";; esac; done\n',
        encoding="utf-8",
    )
    fake.chmod(fake.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}/usr/bin:/bin")
    monkeypatch.setattr(printing, "BROWSERS", ("chromium",))
    assert printing.find_browser() == str(fake)
    assert printing.print_page(page, str(fake)) == ""
    assert page.resolve().as_uri() in (tmp_path / "brief.pdf").read_text(encoding="utf-8")
    fake.write_text("#!/bin/sh\necho no screen >&2\nexit 3\n", encoding="utf-8")
    assert printing.print_page(page, str(fake)).endswith("did not print it: no screen")
    assert "did not print it" in printing.print_page(page, str(tmp_path / "none"))


@pytest.mark.thorough
@pytest.mark.extra
@pytest.mark.skipif(printing.find_browser() is None, reason="there is no browser")
def test_the_page_prints_on_two_sheets(tmp_path: pathlib.Path):
    asked = (CASE, "-e", "housner", *OPTIONS, "-o", tmp_path)
    succeed("brief", *asked)
    content = (tmp_path / "brief.pdf").read_bytes()
    assert len(re.findall(rb"/Type\s*/Page\b", content)) == 2


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ((), "--hazard: got nothing, must be a file"),
        (("--k0", 1e-3, "--k", 2, "--clearance", "far"), "--clearance: got 'far', must be"),
        (("--k0", 1e-3, "--k", 2, "--clearance", "-1 mm"), "--clearance: got '-1 mm', must be abo"),
        (("--k0", 1e-3, "--k", 2, "--clearance", "1 g"), "--clearance: got '1 g', must be"),
    ],
)
def test_what_cannot_be_asked_is_refused(asked: tuple[object, ...], said: str):
    done = invoke("brief", CASE, "-s", "motion.scale=1", "-e", "housner", *asked)
    assert done.exit_code == 2
    assert said in done.output
