"""The engines by name; each is imported only when asked for."""

from __future__ import annotations

import importlib

from warprock.engines.base import AbstractEngine
from warprock.errors import InputError

ENGINES: dict[str, str] = {
    "housner": "warprock.engines.housner:Housner",
    "impulse": "warprock.engines.impulse:Impulse",
    "event": "warprock.engines.event:Event",
    "direct": "warprock.engines.direct:Direct",
    "xpbd": "warprock.engines.xpbd:Xpbd",
    "dem": "warprock.engines.dem:Dem",
    "two-block": "warprock.engines.two_block:TwoBlock",
}
"""Engine name -> "module:Class"."""


def engine_class(name: str) -> type[AbstractEngine]:
    """The class of an engine.

    Raises:
        InputError: No engine has that name.
    """
    if name not in ENGINES:
        raise InputError("engine", "", name, f"allowed: {', '.join(ENGINES)}")
    module, _, class_name = ENGINES[name].partition(":")
    found: type[AbstractEngine] = getattr(importlib.import_module(module), class_name)
    return found
