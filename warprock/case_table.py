"""What every table of a case file is: a model that refuses keys it does not know."""

from __future__ import annotations

import pydantic


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
