"""The table [assembly]: many blocks with dry joints, laid by a pattern or drawn in a file."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, NamedTuple, Self

import pydantic

from warprock.case.contact import FRICTION
from warprock.case.validation import KeyedError, Table
from warprock.case.value_kinds import OtherKey
from warprock.errors import GIVEN, NOTHING
from warprock.quantity import Column, FrictionKey, NumberKey, TextKey
from warprock.units import Dimension, parse_quantity

ARCH, WALL, DRY_STONE, COLUMN, FRAME, FILE = "arch", "wall", "dry-stone", "column", "frame", "file"
"""Patterns in the plane; in space their blocks are as deep as `depth` says."""

CORNER, VAULT = "corner", "vault"
"""Patterns in space."""

SPATIAL_PATTERNS = (CORNER, VAULT)

WHOLE, HALF = "whole", "half"
"""What the lowest course of a wall begins with."""

MOST_ASSEMBLED = 20_000
"""Blocks of an assembly: one second of motion of 10,000 takes tens of minutes."""

MOST_OPENINGS = 20


class Keys(NamedTuple):
    """Keys that belong to a pattern alone.

    Attributes:
        needs: Those that must be given.
        may: Those that may be given, too.
    """

    needs: tuple[str, ...]
    may: tuple[str, ...] = ()


PATTERNS: dict[str, Keys] = {
    ARCH: Keys(("mean_radius", "thickness", "embrace", "voussoirs")),
    WALL: Keys(
        ("block_length", "block_height", "blocks", "courses"),
        ("first_course", "head_friction", "openings"),
    ),
    DRY_STONE: Keys(
        ("wall_length", "wall_height", "stone_length", "stone_height", "variation", "seed"),
        ("head_friction",),
    ),
    COLUMN: Keys(("drum_width", "drum_height", "drums")),
    FRAME: Keys(("column_width", "column_height", "columns", "span", "beam_height")),
    CORNER: Keys(
        ("block_length", "block_height", "blocks", "courses", "return_blocks"),
        ("returns", "head_friction", "openings"),
    ),
    VAULT: Keys(("mean_radius", "thickness", "embrace", "voussoirs", "blocks"), ("first_course",)),
    FILE: Keys(("file",), ("file_unit", "joint_tolerance", "fixed", "head_friction")),
}
"""Pattern -> its keys."""

_MUST = (
    "must be a list of rectangles [left, bottom, width, height], lengths from the lower left "
    'corner of the wall, such as [["1 m", "0.5 m", "0.8 m", "1 m"]]'
)


def _read_openings(got: Any) -> tuple[tuple[float, ...], ...]:
    """Rectangles of lengths [m]."""
    if not isinstance(got, list | tuple) or not 0 < len(got) <= MOST_OPENINGS:
        raise ValueError(f"{_MUST}, 1 to {MOST_OPENINGS} of them")
    found = []
    for each in got:
        if not isinstance(each, list | tuple) or len(each) != 4:
            raise ValueError(_MUST)
        rectangle = tuple(parse_quantity(length, Dimension.LENGTH) for length in each)
        if min(rectangle[:2]) < 0.0 or min(rectangle[2:]) <= 0.0:
            raise ValueError(f"{_MUST}, none below 0 m, width and height above")
        found.append(rectangle)
    return tuple(found)


BETWEEN = " / "
"""What stands between the two blocks of a joint."""

_JOINTS = f'must be a list of joints by their two blocks, such as ["1.1{BETWEEN}2.1"]'


def _read_joints(got: Any) -> tuple[tuple[str, str], ...]:
    """The names of the two blocks of each joint."""
    if not isinstance(got, list | tuple) or not got:
        raise ValueError(_JOINTS)
    found = []
    for each in got:
        parts = each.split(BETWEEN) if isinstance(each, str) else ()
        if len(parts) != 2:
            raise ValueError(_JOINTS)
        found.append((parts[0].strip(), parts[1].strip()))
    return tuple(found)


_NAMES = "must be a list of names of blocks, or of their layers"


def _read_fixed(got: Any) -> tuple[str, ...]:
    """Names of blocks."""
    if not isinstance(got, list | tuple) or not all(isinstance(each, str) for each in got):
        raise ValueError(f'{_NAMES}, such as ["ground", "abutment"]')
    return tuple(got)


def _length(text: str, column: str) -> NumberKey:
    return NumberKey(text, "1 mm to 1 km", swept=True, column=Column(column))


def _number(text: str, most: int, column: str) -> NumberKey:
    return NumberKey(text, f"1 to {most}", swept=True, column=Column(column))


class Assembly(Table):
    """Many blocks with dry joints on what is fixed to the base, by a pattern or from a file."""

    place: ClassVar[str] = "assembly"

    pattern: Annotated[str, TextKey("the pattern by which the blocks are laid", tuple(PATTERNS))]
    density: Annotated[
        float,
        NumberKey(
            "the density of the blocks",
            "1 kg/m^3 to 1e5 kg/m^3",
            swept=True,
            column=Column("assembly_density"),
        ),
    ]
    depth: Annotated[
        float,
        _length(
            "the depth of the blocks across the plane; in space the thickness of a wall and the "
            "length of a vault",
            "assembly_depth",
        ),
    ] = 1.0
    mean_radius: Annotated[
        float | None, _length("the radius of the middle line of the arch", "mean_radius")
    ] = None
    thickness: Annotated[
        float | None, _length("the thickness of the arch, along its radial joints", "thickness")
    ] = None
    embrace: Annotated[
        float | None,
        NumberKey(
            "the angle between the springings of the arch, seen from its centre",
            "1 deg to 180 deg",
            swept=True,
            column=Column("embrace", "deg"),
        ),
    ] = None
    voussoirs: Annotated[
        float | None, _number("the number of voussoirs", MOST_ASSEMBLED, "voussoirs")
    ] = None
    block_length: Annotated[
        float | None, _length("the length of a whole block of the wall", "block_length")
    ] = None
    block_height: Annotated[
        float | None, _length("the height of a course of the wall", "block_height")
    ] = None
    blocks: Annotated[
        float | None,
        _number(
            "the length of the wall, or of the vault, in blocks", MOST_ASSEMBLED, "wall_blocks"
        ),
    ] = None
    courses: Annotated[
        float | None, _number("the number of courses of the wall", MOST_ASSEMBLED, "courses")
    ] = None
    return_blocks: Annotated[
        float | None,
        _number(
            "the length in blocks of the walls across, the thickness of the wall included",
            MOST_ASSEMBLED,
            "return_blocks",
        ),
    ] = None
    returns: Annotated[
        float,
        _number("the number of walls across: 1 at the left end, or 2 at both", 2, "returns"),
    ] = 1.0
    first_course: Annotated[
        str,
        TextKey(
            "what the lowest course, of a vault that at its left springing, begins with, a whole "
            "block or half of one",
            (WHOLE, HALF),
        ),
    ] = WHOLE
    openings: Annotated[
        tuple[tuple[float, ...], ...],
        OtherKey(
            "the openings of the wall, [left, bottom, width, height] from its lower left corner",
            "list of rectangles",
            _read_openings,
            _MUST,
        ),
    ] = ()
    wall_length: Annotated[
        float | None, _length("the length of the wall of dry stone", "wall_length")
    ] = None
    wall_height: Annotated[float | None, _length("the height of that wall", "wall_height")] = None
    stone_length: Annotated[
        float | None, _length("the mean length of the stones of the wall", "stone_length")
    ] = None
    stone_height: Annotated[
        float | None, _length("the mean height of the courses of stone", "stone_height")
    ] = None
    variation: Annotated[
        float | None,
        NumberKey(
            "how much stones differ: 0 for a regular wall, 1 for lengths off by up to 60 %, "
            "heights by up to 50 %, head joints that lean by up to 12 deg, and beds that slope",
            "0 to 1",
            swept=True,
            column=Column("variation"),
        ),
    ] = None
    seed: Annotated[
        float | None,
        NumberKey(
            "a whole number from which stones are drawn: another number, another wall",
            "0 to 1e9",
            swept=True,
            column=Column("assembly_seed"),
        ),
    ] = None
    drum_width: Annotated[float | None, _length("the width of a drum", "drum_width")] = None
    drum_height: Annotated[float | None, _length("the height of a drum", "drum_height")] = None
    drums: Annotated[float | None, _number("the number of drums", MOST_ASSEMBLED, "drums")] = None
    column_width: Annotated[float | None, _length("the width of a column", "column_width")] = None
    column_height: Annotated[float | None, _length("the height of a column", "column_height")] = (
        None
    )
    columns: Annotated[
        float | None, _number("the number of columns below the beam", MOST_ASSEMBLED, "columns")
    ] = None
    span: Annotated[float | None, _length("the clear distance between columns", "span")] = None
    beam_height: Annotated[float | None, _length("the height of the beam", "beam_height")] = None
    file: Annotated[
        str | None,
        TextKey(
            "the path of a drawing: closed polylines (.dxf), blocks of COMPAS (.json) or faces in "
            "a plane (.obj)",
            most=4096,
            swept=True,
            column=Column("assembly_file", text="File of the drawing"),
        ),
    ] = None
    file_unit: Annotated[
        float | None,
        NumberKey(
            "the length of one unit of the drawing, which a .dxf may say itself",
            "1e-6 m to 1 km",
            swept=True,
            column=Column("file_unit"),
        ),
    ] = None
    joint_tolerance: Annotated[
        float,
        NumberKey(
            "the distance up to which edges of drawn blocks touch; a joint is at least ten times "
            "as long",
            "1e-6 mm to 1 m",
        ),
    ] = 1e-3
    fixed: Annotated[
        tuple[str, ...],
        OtherKey(
            "the drawn blocks that move with the base, by name or layer; supports of COMPAS do "
            "without",
            "list of names",
            _read_fixed,
            _NAMES,
        ),
    ] = ()
    head_friction: Annotated[
        float | None,
        FrictionKey(
            "the friction of joints that are nearer to upright than to level; without it "
            "contact.friction",
            FRICTION,
            swept=True,
            column=Column("head_friction"),
        ),
    ] = None

    weak_joints: Annotated[
        tuple[tuple[str, str], ...],
        OtherKey(
            "single joints with a friction of their own, by their two blocks as `explain` names "
            "them",
            "list of joints",
            _read_joints,
            _JOINTS,
        ),
    ] = ()
    weak_friction: Annotated[
        float | None,
        FrictionKey(
            "the friction of the weak joints",
            FRICTION,
            swept=True,
            column=Column("weak_friction"),
        ),
    ] = None

    joint_cohesion: Annotated[
        float | None,
        NumberKey(
            "the shear strength of bonded joints without load, until they break",
            "1 Pa to 1000 MPa",
            swept=True,
            column=Column("joint_cohesion"),
        ),
    ] = None
    joint_tensile_strength: Annotated[
        float | None,
        NumberKey(
            "the tensile strength of bonded joints, until they break",
            "1 Pa to 1000 MPa",
            swept=True,
            column=Column("joint_tensile_strength"),
        ),
    ] = None

    @pydantic.model_validator(mode="after")
    def _keys_of_the_pattern(self) -> Self:
        own = PATTERNS[self.pattern]
        for name in self.model_fields_set:
            others = [pattern for pattern, keys in PATTERNS.items() if name in sum(keys, ())]
            if others and self.pattern not in others:
                allowed = f"must be left out: it belongs to pattern {' or '.join(others)}"
                raise KeyedError(name, GIVEN, allowed)
        for name in own.needs:
            if getattr(self, name) is None:
                allowed = f"{self.declared()[name].allowed}, with pattern {self.pattern}"
                raise KeyedError(name, NOTHING, allowed)
        return self
