"""How numbers of a column are said: its scale, digits, unit and short heading, declared once."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from warprock.findings.numbers import MISSING, three
from warprock.findings.sheets import heading
from warprock.units import split_unit

if TYPE_CHECKING:
    import pandas as pd


class Shown(NamedTuple):
    """How the numbers of a column are said.

    Attributes:
        form: Digits, as Python formats them; empty writes the number as `three` does.
        size: The number that is said over that of the column.
        unit: The unit that is said, where it is not that of the column.
        grouped: Whether the number is rounded to its digits and then written out: 12,300.
        short: Heading of the column on the terminal, in short lines; empty takes its name.
    """

    form: str = ".3g"
    size: float = 1.0
    unit: str = ""
    grouped: bool = False
    short: str = ""


MEASURED = Shown()
"""What is measured or computed: three digits, no zeros behind them."""

ASKED = Shown("g")
"""What was asked for: as it was typed."""

ASKED_PERCENT, SHARE = Shown("g", 100.0, "%"), Shown(".3f")
OFF = Shown(".1e")
"""A difference of two runs, of any size."""
OFF_ANGLE = OFF._replace(size=180.0 / math.pi, unit="deg")
LENGTH, ANGLE = Shown("", 1e3, "mm"), Shown("", 180.0 / math.pi, "deg")
MILLIMETRES, DEGREES = Shown(size=1e3, unit="mm"), Shown(size=180.0 / math.pi, unit="deg")
FACTOR = Shown(".4g")

DIGITS: Mapping[str, Shown] = {
    **dict.fromkeys(
        (
            *("lowest_factor", "highest_factor", "accuracy", "boundary_accuracy"),
            *("tolerance", "level", "error_met", "value", "within_years", "duration_s"),
            *("decided_after_s", "years", "margin", "interval_s"),
        ),
        ASKED,
    ),
    **dict.fromkeys(
        ("spread_size", "spread_friction", "spread_motion", "idle_share", "damping"), ASKED_PERCENT
    ),
    "chance": Shown(".2g", 100.0, "%"),
    **dict.fromkeys(("right_share", "compared_share", "limit_gap"), Shown(".1f", 100.0, "%")),
    **dict.fromkeys(
        (
            *("right", "over_observed", "rank_correlation", "predicted", "observed"),
            *("total", "first_order", "width_m", "statistic"),
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
    "towards_deg": Shown(".4g"),
    "acceleration_ratio": Shown(".4f"),
    "peak_rotation_ratio": Shown(".4f", short="peak\nratio"),
    "given_slenderness_angle_rad": DEGREES._replace(form=".4g"),
    "angular_restitution_by_formula": Shown(".4f"),
    "median_change": Shown("+.1f", 100.0, "%"),
    "brier_difference": Shown("+.3f"),
    "probability": Shown(".1f"),
    "input": Shown(".6g"),
    "cpu_s_per_simulated_s": Shown(".1e", short="CPU s for 1 s\nof one block"),
    "cpu_s": Shown(".2g", short="CPU\n[s]"),
    "steps_per_s": Shown(".0f", short="steps\n[1/s]"),
    "time_step_s": Shown(".1e", short="step\n[s]"),
    **dict.fromkeys(("overturned", "overturned_low", "overturned_high"), Shown(".1f", 100.0, "%")),
    "clearance_m": LENGTH,
    "peak_slide_m": LENGTH._replace(short="slide\n[mm]"),
    "peak_displacement_m": LENGTH._replace(short="moved\n[mm]"),
    "peak_rotation_rad": ANGLE._replace(short="peak\n[deg]"),
    "peak_rotation_across_rad": ANGLE._replace(short="across\n[deg]"),
    "peak_yaw_rad": ANGLE._replace(short="yaw\n[deg]"),
    "rotation_error_rad": OFF_ANGLE._replace(short="error\n[deg]"),
    "peak_tie_force_N": Shown("", 1e-3, "kN", short="tie\n[kN]"),
    "collapse_time_s": Shown("", short="fell at\n[s]"),
    "rest_time_s": Shown("", short="at rest\nat [s]"),
    "peak_time_s": Shown("", short="peak at\n[s]"),
    "impact_count": Shown(",.0f", short="impacts"),
    "opened_joints": Shown(",.0f", short="joints\nopened"),
    "slid_joints": Shown(",.0f", short="joints\nslid"),
    "broken_joints": Shown(",.0f", short="joints\nbroken"),
    "broken_ties": Shown(",.0f", short="ties\nbroken"),
    "collapse_load_g": FACTOR,
    **dict.fromkeys(
        ("error_5s_ratio", "difference_5s_ratio"), OFF._replace(short="diff.*\nfirst 5 s")
    ),
    **dict.fromkeys(
        ("error_run_ratio", "difference_run_ratio"), OFF._replace(short="diff.*\nwhole run")
    ),
    "difference_across_5s_ratio": OFF._replace(short="across*\nfirst 5 s"),
    "difference_yaw_5s_rad": OFF_ANGLE._replace(short="yaw**\n[deg]"),
    "difference_deg": Shown(".2g", short="diff.*\n[deg]"),
    "peak_error": Shown("+.2f", 100.0, "%", short="peak\nerror"),
    "rest_time_error_s": Shown("+.3f", short="rest time\nerror [s]"),
    "peak_slide_mm": Shown(".2g", short="slide\n[mm]"),
    "peak_tilt_ratio": Shown(".4f", short="peak\ntilt"),
    "fell_at_s": Shown(short="fell at\n[s]"),
    "moved_mm": Shown(short="moved\n[mm]"),
    "friction_needed": Shown(short="friction\nneeded"),
    "position_error_mm": Shown(".1f", short="position\n[mm]"),
    "rotation_error_deg": Shown(".1f", short="rotation\n[deg]"),
    "position_error_at_end_mm": Shown(".1f", short="position at\nthe end [mm]"),
    "rotation_error_at_end_deg": Shown(".1f", short="rotation at\nthe end [deg]"),
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
    >>> number_of("error_5s_ratio", 0.0123), number_of("error_5s_ratio", 4.88e-7)
    ('0.012', '4.9e-7')
    """
    if value is None or math.isnan(value):
        return MISSING
    shown = DIGITS.get(column, MEASURED)
    if not shown.form:
        return three(shown.size * value)
    text = format(shown.size * value, shown.form)
    return three(float(text)) if shown.grouped else _plain_power(text)


def _plain_power(text: str) -> str:
    """A number with the power of ten that Python gives it as `three` writes that, or without it."""
    mantissa, _e, power = text.partition("e")
    if not power:
        return text
    if -3 <= int(power) <= 3:
        digits = len(mantissa.partition(".")[2])
        return f"{float(text):.{max(0, digits - int(power))}f}"
    return f"{mantissa}e{int(power)}"


def cell_of(column: str, value: float | None) -> str:
    """A number of a column in a cell: its unit is in the heading, but a share has its %.

    >>> cell_of("peak_slide_mm", 1.234), cell_of("overturned", 0.25), cell_of("overturned", None)
    ('1.2', '25.0%', '-')
    """
    text = number_of(column, value)
    share = DIGITS.get(column, MEASURED).unit == "%" and text != MISSING
    return f"{text}%" if share else text


def short_heading(column: str) -> str:
    r"""The heading of a column on the terminal, in short lines.

    >>> short_heading("peak_slide_mm"), short_heading("impact_count")
    ('slide\n[mm]', 'impact count')
    """
    return DIGITS.get(column, MEASURED).short or heading(column).label


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
