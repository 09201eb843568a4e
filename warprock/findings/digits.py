"""How numbers of a column are said: its scale, digits and unit, declared once."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from warprock.findings.numbers import MISSING, three
from warprock.units import split_unit

if TYPE_CHECKING:
    import pandas as pd


class Shown(NamedTuple):
    """How the numbers of a column are said.

    Attributes:
        form: Digits, as Python formats them.
        size: The number that is said over that of the column.
        unit: The unit that is said, where it is not that of the column.
        grouped: Whether the number is rounded to its digits and then written out: 12,300.
    """

    form: str = ".3g"
    size: float = 1.0
    unit: str = ""
    grouped: bool = False


MEASURED = Shown()
"""What is measured or computed: three digits, no zeros behind them."""

ASKED = Shown("g")
"""What was asked for: as it was typed."""

ASKED_PERCENT, SHARE = Shown("g", 100.0, "%"), Shown(".3f")
MILLIMETRES, DEGREES = Shown(size=1e3, unit="mm"), Shown(size=180.0 / math.pi, unit="deg")
FACTOR = Shown(".4g")

DIGITS: Mapping[str, Shown] = {
    **dict.fromkeys(
        (
            *("lowest_factor", "highest_factor", "accuracy", "boundary_accuracy"),
            *("tolerance", "level", "error_met", "value", "within_years", "duration_s"),
            *("decided_after_s", "years", "margin"),
        ),
        ASKED,
    ),
    **dict.fromkeys(
        ("spread_size", "spread_friction", "spread_motion", "idle_share"), ASKED_PERCENT
    ),
    "chance": Shown(".2g", 100.0, "%"),
    **dict.fromkeys(("right_share", "compared_share", "limit_gap"), Shown(".1f", 100.0, "%")),
    **dict.fromkeys(
        (
            *("right", "over_observed", "rank_correlation", "predicted", "observed"),
            *("total", "first_order", "width_m"),
        ),
        SHARE,
    ),
    **dict.fromkeys(("overturning_factor", "standing_factor", "frequency_ratio"), FACTOR),
    **dict.fromkeys(("none_up_to", "all_from", "given_frequency_parameter_rad_s"), FACTOR),
    **dict.fromkeys(
        ("tolerance_m", "height_m", "median_difference_m", "median_error_m"), MILLIMETRES
    ),
    **dict.fromkeys(("median_difference_rad", "median_error_rad"), DEGREES),
    **dict.fromkeys(
        ("settled_deg", "duration_misfit", "p_value", "error_run_ratio", "odds"), Shown(".2g")
    ),
    **dict.fromkeys(("acceleration_ratio", "peak_rotation_ratio"), Shown(".4f")),
    "towards_deg": Shown(".4g"),
    "given_slenderness_angle_rad": DEGREES._replace(form=".4g"),
    "angular_restitution_by_formula": Shown(".4f"),
    "median_change": Shown("+.1f", 100.0, "%"),
    "brier_difference": Shown("+.3f"),
    "probability": Shown(".1f"),
    "input": Shown(".6g"),
    "cpu_s_per_simulated_s": Shown(".1e"),
    "error_bound": Shown(".0e"),
    "cost_ratio": Shown(".1f"),
    "return_period_years": Shown(grouped=True),
    "object_mass_kg": Shown(grouped=True),
}
"""Column -> how its numbers are said; what is not here is `MEASURED`."""


def number_of(column: str, value: float | None) -> str:
    """A number of a column, without its unit; a dash where there is none.

    >>> number_of("overturning_factor", 1.23456), number_of("chance", 0.0456)
    ('1.235', '4.6')
    """
    if value is None or math.isnan(value):
        return MISSING
    shown = DIGITS.get(column, MEASURED)
    text = format(shown.size * value, shown.form)
    return three(float(text)) if shown.grouped else text


def value_of(row: Mapping[str, Any] | pd.Series[Any], column: str) -> str:
    """The number that a row has in a column, or facts by its name, without its unit."""
    return number_of(column, row[column])


def quantity_of(column: str, value: float | None) -> str:
    """A number of a column with its unit.

    >>> quantity_of("chance", 0.0456), quantity_of("finest_step_s", 1e-4)
    ('4.6 %', '0.0001 s')
    """
    text = number_of(column, value)
    unit = DIGITS.get(column, MEASURED).unit or split_unit(column)[1]
    return text if text == MISSING or not unit else f"{text} {unit}"
