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
import re
from collections.abc import Mapping, Sequence
from typing import Any

import pydantic

from warprock.case.axes import LABEL, Axis, fix_keys, read_axes
from warprock.case.blocks import SINGLE, STACK
from warprock.case.case import Case
from warprock.case.checks import CheckSpec, HousnerCheck, PeaksCheck
from warprock.case.ensemble import read_ensemble
from warprock.case.keys import EXCLUSIVE, KEYS, SourceOf, general_key
from warprock.case.sample import read_sample
from warprock.case.spectrum import read_spectrum
from warprock.case.study_table import read_study
from warprock.case.table import KeyedError
from warprock.case.tables import APART, CaseTables, known_keys
from warprock.case.text import find_case, override, parse_case, source_name
from warprock.errors import InputError, did_you_mean, listed
from warprock.quantity import NOTHING


def load_case(name_or_path: str | os.PathLike[str], overrides: Sequence[str] = ()) -> Case:
    """Reads a case and judges every value in it.

    Args:
        name_or_path: Name of a shipped case, or path of a case file or of its folder.
        overrides: Texts `key=value`, such as `block.height=5.5 m`. An override of a key that the
            case sweeps replaces the whole axis it lies on.

    Raises:
        InputError: No such case, or something in it cannot be used.
    """
    name, file, folder, text = find_case(os.fspath(name_or_path))
    raw = parse_case(text, file)
    overridden = frozenset(override(raw, text) for text in overrides)
    fix_keys(raw, overridden | {EXCLUSIVE[key] for key in overridden if key in EXCLUSIVE})
    return build_case(name, file, folder, raw, overridden)


def build_case(
    name: str,
    file: str,
    folder: pathlib.Path | None,
    raw: Mapping[str, Any],
    overridden: frozenset[str] = frozenset(),
) -> Case:
    """A case from what was written, judged as by `load_case`; arguments as in `Case`."""
    source_of = functools.partial(source_name, file=file, overridden=overridden)
    axes = read_axes(raw.get("sweep", []), source_of("sweep"))
    axes += read_spectrum(raw, axes, source_of)
    axes += read_sample(raw, axes, source_of)
    tables = _read_tables(raw, axes, source_of)
    ensemble = read_ensemble(raw, axes, tables, source_of)
    case = Case(name, file, folder, raw, tables, axes, overridden, ensemble)
    for engine in tables.engines:
        case.engine_settings(engine)
    for program in tables.peers:
        case.peer_settings(program)
    if "study" in raw:
        case = dataclasses.replace(case, study=read_study(case))
    if not overridden:
        _judge_checks(case)
    return case


def _read_tables(raw: Mapping[str, Any], axes: Sequence[Axis], source_of: SourceOf) -> CaseTables:
    """The tables of a case, in which the first value along each axis stands for the swept ones."""
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
    try:
        return CaseTables.model_validate(body)
    except pydantic.ValidationError as error:
        raise _input_error(error, source_of) from None


_SAID_PLAINLY = {
    "model_type": "must be a table",
    "dict_type": "must be a table",
    "tuple_type": "must be a list",
    "string_type": "must be text",
}
"""pydantic's kind of error -> what a writer of TOML calls it."""


def _input_error(error: pydantic.ValidationError, source_of: SourceOf) -> InputError:
    """The first thing wrong; a mistyped key before what is missing because of it."""
    details = error.errors(include_url=False)
    detail = next((d for d in details if d["type"] == "extra_forbidden"), details[0])
    kind, location, context = detail["type"], detail["loc"], detail.get("ctx", {})
    path = list(location)
    if location[:1] == ("block",) and location[1:2] in ((SINGLE,), (STACK,)):
        path[1:2] = []  # pydantic puts the kind of the scene here, which is no key
    if location[:1] == ("check",):
        path[2:3] = []  # pydantic puts the kind of the check here, which is no key
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        path.append("kind")
    got: object = detail["input"]
    fault = context.get("error")
    if isinstance(fault, KeyedError):
        path.append(fault.name)
        got = fault.got
    key = _dotted(path)
    if kind == "extra_forbidden":
        allowed = _unknown_key(location, path)
    elif kind == "missing":
        known = KEYS.get(general_key(key))
        got, allowed = NOTHING, known.allowed if known else "must be given"
    elif kind == "value_error":
        allowed = str(fault)
    elif kind in ("union_tag_invalid", "union_tag_not_found"):
        got = context.get("tag", NOTHING)
        allowed = "must be peaks, housner or boundaries"
    else:
        allowed = _SAID_PLAINLY.get(kind) or re.sub(r"^.*? should ", "must ", detail["msg"])
    return InputError(source_of(key), key, got, allowed)


def _unknown_key(location: Sequence[int | str], path: Sequence[int | str]) -> str:
    """What is said about an unknown key: those allowed, and the one perhaps meant."""
    known = known_keys(location)
    plain = _dotted([part for part in path if not isinstance(part, int)])
    names = [key.rpartition(".")[2] for key in known]
    near = did_you_mean(plain.rpartition(".")[2], names) or did_you_mean(plain, KEYS)
    return f"unknown key (allowed: {listed(plain, names)}){near}"


def _dotted(path: Sequence[int | str]) -> str:
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


def _judge_checks(case: Case) -> None:
    """Refuses a check that cannot be made on its case."""
    values = {
        key.removeprefix(LABEL): getattr(column, "values", ())
        for axis in case.axes
        for key, column in axis.columns.items()
        if key.startswith(LABEL)
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
