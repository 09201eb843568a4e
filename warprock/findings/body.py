"""What a body from a mesh is, what it stands on, and which way it falls."""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from warprock.bodies.body import Body
from warprock.bodies.footing import DIRECTIONS
from warprock.bodies.rests import turns_over as hull_turns_over
from warprock.findings.digits import number_of, quantity_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.numbers import three
from warprock.findings.sheets import Heading, Sheet, declared
from warprock.running.machine import package_versions
from warprock.running.run_file import ROWS

RESTS_SHOWN = 8
ROLLS_ON = 1.2
"""Lean at which the hull turns over, over that of the base, above which that is said."""
KEPT = 0.98
"""Part of the slenderness angle that fewer points leave, below which that is said."""
TABLE = "directions"

_COLUMNS = {
    "direction_deg": ("deg", "From the x axis of the mesh towards y"),
    "slenderness_angle_deg": ("deg", "Slenderness angle of the base, to the edge that lies there"),
    "slenderness_angle_plane_deg": ("deg", "The same in the plane, to the farthest contact point"),
    "turns_over_deg": ("deg", "Lean at which it turns over in that plane, rolling on its points"),
}
_SIDE = ("slenderness_angle_deg", "lift_g", "turns_over_deg")


def find_body(body: Body) -> Finding:
    """What a body came to."""
    return tell_body(body_facts(body), {TABLE: direction_table(body)})


def tell_body(facts: Facts, tables: Tables) -> Finding:
    """What a body came to, of its facts and table."""
    body = facts["body"]
    where = f"{body['file']}, lengths in {body['unit']}, {body['up']} upwards"
    return Finding(
        kind="Body from a mesh",
        title=body["name"],
        facts=facts,
        tables=tables,
        sentences=[facts["came_out"], *facts["notes"]],
        sheets=[_body_sheet(facts), _rest_sheet(facts["rests"])],
        asked=[
            ("Mesh", f"{where}; SHA-256 {facts['sha256']}"),
            ("Model", f"{body['model']}, shaken at {three(body['direction_deg'])} deg from x"),
        ],
        pictures=["body.png"],
    )


BODY = Kind(
    (TABLE,),
    tell_body,
    "body",
    {
        "body": {
            **dict.fromkeys(("name", "file", "unit", "up", "model"), str),
            "sizes_m": [float],
            **dict.fromkeys(
                ("mass_kg", "density_kg_m3", "volume_m3", "centre_height_m", "tolerance_m"), float
            ),
            **dict.fromkeys(("weakest_deg", "frequency_parameter_rad_s"), float),
            **{f"{side}_{name}": float for side in ("weakest", "opposite") for name in _SIDE},
            "inertia_kg_m2": [[float]],
            "base_m": [[float]],
            "on_the_ground": int,
            "direction_deg": (float, None),
        },
        "came_out": str,
        "notes": [str],
        "sha256": str,
        "rests": ROWS,
        "by_tolerance": ROWS,
    },
)


def direction_table(body: Body) -> pd.DataFrame:
    """Slenderness angles by direction, one row a direction around the body."""
    around = np.radians(np.linspace(-180.0, 180.0, DIRECTIONS + 1)[1:])
    leans = np.array([fall.lean for fall in body.turns_over(*around)])
    values = (around, body.base.in_space(around), body.base.in_plane(around), leans)
    columns = {
        name: np.round(np.degrees(value), 4) for name, value in zip(_COLUMNS, values, strict=True)
    }
    return declared(pd.DataFrame(columns), _COLUMNS)


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
        f"{body.name} is weakest towards {_degrees('weakest', body.weakest)} from x: it lifts off "
        f"at {value_of(weak, 'lift_g')} g and turns over at a lean of "
        f"{quantity_of('turns_over_deg', weak['turns_over_deg'])}; on the opposite side at "
        f"{value_of(other, 'lift_g')} g and "
        f"{quantity_of('turns_over_deg', other['turns_over_deg'])}."
    )


