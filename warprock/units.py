"""Quantities with units: "8 mm", "0.35 g", "3 Hz", "10 deg" become SI and rad, and back.

A number without a unit is refused wherever a dimension needs one, so that nobody has to guess
whether 8 was meant in millimetres. Conversion multiplies in decimal and rounds once, so "8 mm"
is the double nearest to 0.008.
"""

from __future__ import annotations

import decimal
import difflib
import enum
import math
import re
import sys
from collections.abc import Iterable
from typing import NamedTuple

GRAVITY = 9.81
"""Standard acceleration of gravity [m/s^2], as the closed forms and the seed paper take it."""


class Dimension(enum.StrEnum):
    """What a quantity measures."""

    LENGTH = "length"
    TIME = "time"
    FREQUENCY = "frequency"
    ANGLE = "angle"
    ACCELERATION = "acceleration"
    VELOCITY = "velocity"
    DENSITY = "density"
    MASS = "mass"
    INERTIA = "moment of inertia"
    FORCE = "force"
    STRESS = "stress"
    STIFFNESS = "stiffness"
    BED_STIFFNESS = "stiffness a unit of area"
    BED_DAMPING = "damping a unit of area"
    AGE = "age"
    DIMENSIONLESS = "dimensionless"


class Quantity(NamedTuple):
    """A value and what it measures.

    Attributes:
        value: In the SI unit of the dimension, or rad; an age in years.
        dimension: What it measures.
    """

    value: float
    dimension: Dimension


# Per dimension: unit -> its size in the first unit of the table, which is the SI unit (or rad).
# Sizes are decimal text; pi/180 and 1/(2 pi) carry more digits than a double.
UNITS: dict[Dimension, dict[str, str]] = {
    Dimension.LENGTH: {
        "m": "1",
        "cm": "0.01",
        "mm": "0.001",
        "km": "1000",
        "in": "0.0254",
        "ft": "0.3048",
    },
    Dimension.TIME: {"s": "1", "ms": "0.001", "min": "60"},
    Dimension.FREQUENCY: {
        "Hz": "1",
        "kHz": "1000",
        "rad/s": "0.159154943091895335768883763373",
        "deg/s": "0.00277777777777777777777777777778",
    },
    Dimension.ANGLE: {"rad": "1", "mrad": "0.001", "deg": "0.0174532925199432957692369076849"},
    Dimension.ACCELERATION: {
        "m/s^2": "1",
        "cm/s^2": "0.01",
        "mm/s^2": "0.001",
        "g": str(GRAVITY),
        "gal": "0.01",
    },
    Dimension.VELOCITY: {"m/s": "1", "cm/s": "0.01", "mm/s": "0.001"},
    Dimension.DENSITY: {"kg/m^3": "1", "g/cm^3": "1000", "t/m^3": "1000"},
    Dimension.MASS: {"kg": "1", "t": "1000"},
    Dimension.INERTIA: {"kg m^2": "1", "t m^2": "1000"},
    Dimension.FORCE: {"N": "1", "kN": "1000", "MN": "1000000"},
    Dimension.STRESS: {"Pa": "1", "kPa": "1000", "MPa": "1000000", "N/mm^2": "1000000"},
    Dimension.STIFFNESS: {
        "N/m": "1",
        "kN/m": "1000",
        "N/mm": "1000",
        "kN/mm": "1000000",
        "MN/m": "1000000",
    },
    Dimension.BED_STIFFNESS: {"N/m^3": "1", "kN/m^3": "1000", "MN/m^3": "1000000"},
    Dimension.BED_DAMPING: {"N s/m^3": "1", "kN s/m^3": "1000", "MN s/m^3": "1000000"},
    Dimension.AGE: {"years": "1", "a": "1", "ka": "1000", "Ma": "1000000"},
    Dimension.DIMENSIONLESS: {"": "1"},
}

