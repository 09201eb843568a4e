"""Options are those of the Python function of the same name, which is read and not imported."""

from __future__ import annotations

import inspect
import re

import click
import pytest

import warprock as wr
from warprock.cli.main import main
from warprock.cli.signatures import SHARED, read_function

MADE = {
    name: f"analyses/{name}"
    for name in ("fragility", "ida", "map", "risk", "sensitivity", "spectrum")
}
MADE |= {"body": "body", "validate": "validation", "trade": "trade", "stability": "stability"}
MADE |= {"verdict": "verdict", "identify": "identification", "measures": "measures"}
MADE |= {"capacity": "capacity", "bench": "bench"}


def _command(name: str) -> click.Command:
    """A command, whose file is imported when it is asked for."""
    command = main.get_command(click.Context(main), name)
    assert command is not None
    return command


@pytest.mark.parametrize(("name", "module"), MADE.items())
def test_a_function_that_is_read_is_the_one_that_is_imported(name: str, module: str):
    parameters = inspect.signature(inspect.unwrap(getattr(wr, name))).parameters.values()
    own = {
        each.name: each.default
        for each in parameters
        if each.kind is each.KEYWORD_ONLY and each.name not in SHARED
    }
    found = read_function(module, name).arguments
    assert {each.name: each.default for each in found} == own
    options = {each.name: each for each in _command(name).params}
    for argument in found:
        option = options[argument.name]
        assert isinstance(option, click.Option)
        assert option.opts == [argument.option]
        assert option.multiple == (argument.default == ())
        assert option.multiple or option.default == argument.default
    # What a function takes as a record, with others, is an option of its command, too.
    for each in inspect.signature(getattr(wr, name)).parameters.values():
        if each.kind is each.KEYWORD_ONLY and each.name not in SHARED | {"tolerance"}:
            assert options[each.name].default == (None if each.default == () else each.default)


@pytest.mark.parametrize(
    "name", [name for name in wr.__all__ if inspect.isfunction(getattr(wr, name))]
)
def test_the_docstring_says_what_every_argument_is(name: str):
    function = getattr(wr, name)
    said = set(re.findall(r"^ {4}(?:\*\*)?(\w+): ", inspect.getdoc(function) or "", re.MULTILINE))
    assert set(inspect.signature(function).parameters) <= said


@pytest.mark.parametrize(
    "name", ["engine", "tolerance", "precision", "device", "workers", "cheapest"]
)
def test_what_a_run_takes_is_said_in_its_docstring_alone(name: str):
    options = {each.name: each for each in _command("run").params}
    option = options[name]
    assert isinstance(option, click.Option)
    said = " ".join((inspect.getdoc(wr.run) or "").split()).replace(" [-]", "")
    assert option.help is not None
    assert f"{name}: {option.help}" in said