def _degrees(name: str, angle: float) -> str:
    """An angle [rad] in degrees."""
    return quantity_of(f"{name}_deg", math.degrees(angle))


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
        settled = _degrees("settled", body.pose.turn)
        notes.append(f"It settles by {settled} from its pose in the file, --pose 0.")
    weak = _side(body, body.weakest)
    hull = math.degrees(hull_turns_over(body.hull, np.array([body.weakest]))[0].lean)
    if asked.base == "flat" and hull > ROLLS_ON * weak["turns_over_deg"]:
        notes.append(
            "Its base is not flat: beyond what touches the ground at rest it rolls on, and turns "
            f"over at {quantity_of('turns_over_deg', hull)}. --base hull keeps the points that "
            "touch then."
        )
    if asked.base == "hull" and hull > ROLLS_ON * weak["slenderness_angle_deg"]:
        notes.append(
            "Its base is not flat: it lifts off early, and rolls on to points above the ground."
        )
    full, kept = body.footing.slenderness_angle, body.base.slenderness_angle
    if kept < KEPT * full:
        notes.append(
            f"{len(body.base.polygon)} of the {len(body.footing.polygon)} points that touch the "
            f"ground were kept (--points): {_degrees('slenderness_angle', kept)} is its "
            f"slenderness angle with them, {_degrees('slenderness_angle', full)} with all."
        )
    return notes


def _body_sheet(facts: Facts) -> Sheet:
    """Sizes, mass, what the body stands on and what its weakest side and the opposite one bear."""
    body = facts["body"]
    x, y, z = map(three, body["sizes_m"])
    inertia = np.array(body["inertia_kg_m2"]) / body["mass_kg"]
    ways = [three(math.sqrt(value)) for value in np.linalg.eigvalsh(inertia)]
    rows = [
        ("size", f"{x} x {y} x {z} m (x, y, z upwards)"),
        ("volume", f"{three(body['volume_m3'])} m^3"),
        ("mass", f"{three(body['mass_kg'])} kg, {three(body['density_kg_m3'])} kg/m^3"),
        ("centre of mass", f"{three(body['centre_height_m'])} m above the ground"),
        ("radii of gyration", f"{', '.join(ways)} m"),
        ("contact points", _contacts(body)),
        ("weakest", _side_text(body, "weakest", body["weakest_deg"])),
        ("opposite", _side_text(body, "opposite", body["weakest_deg"] + 180.0)),
        ("base pressed flat", _flat_bases(facts["by_tolerance"])),
        ("frequency parameter p", f"{three(body['frequency_parameter_rad_s'])} rad/s"),
    ]
    return Sheet(body["name"], [Heading(""), Heading("value")], rows)


def _contacts(body: Mapping[str, Any]) -> str:
    """How many contact points, and where."""
    low, tolerance = body["on_the_ground"], quantity_of("tolerance_m", body["tolerance_m"])
    raised, highest = len(body["base_m"]) - low, max(point[2] for point in body["base_m"])
    more = f", and {raised} up to {quantity_of('height_m', highest)} above" if raised else ""
    return f"{low} within {tolerance} of the ground{more}"


def _side_text(body: Mapping[str, Any], name: str, direction: float) -> str:
    """What a side of a body bears."""
    angle, lift, lean = (body[f"{name}_{what}"] for what in _SIDE)
    towards = quantity_of("weakest_deg", math.remainder(direction, 360.0))
    return (
        f"towards {towards} from x, lifts off at {number_of('lift_g', lift)} g "
        f"({quantity_of('slenderness_angle_deg', angle)}), turns over at a lean of "
        f"{quantity_of('turns_over_deg', lean)}"
    )


def _flat_bases(rows: list[Mapping[str, Any]]) -> str:
    """What a tolerance makes of a base pressed flat."""
    found = []
    for row in rows:
        angle = row["slenderness_angle_deg"]
        lean = quantity_of("slenderness_angle_deg", angle) if angle > 0.0 else "falls"
        found.append(f"{lean} within {quantity_of('tolerance_mm', row['tolerance_mm'])}")
    return ", ".join(found)


def _rest_sheet(rests: list[Mapping[str, Any]]) -> Sheet:
    """Poses in which it stands."""
    shown = rests[:RESTS_SHOWN]
    more = f" ({RESTS_SHOWN} of {len(rests)})" if len(rests) > RESTS_SHOWN else ""
    heads = [Heading("--pose"), Heading("turned by", "deg"), Heading("centre of mass at", "m")]
    rows = [
        [str(rest["pose"]), three(rest["turn_deg"]), three(rest["centre_height_m"])]
        for rest in shown
    ]
    return Sheet(f"Poses in which it stands{more}; 0 is the pose of the file", heads, rows)
