"""The fingerprints that show whether a move of code changed an answer."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable

import pytest

from tools import freeze
from warprock import InputError
from warprock.engines.launching import Form
from warprock.model.response import LANE_FIELDS

HASH = "[0-9a-f]{16}"
CASE = "free-b1-b3"


@pytest.fixture
def lines() -> Callable[..., list[str]]:
    """Lines of two lanes of a case over a moment, of one engine in double precision."""

    def printed(case: str = CASE, seconds: float = 0.3) -> list[str]:
        asked = argparse.Namespace(
            cases=[case], lanes=2, seconds=seconds, precisions=["float64"], engines=["housner"]
        )
        return list(freeze.lines(asked))

    return printed


def test_every_field_of_both_forms_has_a_line_and_the_same_one_twice(
    lines: Callable[..., list[str]],
) -> None:
    inputs, *fields = lines()
    assert re.fullmatch(f"inputs {CASE} {HASH}", inputs)
    found = {form: set[str]() for form in Form}
    for line in fields:
        match = re.fullmatch(rf"lanes {CASE} housner float64 (\w+) (\w+) {HASH}", line)
        assert match, line
        found[Form(match[1])].add(match[2])
    for names in found.values():
        assert {*LANE_FIELDS, "rotation"} <= names
    assert len(fields) == sum(len(names) for names in found.values())
    assert lines() == [inputs, *fields]


def test_another_answer_has_another_line(lines: Callable[..., list[str]]) -> None:
    one, other = lines(), lines(seconds=0.31)
    assert len(one) == len(other)
    changed = {a.rsplit(" ", 1)[0] for a, b in zip(one, other, strict=True) if a != b}
    assert f"lanes {CASE} housner float64 packed rotation" in changed
    assert f"inputs {CASE}" not in changed


def test_a_case_that_is_asked_for_is_never_left_out(lines: Callable[..., list[str]]) -> None:
    with pytest.raises(InputError, match="no-such-case"):
        lines("no-such-case")


def test_what_belongs_to_the_moment_is_left_out() -> None:
    answer = {"wall_time_s": 1.0, "lanes": [{"finished": "now", "rotation": 0.1}], "cases": 3}
    assert freeze.without_moment(answer) == {"lanes": [{"rotation": 0.1}], "cases": 3}


def test_every_command_has_a_line_of_its_help() -> None:
    found = list(freeze.help_lines(freeze.warprock))
    assert all(re.fullmatch(f"help warprock[a-z ]* {HASH}", line) for line in found)
    named = {line.rsplit(" ", 1)[0] for line in found}
    assert {"help warprock", "help warprock run", "help warprock sweep plan"} <= named
    assert len(named) == len(found)
