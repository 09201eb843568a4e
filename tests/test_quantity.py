"""Kinds of values that a key may hold: how they are read, and what is said where they cannot be."""

from __future__ import annotations

import math
from typing import Annotated

import pydantic
import pytest

from warprock.quantity import AMPLITUDE, Column, FrictionKey, NumberKey, TextKey
from warprock.units import Dimension, Quantity

WIDTH = NumberKey("the width", "1 mm to 1 km", column=Column("width", "mm"))
FRICTION = FrictionKey("the friction", "0 to 100 or 0 deg to 89 deg", column=Column("friction"))
RATIO = NumberKey("the ratio", "-1 to 1", low_open=True, high_open=True)


def test_bounds_are_read_from_their_text():
    assert WIDTH.bounds == {Dimension.LENGTH: ("1 mm", "1 km")}
    assert FRICTION.bounds[Dimension.ANGLE] == ("0 deg", "89 deg")
    assert list(AMPLITUDE.bounds) == [Dimension.LENGTH, Dimension.VELOCITY, Dimension.ACCELERATION]
    assert WIDTH.bounds_text == "1 mm to 1 km"
    assert RATIO.bounds_text == "more than -1 and less than 1"
    assert (WIDTH.unit, FRICTION.unit) == ("length", "number or angle")


def test_a_number_is_read_in_si_units():
    assert WIDTH.value("8 mm") == 0.008
    assert AMPLITUDE.value("0.35 g") == Quantity(0.35 * 9.81, Dimension.ACCELERATION)
    assert FRICTION.value("45 deg") == pytest.approx(1.0, rel=1e-15)
    assert FRICTION.value(0.7) == 0.7


@pytest.mark.parametrize(
    ("key", "got", "words"),
    [
        (WIDTH, "0.9 mm", "must be at least 1 mm and at most 1 km: the width"),
        (WIDTH, "2 km", "must be at least 1 mm and at most 1 km: the width"),
        (WIDTH, 3, "must be a length with a unit"),
        (RATIO, 1, "must be more than -1 and less than 1: the ratio"),
        (FRICTION, "89.1 deg", "must be at least 0 deg and at most 89 deg: the friction"),
        (FRICTION, 101, "must be at least 0 and at most 100: the friction"),
        (FRICTION, math.nan, "must be a number without a unit or an angle"),
    ],
)
def test_a_number_out_of_bounds_is_refused_with_them(key: NumberKey, got: object, words: str):
    with pytest.raises(ValueError, match=f"^{words}"):
        key.value(got)


def test_a_column_bears_its_unit_and_the_meaning_of_its_key():
    (column,) = WIDTH.columns
    assert column == Column("width", "mm", "Width")
    assert column.named() == "width_mm"
    assert column.named("_2") == "width_2_mm"
    assert FRICTION.columns == (Column("friction", "-", "Friction"),)
    assert [c.named() for c in AMPLITUDE.columns] == [
        "amplitude_mm",
        "amplitude_m_s",
        "amplitude_m_s2",
    ]
    assert RATIO.columns == ()


def test_pydantic_reads_a_field_by_the_key_in_its_annotation():
    class Box(pydantic.BaseModel):
        width: Annotated[float, WIDTH]
        name: Annotated[str | None, TextKey("a name", ("a", "b"))] = None

    assert Box.model_validate({"width": "1 cm"}).width == 0.01
    with pytest.raises(
        pydantic.ValidationError, match=r"must be at least 1 mm and at most 1 km: the width"
    ):
        Box.model_validate({"width": "0 m"})
    with pytest.raises(pydantic.ValidationError, match=r"must be a name: a, b"):
        Box.model_validate({"width": "1 m", "name": "c"})
