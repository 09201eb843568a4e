"""What a check comes to."""

from __future__ import annotations

import dataclasses


@dataclasses.dataclass(frozen=True)
class CheckRow:
    """One result of one check.

    Attributes:
        case: Name of the case.
        name: What is measured.
        engine: Engine that is checked.
        lanes: The lanes that were selected, in words.
        value: What was found [-].
        limit: Largest value that passes [-].
        ok: Whether it passes.
        because: Why the limit is right, as the case says it.
        note: Lanes left out and why, or the worst lane.
        outside: Lanes selected that are outside the model: of the engine, or of Housner where the
            engine is held against him; None where that is not known.
    """

    case: str
    name: str
    engine: str
    lanes: str
    value: float
    limit: float
    ok: bool
    because: str
    note: str
    outside: int | None = None
