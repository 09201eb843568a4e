"""A body from a mesh: on the terminal, as JSON and as files."""

from __future__ import annotations

import datetime
import math
from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console

from warprock.bodies.body import Body
from warprock.bodies.footing import DIRECTIONS
from warprock.bodies.rests import turns_over as hull_turns_over
from warprock.running.machine import package_versions
from warprock.tables.report import Report
from warprock.tables.terminal import measured, plain_table, print_table, say, stdout

RESTS_SHOWN = 8
ROLLS_ON = 1.2
"""Lean at which the hull turns over, over that of the base, above which that is said."""
KEPT = 0.98
"""Part of the slenderness angle that fewer points leave, below which that is said."""

_COLUMNS = {
    "direction_deg": ("deg", "From the x axis of the mesh towards y"),
    "slenderness_angle_deg": ("deg", "Slenderness angle of the base, to the edge that lies there"),
    "slenderness_angle_plane_deg": ("deg", "The same in the plane, to the farthest contact point"),
    "turns_over_deg": ("deg", "Lean at which it turns over in that plane, rolling on its points"),
}


def direction_table(body: Body) -> pd.DataFrame:
    """Slenderness angles by direction, one row a direction around the body."""
    around = np.radians(np.linspace(-180.0, 180.0, DIRECTIONS + 1)[1:])
    leans = np.array([fall.lean for fall in body.turns_over(*around)])
    values = (around, body.base.in_space(around), body.base.in_plane(around), leans)
    columns = {
        name: np.round(np.degrees(value), 4) for name, value in zip(_COLUMNS, values, strict=True)
    }
    table = pd.DataFrame(columns)
    table.attrs["columns"] = {
        name: {"unit": unit, "text": text} for name, (unit, text) in _COLUMNS.items()
    }
    return table


def body_facts(body: Body) -> dict[str, Any]:
    """What was found, ready for JSON."""
    tensor = body.mass * body.inertia
    return {
        "body": {
            "name": body.name,
            "file": str(body.file),
            "unit": body.asked.unit or "m",
            "up": body.asked.up,
            "pose": body.asked.pose,
            "turned_deg": math.degrees(body.pose.turn),
            "tolerance_m": body.tolerance,
            "base": body.asked.base,
            "model": body.asked.model,
            "sizes_m": body.sizes.tolist(),
            "volume_m3": body.volume,
            "density_kg_m3": body.density,
            "mass_kg": body.mass,
            "centre_height_m": body.base.height,
            "inertia_kg_m2": tensor.tolist(),
            "base_m": body.points.tolist(),
            "on_the_ground": len(body.base.polygon),
            "weakest_deg": math.degrees(body.weakest),
            **{f"weakest_{name}": value for name, value in _side(body, body.weakest).items()},
            **{f"opposite_{name}": v for name, v in _side(body, body.weakest + math.pi).items()},
            "direction_deg": math.degrees(body.direction),
            "frequency_parameter_rad_s": body.frequency_parameter,
        },
        "rests": [
            {
                "pose": number,
                "turn_deg": math.degrees(rest.turn),
                "centre_height_m": rest.footing.height,
            }
            for number, rest in enumerate(body.rests, start=1)
        ],
        "by_tolerance": [
            {"tolerance_mm": 1e3 * tolerance, "slenderness_angle_deg": math.degrees(angle)}
            for tolerance, angle in body.by_tolerance()
        ],
        "came_out": body_sentence(body),
        "notes": body_notes(body),
        "sha256": body.sha256,
        "versions": package_versions(("numpy", "scipy", "trimesh")),
        "finished": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
    }


def body_sentence(body: Body) -> str:
    """How weak the body is, and where, in one sentence."""
    weak, other = _side(body, body.weakest), _side(body, body.weakest + math.pi)
    return (
        f"{body.name} is weakest towards {math.degrees(body.weakest):.3g} deg from x: it lifts off "
        f"at {weak['lift_g']:.3g} g and turns over at a lean of {weak['turns_over_deg']:.3g} deg; "
        f"on the opposite side at {other['lift_g']:.3g} g and {other['turns_over_deg']:.3g} deg."
    )


def _side(body: Body, direction: float) -> dict[str, float]:
    """What a body bears in a direction, in the plane."""
    angle = float(body.in_plane(direction)[0])
    return {
        "slenderness_angle_deg": math.degrees(angle),
        "lift_g": math.tan(angle),
        "turns_over_deg": math.degrees(body.turns_over(direction)[0].lean),
    }


