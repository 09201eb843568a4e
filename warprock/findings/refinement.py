"""How far lanes may be off by their estimates, and what to do about those that may be too far."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from warprock.findings.digits import number_of, quantity_of, value_of
from warprock.findings.numbers import counted, three
from warprock.model.response import SOUND_NAMES
from warprock.running.refinement import (
    FIRST_STEPS,
    MET,
    MISSED,
    REFINED,
    SENSITIVE,
    TOTAL_STEPS,
    count_bad,
)
from warprock.settings.engines import SETTINGS, has_time_step

FINER = 2
"""Halvings of the step that the advice is of."""


def refinement_sentences(
    facts: Mapping[str, Any], finest_step: float | None = None, mend: str = ""
) -> list[str]:
    """How far the numbers may be off.

    Args:
        facts: What `run.json` says of a run.
        finest_step: Finest step that was run [s], where it is known.
        mend: What to do with a smaller step, before its option: `plan anew with`.
    """
    tolerance, counts, lanes = facts.get("tolerance"), facts.get("refinement") or {}, facts["lanes"]
    found = []
    if not has_time_step(SETTINGS.get(facts["engine"]["name"])):
        found.append("The engine follows its equations without a time step: no step adds an error.")
    elif tolerance is None:
        found.append("Errors were not estimated: nothing says how far the time step matters.")
    elif counts:
        advice = f"{mend} {smaller_step(facts['engine'])}".strip()
        found += _counted(counts, facts, advice, finest_step)
    bad = {word: n for word, n in facts["status"].items() if n and word not in SOUND_NAMES}
    bad.pop("sensitive", None)
    if bad:
        parts = [f"{n:,} {word.replace('_', ' ')}" for word, n in bad.items()]
        found.append(f"Statuses to mind, of {counted(lanes, 'lane')}: {', '.join(parts)}.")
    return found


def _counted(
    counts: Mapping[str, int], facts: Mapping[str, Any], advice: str, finest_step: float | None
) -> list[str]:
    """How many lanes meet the tolerance, and what to do about the others."""
    lanes, met = facts["lanes"], counts[MET]
    cost = counts[TOTAL_STEPS] / max(counts[FIRST_STEPS], 1)
    error = facts.get("rotation_error_rad")
    who = f"By their estimated errors {met:,} of {counted(lanes, 'lane')} are"
    if lanes == 1:
        who = f"By its estimated error the lane is{'' if met else ' not'}"
    text = (
        f"{who} within the tolerance, {value_of(facts, 'tolerance')} of the slenderness angle; "
        f"refined: {counts[REFINED]:,}, in {number_of('cost_ratio', cost)} times the steps of one "
        "run"
    )
    if error:
        ends = [f"{three(math.degrees(error[name]))} deg" for name in ("median", "largest")]
        text += f"; estimates of sound lanes: median {ends[0]}, largest {ends[1]}"
    found = [f"{text}."]
    down_to = ""
    if finest_step is not None:
        down_to = f", tried down to {quantity_of('finest_step_s', finest_step)}"
    if counts[MISSED]:
        found.append(
            f"The tolerance is missed by {counted(counts[MISSED], 'lane')} whose runs approach one "
            f"another{down_to}. Next: begin at a smaller step, {advice}, or a larger --tolerance."
        )
    if counts[SENSITIVE]:
        found.append(
            f"Sensitive: {counted(counts[SENSITIVE], 'lane')}, whose numbers depend on the step"
            f"{down_to}: chaos, or close to overturning. Next: begin at a smaller step, {advice}; "
            f"where that does not help, {_distributions(facts)} instead of single lanes."
        )
    return found


def _distributions(facts: Mapping[str, Any]) -> str:
    """What tells of lanes that no step settles."""
    case = facts.get("case")
    if isinstance(case, Mapping) and "ensemble" in case["resolved"]:
        return "the distributions of the cells"
    return "an [ensemble] in the case, and its distributions"


def bad_sentences(facts: Mapping[str, Any]) -> list[str]:
    """How to end a command with an exit code where lanes are bad; none where none is.

    Args:
        facts: What `run.json` says of a run.
    """
    if not count_bad(facts["status"], facts.get("refinement") or {}):
        return []
    return [
        "--max-bad SHARE ends with exit code 4 where more lanes than that are unusable or miss the "
        "tolerance."
    ]


def smaller_step(engine: Mapping[str, Any]) -> str:
    """Option of the command line that makes the step smaller, such as -s engines.event.time_step=.

    Args:
        engine: What `run.json` says of an engine with a time step; empty of what is no setting.
    """
    name, old = engine["name"], engine["settings"]
    try:
        finer = SETTINGS[name](**old)
        for _ in range(FINER):
            finer = finer.halved()
    except (TypeError, ValueError):
        return ""
    new = dataclasses.asdict(finer)
    changed = {key: number_of("value", new[key]) for key in new if new[key] != old.get(key)}
    return " ".join(f"-s engines.{name}.{key}={text}" for key, text in changed.items())
