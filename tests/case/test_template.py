"""Case files to start from: what may be asked for, and that the result is a case."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from warprock.case.template import bodies, start_case
from warprock.case.text import template_kinds, template_text
from warprock.errors import InputError
from warprock.recordings.column_file import Reading
from warprock.units import Dimension, parse_quantity

NOTHING_SAID = Reading()


def made(kind: str, **asked: Any) -> dict[str, Any]:
    return tomllib.loads(start_case(kind, reading=NOTHING_SAID, **asked).text)


def test_nothing_asked_is_the_template():
    for kind in template_kinds():
        assert start_case(kind, reading=NOTHING_SAID).text == template_text(kind)


@pytest.mark.parametrize("name", bodies())
def test_every_body_makes_a_case(name: str):
    tables = made("pulse", body=name)
    assert ("diameter" in tables["block"]) != ("width" in tables["block"])
    assert tables["contact"]["friction"] == bodies()[name]["friction"]
    assert tables["title"].lower() == bodies()[name]["text"].lower()


def test_sizes_make_a_body():
    box = made("pulse", body="0.6 m x 2 m x 40 cm")["block"]
    assert (box["width"], box["height"], box["depth"]) == ("0.6 m", "2 m", "40 cm")
    round_base = made("pulse", body="0.9 m x 6 m")["block"]
    assert round_base["diameter"] == "0.9 m"
    assert "width" not in round_base


def test_a_body_takes_out_what_draws_or_sweeps_its_sizes():
    assert [set(axis) for axis in made("sweep", body="drum")["sweep"]] == [{"motion"}, {"motion"}]
    assert "block" not in made("sample", body="drum")["sample"]["over"]


def test_a_body_a_record_and_a_sweep_at_once(tmp_path):
    file = tmp_path / "my quake.txt"
    file.write_text("time,acceleration\n0,0\n0.5,1\n1,0\n")
    start = start_case(
        "record",
        body="cabinet",
        record=str(file),
        reading=Reading(unit="g"),
        sweeps=["motion.target_pga=0.1 g to 1 g, 4", "block.height=1 m, 2 m"],
        overrides=["contact.friction=0.3"],
    )
    assert start.lanes == 8
    tables = tomllib.loads(start.text)
    assert tables["motion"] == {"waveform": "record", "record": "my-quake.csv", "start": "0 s"}
    assert tables["run"]["duration"] == "11 s"
    assert tables["contact"]["friction"] == 0.3
    assert list(start.beside) == ["my-quake.csv"]
    assert b"# unit: m/s^2" in start.beside["my-quake.csv"]
    own = file.rename(tmp_path / "quake.csv")
    start = start_case("record", record=str(own), reading=Reading(unit="g"))
    assert list(start.beside) == ["quake-si.csv"]
    shipped = start_case("record", record="ridgecrest-2019-ccc-360", reading=NOTHING_SAID)
    assert not shipped.beside


@pytest.mark.parametrize(
    ("kind", "asked", "words"),
    [
        ("spectrum", {"body": "1 m x 2 m"}, "--body: .* must be left out with spectrum"),
        ("pulse", {"body": "cabinett"}, "did you mean cabinet"),
        ("pulse", {"body": "1 m x 2"}, "sizes with units"),
        ("pulse", {"record": "q.csv"}, "--record: .* follows no record: warprock init record"),
        ("pulse", {"sweeps": ["motion.amplitude=1 g"]}, "--sweep: motion.amplitude: .* several"),
        ("pulse", {"sweeps": ["motion.amplitude=1 g to 2 g"]}, "--sweep: .* how many values"),
        ("pulse", {"overrides": ["block.height=1 kg"]}, "^-s: block.height: got '1 kg'"),
    ],
)
def test_what_has_no_place_is_refused(kind: str, asked: dict[str, Any], words: str):
    with pytest.raises(InputError, match=words):
        made(kind, **asked)


@pytest.mark.parametrize("name", [*bodies(), "0.6 m x 2 m x 0.4 m", "0.9 m x 6 m"])
def test_a_body_of_a_stack_stands_on_a_pedestal_wide_enough(name: str):
    record = "ridgecrest-2019-ccc-090"
    start = start_case("stack", body=name, record=record, reading=NOTHING_SAID)
    tables, alone = tomllib.loads(start.text), made("pulse", body=name)
    block = tables["block"]["2"]
    sizes = {key: alone["block"][key] for key in ("width", "diameter", "height") if key in block}
    assert sizes == {key: block[key] for key in sizes}
    across = block.get("diameter") or block["width"]
    assert parse_quantity(tables["block"]["1"]["width"], Dimension.LENGTH) > parse_quantity(
        across, Dimension.LENGTH
    )
    assert tables["motion"] == {"waveform": "record", "record": record, "scale": 1.0}
    assert start.lanes >= 1
