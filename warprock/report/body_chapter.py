"""The chapter of a body from a mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from warprock.findings.asked import citations, provenance_pairs
from warprock.findings.numbers import three
from warprock.findings.sheets import sheet_of
from warprock.report.content import Chapter
from warprock.report.folder import ResultFolder


def body_chapter(folder: ResultFolder, scenes: Mapping[str, Any] | None) -> Chapter:
    """The chapter of a body from a mesh, whose case lies beside it."""
    facts = folder.facts
    body = facts["body"]
    sheets = [
        sheet_of(title, pd.DataFrame(facts[key], columns=list(columns)).rename(columns=columns))
        for key, title, columns in (
            ("rests", "Poses in which it stands; pose 0 is that of the file", _RESTS),
            ("by_tolerance", "Slenderness angle of a base pressed flat, by tolerance", _TOLERANCES),
        )
        if facts[key]
    ]
    return Chapter(
        kind="Body from a mesh",
        title=body["name"],
        found=[facts["came_out"], *facts["notes"]],
        asked=_asked(body),
        pictures=folder.pictures("body.png"),
        sheets=sheets,
        provenance=[*provenance_pairs(facts), ("Mesh", f"SHA-256 {facts['sha256']}")],
        citations=citations(facts),
    )


_RESTS = {
    "pose": "pose",
    "turn_deg": "turned_deg",
    "centre_height_m": "centre_height_m",
}
_TOLERANCES = {"tolerance_mm": "within_mm", "slenderness_angle_deg": "slenderness_angle_deg"}


def _asked(body: Mapping[str, Any]) -> Sequence[tuple[str, str]]:
    """What is known of the body, as names and texts."""
    size = " x ".join(three(each) for each in body["sizes_m"])
    return [
        ("Mesh", f"{body['file']}, lengths in {body['unit']}, {body['up']} upwards"),
        ("Size", f"{size} m"),
        ("Mass", f"{three(body['mass_kg'])} kg, {three(body['density_kg_m3'])} kg/m³"),
        ("Centre of mass", f"{three(body['centre_height_m'])} m above the ground"),
        ("Contact points", _contacts(body)),
        ("Model", f"{body['model']}, shaken at {three(body['direction_deg'])} deg from x"),
    ]


def _contacts(body: Mapping[str, Any]) -> str:
    """How many contact points, and where."""
    low, tolerance = body["on_the_ground"], 1e3 * body["tolerance_m"]
    raised = len(body["base_m"]) - low
    above = f", {raised} above that touch it as the body leans" if raised else ""
    return f"{low} within {tolerance:.3g} mm of the ground{above}"
