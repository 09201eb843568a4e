"""Which lanes of an analysis, a study or a comparison a page plays, and with which engines."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from warprock.analysis.incremental import Analysis, alone_at, telling
from warprock.case.case import Case
from warprock.case.lanes import expand_lanes
from warprock.report.replays import Replay, played
from warprock.report.scenes import SOME
from warprock.running.options import RunOptions
from warprock.settings.engines import SETTINGS
from warprock.verification.lane_names import lane_name
from warprock.verification.settings import case_asked, plain_name
from warprock.verification.study import StudyRun

Played = Mapping[str, Any] | None
"""`note` and `lanes`, as a page plays them; None where no lane is played."""

_OFF = ("error_run_ratio", "difference_run_ratio", "position_error_mm", "difference_deg")
"""How far a lane is from Housner, from the engine named first, or from what was observed."""


def played_of_analysis(case: Case, engine: str, options: RunOptions, found: Analysis) -> Played:
    """The runs at either side of the first fall, of a few lanes.

    Args:
        case: The case.
        engine: Name of the engine.
        options: How its lanes were run.
        found: The incremental dynamic analysis.
    """
    runs, settings = telling(found), case.engine_settings(engine)
    replays = [
        Replay(
            alone_at(found.lane_set, lane, factor),
            engine,
            settings,
            f"lane {lane}, {factor:.3g} times its motion",
            why,
        )
        for lane, factor, why in runs
    ]
    lanes = len({lane for lane, _, _ in runs})
    note = f"{lanes} of the lanes that fall, each just below and at the motion that fells it."
    return played(case, options, replays, note)


def played_of_study(found: StudyRun) -> Played:
    """Lanes of the case with every engine of the study, at the settings that all others vary.

    Args:
        found: The study.
    """
    study = found.case.study
    assert study is not None
    names = found.table.drop_duplicates("lane").set_index("lane")["lane_name"]
    lanes = list(names.index)[: max(1, SOME // len(found.engines))]
    replays = [
        Replay(
            found.lane_set.alone(lane),
            engine,
            study.baseline[engine],
            f"{engine}, lane {lane} ({names[lane]})",
        )
        for lane in lanes
        for engine in found.engines
    ]
    note = "The engines of the study at the settings of the case, before one of them is varied."
    once = dataclasses.replace(found.options, tolerance=None)
    return played(found.case, once, replays, note)


def played_of_comparison(case: Case, found: Mapping[str, Any]) -> Played:
    """The lane in which engines differ most, and the first, with every engine of ours.

    Args:
        case: The case.
        found: The comparison, as `warprock.verification.checks.compare` gives it.
    """
    if case.ensemble is not None:
        return None
    lane_set, worst = expand_lanes(case), _worst(found, case.tables.block_count)
    ours = [engine for engine in found["engines"] if plain_name(engine) in SETTINGS][:SOME]
    lanes = list(dict.fromkeys((worst, 0)))[: SOME // max(1, len(ours)) or 1]
    replays = [
        Replay(
            lane_set.alone(lane),
            plain_name(engine),
            case_asked(case, engine).engine_settings(plain_name(engine)),
            f"{engine}, lane {lane} ({lane_name(lane_set, lane)})",
            "engines differ most here" if lane == worst else "the first lane",
        )
        for lane in lanes
        for engine in ours
    ]
    note = "The lane in which the engines differ most, and the first, each engine by itself."
    return played(case, RunOptions(tolerance=None), replays, note)


def _worst(found: Mapping[str, Any], blocks: int) -> int:
    """The lane in which an engine is farthest from what it was held against."""
    most, worst = 0.0, 0
    for engine in found["engines"]:
        mine = [row for row in found["rows"] if row["engine"] == engine]
        for place, row in enumerate(mine):
            off = next((row[name] for name in _OFF if row.get(name) is not None), 0.0)
            if off > most:
                most, worst = off, place // blocks
    return worst
