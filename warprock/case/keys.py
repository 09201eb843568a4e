"""Every key that a lane of a case may have a value of, as its table declares it.

The tables are the files of this room; what is here is made from them.
"""

from __future__ import annotations

import itertools
import re

from warprock.case.block import Block, StackedBlock
from warprock.case.case_file import CaseFile
from warprock.case.contact import Contact
from warprock.case.motion import Direction
from warprock.case.run import Run
from warprock.case.start import Start
from warprock.case.validation import Table
from warprock.quantity import NumberKey, TextKey

_TABLES: tuple[type[Table], ...] = (Block, Contact, Start, Direction, Run, StackedBlock)


def _keys() -> dict[str, NumberKey | TextKey]:
    found = {"model": CaseFile.declared()["model"]}
    found |= {f"{t.place}.{name}": key for t in _TABLES for name, key in t.declared().items()}
    return {key: each for key, each in found.items() if isinstance(each, NumberKey | TextKey)}


KEYS: dict[str, NumberKey | TextKey] = _keys()
"""Dotted key -> how its value is read; N stands for the number of a block in a stack."""

SWEEP_KEYS: tuple[str, ...] = tuple(key for key, declared in KEYS.items() if declared.swept)
"""Keys that may differ from lane to lane."""

_BLOCK_NUMBER = re.compile(r"^block\.[1-9][0-9]*\.")
_DIRECTION = re.compile(r"^motion\.[yz]\.")


def general_key(key: str) -> str:
    """The key of `KEYS` that says how a key is read.

    block.2.width is an instance of block.N.width, motion.y.scale is read as motion.scale.
    """
    return _DIRECTION.sub("motion.", _BLOCK_NUMBER.sub("block.N.", key))


def _exclusive() -> dict[str, frozenset[str]]:
    found: dict[str, frozenset[str]] = {}
    for key, declared in KEYS.items():
        table, _, name = key.rpartition(".")
        places = ("motion", "motion.y", "motion.z") if table == "motion" else (table,)
        for place, rival in itertools.product(places, declared.others):
            for one, other in itertools.permutations((f"{place}.{name}", f"{place}.{rival}")):
                found[one] = found.get(one, frozenset()) | {other}
    return found


EXCLUSIVE: dict[str, frozenset[str]] = _exclusive()
"""Key -> the other keys that say the same thing; only one of them may be given."""
