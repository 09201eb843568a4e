"""Batched simulation of rocking rigid blocks: a case becomes lanes, an engine answers for each.

The public names below are imported when they are first used, so that `import warprock` is cheap.
"""

from __future__ import annotations

import importlib
import pathlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warprock.batch import run_batch
    from warprock.case import Case, load_case
    from warprock.case_text import case_names
    from warprock.engines import ENGINES
    from warprock.errors import InputError
    from warprock.expansion import LaneSet, expand_lanes
    from warprock.lanes import Lanes
    from warprock.response import FIELDS, Outcome, Response, SampleTimes, Status
    from warprock.runner import CaseRun, run_case
    from warprock.store import lane_table, write_run

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
    "FIELDS": "warprock.response",
    "Case": "warprock.case",
    "CaseRun": "warprock.runner",
    "InputError": "warprock.errors",
    "LaneSet": "warprock.expansion",
    "Lanes": "warprock.lanes",
    "Outcome": "warprock.response",
    "Response": "warprock.response",
    "SampleTimes": "warprock.response",
    "Status": "warprock.response",
    "case_names": "warprock.case_text",
    "expand_lanes": "warprock.expansion",
    "lane_table": "warprock.store",
    "load_case": "warprock.case",
    "run_batch": "warprock.batch",
    "run_case": "warprock.runner",
    "write_run": "warprock.store",
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