def body_notes(body: Body) -> list[str]:
    """What a user should know before believing the case, in sentences."""
    notes, asked = [], body.asked
    if asked.unit is None:
        notes.append("The file names no unit: its lengths were taken as metres (--unit).")
    if asked.pose is None and body.pose.turn > 1e-4:
        settled = math.degrees(body.pose.turn)
        notes.append(f"It settles by {settled:.2g} deg from its pose in the file, --pose 0.")
    weak = _side(body, body.weakest)
    hull = math.degrees(hull_turns_over(body.hull, np.array([body.weakest]))[0].lean)
    if asked.base == "flat" and hull > ROLLS_ON * weak["turns_over_deg"]:
        notes.append(
            "Its base is not flat: beyond what touches the ground at rest it rolls on, and turns "
            f"over at {hull:.3g} deg. --base hull keeps the points that touch then."
        )
    if asked.base == "hull" and hull > ROLLS_ON * weak["slenderness_angle_deg"]:
        notes.append(
            "Its base is not flat: it lifts off early, and rolls on to points above the ground."
        )
    full, kept = body.footing.slenderness_angle, body.base.slenderness_angle
    if kept < KEPT * full:
        notes.append(
            f"{len(body.base.polygon)} of the {len(body.footing.polygon)} points that touch the "
            f"ground were kept (--points): {math.degrees(kept):.3g} deg is its slenderness angle "
            f"with them, {math.degrees(full):.3g} deg with all."
        )
    return notes


def body_report(body: Body, case: str = "CASE") -> Report:
    """What a body has to show.

    Args:
        body: The body.
        case: Its case, as a command names it.
    """
    facts = body_facts(body)
    return Report(
        json=facts,
        tables={"directions": direction_table(body)},
        facts=facts,
        show=lambda: print_body(body),
        came_out=body_sentence(body),
        then=f"warprock run {case} -o results",
    )


def print_body(body: Body, console: Console | None = None) -> None:
    """Prints what a body is, what it stands on, its poses, and what the tolerance changes.

    Args:
        body: The body.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    x, y, z = (measured(size) for size in body.sizes)
    ways = [measured(math.sqrt(value)) for value in np.linalg.eigvalsh(body.inertia)]
    table = plain_table(body.name, ["", "value"], left=["", "value"])
    for row in (
        ("size", f"{x} x {y} x {z} m (x, y, z upwards)"),
        ("volume", f"{measured(body.volume)} m^3"),
        ("mass", f"{measured(body.mass)} kg, {measured(body.density)} kg/m^3"),
        ("centre of mass", f"{measured(body.base.height)} m above the ground"),
        ("radii of gyration", f"{', '.join(ways)} m"),
        ("contact points", _contacts(body)),
        *_sides(body),
        ("base pressed flat", _flat_bases(body)),
        ("frequency parameter p", f"{measured(body.frequency_parameter)} rad/s"),
    ):
        table.add_row(*row)
    print_table(out, table)
    print_table(out, _rest_table(body))
    for note in body_notes(body):
        say(out, note)


def _contacts(body: Body) -> str:
    """How many contact points, and where."""
    low, tolerance = len(body.base.polygon), f"{1e3 * body.tolerance:.3g} mm"
    raised = len(body.points) - low
    more = f", and {raised} up to {1e3 * body.points[:, 2].max():.3g} mm above" if raised else ""
    return f"{low} within {tolerance} of the ground{more}"


def _sides(body: Body) -> list[tuple[str, str]]:
    """What its weakest side and the opposite one bear."""
    rows = []
    for name, direction in (("weakest", body.weakest), ("opposite", body.weakest + math.pi)):
        side, towards = _side(body, direction), math.remainder(direction, 2.0 * math.pi)
        rows.append(
            (
                name,
                f"towards {math.degrees(towards):.3g} deg from x, lifts off at "
                f"{side['lift_g']:.3g} g ({side['slenderness_angle_deg']:.3g} deg), turns over at "
                f"a lean of {side['turns_over_deg']:.3g} deg",
            )
        )
    return rows


def _rest_table(body: Body) -> Any:
    """Poses in which it stands."""
    shown = body.rests[:RESTS_SHOWN]
    more = f" ({RESTS_SHOWN} of {len(body.rests)})" if len(body.rests) > RESTS_SHOWN else ""
    headings = ("--pose", "turned by [deg]", "centre of mass at [m]")
    table = plain_table(f"Poses in which it stands{more}; 0 is the pose of the file", headings)
    for number, rest in enumerate(shown, start=1):
        turn, height = measured(math.degrees(rest.turn)), measured(rest.footing.height)
        table.add_row(str(number), turn, height)
    return table


def _flat_bases(body: Body) -> str:
    """What a tolerance makes of a base pressed flat."""
    found = []
    for tolerance, angle in body.by_tolerance():
        lean = f"{math.degrees(angle):.3g} deg" if angle > 0.0 else "falls"
        found.append(f"{lean} within {1e3 * tolerance:.3g} mm")
    return ", ".join(found)
