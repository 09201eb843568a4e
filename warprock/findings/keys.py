"""Keys of a case file, as a table."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence

from warprock.case.columns import Columns
from warprock.case.reference import Section, facts
from warprock.findings.finding import Finding
from warprock.findings.numbers import counted


def find_keys(found: Sequence[Section], show: Callable[..., None]) -> Finding:
    """Keys of a case file.

    Args:
        found: Their tables, from `case.reference.find_sections`.
        show: Prints them.
    """
    rows = [
        {
            "table": section.title,
            "key": row.key,
            "unit": row.unit,
            "default": row.default,
            "required": row.required,
            "swept": row.swept,
            "holds": facts(row),
            "meaning": row.text,
        }
        for section in found
        for row in section.keys
    ]
    return Finding(
        kind="Keys of a case file",
        facts={},
        tables={"keys": Columns.of(rows)},
        sentences=[f"{counted(len(rows), 'key is', 'keys are')} listed."],
        said={"tables": [section.as_json() for section in found]},
        show=functools.partial(show, found),
        then="warprock init pulse mine/case.toml",
    )
