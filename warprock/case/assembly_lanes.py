"""Assemblies from the values of a case, lane by lane, and their input columns."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.assembly import (
    ARCH,
    BETWEEN,
    COLUMN,
    CORNER,
    DRY_STONE,
    FILE,
    FRAME,
    MOST_ASSEMBLED,
    PATTERNS,
    SPATIAL_PATTERNS,
    VAULT,
    WALL,
    WHOLE,
    Assembly,
)
from warprock.case.body_lanes import DIRECTION
from warprock.case.input_columns import computed, key_column
from warprock.case.space import spatial_because
from warprock.errors import NOTHING, InputError, Said, did_you_mean
from warprock.model import patterns
from warprock.model.assembly import SPACE, Assemblies, Piece, assemble
from warprock.model.assembly import Assembly as Laid
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.solids import assemble_solids
from warprock.quantity import NumberKey

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from warprock.case.case import Case
    from warprock.case.values import LaneValues
    from warprock.drawings.outline import Drawing

PLACE = Assembly.place
FRICTION = "contact.friction"
BONDS = ("joint_cohesion", "joint_tensile_strength")
"""Keys that make joints bonded, together."""
COUNTS = (
    *("voussoirs", "blocks", "courses", "drums", "columns", "seed"),
    *("return_blocks", "returns"),
)
"""Keys that hold whole numbers."""


def assembly_lanes(values: LaneValues, *, in_space: bool) -> Lanes:
    """Assemblies at rest, each in the box around its blocks.

    Args:
        values: Values of the case.
        in_space: Whether their blocks move in space.

    Raises:
        InputError: A key of a single block, numbers that are not whole, too many blocks, or blocks
            that overlap or rest on nothing.
    """
    table = values.case.tables.assembly
    assert table is not None
    _refuse_others(values, in_space=in_space)
    numbers = _numbers(values, table)
    _refuse_numbers(values, table, numbers)
    files, of_file = _files(values, table)
    stacked = np.stack([*numbers.values(), of_file], axis=1)
    distinct, lane = np.unique(stacked, axis=0, return_inverse=True)
    lane = lane.reshape(-1)
    kinds = []
    for place, row in enumerate(distinct):
        *own_numbers, number = row.tolist()
        own = dict(zip(numbers, own_numbers, strict=True))
        file = files[int(number)] if files else None
        try:
            make = _assemble_in_space if in_space else _assemble
            kinds.append(make(values.case, table, own, file))
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            # The blocks of one pattern overlap or float where an opening leaves them nothing.
            key = f"{PLACE}.openings" if table.openings else PLACE
            got: object = Said("blocks")
            if file is not None:
                key, got = f"{PLACE}.file", file
            at = values.lanes[int(np.argmax(lane == place))]
            allowed = f"must {error} (lane {at})"
            raise InputError(values.case.source_of(key), key, got, allowed) from None
    found = Assemblies(tuple(kinds), lane)
    size = np.array([kind.size for kind in kinds])[lane]
    mass = np.array([kind.mass[~kind.fixed].sum() for kind in kinds])[lane]
    depth = size[:, 1] if in_space else numbers["depth"]
    nothing = np.zeros(len(lane))
    box: dict[str, Any] = {
        "width": size[:, 0],
        "height": size[:, -1],
        "depth": depth,
        "density": mass / (size[:, 0] * size[:, -1] * depth),
        "friction": numbers[FRICTION],
        **dict.fromkeys(_AT_REST, nothing),
        "assembly": found,
    }
    if in_space:
        return SpatialLanes(**(box | dict.fromkeys(_AT_REST_IN_SPACE, nothing)))
    return Lanes(**box)


_AT_REST = ("chamfer", "offset", "rotation_start", "angular_restitution")
_AT_REST_IN_SPACE = (
    *("rotation_across_start", "yaw_start", "gap_start"),
    *("centre_offset_x", "centre_offset_y", "offset_across"),
)
"""What lanes say of single blocks, of which assemblies have nothing."""


def assembly_columns(values: LaneValues, lanes: Lanes) -> dict[str, object]:
    """Input columns of assemblies: keys that are given, and what follows from them."""
    table = values.case.tables.assembly
    assert table is not None
    assert lanes.assembly is not None
    columns: dict[str, object] = {}
    for name, numbers in _numbers(values, table).items():
        columns |= key_column(name if name == FRICTION else f"{PLACE}.{name}", numbers)
    columns |= {"pattern": values.column(f"{PLACE}.pattern")}
    if table.pattern == FILE:
        columns |= {"assembly_file": values.column(f"{PLACE}.file")}
    kinds, lane = lanes.assembly.kinds, lanes.assembly.lane
    columns |= computed("slenderness_angle", lanes.slenderness_angle)
    columns |= computed("frequency_parameter", lanes.frequency_parameter)
    columns |= computed("blocks", np.array([int((~kind.fixed).sum()) for kind in kinds])[lane])
    return columns | computed("joints", np.array([kind.joints.count for kind in kinds])[lane])


def _numbers(values: LaneValues, table: Assembly) -> dict[str, npt.NDArray[np.float64]]:
    """Numbers that make an assembly by their keys, shape [lane] each."""
    keys = PATTERNS[table.pattern]
    declared = Assembly.declared()
    swept = [
        name
        for name in ("density", "depth", *keys.needs, *keys.may, "weak_friction", *BONDS)
        if isinstance(key := declared[name], NumberKey) and key.swept
    ]
    names = [name for name in swept if values.given(f"{PLACE}.{name}")]
    found = {name: values.numbers(f"{PLACE}.{name}") for name in names}
    return found | {FRICTION: values.numbers(FRICTION)}


def _refuse_others(values: LaneValues, *, in_space: bool) -> None:
    """Refuses what only single blocks have, or assemblies in the plane."""
    case, tables = values.case, values.case.tables
    for key in () if in_space else ("motion.z", DIRECTION):
        if tables.constant(key) is not None:
            allowed = "must be left out: in the plane the base moves along x"
            raise InputError(case.source_of(key), key, Said("a value"), allowed)
    for key in tables.start.model_fields_set:
        allowed = "must be left out: an assembly starts at rest"
        raise InputError(case.source_of("start"), f"start.{key}", Said("a start"), allowed)
    if values.given("contact.angular_restitution"):
        key, allowed = "contact.angular_restitution", "must be left out: impacts are plastic"
        raise InputError(case.source_of(key), key, Said("a value"), f"{allowed} in an assembly")


def _refuse_numbers(
    values: LaneValues, table: Assembly, numbers: Mapping[str, npt.NDArray[np.float64]]
) -> None:
    """Refuses numbers that fit no assembly: counts that are not whole, sizes, too many blocks."""
    if "weak_friction" in numbers and not table.weak_joints:
        key = f"{PLACE}.weak_joints"
        allowed = f"{Assembly.declared()['weak_joints'].allowed}, with weak_friction"
        raise InputError(values.case.source_of(key), key, NOTHING, allowed)
    if (given := set(BONDS) & set(numbers)) and len(given) == 1:
        (key,) = set(BONDS) - given
        allowed = f"{Assembly.declared()[key].allowed}, with {given.pop()}"
        raise InputError(
            values.case.source_of(f"{PLACE}.{key}"), f"{PLACE}.{key}", NOTHING, allowed
        )
    for name in COUNTS:
        if name in numbers:
            broken = numbers[name] != np.round(numbers[name])
            values.refuse(broken, f"{PLACE}.{name}", "must be a whole number")
    if table.pattern in (ARCH, VAULT):
        thick = numbers["thickness"] >= 2.0 * numbers["mean_radius"]
        allowed = f"must be less than twice {PLACE}.mean_radius"
        values.refuse(thick, f"{PLACE}.thickness", allowed)
    if table.pattern in (WALL, CORNER, VAULT):
        rows = "voussoirs" if table.pattern == VAULT else "courses"
        across = numbers.get("return_blocks", 0.0) * numbers.get("returns", 1.0)
        blocks = (numbers["blocks"] + across + 0.5) * numbers[rows]
        allowed = f"must make at most {MOST_ASSEMBLED:,} blocks"
        values.refuse(blocks > MOST_ASSEMBLED, f"{PLACE}.{rows}", allowed)
    if table.pattern == CORNER:
        thick = numbers["depth"] >= numbers["block_length"]
        allowed = f"must be less than {PLACE}.block_length, so that walls are bonded"
        values.refuse(thick, f"{PLACE}.depth", allowed)
    if table.pattern in (WALL, CORNER):
        _refuse_openings(values, table, numbers)
    if table.pattern == DRY_STONE:
        for size in ("length", "height"):
            small = numbers[f"wall_{size}"] < numbers[f"stone_{size}"]
            values.refuse(small, f"{PLACE}.stone_{size}", f"must be at most {PLACE}.wall_{size}")
        area = numbers["wall_length"] * numbers["wall_height"]
        stones = area / (numbers["stone_length"] * numbers["stone_height"])
        allowed = f"must make at most some {MOST_STONES:,} stones"
        values.refuse(stones > MOST_STONES, f"{PLACE}.stone_length", allowed)


MOST_STONES = MOST_ASSEMBLED * 9 // 10
"""Mean number of stones of a wall of dry stone, of which few have a tenth more."""


def _refuse_openings(
    values: LaneValues, table: Assembly, numbers: Mapping[str, npt.NDArray[np.float64]]
) -> None:
    """Refuses openings beside the wall, or that begin or end within a course."""
    key = f"{PLACE}.openings"
    length = numbers["blocks"] * numbers["block_length"]
    high = numbers["block_height"]
    for left, bottom, width, height in table.openings:
        for level in (bottom, bottom + height):
            parts = level / high
            between = np.abs(parts - np.round(parts)) > WITHIN_A_COURSE
            beyond = np.round(parts) > numbers["courses"]
            bad = between | beyond | (left + width > length * (1.0 + WITHIN_A_COURSE))
            if bad.any():
                at = int(np.argmax(bad))
                said = Said(f"an opening from {bottom:g} m to {bottom + height:g} m")
                allowed = (
                    f"must lie in the wall, {length[at]:g} m long, and begin and end with courses "
                    f"of {high[at]:g} m (lane {values.lanes[at]})"
                )
                raise InputError(values.case.source_of(key), key, said, allowed)


WITHIN_A_COURSE = 1e-6
"""How far an opening may be from the edge of a course, over its height: round-off of lengths."""


def _assemble(case: Case, table: Assembly, own: Mapping[str, Any], file: str | None) -> Laid:
    """The assembly of some numbers, or of a file."""
    found = assemble(
        _pieces(table, own) if file is None else _drawn(case, table, own, file),
        depth=own["depth"],
        density=own["density"],
        friction=own[FRICTION],
        head_friction=own.get("head_friction"),
        cohesion=own.get("joint_cohesion", 0.0),
        tension=own.get("joint_tensile_strength", 0.0),
        tolerance=None if file is None else table.joint_tolerance,
    )
    return _weakened(case, table, own, found) if table.weak_joints else found


def _assemble_in_space(
    case: Case, table: Assembly, own: Mapping[str, Any], file: str | None
) -> Laid:
    """The assembly in space of some numbers, or of a file."""
    if table.pattern in SPATIAL_PATTERNS:
        pieces = _pieces(table, own)
    else:
        if file is None:
            pieces = _pieces(table, own)
        else:
            pieces = _drawn(case, table, own, file, in_space=True)
        if pieces[0].corners.shape[1] < SPACE:
            pieces = patterns.extruded(pieces, own["depth"])
    found = assemble_solids(
        pieces,
        density=own["density"],
        friction=own[FRICTION],
        head_friction=own.get("head_friction"),
        tolerance=None if file is None else table.joint_tolerance,
        cohesion=own.get("joint_cohesion", 0.0),
        tension=own.get("joint_tensile_strength", 0.0),
    )
    return _weakened(case, table, own, found) if table.weak_joints else found


def _weakened(case: Case, table: Assembly, own: Mapping[str, Any], found: Laid) -> Laid:
    """An assembly in which some joints have a friction of their own.

    Raises:
        InputError: A block of that name is not there, or the two do not touch.
    """
    place = {name: number for number, name in enumerate(found.names)}
    key, friction = f"{PLACE}.weak_joints", found.joints.friction.copy()
    for pair in table.weak_joints:
        got = BETWEEN.join(pair)
        for name in pair:
            if name not in place:
                allowed = f"must be joints by their two blocks{did_you_mean(name, found.names)}"
                raise InputError(case.source_of(key), key, got, allowed)
        meant = sorted(place[name] for name in pair)
        chosen = (np.sort(found.joints.blocks, axis=1) == meant).all(axis=1)
        if not chosen.any():
            allowed = "must be joints: these two blocks do not touch"
            raise InputError(case.source_of(key), key, got, allowed)
        if "weak_friction" not in own:
            name = f"{PLACE}.weak_friction"
            allowed = f"{Assembly.declared()['weak_friction'].allowed}, with weak_joints"
            raise InputError(case.source_of(name), name, NOTHING, allowed)
        friction[chosen] = own["weak_friction"]
    return dataclasses.replace(found, joints=dataclasses.replace(found.joints, friction=friction))


def _files(values: LaneValues, table: Assembly) -> tuple[tuple[str, ...], npt.NDArray[np.float64]]:
    """The files of drawings, none for patterns, and the place of each lane's, shape [lane]."""
    if table.pattern != FILE:
        return (), np.zeros(len(values.lanes))
    files, codes = values.texts(f"{PLACE}.file")
    return files, codes.astype(np.float64)


