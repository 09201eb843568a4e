"""The engines by name; each is imported only when asked for."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from warprock.engines.base import AbstractEngine
from warprock.errors import InputError
from warprock.plugins import GROUP, Plugged, brought, load

_OWN = {
    "housner": "warprock.engines.housner:Housner",
    "impulse": "warprock.engines.impulse:Impulse",
    "event": "warprock.engines.event:Event",
    "direct": "warprock.engines.direct:Direct",
    "xpbd": "warprock.engines.xpbd:Xpbd",
    "dem": "warprock.engines.dem:Dem",
    "two-block": "warprock.engines.two_block:TwoBlock",
    "assembly": "warprock.engines.assembly:Assembly",
}


def _place(name: str) -> str:
    """Where the class of an engine is that another package brings."""
    return brought()[name][0]


ENGINES: Mapping[str, str] = Plugged(_OWN, _place)
"""Engine name -> "module:Class": those of warprock, then those that other packages bring."""


def engine_class(name: str) -> type[AbstractEngine]:
    """The class of an engine.

    Raises:
        InputError: No engine has that name.
    """
    if name not in ENGINES:
        raise InputError("engine", "", name, f"allowed: {', '.join(ENGINES)}")
    if name not in _OWN:
        return _judged(name, load(name))
    module, _, class_name = ENGINES[name].partition(":")
    found: type[AbstractEngine] = getattr(importlib.import_module(module), class_name)
    return found


def _judged(name: str, found: Any) -> type[AbstractEngine]:
    """The class of an engine that another package brings, if it keeps the contract."""
    package = brought()[name][1]
    if not (isinstance(found, type) and issubclass(found, AbstractEngine)):
        raise InputError(package, GROUP, repr(found), "must be a class of AbstractEngine")
    missing = sorted(found.__abstractmethods__) + [
        each for each in ("name", "settings_type", "order") if not hasattr(found, each)
    ]
    if missing:
        raise InputError(package, GROUP, found.__name__, f"must have {', '.join(missing)}")
    if found.name != name:
        raise InputError(package, GROUP, found.name, f"must be {name}, the name of its entry point")
    return found


def reference_engine(*, stacked: bool = False) -> str:
    """The engine that others are held against, of single blocks or of stacks."""
    wanted = "stack" if stacked else "block"
    return next(name for name in ENGINES if engine_class(name).reference_of == wanted)


def preferred_engines() -> list[str]:
    """The engines that are taken where none is named, the most preferred one first."""
    places = {name: engine_class(name).preference for name in ENGINES}
    return [name for _, name in sorted((at, name) for name, at in places.items() if at is not None)]
