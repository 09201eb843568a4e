"""What every table refuses, and how a refusal names the key wherever it lies."""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

import pytest

from tests.shared.marks import first
from warprock.case.load import build_case
from warprock.case.text import template_kinds, template_text
from warprock.case.validation import KeyedError, Table, below, dotted, refusing, validated
from warprock.case.value_kinds import ChoiceKey
from warprock.errors import InputError
from warprock.quantity import NumberKey


class Inner(Table):
    """A table in a table."""

    place: ClassVar[str] = "outer.inner"

    size: Annotated[float, NumberKey("the size", "1 mm to 1 m")]
    share: Annotated[float | None, NumberKey("the share", "0 to 1", instead_of="size")] = None
    kind: Annotated[str, ChoiceKey("the kind", ("a", "b"))] = "a"


class Outer(Table):
    """A table that must have another one."""

    place: ClassVar[str] = "outer"

    inner: Inner
    rest: tuple[Inner, ...] = ()


GOOD = {"size": "1 cm"}


@pytest.mark.parametrize(
    ("table", "path", "got", "words"),
    [
        ({}, "inner", "nothing", "must be given"),
        ({"inner": 3}, "inner", 3, "must be a table"),
        (
            {"inner": [GOOD]},
            "inner",
            [GOOD],
            "must be a table, whose name stands in single brackets",
        ),
        ({"inner": {}}, "inner.size", "nothing", "must be the size: a length"),
        ({"inner": {"size": "2 m"}}, "inner.size", "2 m", "must be at least 1 mm and"),
        ({"inner": {"sise": "1 m"}}, "inner.sise", "1 m", "did you mean size?"),
        ({"iner": {"size": "1 m"}}, "iner", {"size": "1 m"}, "did you mean inner?"),
        (
            {"inner": GOOD | {"share": 1}},
            "inner.share",
            "a value",
            "not be given beside outer.inner.size",
        ),
        ({"inner": GOOD | {"kind": "c"}}, "inner.kind", "c", "must be a or b"),
        ({"inner": GOOD, "rest": 3}, "rest", 3, "must be a list"),
        ({"inner": GOOD, "rest": [GOOD, 5]}, "rest[1]", 5, "must be a table"),
        ({"inner": GOOD, "rest": [GOOD, {}]}, "rest[1].size", "nothing", "must be the size"),
        # The mistyped key, not the one that is missing because of it or what comes first.
        ({"inner": {}, "rest": [{"sise": 1}]}, "rest[0].sise", 1, "unknown key"),
    ],
)
def test_a_refusal_names_the_key(table: dict[str, Any], path: str, got: object, words: str):
    with pytest.raises(KeyedError) as caught:
        validated(Outer, table)
    assert dotted(caught.value.path) == path
    assert caught.value.got == got
    assert words in caught.value.allowed


def test_errors_come_out_as_one_line_with_their_place():
    with (
        pytest.raises(InputError, match=r"^-s: outer\.inner\.size: got nothing, must be the size"),
        refusing(lambda key: "-s" if key.startswith("outer.") else "file"),
        below("outer"),
    ):
        validated(Outer, {"inner": {}})


def test_tables_name_their_keys_once():
    assert Inner.names() == ("size", "share", "kind")
    assert list(Inner.declared()) == ["size", "share", "kind"]
    assert Outer.declared() == {}


JUNK = [3, -0.5, float("nan"), 10**400, True, "", "x", "-3 m", "ricker", [], [[]], [1, {}], {}]


def places(table: dict[str, Any], path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every key of a case as written, and the first of every list."""
    for name, value in table.items():
        yield (*path, name)
        if isinstance(value, dict):
            yield from places(value, (*path, name))
        elif isinstance(value, list):
            yield (*path, name, 0)
            if isinstance(value[0], dict):
                yield from places(value[0], (*path, name, 0))


@pytest.mark.parametrize("kind", first(2, template_kinds()))
def test_whatever_stands_in_a_template_the_answer_is_a_case_or_one_line(kind: str):
    raw = tomllib.loads(template_text(kind))
    others = template_kinds()[: template_kinds().index(kind)]
    known = {path for other in others for path in places(tomllib.loads(template_text(other)))}
    for path in places(raw):
        # A key that another template has, too, is tried there with all of them.
        for junk in JUNK[:: 4 if path in known else 1]:
            changed: Any = copy.deepcopy(raw)
            table = changed
            for part in path[:-1]:
                table = table[part]
            table[path[-1]] = junk
            said = "case.toml: "
            try:
                json.dumps(build_case(kind, "case.toml", None, changed).raw)
            except InputError as error:
                said = str(error)
            assert said.startswith("case.toml: ")
            assert "\n" not in said