def case_drawings(case: Case) -> dict[str, Drawing]:
    """The drawings that a case's assemblies are from, by file as the case names it.

    Raises:
        InputError: A file that cannot be used.
    """
    from warprock.case.values import LaneValues

    table = case.tables.assembly
    if table is None or table.pattern != FILE:
        return {}
    values = LaneValues(case, range(1))
    in_space, files = bool(spatial_because(values)), values.texts(FILE_KEY)[0]
    return {file: _drawing(case, file, in_space=in_space) for file in files}


FILE_KEY = f"{PLACE}.file"


def _drawing(case: Case, file: str, *, in_space: bool) -> Drawing:
    """A drawing of the case."""
    from warprock.drawings.loading import load_drawing

    try:
        return load_drawing(file, case.folder, in_space=in_space)
    except InputError as error:
        if error.key != "file":
            raise
        source = case.source_of(FILE_KEY)
        raise InputError(source, FILE_KEY, file, error.allowed) from None


def _drawn(
    case: Case, table: Assembly, own: Mapping[str, float], file: str, *, in_space: bool = False
) -> list[Piece]:
    """The blocks of a drawing.

    Raises:
        InputError: It says no unit, or not what is fixed.
    """
    drawing = _drawing(case, file, in_space=in_space)
    outlines = drawing.blocks
    unit = own.get("file_unit", drawing.unit)
    if unit is None:
        key, declared = f"{PLACE}.file_unit", Assembly.declared()["file_unit"]
        allowed = f"{declared.allowed}; {file} has none of its own"
        raise InputError(case.source_of(key), key, NOTHING, allowed)
    known = {each.name for each in outlines} | {each.group for each in outlines if each.group}
    key = f"{PLACE}.fixed"
    for name in table.fixed:
        if name not in known:
            allowed = f"must be a block or a layer of {file}{did_you_mean(name, sorted(known))}"
            raise InputError(case.source_of(key), key, name, allowed)
    found = [
        Piece(
            each.name,
            unit * each.corners,
            each.fixed or not {each.name, each.group}.isdisjoint(table.fixed),
        )
        for each in outlines
    ]
    if not any(piece.fixed for piece in found) or all(piece.fixed for piece in found):
        several = ", ".join(sorted(known)[:8]) + ", ..." * (len(known) > 8)
        allowed = f"must name blocks or layers that do not move, and not all ({several})"
        raise InputError(case.source_of(key), key, list(table.fixed) or NOTHING, allowed)
    return found


def _pieces(table: Assembly, own: Mapping[str, float]) -> list[Piece]:
    """The blocks of a pattern."""
    numbers: dict[str, Any] = {
        name: round(own[name]) if name in COUNTS else own[name]
        for name in PATTERNS[table.pattern].needs
    }
    openings = [patterns.Opening(*each) for each in table.openings]
    whole = table.first_course == WHOLE
    if table.pattern == WALL:
        return patterns.wall(**numbers, whole_first=whole, openings=openings)
    if table.pattern == CORNER:
        returns = round(own.get("returns", table.returns))
        return patterns.corner(**numbers, depth=own["depth"], returns=returns, openings=openings)
    if table.pattern == VAULT:
        return patterns.vault(**numbers, depth=own["depth"], whole_first=whole)
    laid: dict[str, Callable[..., list[Piece]]] = {
        ARCH: patterns.arch,
        DRY_STONE: patterns.dry_stone,
        COLUMN: patterns.column,
        FRAME: patterns.frame,
    }
    return laid[table.pattern](**numbers)
