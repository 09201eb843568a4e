"""How far a sweep is, and what its lanes came to."""

from __future__ import annotations

import pathlib
from typing import Any

import pandas as pd

from warprock.findings import asked
from warprock.findings.finding import Finding
from warprock.findings.lanes import lane_sheet
from warprock.findings.run import peak_sentences
from warprock.model.words import ASSEMBLY, BLOCK
from warprock.running.lane_table import LANE_TABLE
from warprock.running.provenance import case_facts
from warprock.sweeps.chunks import sweep_state
from warprock.sweeps.plan import Plan


def sweep_facts(plan: Plan, folder: pathlib.Path) -> dict[str, Any]:
    """What a sweep says of its lanes so far, as `run.json` says it of a run.

    Args:
        plan: Its plan.
        folder: Its folder.
    """
    state = sweep_state(plan, folder)
    counts: dict[str, Any] = {name: state[name] for name in ("outcome", "status") if name in state}
    return {**plan.content, "case": case_facts(plan.case), "lanes": plan.lane_count, **counts}


def find_sweep(plan: Plan, folder: pathlib.Path, lanes: pd.DataFrame | None) -> Finding:
    """How far a sweep is, and what its lanes came to once they are merged.

    Args:
        plan: Its plan.
        folder: Its folder.
        lanes: Its merged lane table; None before.
    """
    state, facts = sweep_state(plan, folder), sweep_facts(plan, folder)
    done = f"{state['lanes_done']:,} of {plan.lane_count:,} lanes"
    found = [f"{done} are done, in {state['chunks_done']:,} of {state['chunks']:,} chunks."]
    if state["lanes_done"]:
        thing = ASSEMBLY if plan.case.tables.assembly is not None else BLOCK
        found.append(f"Of these {asked.outcome_words(state['outcome'], thing=thing)}.")
    sheets = []
    if lanes is None:
        found.append(f"Next: warprock sweep run {folder}, then warprock sweep merge.")
    else:
        found += peak_sentences(facts, lanes)
        sheets.append(lane_sheet(facts, lanes, file=LANE_TABLE))
    return Finding(
        kind="Sweep",
        facts={},
        tables={} if lanes is None else {LANE_TABLE: lanes},
        sentences=found,
        sheets=sheets,
        said=state,
        asked=[
            ("Chunks", f"{plan.chunk_count:,} of {plan.chunk_lanes:,}"),
            ("Plan", f"SHA-256 {plan.id}"),
        ],
    )
