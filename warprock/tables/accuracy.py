"""What a command says of the accuracy of its lanes, and what to do about those that lack it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from warprock.model.words import lane_count_text
from warprock.running.accuracy import (
    FIRST_STEPS,
    MET,
    MISSED,
    REFINED,
    SENSITIVE,
    TOTAL_STEPS,
    accuracy_counts,
)

if TYPE_CHECKING:
    from warprock.running.case_run import CaseRun

FINER = 2
"""Halvings of the step that the advice on screen is of."""


def accuracy_lines(
    counts: Mapping[str, int],
    tolerance: float | None,
    lanes: int,
    advice: str,
    finest_step: float | None = None,
) -> list[str]:
    """What to print of the accuracy of a run.

    Args:
        counts: What `accuracy_counts` found.
        tolerance: Largest error of a rotation over the slenderness angle; None without estimates.
        lanes: Lanes of the run.
        advice: Option that makes the first step smaller; see `smaller_step`.
        finest_step: Finest step that was run [s], where it is known.
    """
    if tolerance is None:
        return ["errors were not estimated (--no-estimate): nothing says how far the step matters"]
    if not counts:
        return []
    cost = counts[TOTAL_STEPS] / max(counts[FIRST_STEPS], 1)
    lines = [
        f"tolerance: rotations to {tolerance:g} of the slenderness angle, met by {counts[MET]} of "
        f"{lane_count_text(lanes)} by their estimates; refined {counts[REFINED]} of "
        f"{lane_count_text(lanes)}; "
        f"{cost:.1f} times the steps of one run"
    ]
    down_to = "" if finest_step is None else f", tried down to {finest_step:.3g} s"
    if counts[MISSED]:
        lines.append(
            f"missed by {lane_count_text(counts[MISSED])} whose runs approach one another"
            f"{down_to}. Next: a smaller step, {advice}, or a larger --tolerance"
        )
    if counts[SENSITIVE]:
        lines.append(
            f"sensitive: {lane_count_text(counts[SENSITIVE])}, whose numbers depend on the "
            f"step{down_to}: "
            f"chaos, or close to overturning. Next: a smaller step, {advice}; where that does not "
            "help, an [ensemble] in the case, and its distributions instead of single lanes"
        )
    if counts[MISSED] or counts[SENSITIVE]:
        lines.append("--max-bad SHARE ends with exit code 4 where more lanes than that are so")
    return lines


def run_accuracy_lines(run: CaseRun) -> list[str]:
    """What to print of the accuracy of a run of a case."""
    response, tolerance = run.response, run.options.tolerance
    counts = accuracy_counts(response, run.lane_set, run.settings, tolerance)
    if not counts:
        has_step = hasattr(run.settings, "halved")
        return accuracy_lines(counts, tolerance, 0, "") if has_step else []
    return accuracy_lines(
        counts,
        tolerance,
        response.lane_count,
        smaller_step(response.engine, run.settings),
        float(response["time_step"].min()),
    )


def smaller_step(engine: str, settings: Any) -> str:
    """Option of the command line that makes the step smaller, such as -s engines.event.time_step=.

    Args:
        engine: Name of an engine with a time step.
        settings: Its settings.
    """
    finer = settings
    for _ in range(FINER):
        finer = finer.halved()
    old, new = dataclasses.asdict(settings), dataclasses.asdict(finer)
    changed = {name: value for name, value in new.items() if value != old[name]}
    return " ".join(f"-s engines.{engine}.{name}={value:g}" for name, value in changed.items())
