"""Lanes to play on the pages of sweeps and analyses: a few that tell most, each run again alone.

A lane's numbers do not depend on the lanes around it, so these are the lanes of the tables.
"""

from __future__ import annotations

import contextlib
import dataclasses
import pathlib
from collections.abc import Iterable
from typing import Any

import numpy as np
import pandas as pd

from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.errors import InputError
from warprock.findings.kinds import shapes
from warprock.findings.lanes import lane_name, needed, peak_ratio, standing
from warprock.model.response import FALLEN_NAMES
from warprock.report.folder import ResultFolder
from warprock.report.scenes import SOME, choose, outlines_of, sampled, scene, surroundings_of
from warprock.running.case_run import run_lane_set
from warprock.running.devices import start_warp
from warprock.running.lane_table import LANE_TABLE, PEAK_RATIO, history_table, lane_table
from warprock.running.options import RunOptions
from warprock.running.provenance import case_facts
from warprock.running.results import PROVENANCE
from warprock.running.scene_motion import run_of_folder
from warprock.sweeps.plan import PLAN, Plan, read_plan


@dataclasses.dataclass(frozen=True)
class Replay:
    """One lane to be run again.

    Attributes:
        lane_set: That lane alone.
        engine: Name of the engine.
        settings: Its settings.
        name: What sets the lane apart.
        why: Why it is played; empty where that needs no word.
    """

    lane_set: LaneSet
    engine: str
    settings: Any
    name: str
    why: str = ""


def played(
    case: Case, options: RunOptions, replays: Iterable[Replay], note: str
) -> dict[str, Any] | None:
    """Lanes run again with histories, as a page plays them.

    Args:
        case: The case that they are of.
        options: How they were run.
        replays: The lanes.
        note: Which lanes these are.

    Returns:
        `note` and `lanes`, ready for JSON; None where there is no lane.
    """
    times = dataclasses.replace(sampled(case).sample_times, places=True)
    options = options.without_progress()
    start_warp()
    lanes = []
    for replay in replays:
        given = (replay.engine, replay.lane_set, times, options)
        response = run_lane_set(*given, settings=replay.settings)
        history = history_table(response, 0, replay.lane_set, 0)
        row = lane_table(replay.lane_set, response).iloc[0]
        outlines = outlines_of(replay.lane_set.lanes, 0)
        beside = surroundings_of(replay.lane_set, 0, response, 0)
        lanes.append(scene(history, row, replay.name, replay.why, outlines, beside))
    return {"note": note, "lanes": lanes} if lanes else None


def played_of_sweep(plan: Plan, folder: pathlib.Path) -> dict[str, Any] | None:
    """The lanes of a merged sweep that tell most; of very many lanes the first are looked at.

    Args:
        plan: Its plan.
        folder: Its folder, which holds its lane table.
    """
    facts = {"case": case_facts(plan.case)}
    table = ResultFolder(folder).table(LANE_TABLE, needed(facts))
    settings = plan.case.engine_settings(plan.engine)
    replays = [
        Replay(
            expand_lanes(plan.case, range(lane, lane + 1)),
            plan.engine,
            settings,
            lane_name(facts, table, lane),
            why,
        )
        for lane, why in choose(table, SOME).items()
    ]
    return played(
        plan.case, plan.options(None, None), replays, note_of(len(replays), plan.lane_count)
    )


def played_beside(table: pd.DataFrame, path: pathlib.Path, intensity: str) -> dict[str, Any] | None:
    """Lanes of the run or the merged sweep beside a lane table, at either side of the fall.

    Args:
        table: The lane table.
        path: Where it was read: the file, or its folder.
        intensity: Column of the intensity measure.

    Returns:
        As `played`; None where the folder holds neither, or one that cannot be run here any more.
    """
    folder = path if path.is_dir() else path.parent
    if path != folder and path.name != LANE_TABLE:
        # Another table may have other lanes than the run beside it.
        return None
    ratios = [name for name in map(str, table) if name.startswith(PEAK_RATIO)]
    if not (ratios and {"lane", "outcome", "status"} <= set(table)):
        return None
    chosen = telling(table, intensity)
    numbers = [int(table["lane"].iloc[row]) for row, _ in chosen]
    with contextlib.suppress(InputError):
        if (folder / PROVENANCE).is_file():
            run = run_of_folder(folder, shapes())
            case, options, engine = run.case, run.options, run.response.engine
            settings = run.settings
            sets = [run.lane_set.alone(lane) for lane in numbers]
        elif (folder / PLAN).is_file():
            plan = read_plan(folder)
            case, options, engine = plan.case, plan.options(None, None), plan.engine
            settings = case.engine_settings(engine)
            sets = [expand_lanes(case, range(lane, lane + 1)) for lane in numbers]
        else:
            return None
        facts = {"case": case_facts(case)}
        replays = [
            Replay(lane_set, engine, settings, lane_name(facts, table, row), why)
            for lane_set, (row, why) in zip(sets, chosen, strict=True)
        ]
        return played(case, options, replays, note_of(len(replays), len(table)))
    return None


def note_of(some: int, of: int) -> str:
    """Which lanes a page plays, in words."""
    if some == of:
        return "All lanes, each run again for this page."
    return f"{some} of {of:,} lanes, chosen because they tell most, each run again for this page."


def telling(table: pd.DataFrame, intensity: str) -> list[tuple[int, str]]:
    """Rows of a lane table at either side of the fall: what stood at most, what fell at least.

    Args:
        table: The lane table.
        intensity: Column of the intensity measure, by which lanes are ordered.

    Returns:
        Row and why.
    """
    up, measure = np.flatnonzero(standing(table)), table[intensity].to_numpy(dtype=float)
    fell = np.flatnonzero((table["outcome"].isin(FALLEN_NAMES)).to_numpy())
    found: dict[int, str] = {}
    if len(up):
        far = int(up[np.argmax(peak_ratio(table)[up])])
        found[far] = "the largest rotation of those that stayed up"
        strongest = int(up[np.argmax(measure[up])])
        found.setdefault(strongest, "the strongest motion under which one stayed up")
    if len(fell):
        found.setdefault(int(fell[np.argmin(measure[fell])]), "the weakest motion that felled one")
    return list(found.items())
