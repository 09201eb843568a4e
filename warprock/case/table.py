"""What every table of a case file has: no unknown keys, and errors that name one of its keys."""

from __future__ import annotations

import pydantic

from warprock.case.keys import KEYS
from warprock.quantity import NumberKey


def number(key: str) -> pydantic.BeforeValidator:
    """Reads the number of a key as `KEYS` says, in SI units or rad."""
    reader = KEYS[key]
    assert isinstance(reader, NumberKey)
    return pydantic.BeforeValidator(reader.read_number)


class KeyedError(ValueError):
    """An error about one key of a table, found when the whole table is looked at.

    Attributes:
        name: The key, without its table.
        got: Its value.
    """

    def __init__(self, name: str, got: object, allowed: str) -> None:
        super().__init__(allowed)
        self.name, self.got = name, got


class Table(pydantic.BaseModel):
    """A table that refuses keys it does not know."""

    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)
