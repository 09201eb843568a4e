"""Reads the [study] table of a case: settings of its engines, and the values of each."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from warprock.case.case import Case
from warprock.case.keys import read_table
from warprock.case.study import Number, Study
from warprock.errors import InputError, did_you_mean, listed
from warprock.quantity import NOTHING, Said
from warprock.settings.engines import SETTINGS, build_settings

_NAMES = ("engines", "vary")


_FEWEST = 2
"""Values of a setting in a list: the baseline and another."""


def read_study(case: Case) -> Study:
    """Reads and judges the [study] table of a case that was read without it.

    A list in the file must hold the case's own value. One that an override set, or whose own value
    an override set, is completed with it, so that `-s` can ask for other values alone.

    Args:
        case: The case, whose `raw` has the table.

    Raises:
        InputError: An unknown key, engine or setting, a value that its engine would refuse, fewer
            than two values, a list without the case's own value, or a case whose lanes cannot be
            held against Housner's.
    """
    table = read_table(case.raw, "study", _NAMES, case.source_of)
    _refuse_scene(case)
    engines = _read_engines(case, table.get("engines", NOTHING))
    vary = table.get("vary", NOTHING)
    if not isinstance(vary, Mapping) or not vary:
        allowed = "must be a table: a list of values for each setting that is varied"
        raise _refused(case, "study.vary", vary, allowed)
    for name in vary:
        _refuse_setting(case, engines, name, vary[name])
    values = {
        engine: {
            name: _read_values(case, engine, name, vary[name])
            for name in vary
            if name in _fields(engine)
        }
        for engine in engines
    }
    for engine, found in values.items():
        if not found:
            allowed = f"must have a setting that is varied ({', '.join(vary)})"
            raise _refused(case, "study.engines", engine, allowed)
    return Study({engine: case.engine_settings(engine) for engine in engines}, values)


def _refused(case: Case, key: str, got: object, allowed: str) -> InputError:
    return InputError(case.source_of(key), key, got, allowed)


def _fields(engine: str) -> tuple[str, ...]:
    return tuple(field.name for field in dataclasses.fields(SETTINGS[engine]))


def _refuse_scene(case: Case) -> None:
    """Refuses lanes that cannot be held against Housner's, sample by sample."""
    if case.ensemble is not None:
        raise _refused(case, "study", Said("a study"), "must not be beside [ensemble]")
    if case.tables.stacked:
        allowed = "must not be on a stack: runs are held against Housner's single block"
        raise _refused(case, "study", Said("a study"), allowed)
    if case.sample_times.interval is None:
        raise _refused(case, "run.sample_interval", NOTHING, "must be given for [study]")


def _read_engines(case: Case, got: object) -> tuple[str, ...]:
    key = "study.engines"
    if not isinstance(got, list) or not got:
        raise _refused(case, key, got, f"must be a list of engines ({', '.join(SETTINGS)})")
    for number, engine in enumerate(got):
        if engine not in SETTINGS:
            allowed = f"must be one of {', '.join(SETTINGS)}{did_you_mean(engine, SETTINGS)}"
            raise _refused(case, f"{key}[{number}]", engine, allowed)
        if engine in got[:number]:
            raise _refused(case, f"{key}[{number}]", engine, "must not be there twice")
    return tuple(got)


def _refuse_setting(case: Case, engines: tuple[str, ...], name: str, got: object) -> None:
    """Refuses a setting that no engine of the study has, and values that are no list."""
    key = f"study.vary.{name}"
    known = tuple(dict.fromkeys(field for engine in engines for field in _fields(engine)))
    if name not in known:
        others = [engine for engine in SETTINGS if name in _fields(engine)]
        verb = "has" if len(others) == 1 else "have"
        hint = f"; {', '.join(others)} {verb} it" if others else did_you_mean(name, known)
        allowed = f"must be a setting of {' or '.join(engines)} ({listed(name, known)}){hint}"
        raise _refused(case, key, got, allowed)
    if not isinstance(got, list) or len(got) < _FEWEST:
        raise _refused(case, key, got, f"must be a list of at least {_FEWEST} values")


def _read_values(case: Case, engine: str, name: str, listed: list[object]) -> tuple[Number, ...]:
    """The values of one setting of one engine, its own value among them."""
    key, own_key = f"study.vary.{name}", f"engines.{engine}.{name}"
    values: list[Number] = []
    for number, got in enumerate(listed):
        place = f"{key}[{number}]"
        try:
            value = getattr(build_settings(engine, {name: got}, case.file), name)
        except InputError as error:
            raise _refused(case, place, got, f"{error.allowed} ({engine})") from None
        if value in values:
            raise _refused(case, place, got, "must not be there twice")
        values.append(value)
    own = getattr(case.engine_settings(engine), name)
    if own not in values:
        if case.source_of(key) == case.source_of(own_key) == case.file:
            allowed = f"must hold the case's own value, {own:g} ({own_key})"
            raise _refused(case, key, listed, allowed)
        values.append(own)
    return tuple(values)
