"""`run.json` as it is read, that of older versions too."""

from __future__ import annotations

import json
import pathlib

import pytest

from warprock.errors import InputError
from warprock.running.run_file import REFINEMENT, read_facts

COUNTS = dict.fromkeys(REFINEMENT, 3)


@pytest.mark.parametrize("key", ["refinement", "accuracy"])
def test_counts_of_lanes_are_read_under_the_key_of_today_and_the_one_before(
    key: str, tmp_path: pathlib.Path
) -> None:
    file = tmp_path / "run.json"
    file.write_text(json.dumps({"lanes": 9, key: COUNTS}), encoding="utf-8")
    assert read_facts(file) == {"lanes": 9, "refinement": COUNTS}
    file.write_text(json.dumps({"lanes": 9, key: {"met": 3}}), encoding="utf-8")
    with pytest.raises(InputError, match=r"refinement\.missed: got nothing"):
        read_facts(file)
