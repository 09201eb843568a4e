"""What came out of a run, in sentences made from its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from warprock.model.response import SOUND
from warprock.report import asked
from warprock.report.lanes import falling, lane_name, peak_ratio, standing
from warprock.report.numbers import counted, three

WITHOUT_STEP = ("housner", "two-block")
"""Engines whose numbers do not depend on a time step."""
_SOUND = [code.name.lower() for code in SOUND]


def run_sentences(facts: Mapping[str, Any], table: pd.DataFrame) -> list[str]:
    """What came out of a run, in three sentences made from its numbers."""
    count, outcome = len(table), facts["outcome"]
    together = None if "shortest_duration_s" in facts else facts.get("duration_s")
    ended = asked.outcome_words(outcome, together, falling(table))
    first = f"{counted(count, 'lane')} ran: {ended}."
    if count == 1:
        first = f"One lane ran: it {table['outcome'].iloc[0].replace('_', ' ')}."
        first = first.replace("it at rest", "its block came to rest")
        first = first.replace("it rocking", "its block still moved when the run ended")
        first = first.replace("it overturned", "its block overturned")
        first = first.replace("it slid off", "a block slid off")
    return [first, *peak_sentences(facts, table), *accuracy_sentences(facts)]


def peak_sentences(facts: Mapping[str, Any], table: pd.DataFrame) -> list[str]:
    """The largest rotation of what stood, and the median; how far thrown blocks went."""
    if "attitude_w_start" in table:
        return way_sentences(facts, table)
    up, ratio = np.flatnonzero(standing(table)), peak_ratio(table)
    if not len(up):
        return ["No lane with usable numbers stayed up."]
    top = int(up[np.argmax(ratio[up])])
    where = ""
    if len(table) > 1:
        where = f", in {lane_name(facts, table, top)}"
    when = table["peak_time_s"].iloc[top] if "peak_time_s" in table else np.nan
    at = f" at {three(float(when))} s" if when == when and len(table) == 1 else ""
    degrees = ""
    if "peak_rotation_rad" in table:
        degrees = f" ({three(float(np.rad2deg(table['peak_rotation_rad'].iloc[top])))} deg)"
    text = (
        f"The largest rotation of a block that stayed up is {three(float(ratio[top]))} of its "
        f"slenderness angle{degrees}{at}{where}"
    )
    if len(up) > 2:
        text += f"; the median lane that stayed up reaches {three(float(np.median(ratio[up])))}"
    return [f"{text}."]


def way_sentences(facts: Mapping[str, Any], table: pd.DataFrame) -> list[str]:
    """How far thrown blocks went, and when they lay still: they may lie on any side."""
    way, rest = table["peak_slide_m"], table["rest_time_s"]
    if len(table) == 1:
        still = (
            f" and lies still after {three(float(rest.iloc[0]))} s" if rest.notna().any() else ""
        )
        return [f"It goes {three(float(way.iloc[0]))} m along the base{still}."]
    far = int(np.argmax(way))
    name = lane_name(facts, table, far)
    text = f"The farthest goes {three(float(way.iloc[far]))} m along the base, {name}"
    if rest.notna().any():
        text += (
            f"; the last of those that came to rest lies still after {three(float(rest.max()))} s"
        )
    return [f"{text}."]


def accuracy_sentences(facts: Mapping[str, Any]) -> list[str]:
    """How far the numbers may be off."""
    status, lanes = facts["status"], facts["lanes"]
    counts, tolerance = facts.get("accuracy") or {}, facts.get("tolerance")
    bad = {word: n for word, n in status.items() if n and word not in _SOUND}
    flagged = ""
    if bad:
        parts = [f"{n:,} {word.replace('_', ' ')}" for word, n in bad.items()]
        flagged = f" Statuses to mind: {', '.join(parts)} (see what the words mean)."
    if tolerance is None and facts["engine"]["name"] not in WITHOUT_STEP:
        return [
            f"Errors were not estimated, so nothing says how far the time step matters.{flagged}"
        ]
    if not counts:
        own = "The engine follows its equations without a time step, so no step adds an error."
        return [f"{own}{flagged}"]
    met = counts["met"]
    who = "all" if met == lanes else f"{met:,} of the {lanes:,}"
    text = (
        f"By their estimated errors {who} lanes are within the tolerance, {tolerance:g} of the "
        "slenderness angle"
        if lanes > 1
        else f"By its estimated error the lane is {'' if met else 'not '}within the tolerance, "
        f"{tolerance:g} of the slenderness angle"
    )
    error = facts.get("rotation_error_rad")
    if error:
        text += f"; the largest estimate among sound lanes is {three(error['largest'])} rad"
    return [f"{text}.{flagged}"]


def cell_sentences(table: pd.DataFrame) -> list[str]:
    """The cell of an ensemble that overturns most often.

    Args:
        table: What `running.cells.cell_table` gives.
    """
    if "overturned" not in table or not len(table) or table["overturned"].isna().all():
        return []
    share = table["overturned"]
    row = int(np.nanargmax(share.to_numpy(dtype=float)))
    low, high = (float(table[f"overturned_{side}"].iloc[row]) for side in ("low", "high"))
    if share.iloc[row] == 0.0:
        text = f"No member of any of the {len(table):,} cells overturned"
        return [f"{text}; with 95 % confidence at most {three(100 * high)} % do in a cell."]
    return [
        f"Of the {len(table):,} cells, cell {row} overturns most often: "
        f"{three(100.0 * float(share.iloc[row]))} % of its members (95 % interval "
        f"{three(100 * low)} to {three(100 * high)} %)."
    ]
