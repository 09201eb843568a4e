"""What there is to choose from: cases, engines, programs of others.

Nothing here reads the tables of a case, so that `warprock list` answers at once.
"""

from __future__ import annotations

import tomllib
from typing import Any

from warprock.case.text import case_names, find_case
from warprock.engines import ENGINES, engine_class


def list_all() -> dict[str, Any]:
    """The shipped cases, the engines, and the programs beside them, ready for JSON."""
    from warprock.programs.table import PROGRAMS

    # A case file says its title itself; to build the case would read its tables.
    texts = [find_case(name) for name in case_names()]
    cases = [{"name": each.name, "title": tomllib.loads(each.text)["title"]} for each in texts]
    return {
        "cases": cases,
        "engines": [engine_row(name) for name in ENGINES],
        "programs": [_program_row(name) for name in PROGRAMS],
    }


def engine_row(name: str) -> dict[str, Any]:
    """An engine: its name, the order of its error in the time step, and what it is."""
    engine = engine_class(name)
    summary = (engine.__doc__ or "").strip().splitlines()[0]
    return {"name": name, "order": engine.order, "summary": summary}


def _program_row(name: str) -> dict[str, Any]:
    from warprock.programs.table import PROGRAMS

    program = PROGRAMS[name]
    return {
        "name": name,
        "installed": program.installed,
        "needs": "" if program.installed else program.install,
        "summary": program.text,
    }
