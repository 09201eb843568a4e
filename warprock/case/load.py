"""Reads a case file and judges every value in it before anything runs.

Every error is an `InputError` that names the file (or -s, for an override), the dotted key, the
value and what it must be. Unknown keys are errors with a suggestion.
"""

from __future__ import annotations

import copy
import dataclasses
import functools
import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

from warprock.case.axes import LABEL, Axis, Texts
from warprock.case.case import Case
from warprock.case.case_file import APART, CaseFile
from warprock.case.check import CheckSpec, HousnerCheck, PeaksCheck
from warprock.case.ensemble import read_ensemble
from warprock.case.hold import number_ties
from warprock.case.keys import KEYS, rivals
from warprock.case.sample import read_sample
from warprock.case.spectrum import read_spectrum
from warprock.case.study import read_study
from warprock.case.sweep import fix_keys, read_axes, sweep_entries, sweep_overrides
from warprock.case.text import (
    OVERRIDE,
    data_folder,
    find_case,
    override,
    parse_case,
    put,
    source_name,
)
from warprock.case.validation import refusing, validated
from warprock.errors import NOTHING, InputError

Overrides = Sequence[str] | Mapping[str, Any]
"""Changes of a case: texts `key=value`, or values by dotted key."""


def load_case(name_or_path: str | os.PathLike[str], overrides: Overrides = ()) -> Case:
    """Reads a case and judges every value in it.

    Args:
        name_or_path: Name of a shipped case, or path of a case file or of its folder.
        overrides: Texts `key=value`, such as `block.height=5.5 m`, or values by key. An override
            of a key that the case sweeps replaces the whole axis it lies on; one that lists several
            values, or lays a grid, `motion.amplitude=0.1 g to 2 g, 20`, sweeps the key.

    Raises:
        InputError: No such case, or something in it cannot be used.
    """
    name, file, folder, text = find_case(os.fspath(name_or_path))
    raw = parse_case(text, file)
    return build_case(name, file, folder, raw, override_tables(raw, overrides))


def override_tables(raw: dict[str, Any], overrides: Overrides) -> frozenset[str]:
    """Puts overrides into a case.

    Args:
        raw: The case as written; changed in place.
        overrides: As in `load_case`.

    Returns:
        The keys that they changed.

    Raises:
        InputError: One of them is of no such form, lies below what is no table, or is a grid that
            cannot be read.
    """
    number_ties(raw)
    if isinstance(overrides, Mapping):
        for key, value in overrides.items():
            put(raw, key, value, value)
        keys = list(overrides)
    else:
        keys = [override(raw, text) for text in overrides]
    overridden = frozenset(keys)
    number_ties(raw)
    fix_keys(raw, overridden.union(*map(rivals, overridden)))
    with refusing(lambda _key: OVERRIDE):
        sweep_overrides(raw, keys)
    return overridden


def changed(case: Case, changes: Overrides) -> Case:
    """A case some keys of which have other values, without its checks.

    Args:
        case: The case.
        changes: As in `load_case`; a list of values sweeps the key.

    Raises:
        InputError: A change that cannot be used.
    """
    raw = copy.deepcopy({name: each for name, each in case.raw.items() if name != "check"})
    keys = override_tables(raw, changes)
    return build_case(case.name, case.file, case.folder, raw, case.overridden | keys)


def build_case(
    name: str,
    file: str,
    folder: pathlib.Path | None,
    raw: Mapping[str, Any],
    overridden: frozenset[str] = frozenset(),
) -> Case:
    """A case from what was written, judged as by `load_case`; arguments as in `Case`."""
    raw = {**raw}
    number_ties(raw)
    source_of = functools.partial(source_name, file=file, raw=raw, overridden=overridden)
    if isinstance(raw.get("sweep"), Mapping):
        raw = {**raw, "sweep": sweep_entries(raw)}
    with refusing(source_of):
        axes = read_axes(raw, data_folder(name, folder))
        axes += read_spectrum(raw, axes)
        axes += read_sample(raw, axes)
    with refusing(source_of, elsewhere=KEYS):
        tables = validated(CaseFile, _first_lane(raw, axes))
    with refusing(source_of):
        ensemble = read_ensemble(raw, axes, tables)
    case = Case(name, file, folder, raw, tables, axes, overridden, ensemble)
    for engine in tables.engines:
        case.engine_settings(engine)
    for program in tables.peers:
        case.peer_settings(program)
    if "study" in raw:
        beside = ensemble is not None
        with refusing(source_of):
            study = read_study(
                raw["study"], tables, ensemble=beside, file=file, source_of=source_of
            )
        case = dataclasses.replace(case, study=study)
    if not overridden:
        _judge_checks(case)
    return case


def _first_lane(raw: Mapping[str, Any], axes: Sequence[Axis]) -> dict[str, Any]:
    """The case as written, the first value along each axis in the place of the swept ones."""
    body = copy.deepcopy({k: v for k, v in raw.items() if k not in APART})
    columns = {key: column for axis in axes for key, column in axis.columns.items()}
    swept = {key: c.first for key, c in columns.items() if not key.startswith(LABEL)}
    for key, value in swept.items():
        *path, name = key.split(".")
        inner: Any = body
        for part in path:
            inner = inner.setdefault(part, {}) if isinstance(inner, dict) else None
        if isinstance(inner, dict):
            inner[name] = value
    return body


def _judge_checks(case: Case) -> None:
    """Refuses a check that cannot be made on its case."""
    values = {
        key.removeprefix(LABEL): column.values
        for axis in case.axes
        for key, column in axis.columns.items()
        if key.startswith(LABEL) and isinstance(column, Texts)
    }
    for number, check in enumerate(case.checks):
        for label, value in check.where.items():
            key = f"check[{number}].where.{label}"
            if label not in values:
                known = ", ".join(values) or "none"
                raise InputError(case.file, key, value, f"must be a label of the case ({known})")
            if value not in values[label]:
                known = ", ".join(values[label])
                raise InputError(case.file, key, value, f"must be a value of the label ({known})")
        if case.ensemble is not None:
            key = f"check[{number}]"
            raise InputError(case.file, key, check.kind, "must not be on an ensemble")
        _judge_check_of_stack(case, number, check)
        if isinstance(check, HousnerCheck) and case.sample_times.interval is None:
            raise InputError(
                case.file, "run.sample_interval", NOTHING, f"must be given for check[{number}]"
            )


def _judge_check_of_stack(case: Case, number: int, check: CheckSpec) -> None:
    """Refuses a check of a single block on a stack, and one of a block that is not there."""
    stacked = case.tables.stacked
    if isinstance(check, HousnerCheck) and stacked:
        raise InputError(case.file, f"check[{number}].kind", "housner", "must not be on a stack")
    if isinstance(check, PeaksCheck):
        count = case.tables.block_count
        known = range(1, count + 1) if stacked else (None,)
        if check.block not in known:
            allowed = f"must be a block from 1 to {count}" if stacked else "must be left out"
            got = NOTHING if check.block is None else check.block
            raise InputError(case.file, f"check[{number}].block", got, allowed)