ALIASES: dict[str, str] = {
    "m/s2": "m/s^2",
    "m/s²": "m/s^2",
    "cm/s2": "cm/s^2",
    "cm/s²": "cm/s^2",
    "mm/s2": "mm/s^2",
    "mm/s²": "mm/s^2",
    "Gal": "gal",
    "°": "deg",
    "kg/m3": "kg/m^3",
    "kg/m³": "kg/m^3",
    "g/cm3": "g/cm^3",
    "g/cm³": "g/cm^3",
    "t/m3": "t/m^3",
    "kg m2": "kg m^2",
    "kg m²": "kg m^2",
    "kg*m^2": "kg m^2",
    "t/m³": "t/m^3",
    **{
        f"{unit}{time}/m{cube}": f"{unit}{' s' if time else ''}/m^3"
        for unit in ("N", "kN", "MN")
        for time in ("", " s", "s", "*s")
        for cube in ("3", "³", "^3")
        if (time, cube) not in (("", "^3"), (" s", "^3"))
    },
}
"""Other spellings of units that are understood."""

EXAMPLES: dict[Dimension, str] = {
    Dimension.LENGTH: "8 mm",
    Dimension.TIME: "60 s",
    Dimension.FREQUENCY: "3 Hz",
    Dimension.ANGLE: "10 deg",
    Dimension.ACCELERATION: "0.35 g",
    Dimension.VELOCITY: "25 cm/s",
    Dimension.DENSITY: "2670 kg/m^3",
    Dimension.MASS: "350 kg",
    Dimension.INERTIA: "18 kg m^2",
    Dimension.FORCE: "12 kN",
    Dimension.STRESS: "0.2 MPa",
    Dimension.STIFFNESS: "5 kN/mm",
    Dimension.BED_STIFFNESS: "50 MN/m^3",
    Dimension.BED_DAMPING: "200 kN s/m^3",
    Dimension.AGE: "10 ka",
    Dimension.DIMENSIONLESS: "1.0",
}

_ARTICLE = dict.fromkeys((Dimension.ANGLE, Dimension.ACCELERATION, Dimension.AGE), "an")

MOST_CHARACTERS = 1000
"""Characters of a quantity, blanks included."""

_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>[^\s\d.+-].*?)?\s*",
    re.ASCII,
)


def allowed_text(dimensions: Iterable[Dimension]) -> str:
    """What may be written for one of some dimensions, as the end of an error message."""
    parts = []
    for dimension in dimensions:
        if dimension is Dimension.DIMENSIONLESS:
            parts.append("a number without a unit")
            continue
        article, units = _ARTICLE.get(dimension, "a"), ", ".join(UNITS[dimension])
        example = EXAMPLES[dimension]
        parts.append(f'{article} {dimension} with a unit ({units}), such as "{example}"')
    return " or ".join(parts)


def parse_any(text: object, dimensions: Iterable[Dimension]) -> Quantity:
    """Reads a quantity that may have one of several dimensions.

    Args:
        text: Text such as "8 mm"; a bare number only where `DIMENSIONLESS` is allowed.
        dimensions: The dimensions allowed.

    Returns:
        The value in SI units or rad, and the dimension its unit belongs to.

    Raises:
        ValueError: No number, no unit, a unit of another dimension, or a value that is not
            finite; the message begins with "must be" and lists the units allowed.
    """
    wanted = tuple(dimensions)
    allowed = f"must be {allowed_text(wanted)}"
    if isinstance(text, (int, float)) and not isinstance(text, bool):
        # A whole number of TOML may be too large for a float, or even to be written out.
        if not abs(text) <= sys.float_info.max:
            raise ValueError(f"{allowed}, and finite")
        if Dimension.DIMENSIONLESS in wanted:
            return Quantity(float(text), Dimension.DIMENSIONLESS)
        number, unit = str(text), ""
    else:
        short = isinstance(text, str) and len(text) <= MOST_CHARACTERS
        match = _QUANTITY.fullmatch(str(text)) if short else None
        if match is None:
            raise ValueError(allowed)
        number, unit = match["number"], match["unit"] or ""
    unit = ALIASES.get(unit, unit)
    for dimension in wanted:
        size = UNITS[dimension].get(unit)
        if size is not None:
            value = float(_scale(number, size))
            if not math.isfinite(value):
                raise ValueError(f"{allowed}, and finite")
            return Quantity(value, dimension)
    known = [u for dimension in wanted for u in UNITS[dimension] if u]
    near = difflib.get_close_matches(unit, known, 1) or [
        u for u in known if u.casefold() == unit.casefold()
    ]
    raise ValueError(
        f'{allowed}; did you mean "{number} {near[0]}"?' if near and len(number) < 40 else allowed
    )


