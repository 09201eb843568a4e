"""Engines that other packages bring: they name them in an entry point, and users have them by name.

    [project.entry-points."warprock.engines"]
    rk4 = "my_package.my_module:MyEngine"

A table of what warprock brings itself is `Plugged`: other packages are looked at when it is gone
through, or asked for a name that it does not have.
"""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

from warprock.errors import InputError

GROUP = "warprock.engines"
"""Group of entry points; the name of each is that of its engine, the value its class."""

_PACKAGES = (".dist-info", ".egg-info")
"""How folders of a package end that say what it brings."""

Row = TypeVar("Row")


class Plugged(Mapping[str, Row]):
    """What warprock brings by name, and behind it what other packages bring."""

    def __init__(self, own: Mapping[str, Row], row_of: Callable[[str], Row]) -> None:
        """Takes the rows of warprock's own engines.

        Args:
            own: They, by name.
            row_of: Makes the row of an engine that another package brings, of its name.
        """
        self._own, self._row_of = own, row_of

    def __getitem__(self, name: str) -> Row:
        if name in self._own:
            return self._own[name]
        if name not in brought():
            raise KeyError(name)
        return self._row_of(name)

    def __iter__(self) -> Iterator[str]:
        yield from self._own
        for name, where in brought().items():
            if name in self._own:
                allowed = "must not be the name of an engine that warprock brings"
                raise InputError(where[1], GROUP, name, allowed)
            yield name

    def __len__(self) -> int:
        return len(self._own) + len(brought())


@functools.cache
def brought() -> dict[str, tuple[str, str]]:
    """Engines that other packages bring: name -> "module:Class", and the package.

    Raises:
        InputError: Two packages bring an engine of the same name.
    """
    if not any(map(_may_declare, sys.path)):
        return {}
    import importlib.metadata

    found: dict[str, tuple[str, str]] = {}
    for each in importlib.metadata.entry_points(group=GROUP):
        package = each.dist.name if each.dist is not None else each.module
        before = found.get(each.name)
        if before is not None and before[0] != each.value:
            raise InputError(package, GROUP, each.name, f"must be another name: {before[1]} has it")
        found[each.name] = (each.value, package)
    return found


def _may_declare(place: str) -> bool:
    """Whether a package in a folder of the path may bring an engine.

    Python's own reader takes longer to load than all of this, and nearly always nobody brings one.
    It has to look where the path names no folder, such as an archive.
    """
    try:
        with os.scandir(place or ".") as entries:
            packages = [each.path for each in entries if each.name.endswith(_PACKAGES)]
    except FileNotFoundError:
        return False
    except OSError:
        return True
    for package in packages:
        try:
            with open(os.path.join(package, "entry_points.txt"), "rb") as file:
                if GROUP.encode() in file.read():
                    return True
        except OSError:
            continue
    return False


def load(name: str) -> Any:
    """The class of an engine that another package brings.

    Raises:
        InputError: Its module does not load, or has no such class.
    """
    import importlib

    where, package = brought()[name]
    module, _, class_name = where.partition(":")
    try:
        return getattr(importlib.import_module(module), class_name)
    except (ImportError, AttributeError) as error:
        allowed = f"must load: {error}"
        raise InputError(package, GROUP, where, allowed) from error
