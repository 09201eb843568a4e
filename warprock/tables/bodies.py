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
from warprock.run.machine import package_versions
from warprock.tables.report import Report
from warprock.tables.terminal import measured, plain_table, print_table, say, stdout

RESTS_SHOWN = 8
ROLLS_ON = 1.2
"""Lean at which the hull turns over, over the slenderness angle, above which that is said."""
KEPT = 0.98
"""Part of the slenderness angle that fewer points leave, below which that is said."""

_COLUMNS = {
    "direction_deg": ("deg", "From the x axis of the mesh towards y"),
    "slenderness_angle_deg": ("deg", "Lean at which it falls over the edge that lies there"),
    "slenderness_angle_plane_deg": ("deg", "The same where it turns about the axis across it"),
    "turns_over_deg": ("deg", "Lean at which its hull, rolling in that plane, turns over"),
}


def direction_table(body: Body) -> pd.DataFrame:
    """Slenderness angles by direction, one row a direction around the body."""
    around = np.radians(np.linspace(-180.0, 180.0, DIRECTIONS + 1)[1:])
    values = (
        around,
        body.base.in_space(around),
        body.base.in_plane(around),
        body.turns_over(around),
    )
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
            "tolerance_m": body.asked.tolerance,
            "base": body.asked.base,
            "model": body.asked.model,
            "sizes_m": body.sizes.tolist(),
            "volume_m3": body.volume,
            "density_kg_m3": body.density,
            "mass_kg": body.mass,
            "centre_height_m": body.base.height,
            "inertia_kg_m2": tensor.tolist(),
            "base_m": body.points.tolist(),
            "touching": len(body.footing.polygon),
            "slenderness_angle_deg": math.degrees(body.base.slenderness_angle),
            "weakest_deg": math.degrees(body.base.weakest),
            "opposite_deg": math.degrees(_opposite(body)),
            "direction_deg": math.degrees(body.direction),
            "frequency_parameter_rad_s": body.frequency_parameter,
        },
        "rests": [
            {
                "pose": number,
                "turn_deg": math.degrees(rest.turn),
                "slenderness_angle_deg": math.degrees(rest.footing.slenderness_angle),
                "weakest_deg": math.degrees(rest.footing.weakest),
                "centre_height_m": rest.footing.height,
            }
            for number, rest in enumerate(body.rests, start=1)
        ],
        "by_tolerance": [
            {"tolerance_m": tolerance, "slenderness_angle_deg": math.degrees(angle)}
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
    angle, weakest = math.degrees(body.base.slenderness_angle), math.degrees(body.base.weakest)
    return (
        f"{body.name} is weakest towards {weakest:.3g} deg from x: it falls when it leans "
        f"{angle:.3g} deg there, {math.degrees(_opposite(body)):.3g} deg on the opposite side."
    )


def body_notes(body: Body) -> list[str]:
    """What a user should know before believing the case, in sentences."""
    notes, asked = [], body.asked
    if asked.unit is None:
        notes.append("The file names no unit: its lengths were taken as metres (--unit).")
    if asked.pose is None and body.pose.turn > 1e-4:
        settled = math.degrees(body.pose.turn)
        notes.append(f"It settles by {settled:.2g} deg from its pose in the file, --pose 0.")
    weak, angle = body.base.weakest, body.base.slenderness_angle
    over = float(body.turns_over(np.array([weak]))[0])
    if over > ROLLS_ON * angle:
        notes.append(
            "Its base is not flat: beyond what touches the ground at rest it rolls on, and turns "
            f"over at {math.degrees(over):.3g} deg."
            + ("" if asked.base == "hull" else " --base hull keeps the points that touch then.")
        )
    full = body.footing.slenderness_angle
    if angle < KEPT * full:
        notes.append(
            f"{len(body.base.polygon)} of its {len(body.footing.polygon)} contact points were kept "
            f"(--points); with all of them it leans {math.degrees(full):.3g} deg."
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
        ("slenderness angle", _angles(body)),
        ("with other tolerances", _other_tolerances(body)),
        ("frequency parameter p", f"{measured(body.frequency_parameter)} rad/s"),
    ):
        table.add_row(*row)
    print_table(out, table)
    print_table(out, _rest_table(body))
    for note in body_notes(body):
        say(out, note)


def _contacts(body: Body) -> str:
    """How many contact points, and where."""
    low, tolerance = len(body.base.polygon), f"{1e3 * body.asked.tolerance:.3g} mm"
    raised = len(body.points) - low
    more = f", and {raised} up to {1e3 * body.points[:, 2].max():.3g} mm above" if raised else ""
    return f"{low} within {tolerance} of the ground{more}"


def _angles(body: Body) -> str:
    """The slenderness angle of the weakest side, and of the opposite one."""
    angle, weakest = math.degrees(body.base.slenderness_angle), math.degrees(body.base.weakest)
    return (
        f"{angle:.3g} deg towards {weakest:.3g} deg from x, the weakest; "
        f"{math.degrees(_opposite(body)):.3g} deg on the opposite side"
    )


def _opposite(body: Body) -> float:
    """Slenderness angle in the plane, on the side opposite to the weakest [rad]."""
    return float(body.in_plane(body.base.weakest + math.pi)[0])


def _rest_table(body: Body) -> Any:
    """Poses in which it stands."""
    shown = body.rests[:RESTS_SHOWN]
    more = f" ({RESTS_SHOWN} of {len(body.rests)})" if len(body.rests) > RESTS_SHOWN else ""
    headings = ("--pose", "turned [deg]", "centre at [m]", "slenderness [deg]", "towards [deg]")
    table = plain_table(f"Poses in which it stands{more}; 0 is the pose of the file", headings)
    for number, rest in enumerate(shown, start=1):
        foot = rest.footing
        table.add_row(
            str(number),
            measured(math.degrees(rest.turn)),
            measured(foot.height),
            measured(math.degrees(foot.slenderness_angle)),
            f"{math.degrees(foot.weakest):.3g}",
        )
    return table


def _other_tolerances(body: Body) -> str:
    """What the tolerance changes."""
    found = []
    for tolerance, angle in body.by_tolerance():
        lean = f"{math.degrees(angle):.3g} deg" if angle > 0.0 else "falls"
        found.append(f"{lean} within {1e3 * tolerance:.3g} mm")
    return ", ".join(found)
