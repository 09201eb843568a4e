"""Collapse loads by slow pushes against limit analysis."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

import warprock as wr
from tests.shared.hexagons import hexagonal_vault
from warprock.analysis.pushing import _narrowed

pytestmark = pytest.mark.usefixtures("pages_bare")

HEXAGONS = """
title = "A barrel vault of hexagons"
source = "Made up."
model = "spatial"
[assembly]
pattern = "file"
file = "vault.obj"
file_unit = "1 m"
fixed = ["left", "right"]
density = "2000 kg/m^3"
[contact]
friction = 0.7
[motion]
waveform = "tilt"
tilt_rate = "5 deg/s"
[run]
duration = "9 s"
"""

DRUMS = wr.Case(
    assembly=wr.Assembly(
        pattern="column", drum_width="1 m", drum_height="0.75 m", drums=4, density="2000 kg/m^3"
    ),
    contact=wr.Contact(friction=0.7),
    run=wr.Times(duration="1 s"),
    sweep=wr.Sweep({"contact.friction": [0.1, 0.32, 0.7]}),
)


@pytest.mark.thorough
@pytest.mark.usefixtures("two_rooms")
def test_drums_that_slide_and_drums_that_tip_collapse_at_their_loads():
    """At the friction, and at width / height: found to 1e-3, which steps of 1e-3 s add less to.

    At 0.32 what slides under the loads tried first has slid off by the end.
    """
    found = wr.limit(DRUMS, push=True, progress=False)
    due = [0.1, 0.32, 1.0 / 3.0]
    assert found.table["pushed_load_factor"].tolist() == pytest.approx(due, rel=2e-3)
    told = " ".join(found.finding.sentences)
    assert "3 of them collapse at 0.100 to 0.333 of the weight" in told
    assert {drawing.name for drawing in found.figures()} == {"mechanism", "push"}


@pytest.mark.thorough
def test_a_vault_of_hexagons_falls_at_its_load_and_not_by_what_steps_leave(tmp_path: pathlib.Path):
    """Along its axis between Coulomb's estimate, one of several such loads, and the bound.

    Pushes of the vault and of its mirror image come to .316 and .318, from .99 of the estimate on.
    """
    (tmp_path / "vault.obj").write_text(hexagonal_vault(), encoding="utf-8")
    (tmp_path / "case.toml").write_text(HEXAGONS, encoding="utf-8")
    found = wr.limit(tmp_path, direction="270 deg", push=True, progress=False).table.iloc[0]
    assert found["coulomb_load_factor"] == pytest.approx(0.317, abs=1e-3)
    assert 0.99 * found["coulomb_load_factor"] < found["pushed_load_factor"] < found["load_factor"]


def test_a_lane_without_a_number_below_the_collapse_leaves_nothing_found():
    bracket, factors = np.array([0.0, 4.0]), np.array([1.0, 2.0, 3.0])
    fell, sound = np.array([False, False, True]), np.ones(3, dtype=bool)
    assert _narrowed(bracket, factors, fell, sound)[0].tolist() == [2.0, 3.0]
    lost = np.array([True, True, False])
    assert _narrowed(bracket, factors, fell, lost)[1]
    assert _narrowed(bracket, factors, np.array([False, True, False]), lost)[0].tolist() == [1, 2]


def test_a_map_is_of_pulses():
    motion = {"motion.waveform": "push", "motion.amplitude": "0.3 g"}
    with pytest.raises(wr.InputError, match=r"limit (--)?push"):
        wr.map(DRUMS, overrides=motion, progress=False)


def test_an_engine_is_named_for_pushes_alone():
    with pytest.raises(wr.InputError, match="engine"):
        wr.limit(DRUMS, "assembly", progress=False)


@pytest.mark.usefixtures("two_rooms")
def test_the_page_of_a_push_tells_limit_analysis_beside_the_collapse(tmp_path: pathlib.Path):
    push = {"motion.waveform": "push", "motion.amplitude": "0.5 g", "contact.friction": 0.7}
    longer = {"run.duration": "6 s"}
    run = wr.run(DRUMS, overrides=push | longer, tolerance=None, progress=False)
    said = "a steady sideways load of 0.333 of the weight brings it down"
    assert said in " ".join(run.finding.sentences)
    run.save(tmp_path / "push")
    assert said in (tmp_path / "push" / "report.html").read_text(encoding="utf-8")
