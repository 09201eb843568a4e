"""What holds single blocks, from the values of a case, lane by lane, and its input columns."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.hold import BY_FORMULA, STAYS, Frame, Ground, Strip, Tie, TopLoad, TransverseWall
from warprock.case.input_columns import computed, key_column
from warprock.errors import InputError, Said
from warprock.model.hold import SIDES, Bed, Hold, Ties, three_impacts
from warprock.model.hold import Frame as Frames
from warprock.model.hold import TopLoad as Loads
from warprock.model.lanes import Lanes
from warprock.model.strip import Strip as Strips
from warprock.quantity import NumberKey

if TYPE_CHECKING:
    from warprock.case.values import LaneValues

Array = npt.NDArray[np.float64]

MOST_SUNK = 0.1
"""Depth at rest on compliant ground over the width of a block up to which sizes are as drawn."""

WALL, TIE, LOAD, FRAME, STRIP, GROUND = (
    TransverseWall.place,
    Tie.place.partition(".")[0],
    TopLoad.place,
    Frame.place,
    Strip.place,
    Ground.place,
)


def held(values: LaneValues, lanes: Lanes) -> tuple[Lanes, dict[str, object]]:
    """Single blocks with what the case holds them by, and its input columns.

    Args:
        values: Values of the case.
        lanes: Its blocks.

    Raises:
        InputError: A block that starts in its wall, a tie above its block, forces and elongations
            of a tie that do not fit together, a weight beside its block, or a strip that starts
            beyond its balance or is too stout to rock on.
    """
    columns: dict[str, object] = {}
    hold = Hold()
    if values.case.tables.strip is not None:
        return _strips(values, lanes)
    if values.case.tables.frame is not None:
        return _frames(values, lanes)
    if values.case.tables.ground is not None:
        return _on_ground(values, lanes)
    if values.case.tables.transverse_wall is not None:
        hold, of_wall = _beside_wall(values, lanes)
        columns |= of_wall
    if values.case.tables.tie is not None:
        numbers = range(1, values.case.tables.tie.count + 1)
        found = [_tie(values, f"{TIE}.{number}", lanes) for number in numbers]
        parts = {name: np.stack([each[name] for each in found], axis=1) for name in found[0]}
        hold = dataclasses.replace(hold, ties=Ties(**parts))
        for number in numbers:
            columns |= _tie_columns(values, number)
    if values.case.tables.top_load is not None:
        load, of_load = _load(values, lanes)
        hold = dataclasses.replace(hold, load=load)
        columns |= of_load
    return (dataclasses.replace(lanes, hold=hold) if columns else lanes), columns


def _beside_wall(values: LaneValues, lanes: Lanes) -> tuple[Hold, dict[str, object]]:
    """Blocks beside a transverse wall, and its columns."""
    side, rebound = _sides(values, f"{WALL}.side"), values.numbers(f"{WALL}.rebound")
    towards = np.where(side < 0.0, "left", "right")
    into = side * lanes.rotation_start > 0.0
    allowed = f"must lean away from the wall at its {towards[int(np.argmax(into))]}"
    key = "start.rotation_ratio" if values.given("start.rotation_ratio") else "start.rotation"
    values.refuse(into, key, allowed)
    formula = rebound == BY_FORMULA
    rebound = np.where(formula, three_impacts(lanes.slenderness_angle), rebound)
    columns: dict[str, object] = {"wall_side": values.column(f"{WALL}.side")}
    return Hold(side, rebound), columns | key_column(f"{WALL}.rebound", rebound)


def _sides(values: LaneValues, key: str) -> Array:
    """Sides as -1 and 1, shape [lane]."""
    names, codes = values.texts(key)
    return np.array([SIDES[name] for name in names])[codes]


def _tie(values: LaneValues, table: str, lanes: Lanes) -> dict[str, npt.NDArray[Any]]:
    """Fields of `Ties` of one tie, shape [lane] each."""
    height, prestress, slack, stiffness = (
        values.numbers(f"{table}.{name}") for name in ("height", "prestress", "slack", "stiffness")
    )
    high = height > lanes.height
    top = lanes.height[int(np.argmax(high))]
    values.refuse(high, f"{table}.height", f"must be at most the height of the block, {top:g} m")
    limits = {}
    for name in ("yield_force", "ultimate_elongation"):
        given = values.given(f"{table}.{name}")
        limits[name] = values.numbers(f"{table}.{name}") if given else np.full_like(height, np.inf)
    weak = limits["yield_force"] <= prestress
    at = int(np.argmax(weak))
    allowed = f"must be more than {table}.prestress, {prestress[at]:g} N"
    values.refuse(weak, f"{table}.yield_force", allowed)
    names, codes = values.texts(f"{table}.acts")
    pushes = np.array([name == "both" for name in names])[codes]
    allowed = f"must be 0 m where {table}.acts is both: such a tie would push a block at rest"
    values.refuse(pushes & (slack > 0.0), f"{table}.slack", allowed)
    return {
        "side": _sides(values, f"{table}.side"),
        "height": height,
        "stiffness": stiffness,
        "slack": slack,
        "prestress": prestress,
        "pushes": pushes,
        **limits,
    }


def _tie_columns(values: LaneValues, number: int) -> dict[str, object]:
    """Input columns of a tie: those of the keys that are given."""
    columns: dict[str, object] = {}
    for name, declared in Tie.declared().items():
        key = f"{TIE}.{number}.{name}"
        if not values.given(key):
            continue
        if isinstance(declared, NumberKey):
            columns |= key_column(f"{Tie.place}.{name}", values.numbers(key), f"_{number}")
        else:
            columns |= {f"tie_{name}_{number}": values.column(key)}
    return columns


def _on_ground(values: LaneValues, lanes: Lanes) -> tuple[Lanes, dict[str, object]]:
    """Blocks on compliant ground, and its columns."""
    _refuse_beside(values, (WALL, TIE, LOAD), "[ground], on which the block stands free")
    key = "contact.angular_restitution"
    if values.given(key):
        allowed = "must be left out beside [ground], which says what an impact leaves"
        raise InputError(values.case.source_of(key), key, float(values.numbers(key)[0]), allowed)
    given = {name: values.numbers(f"{GROUND}.{name}") for name in Ground.declared()}
    bed = Bed(**given)
    sunk = bed.sunk(lanes.width, lanes.depth, lanes.mass)
    soft = sunk >= MOST_SUNK * lanes.width
    at = int(np.argmax(soft))
    least = given["stiffness"][at] * sunk[at] / (MOST_SUNK * lanes.width[at])
    # A box that sinks by w at rest falls by itself where w > width^2 / (6 height).
    tips = sunk * 6.0 * lanes.height >= lanes.width**2
    which = int(np.argmax(tips))
    steady = given["stiffness"][which] * (6.0 * sunk * lanes.height / lanes.width**2)[which]
    values.refuse(
        tips,
        f"{GROUND}.stiffness",
        f"must be more than {steady:.3g} N/m^3, or the block falls by itself",
    )
    values.refuse(
        soft,
        f"{GROUND}.stiffness",
        f"must be more than {least:.3g} N/m^3: at rest the block would lie deeper than "
        f"{MOST_SUNK:g} of its width",
    )
    columns: dict[str, object] = {}
    for name, numbers in given.items():
        columns |= key_column(f"{GROUND}.{name}", numbers)
    lanes = dataclasses.replace(lanes, hold=Hold(bed=bed))
    return lanes, columns | computed("ground_depth", sunk)


def _frames(values: LaneValues, lanes: Lanes) -> tuple[Lanes, dict[str, object]]:
    """Frames of which the blocks are columns, and their columns of the table of inputs."""
    _refuse_beside(values, (WALL, TIE, LOAD, GROUND), "[frame], whose columns stand free")
    count, beam = values.numbers(f"{FRAME}.columns"), values.numbers(f"{FRAME}.beam_mass")
    values.refuse(count != np.round(count), f"{FRAME}.columns", "must be a whole number")
    frame = Frames(count, beam / (count * lanes.mass))
    lanes = dataclasses.replace(lanes, hold=Hold(frame=frame))
    if not lanes.restitution_given:
        found = frame.angular_restitution(lanes.slenderness_angle)
        lanes = dataclasses.replace(lanes, angular_restitution=found)
    columns: dict[str, object] = {
        **key_column(f"{FRAME}.columns", count),
        **key_column(f"{FRAME}.beam_mass", beam),
        **key_column("contact.angular_restitution", lanes.angular_restitution),
        **computed("frequency_parameter", lanes.frequency_parameter),
    }
    return lanes, columns


def _strips(values: LaneValues, lanes: Lanes) -> tuple[Lanes, dict[str, object]]:
    """Strips of wall, and their columns of the table of inputs."""
    others = (WALL, TIE, LOAD, FRAME, GROUND)
    _refuse_beside(values, others, "[strip], which base and floor alone hold")
    hinge, weight = values.numbers(f"{STRIP}.hinge_height"), values.numbers(f"{STRIP}.weight")
    columns: dict[str, object] = {
        **key_column(f"{STRIP}.hinge_height", hinge),
        **key_column(f"{STRIP}.weight", weight),
    }
    arm = np.stack([lanes.width] * 2, axis=1)
    if values.given(f"{STRIP}.eccentricity"):
        aside = values.numbers(f"{STRIP}.eccentricity")
        _refuse_beside_top(values, aside, f"{STRIP}.eccentricity", lanes)
        arm = np.stack([0.5 * lanes.width - aside, 0.5 * lanes.width + aside], axis=1)
        columns |= key_column(f"{STRIP}.eccentricity", aside)
    lower = hinge * lanes.height
    strip = Strips(lanes.width, lower, lanes.height - lower, lanes.mass, weight, arm)
    lanes = dataclasses.replace(lanes, hold=Hold(strip=strip))
    if not lanes.restitution_given:
        found = strip.angular_restitution
        at = int(np.argmax(found <= 0.0))
        allowed = (
            "must be higher, or contact.angular_restitution given: bodies as stout as these would "
            f"turn back where they come upright (ratio {found[at]:.3g})"
        )
        values.refuse(found <= 0.0, f"{STRIP}.hinge_height", allowed)
        lanes = dataclasses.replace(lanes, angular_restitution=found)
    angle = lanes.slenderness_angle
    if values.given("start.rotation_ratio"):
        start = angle * values.numbers("start.rotation_ratio")
        lanes = dataclasses.replace(lanes, rotation_start=start)
    beyond = np.abs(lanes.rotation_start) >= angle
    limit = np.rad2deg(angle[int(np.argmax(beyond))])
    allowed = f"must be less than the lean at which the strip is in balance, {limit:.6g} deg"
    values.refuse(beyond, "start.rotation", allowed)
    return lanes, columns | {
        **key_column("contact.angular_restitution", lanes.angular_restitution),
        **computed("slenderness_angle", angle),
        **computed("frequency_parameter", lanes.frequency_parameter),
        **key_column("start.rotation", lanes.rotation_start),
        **key_column("start.rotation_ratio", lanes.rotation_start / angle),
    }


def _refuse_beside(values: LaneValues, names: tuple[str, ...], table: str) -> None:
    """Refuses tables beside one that says why."""
    for name in names:
        if getattr(values.case.tables, name) is not None:
            allowed = f"must be left out beside {table}"
            raise InputError(values.case.source_of(name), name, Said("a table"), allowed)


def _refuse_beside_top(values: LaneValues, aside: Array, key: str, lanes: Lanes) -> None:
    """Refuses weights beside the top of their block."""
    beside = np.abs(aside) > 0.5 * lanes.width
    half = 0.5 * lanes.width[int(np.argmax(beside))]
    values.refuse(
        beside, key, f"must lie on the top of the block, at most {half:g} m from its middle"
    )


def _load(values: LaneValues, lanes: Lanes) -> tuple[Loads, dict[str, object]]:
    """Loads on top of blocks, and their columns."""
    names = ("weight", "eccentricity", "thrust")
    numbers = {name: values.numbers(f"{LOAD}.{name}") for name in names}
    _refuse_beside_top(values, numbers["eccentricity"], f"{LOAD}.eccentricity", lanes)
    points, codes = values.texts(f"{LOAD}.point")
    columns: dict[str, object] = {}
    for name, each in numbers.items():
        columns |= key_column(f"{LOAD}.{name}", each)
    columns |= {"load_point": values.column(f"{LOAD}.point")}
    return Loads(**numbers, stays=np.array([p == STAYS for p in points])[codes]), columns


def refuse_elsewhere(values: LaneValues, place: str) -> None:
    """Refuses what holds a block where blocks are not single boxes in the plane.

    Args:
        values: Values of the case.
        place: What the case has instead.

    Raises:
        InputError: The case holds its block.
    """
    for name in (WALL, TIE, LOAD, FRAME, STRIP, GROUND):
        if getattr(values.case.tables, name) is not None:
            allowed = f"must be left out: it holds a single box in the plane, and the case {place}"
            raise InputError(values.case.source_of(name), name, Said("a table"), allowed)
