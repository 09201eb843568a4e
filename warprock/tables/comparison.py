"""A comparison of engines on the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warprock.case.case import Case
from warprock.tables.cells import print_cell_comparison
from warprock.tables.compare import print_comparison
from warprock.tables.peers import print_costs
from warprock.tables.poses import print_pose_comparison
from warprock.tables.stack import print_assembly_comparison, print_stack_comparison


def print_any_comparison(case: Case, found: Mapping[str, Any]) -> None:
    """Prints what `verification.checks.compare` returned of a case."""
    if case.ensemble is not None:
        print_cell_comparison(case, found)
    elif "observed" in found:
        print_pose_comparison(found)
    elif found.get("assembly"):
        print_assembly_comparison(found)
    elif found["stacked"] or found["spatial"]:
        print_stack_comparison(found)
    else:
        print_comparison(found)
    print_costs(found)
