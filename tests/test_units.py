"""Quantities with units: conversion, refusal, and back."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from warprock.units import (
    ALIASES,
    EXAMPLES,
    GRAVITY,
    UNITS,
    Dimension,
    Quantity,
    format_quantity,
    parse_any,
    parse_quantity,
)

ALL_UNITS = [(dimension, unit) for dimension, units in UNITS.items() for unit in units]


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("8 mm", "length", 0.008),
        ("8mm", "length", 0.008),
        ("  .5   m ", "length", 0.5),
        ("1 ft", "length", 0.3048),
        ("-2e-3 km", "length", -2.0),
        ("0.35 g", "acceleration", 0.35 * 9.81),
        ("981 gal", "acceleration", 9.81),
        ("981 cm/s²", "acceleration", 9.81),
        ("9.81 m/s2", "acceleration", 9.81),
        ("3.3 Hz", "frequency", 3.3),
        ("25 cm/s", "velocity", 0.25),
        ("2.67 g/cm^3", "density", 2670.0),
        ("2670 kg/m3", "density", 2670.0),
        ("10 ms", "time", 0.01),
        ("2 min", "time", 120.0),
        ("0.7", "dimensionless", 0.7),
        (0.7, "dimensionless", 0.7),
        (1, "dimensionless", 1.0),
    ],
)
def test_decimal_units_are_exact(text, dimension, value):
    # Products of decimals rounded once: the same double as the literal, no tolerance.
    assert parse_quantity(text, dimension) == value


@pytest.mark.parametrize("degrees", [0.2, 5.0, 10.0, 45.0, 89.5, -30.0])
def test_degrees_and_radians_per_second(degrees):
    # One rounding here, two in the math module: 2 units in the last place.
    assert parse_quantity(f"{degrees} deg", "angle") == pytest.approx(
        math.radians(degrees), rel=4.5e-16
    )
    assert parse_quantity(f"{degrees} rad/s", "frequency") == pytest.approx(
        degrees / (2.0 * math.pi), rel=4.5e-16
    )


@pytest.mark.parametrize("dimension", [d for d in Dimension if d is not Dimension.DIMENSIONLESS])
@pytest.mark.parametrize("bare", [8, 8.0, "8", "8.5e1", True, None, "", "mm", "eight mm", [8]])
def test_a_bare_number_is_refused_with_the_units_allowed(dimension, bare):
    with pytest.raises(ValueError, match=r"^must be ") as caught:
        parse_quantity(bare, dimension)
    for unit in UNITS[dimension]:
        assert unit in str(caught.value)
    assert EXAMPLES[dimension] in str(caught.value)


@pytest.mark.parametrize("text", ["8 s", "8 kg/m^3", "8 parsec", "8 m m", "8 g"])
def test_a_unit_of_another_dimension_is_refused(text):
    with pytest.raises(ValueError, match="must be a length with a unit"):
        parse_quantity(text, "length")


@pytest.mark.parametrize("text", ["nan m", "inf m", "1e999 m", "1e99999999999999999999 m"])
def test_what_is_not_finite_is_refused(text):
    with pytest.raises(ValueError, match="must be a length"):
        parse_quantity(text, "length")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, "nan", "1e999"])
def test_a_bare_number_that_is_not_finite_is_refused(value):
    with pytest.raises(ValueError, match="must be a number"):
        parse_quantity(value, "dimensionless")


@pytest.mark.parametrize(
    ("text", "meant"), [("8 hz", "8 Hz"), ("8 HZ", "8 Hz"), ("2 khz", "2 kHz")]
)
def test_a_misspelt_unit_is_named(text, meant):
    with pytest.raises(ValueError, match=f'did you mean "{meant}"'):
        parse_quantity(text, "frequency")


def test_one_of_several_dimensions():
    kinds = (Dimension.LENGTH, Dimension.ACCELERATION)
    assert parse_any("8 mm", kinds) == Quantity(0.008, Dimension.LENGTH)
    assert parse_any("0.5 g", kinds) == Quantity(0.5 * GRAVITY, Dimension.ACCELERATION)
    with pytest.raises(ValueError, match=r"a length with a unit .* or an acceleration with a unit"):
        parse_any("3 Hz", kinds)


def test_every_alias_means_a_unit_and_no_unit_has_two_dimensions():
    names = [unit for _, unit in ALL_UNITS]
    assert len(set(names)) == len(names)
    assert set(ALIASES.values()) <= set(names)
    assert not set(ALIASES) & set(names)


@settings(max_examples=40)
@given(
    unit=st.sampled_from(ALL_UNITS),
    value=st.floats(min_value=-1e12, max_value=1e12, allow_subnormal=False),
)
def test_writing_and_reading_give_the_value_back(unit, value):
    dimension, name = unit
    text = format_quantity(value, dimension, name)
    # Written with 12 significant digits: half of the last one, and two roundings.
    assert parse_quantity(text, dimension) == pytest.approx(value, rel=5.1e-12, abs=1e-300)


@given(unit=st.sampled_from(ALL_UNITS), number=st.decimals(-1000, 1000, places=3))
def test_twice_the_number_is_twice_the_quantity(unit, number):
    dimension, name = unit
    once = parse_quantity(f"{number} {name}", dimension)
    assert parse_quantity(f"{2 * number} {name}", dimension) == 2.0 * once
