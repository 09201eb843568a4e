"""A comparison of engines as a report: what it prints, its tables and its facts."""

from __future__ import annotations

import functools
import shlex
from collections.abc import Mapping
from typing import Any

import pandas as pd

from warprock.case.case import Case
from warprock.running.provenance import case_facts, surroundings
from warprock.tables.cells import print_cell_comparison
from warprock.tables.compare import nearest, print_comparison
from warprock.tables.peers import print_costs
from warprock.tables.poses import print_pose_comparison
from warprock.tables.report import Report
from warprock.tables.stack import print_stack_comparison
from warprock.tables.terminal import plain
from warprock.verification.settings import plain_name


def comparison_report(case: Case, found: Mapping[str, Any]) -> Report:
    """The report of a comparison.

    Args:
        case: The case.
        found: What `verification.checks.compare` returned.
    """
    tables = {"comparison": pd.DataFrame(found["rows"])}
    if found["costs"]:
        tables["costs"] = pd.DataFrame(found["costs"])
    facts = plain({**found, "asked": case_facts(case), **surroundings(case)})
    others, first = len(found["engines"]), found["engines"][0]
    said, engine = f"{others} engines were held against {first}.", first
    if "observed" in found:
        said = ""
    elif case.ensemble is None and not (found["stacked"] or found["spatial"]):
        said, engine = nearest(found)
    where = case.name if case.folder is None else case.file
    then = f"warprock run {shlex.quote(where)} -e {plain_name(engine)} -o results"
    show = functools.partial(_show, case, found)
    return Report(found, tables, facts, show, came_out=said, then=then)


def _show(case: Case, found: Mapping[str, Any]) -> None:
    if case.ensemble is not None:
        print_cell_comparison(case, found)
    elif "observed" in found:
        print_pose_comparison(found)
    elif found["stacked"] or found["spatial"]:
        print_stack_comparison(found)
    else:
        print_comparison(found)
    print_costs(found)
