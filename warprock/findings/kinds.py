"""The kinds of findings that there are: each file of this room declares its own."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Mapping

import warprock.findings
from warprock.findings.finding import Facts, Kind


@functools.cache
def every_kind() -> tuple[Kind, ...]:
    """All kinds of findings."""
    names = [each.name for each in pkgutil.iter_modules(warprock.findings.__path__)]
    modules = [importlib.import_module(f"warprock.findings.{name}") for name in names]
    values = [value for module in modules for value in vars(module).values()]
    return tuple(each for each in values if isinstance(each, Kind))


def kinds() -> Mapping[str, Kind]:
    """The kinds of findings by the key of `run.json` that only they have."""
    return {each.key: each for each in every_kind() if each.key}


KNOWN_BY_FILE = {
    "fragility-p58.csv": "fragility",
    "predictors.csv": "predictors",
    "risk.csv": "risk",
    "trade.parquet": "trade",
}
"""Files by which kinds of findings are known, beside other results, too, and the files of this room
that declare them: a page of none of them is written without any."""


def kind_of_file(name: str) -> Kind:
    """The kind that is known by a file of `KNOWN_BY_FILE`."""
    module = importlib.import_module(f"warprock.findings.{KNOWN_BY_FILE[name]}")
    values = vars(module).values()
    return next(each for each in values if isinstance(each, Kind) and each.file == name)


def shapes() -> Mapping[str, Facts]:
    """What findings of each kind say in `run.json`, by the key that only they have there."""
    return {key: kind.shape for key, kind in kinds().items()}
