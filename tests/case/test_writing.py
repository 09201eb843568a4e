"""The text of a case: `load_case` and `to_toml` undo one another."""

import functools
import json
import pathlib
import shutil
import tomllib

import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.shared.shipped import RUNNABLE_CASES
from warprock.case.lanes import expand_lanes
from warprock.case.load import build_case, load_case
from warprock.case.text import case_names, data_folder, template_kinds, template_text
from warprock.case.writing import WIDTH, toml_text
from warprock.units import UNITS, Dimension, parse_quantity

of_name = functools.cache(load_case)


@pytest.mark.parametrize("name", case_names())
def test_a_shipped_case_that_is_written_reads_as_it_was(name: str, write):
    case = of_name(name)
    file = write(case.to_toml())
    for table in data_folder(name, None).glob("*.csv"):
        shutil.copy(table, pathlib.Path(file).parent)
    again = load_case(file)
    # As JSON the order is compared, too: it numbers lanes and the dimensions of a sample.
    for table, written in again.raw.items():
        assert json.dumps(written) == json.dumps(case.raw[table])
    assert again.raw.keys() == case.raw.keys()
    assert again.lane_count == case.lane_count
    assert again.tables == case.tables
    some = range(min(case.lane_count, 50))
    if name in RUNNABLE_CASES:
        one, other = (expand_lanes(each, some).inputs for each in (case, again))
        pd.testing.assert_frame_equal(one, other, check_exact=True)


@pytest.mark.parametrize("kind", template_kinds())
def test_a_template_that_is_written_reads_as_it_was(kind: str):
    tables = tomllib.loads(template_text(kind))
    assert tomllib.loads(toml_text(tables)) == tables


@pytest.mark.parametrize("name", case_names())
def test_a_case_is_written_as_a_person_would(name: str):
    case = of_name(name)
    text = case.to_toml()
    prose = 0
    for line in text.splitlines():
        prose ^= line.count('"""') % 2
        assert len(line) <= WIDTH or prose or line.startswith(("title", "because"))
    assert "[sweep." not in text
    assert "[[sweep]]" in text or "sweep" not in case.raw


_TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
_VALUES = st.recursive(
    _TEXT
    | st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False)
    | st.sampled_from(['a"""b', 'ends "', "back\\slash\n", "\r\n", "\x7f\n", "from"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(_TEXT | st.sampled_from(["from", "a.b", "y", ""]), inner, max_size=3)
    ),
    max_leaves=8,
)


@given(st.dictionaries(_TEXT, _VALUES, max_size=4))
def test_any_tables_are_read_as_they_were_written(tables):
    assert tomllib.loads(toml_text(tables)) == tables


@settings(max_examples=20)
@given(
    sizes=st.lists(st.floats(10.0, 1000.0), min_size=1, max_size=5),
    friction=st.floats(0.0, 50.0),
    unit=st.sampled_from(["m", "mm", "ft"]),
    seed=st.integers(0, 2**63 - 1),
    order=st.permutations(["amplitude", "start"]),
)
def test_a_case_of_any_numbers_reads_as_the_same_lanes(sizes, friction, unit, seed, order):
    drawn = {
        "amplitude": {"distribution": "lognormal", "median": "1 g", "dispersion": 0.25},
        "start": ["0.1 s", "0.2 s"],
    }
    raw = {
        "title": "any",
        "source": 'lines\nof "text" \\ in C:\\n',
        "block": {"width": "0.5 m", "depth": "1 m", "density": "1 t/m^3"},
        "contact": {"friction": friction},
        "motion": {"waveform": "sine", "control": "acceleration", "cycles": 1, "frequency": "2 Hz"},
        "run": {"duration": "5 s"},
        "sweep": [{"block.height": [f"{size!r} {unit}" for size in sizes]}],
        "sample": {"lanes": 4, "seed": seed, "over": {"motion": {k: drawn[k] for k in order}}},
    }
    case = build_case("any", "any.toml", None, raw)
    again = build_case("any", "any.toml", None, tomllib.loads(case.to_toml()))
    assert again.raw == raw
    assert list(again.axes[-1].columns) == list(case.axes[-1].columns)
    one, other = (expand_lanes(each).inputs for each in (case, again))
    pd.testing.assert_frame_equal(one, other, check_exact=True)


@given(st.floats(-1e300, 1e300, allow_subnormal=False), st.sampled_from(list(Dimension)))
def test_a_number_and_its_si_unit_are_read_as_that_very_number(value, dimension):
    text = f"{value!r} {next(iter(UNITS[dimension]))}"
    assert parse_quantity(text.strip(), dimension) == value
