"""Every key that a lane of a case may have a value of, as its table declares it.

The tables are the files of this room; what is here is made from them.
"""

from __future__ import annotations

import re

from warprock.case.assembly import Assembly
from warprock.case.block import Block, StackedBlock
from warprock.case.body import Body, StackedBody
from warprock.case.case_file import CaseFile
from warprock.case.contact import Contact
from warprock.case.hold import Frame, Ground, Strip, Tie, TopLoad, TransverseWall
from warprock.case.motion import Motion
from warprock.case.run import DURATION, Run
from warprock.case.start import Start
from warprock.case.support import Support
from warprock.case.validation import Table
from warprock.quantity import NumberKey, TextKey

_TABLES: tuple[type[Table], ...] = (
    *(
        Body,
        Block,
        Assembly,
        Contact,
        TransverseWall,
        Tie,
        TopLoad,
        Frame,
        Strip,
        Ground,
        Start,
        Motion,
        Support,
        Run,
    ),
    *(StackedBody, StackedBlock),
)


def _keys() -> dict[str, NumberKey | TextKey]:
    found = {"model": CaseFile.declared()["model"]}
    found |= {f"{t.place}.{name}": key for t in _TABLES for name, key in t.declared().items()}
    return {key: each for key, each in found.items() if isinstance(each, NumberKey | TextKey)}


KEYS: dict[str, NumberKey | TextKey] = _keys()
"""Dotted key -> how its value is read; N stands for the number of a block or of a tie."""

SWEEP_KEYS: tuple[str, ...] = tuple(key for key, declared in KEYS.items() if declared.swept)
"""Keys that may differ from lane to lane."""

DRAWN_KEYS: tuple[str, ...] = tuple(key for key in SWEEP_KEYS if key != DURATION)
"""Keys that may be drawn or spread: lanes of one duration run together, so that it should have few
values."""

_NUMBER = re.compile(r"^(block|tie)\.[1-9][0-9]*\.")
_DIRECTION = re.compile(r"^motion\.[yz]\.")


def general_key(key: str) -> str:
    """The key of `KEYS` that says how a key is read.

    block.2.width is an instance of block.N.width, tie.1.slack of tie.N.slack, motion.y.scale is
    read as motion.scale.
    """
    return _DIRECTION.sub("motion.", _NUMBER.sub(r"\1.N.", key))


def _rivals() -> dict[str, frozenset[str]]:
    found: dict[str, frozenset[str]] = {}
    for key, declared in KEYS.items():
        table = key.rpartition(".")[0]
        for rival in declared.others:
            other = f"{table}.{rival}"
            found[key] = found.get(key, frozenset()) | {other}
            found[other] = found.get(other, frozenset()) | {key}
    return found


_RIVALS: dict[str, frozenset[str]] = _rivals()
"""Key of `KEYS` -> the other keys that say the same thing."""


def rivals(key: str) -> frozenset[str]:
    """The other keys that say the same thing as a dotted key: only one of them may be given."""
    table = key.rpartition(".")[0]
    found = _RIVALS.get(general_key(key), frozenset())
    return frozenset(f"{table}.{other.rpartition('.')[2]}" for other in found)
