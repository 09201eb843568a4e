"""What there is to choose from, what a case requires, and what this machine offers."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any

from warprock.case.columns import Columns
from warprock.findings.finding import Finding
from warprock.findings.numbers import counted

Show = Callable[..., None]
"""Prints on the terminal what was found."""


def find_list(found: Mapping[str, Any], show: Show) -> Finding:
    """Shipped cases, engines and programs of others.

    Args:
        found: What `running.choices.list_all` found.
        show: Prints it.
    """
    count = f"{len(found['cases'])} cases are shipped, {len(found['engines'])} engines run them."
    return Finding(
        kind="Cases and engines",
        facts={},
        tables={name: Columns.of(found[name]) for name in ("cases", "engines", "programs")},
        sentences=[count],
        said=found,
        show=functools.partial(show, found),
        then="warprock explain free-b0",
    )


def find_explanation(found: Mapping[str, Any], show: Show) -> Finding:
    """What a case requires, and which engines run it.

    Args:
        found: What `running.catalogue.explain_case` found.
        show: Prints it.
    """
    engines = [
        {
            "engine": each["name"],
            "order": each["order"],
            "kernel": each.get("kernel"),
            "declines": each["declines"],
        }
        for each in found["engines"]
    ]
    able = any(not each["declines"] for each in engines)
    name = found["engine"]["engine"]
    lanes, them = counted(found["lanes"], "lane"), "it" if found["lanes"] == 1 else "them"
    runs = f"{name} runs {them} unless another engine is named"
    if not able:
        runs = f"no engine runs {them}"
    return Finding(
        kind="What a case requires",
        facts={},
        tables={"engines": Columns.of(engines)},
        sentences=[f"{found['case']['name']} makes {lanes}; {runs}."],
        said=found,
        title=found["case"]["name"],
        show=functools.partial(show, found),
    )


def find_examination(found: Mapping[str, Any], show: Show) -> Finding:
    """What this machine offers, and what is missing.

    Args:
        found: What `measure.doctor.examine` found.
        show: Prints it.
    """
    missing = len(found["missing"])
    said = f"{counted(missing, 'thing is', 'things are')} missing." if missing else ""
    return Finding(
        kind="This machine",
        facts={},
        tables={
            "engines": Columns.of(
                [{"engine": name, "state": state} for name, state in found["engines"].items()]
            ),
            "packages": Columns.of(
                [
                    {"package": name, "version": version}
                    for name, version in found["versions"].items()
                ]
            ),
            "devices": Columns.of(found["devices"]),
        },
        sentences=[said or "Nothing is missing."],
        said=found,
        show=functools.partial(show, found),
        then="" if missing else "warprock run free-b0 -o results",
    )