def bare_number(text: str) -> bool:
    """Whether text is a number without a unit."""
    match = _QUANTITY.fullmatch(text) if len(text) <= MOST_CHARACTERS else None
    return match is not None and match["unit"] is None


def _scale(number: str, size: str) -> decimal.Decimal | float:
    """Product of number and size, rounded once; nan and inf pass through."""
    try:
        return decimal.Decimal(number) * decimal.Decimal(size)
    except decimal.DecimalException:
        return math.nan


def parse_quantity(text: object, dimension: Dimension | str) -> float:
    """Reads a quantity of one dimension.

    Args:
        text: Text such as "8 mm"; a bare number only for `DIMENSIONLESS`.
        dimension: What it must measure.

    Returns:
        The value in the SI unit of the dimension, or rad.

    Raises:
        ValueError: As `parse_any`.
    """
    return parse_any(text, (Dimension(dimension),)).value


def format_quantity(value: float, dimension: Dimension | str, unit: str | None = None) -> str:
    """Writes a value with its unit, so that `parse_quantity` reads it again.

    Args:
        value: In the SI unit of the dimension, or rad.
        dimension: What it measures.
        unit: Unit to write it in; the SI unit (or rad) without one.

    Returns:
        Text such as "8 mm", with up to 12 significant digits.

    Raises:
        KeyError: The dimension has no such unit.
    """
    sizes = UNITS[Dimension(dimension)]
    unit = next(iter(sizes)) if unit is None else unit
    return f"{value / float(sizes[unit]):.12g} {unit}".rstrip()


def unit_written(text: str) -> str:
    """The unit that a quantity is written in; empty where it is no number with a known unit.

    >>> unit_written("0.8 g"), unit_written("2 m/s2"), unit_written("3"), unit_written("sine")
    ('g', 'm/s^2', '', '')
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= MOST_CHARACTERS else None
    unit = (match["unit"] or "").strip() if match else ""
    unit = ALIASES.get(unit, unit)
    return unit if any(unit in sizes for sizes in UNITS.values()) else ""


def relative_size(unit: str, other: str) -> float | None:
    """The size of a unit over that of another one; None where they measure different things.

    >>> round(relative_size("m/s^2", "g"), 6), relative_size("m", "g")
    (0.101972, None)
    """
    for sizes in UNITS.values():
        if unit in sizes and other in sizes:
            return float(sizes[unit]) / float(sizes[other])
    return None


ENDINGS = {
    "1/year": "_per_year",
    "years": "_years",
    "m/s^2": "_m_s2",
    "kg/m^3": "_kg_m3",
    "rad/s": "_rad_s",
    "deg/s": "_deg_s",
    "1/s": "_per_s",
    "N s/m^3": "_N_s_m3",
    "N/m^3": "_N_m3",
    "N/m": "_N_m",
    "m/s": "_m_s",
    "deg": "_deg",
    "rad": "_rad",
    "Pa": "_Pa",
    "mm": "_mm",
    "Hz": "_hz",
    "GB": "_gb",
    "kg": "_kg",
    "m": "_m",
    "s": "_s",
    "J": "_J",
    "N": "_N",
    "%": "_pct",
}
"""Unit -> end of the names of columns in it, longer ends before those that they end with."""


def ending(unit: str) -> str:
    """The end of the name of a column in a unit; empty without one.

    >>> ending("m/s^2"), ending("kg m^2"), ending("-")
    ('_m_s2', '_kg_m2', '')
    """
    if unit in ("", "-"):
        return ""
    plain = unit.lower().translate({ord("/"): "_", ord(" "): "_", ord("^"): None})
    return ENDINGS.get(unit, f"_{plain}")


def split_unit(column: str) -> tuple[str, str]:
    """The name of a column without its unit, and the unit; empty where its name ends in none.

    >>> split_unit("peak_time_s"), split_unit("outcome")
    (('peak_time', 's'), ('outcome', ''))
    """
    for unit, end in ENDINGS.items():
        if len(column) > len(end) and column.lower().endswith(end.lower()):
            return column[: -len(end)], unit
    return column, ""
