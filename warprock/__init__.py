"""Batched simulation of rocking rigid blocks: a case becomes lanes, an engine answers for each.

The public names below are imported when they are first used, so that `import warprock` is cheap.
"""

from __future__ import annotations

import importlib
import pathlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warprock.case.case import Case
    from warprock.case.lanes import LaneSet, expand_lanes
    from warprock.case.load import load_case
    from warprock.case.text import case_names
    from warprock.engines import ENGINES
    from warprock.errors import InputError
    from warprock.model.lanes import Lanes
    from warprock.model.response import FIELDS, Outcome, Response, SampleTimes, Status
    from warprock.run.batch import run_batch
    from warprock.run.case_run import CaseRun, run_case
    from warprock.run.lane_table import lane_table
    from warprock.run.results import write_run

__version__ = "0.1.0"

__all__ = [
    "ENGINES",
    "FIELDS",
    "Case",
    "CaseRun",
    "InputError",
    "LaneSet",
    "Lanes",
    "Outcome",
    "Response",
    "SampleTimes",
    "Status",
    "case_names",
    "expand_lanes",
    "lane_table",
    "load_case",
    "run_batch",
    "run_case",
    "write_run",
]

_HOME = {
    "ENGINES": "warprock.engines",
    "FIELDS": "warprock.model.response",
    "Case": "warprock.case.case",
    "CaseRun": "warprock.run.case_run",
    "InputError": "warprock.errors",
    "LaneSet": "warprock.case.lanes",
    "Lanes": "warprock.model.lanes",
    "Outcome": "warprock.model.response",
    "Response": "warprock.model.response",
    "SampleTimes": "warprock.model.response",
    "Status": "warprock.model.response",
    "case_names": "warprock.case.text",
    "expand_lanes": "warprock.case.lanes",
    "lane_table": "warprock.run.lane_table",
    "load_case": "warprock.case.load",
    "run_batch": "warprock.run.batch",
    "run_case": "warprock.run.case_run",
    "write_run": "warprock.run.results",
}

# The checkout bridge: an installed package holds kernels/ and cases/; a checkout keeps them next
# to warprock/, where `warprock.kernels` and `warprock.cases` are found through this path.
_PACKAGE = pathlib.Path(__file__).parent
if not (_PACKAGE / "kernels").is_dir():
    __path__.append(str(_PACKAGE.parent))


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
