"""The examples in the docstrings of everything public: there are some, and they are true."""

import doctest
import importlib
import inspect
import pkgutil

import pytest

import warprock
import warprock.api

pytestmark = pytest.mark.usefixtures("nothing_rendered", "two_rooms")

PUBLIC = {name: getattr(warprock, name) for name in warprock.__all__}
"""All that is public. From here on it says that it lives in `warprock`, so that a look at the file
that has its text does not find it."""
HOMES = {f"warprock.{home}" for home in warprock._HOME.values()}
ROOM = {f"warprock.api.{found.name}" for found in pkgutil.iter_modules(warprock.api.__path__)}


@pytest.mark.parametrize("name", sorted(HOMES | ROOM))
def test_examples_come_to_what_they_say(name: str):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


LONG = ("trade", "limit", "predictors", "study")
"""Public functions whose examples measure or run for a second: `thorough`."""


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.thorough if name in LONG else ())
        for name in warprock.__all__
    ],
)
def test_examples_of_what_is_public_come_to_what_they_say(name: str):
    runner, finder = doctest.DocTestRunner(), doctest.DocTestFinder()
    for test in finder.find(PUBLIC[name], name, module=False, globs={}):
        runner.run(test)
    assert runner.failures == 0


@pytest.mark.parametrize("name", warprock.__all__)
def test_every_public_object_has_an_example(name: str):
    found = PUBLIC[name]
    if callable(found):
        assert "Example:" in inspect.getdoc(found)
