"""Parts that are kept: a file is whole, and of what is asked for, or it is not taken."""

from __future__ import annotations

import pathlib

import numpy as np
import pyarrow as pa
import pytest

from warprock.running.parts import State, find_part, read_part, write_part

TABLE = pa.table({"lane": np.arange(500), "peak": np.random.default_rng(1).uniform(size=500)})
OF = {"plan": "abc", "part": 1}


@pytest.fixture
def place(tmp_path: pathlib.Path) -> pathlib.Path:
    path = tmp_path / "parts" / "one.parquet"
    write_part(path, TABLE, {**OF, "more": [1, 2]})
    return path


def test_a_part_comes_back_as_it_was_written(place: pathlib.Path):
    part = find_part(place, OF)
    assert (part.state, part.rows, part.footer["more"]) == (State.DONE, 500, [1, 2])
    assert read_part(place).replace_schema_metadata(None).equals(TABLE)
    assert [path.name for path in place.parent.iterdir()] == ["one.parquet"]


@pytest.mark.parametrize("of", [{"plan": "abd"}, {"part": 2}, {"other": None}])
def test_a_part_of_something_else_is_foreign(place: pathlib.Path, of: dict[str, object]):
    part = find_part(place, {**OF, **of})
    assert part.state is State.FOREIGN
    assert part.footer["plan"] == "abc"


def test_a_part_that_is_missing_or_cut_off_is_not_taken(place: pathlib.Path):
    assert find_part(place.with_name("two.parquet"), OF).state is State.MISSING
    content = place.read_bytes()
    place.write_bytes(content[:-20])
    assert find_part(place, OF).state is State.BROKEN
    with pytest.raises(OSError, match=r"."):
        read_part(place)


def test_damaged_numbers_are_not_read(place: pathlib.Path):
    content = bytearray(place.read_bytes())
    content[len(content) // 2] ^= 0xFF
    place.write_bytes(bytes(content))
    assert find_part(place, OF).state is State.DONE
    with pytest.raises(OSError, match=r"."):
        read_part(place)
