"""The examples in the docstrings of everything public: they run, and come to what they say."""

import doctest
import importlib
import pkgutil

import pytest

import warprock.api

MODULES = [f"warprock.api.{found.name}" for found in pkgutil.iter_modules(warprock.api.__path__)]


@pytest.mark.parametrize("name", MODULES)
def test_examples_come_to_what_they_say(name: str):
    assert doctest.testmod(importlib.import_module(name)).failed == 0
