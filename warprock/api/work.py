"""What all commands of this room take: a case, an engine, and how its lanes are run."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import TypedDict

from warprock.api.case import AnyCase, any_case
from warprock.api.names import calling_command, python_names
from warprock.api.progress import Shown, shown
from warprock.arguments import at_the_door
from warprock.case.load import Overrides
from warprock.running.engine_choice import EngineChoice, choose_engine
from warprock.running.options import TOLERANCE, RunOptions
from warprock.running.work import Work


class How(TypedDict, total=False):
    """How lanes are run; `run` says what each is."""

    overrides: Overrides
    precision: str
    device: str
    workers: int | None
    progress: Shown


class HowHeld(How, total=False):
    """How lanes are run and held to a tolerance; `run` says what each is."""

    tolerance: float | None


@at_the_door
@contextlib.contextmanager
def working(
    case: AnyCase,
    engine: str | None,
    *,
    overrides: Overrides = (),
    tolerance: float | None = TOLERANCE,
    precision: str = "float64",
    device: str = "cpu",
    workers: int | None = None,
    progress: Shown = True,
    runs: int = 1,
    factors: Sequence[float] = (1.0,),
) -> Iterator[Work]:
    """Finds the case and its engine, and shows how far the block is.

    Args:
        case: The case that is meant.
        engine: Name of the engine; None takes the one that the case has as a rule.
        overrides: As in `run`.
        tolerance: As in `run`.
        precision: As in `run`.
        device: As in `run`.
        workers: As in `run`.
        progress: As in `run`.
        runs: How often all lanes will run; 0 where that is not known.
        factors: On the motion of the case: those at which it will run.

    Yields:
        The case, its engine, and how lanes are run, with the progress to report.

    Raises:
        InputError: Something cannot be used, before the block or in it.
    """
    with python_names():
        found = any_case(case, overrides).judged
        named = None if engine is None else EngineChoice(engine, named=True)
        choice = named or choose_engine(found, factors)
        with shown(progress, found.name, runs * found.lane_count or None) as report:
            options = RunOptions(precision, device, workers, tolerance, report)
            yield Work(found, choice, options)
    call = calling_command()
    if call is not None:
        call.choice = choice
