"""What commands work on: a case, the engine of its lanes, and how these run."""

from __future__ import annotations

import dataclasses

from warprock.case.case import Case
from warprock.running.engine_choice import EngineChoice
from warprock.running.options import RunOptions


@dataclasses.dataclass(frozen=True)
class Work:
    """A case to be worked on.

    Attributes:
        case: The case.
        choice: The engine named, or the one that the case has as a rule.
        options: How its lanes are run.
    """

    case: Case
    choice: EngineChoice
    options: RunOptions

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return self.choice.engine
