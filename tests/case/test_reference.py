"""The reference of all keys: it says what the tables declare, and a case is judged by it."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator

import pytest

from tests.shared.case_texts import FREE, PULSE, refusal
from tests.shared.commands import invoke, succeed
from warprock.case.case_file import APART, CaseFile
from warprock.case.check import Check
from warprock.case.input_columns import input_meaning
from warprock.case.keys import KEYS, SWEEP_KEYS
from warprock.case.motion import Direction
from warprock.case.reference import find_sections, reference_page, sections
from warprock.case.validation import Table
from warprock.errors import InputError
from warprock.quantity import NumberKey
from warprock.settings.engines import SETTINGS, build_settings, declared_settings
from warprock.settings.programs import PEER_SETTINGS
from warprock.units import Dimension, ending, format_quantity, parse_quantity

ROWS = [row for section in sections() for row in section.keys]
BY_KEY = {row.key: row for row in ROWS}


def tables_below(table: type[Table]) -> Iterator[type[Table]]:
    """Every table that declares keys of a case file, as Python knows them."""
    for each in table.__subclasses__():
        if each.__module__.startswith("warprock."):
            yield each
        yield from tables_below(each)


def test_every_table_of_a_case_file_is_there():
    titles = " ".join(section.title for section in sections())
    values = {"title", "source", "model"}
    tables = set(CaseFile.names()) - values - {"engines", "peers"}
    assert set(APART) < tables
    for name in tables:
        assert f"[{name}" in titles, name
    for name in SETTINGS:
        assert f"[engines.{name}]" in titles
    for name in PEER_SETTINGS:
        assert f"[peers.{name}]" in titles


def test_every_key_of_every_table_is_there():
    shown = {section.text for section in sections()}
    for table in tables_below(Table):
        if table is Direction or table is Check or table.__name__.startswith("_"):
            continue
        assert (table.__doc__ or "").splitlines()[0] in shown, table
        for name, declared in table.declared().items():
            key = f"{table.place}.{name}" if table.place else name
            assert BY_KEY[key].text, key
            assert declared.text in {row.text for row in ROWS if row.key == key}


def test_every_field_of_every_table_is_declared():
    inner = {"block", "contact", "start", "motion", "run", "engines", "peers", "check", "y", "z"}
    inner |= {"assembly", "transverse_wall", "tie", "top_load", "frame", "strip", "ground"}
    inner |= {"support"}
    for table in tables_below(Table):
        fields = {field.alias or name for name, field in table.model_fields.items()}
        assert fields - set(table.declared()) <= inner | {"kind"}, table


def test_what_may_be_swept_is_what_the_sweep_takes():
    assert {row.key for row in ROWS if row.swept} == set(SWEEP_KEYS)
    assert set(KEYS) <= set(BY_KEY)


@pytest.mark.parametrize("row", [row for row in ROWS if row.columns], ids=lambda row: row.key)
def test_every_column_has_a_unit_and_a_meaning(row):
    for column in row.columns:
        numbered = column.replace("_N", "_2", 1) if ".N." in row.key else column
        unit, text = input_meaning(numbered)
        assert text != input_meaning("a label")[1], column
        assert unit == "-" or ending(unit).lower() in column.lower()


NUMBERS = [(key, each) for key, each in KEYS.items() if isinstance(each, NumberKey)]


@pytest.mark.parametrize(("key", "declared"), NUMBERS, ids=[key for key, _ in NUMBERS])
def test_the_bounds_are_those_that_a_value_is_judged_by(key, declared):
    row = BY_KEY[key]
    for dimension, ends in declared.bounds.items():
        for end, out, away in (
            (ends[0], declared.low_open, -1.0),
            (ends[1], declared.high_open, 1.0),
        ):
            assert end in row.holds
            value = parse_quantity(end, dimension)
            if out:
                with pytest.raises(ValueError, match="must be"):
                    declared.read(end)
            else:
                declared.read(end)
            beyond = format_quantity(value + away * max(abs(value), 1.0), dimension)
            with pytest.raises(ValueError, match=r"at least|more than"):
                declared.read(float(beyond) if dimension is Dimension.DIMENSIONLESS else beyond)


def test_a_refusal_names_what_the_reference_says(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(FREE.replace('"1 m"', '"2 km"'), encoding="utf-8")
    said = str(refusal(file))
    assert BY_KEY["block.height"].text in said
    assert all(end in said for end in BY_KEY["block.height"].holds.split(" to "))


@pytest.mark.parametrize("waveform", ["sine", "ricker", "mavroeidis-papageorgiou", "record"])
def test_a_waveform_needs_what_the_reference_says(waveform, tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(f'{FREE}[motion]\nwaveform = "{waveform}"\n', encoding="utf-8")
    needed = [row for row in ROWS if waveform in row.needed_by]
    assert str(refusal(file)).startswith(f"{file}: {needed[0].key}: got nothing, must be ")
    allowed = {r.key for r in ROWS if not r.allowed_with or waveform in r.allowed_with}
    pulse = PULSE.replace('"sine"', f'"{waveform}"')
    file.write_text(pulse, encoding="utf-8")
    if waveform == "ricker":
        assert "motion.cycles" not in allowed
        assert f"{file}: motion.cycles: got a value, must not be given" in str(refusal(file))


@pytest.mark.parametrize("engine", SETTINGS)
def test_settings_are_judged_by_their_declarations(engine: str):
    settings = build_settings(engine, {}, "test")
    assert settings == SETTINGS[engine]()
    for name, declared in declared_settings(SETTINGS[engine]).items():
        assert declared.low <= getattr(settings, name) <= declared.high
        assert isinstance(getattr(settings, name), int if declared.whole else float)
        assert BY_KEY[f"engines.{engine}.{name}"].unit == declared.unit
        with pytest.raises(InputError, match=f"engines.{engine}.{name}: got .* must be from"):
            build_settings(engine, {name: 2 * declared.high + 1}, "test")
    assert set(declared_settings(SETTINGS[engine])) == {
        field.name for field in dataclasses.fields(SETTINGS[engine])
    }


def test_the_page_has_a_row_for_every_key():
    page = reference_page(sections())
    for row in ROWS:
        assert f"| `{row.key}` |" in page
    assert all(line.count(" | ") == 3 for line in page.splitlines() if line.startswith("| `"))


@pytest.mark.parametrize(
    ("wanted", "keys"),
    [
        ("block.height", ["block.height", "block.height"]),
        ("block.2.height", ["block.N.height", "block.N.height"]),
        ("[run]", ["run.duration", "run.sample_interval"]),
        ("motion.y.scale", ["motion.scale"]),
        ("engines.two-block", ["engines.two-block.rest_rotation_ratio"]),
    ],
)
def test_a_table_or_a_key_is_found(wanted: str, keys: list[str]):
    assert [row.key for section in find_sections(wanted) for row in section.keys] == keys
    assert find_sections("motion.y") == find_sections("motion")


def test_the_command_prints_keys():
    printed = succeed("keys", "block.height")
    assert "1 mm to 1 km" in printed.stdout
    assert "height_m" in printed.stdout
    found = json.loads(invoke("keys", "block", "--json").stdout)
    assert [table["title"] for table in found["tables"]] == [
        "[block]",
        "[block] of a body",
        "[block.N]",
        "[block.N] of a body",
    ]
    assert found["tables"][0]["keys"][1]["holds"] == "1 mm to 1 km"
    page = invoke("keys", "--markdown").stdout
    assert page.rstrip("\n") == reference_page(sections())


def test_the_command_refuses_what_is_no_key():
    refused = invoke("keys", "block.hight")
    assert refused.exit_code == 2
    assert refused.stderr.startswith("error: TABLE: got 'block.hight', must be a table or a key")
    assert "did you mean block.height?" in refused.stderr
