"""What a test of free rocking told of a block."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.identification import FREQUENCY, SLENDERNESS, Identified
from warprock.findings.digits import number_of, quantity_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.numbers import counted, three, with_error
from warprock.findings.plain import plain
from warprock.findings.sheets import declared, sheet_of

SWINGS = "swings"
"""Name of the table."""
DEGREE = np.pi / 180.0
FORMULA = "angular_restitution_by_formula"
FINE, NOTED = 1e-3, 1.5
"""A misfit of durations that nobody minds, and one over their errors that chance explains."""

COLUMNS = {
    "swing": ("", "Number of the swing, from the first impact on"),
    "side": ("", "Side to which the block leans"),
    "peak_time_s": ("s", "Time at which its lean is largest"),
    "peak_rotation_rad": ("rad", "Largest |rotation|"),
    "peak_rotation_error_rad": ("rad", "Standard error of the largest |rotation|"),
    "duration_s": ("s", "Time from impact to impact"),
    "duration_error_s": ("s", "Standard error of the time from impact to impact"),
    "duration_by_housner_s": ("s", "Time from impact to impact by Housner's equation"),
    "angular_restitution": ("-", "What the impact before it left of the angular velocity"),
}


def find_identify(found: Identified, source: str, column: str) -> Finding:
    """What a history of free rocking came to.

    Args:
        found: What it tells.
        source: Where it is from.
        column: The column of the rotation.
    """
    facts = {"identified": _facts(found), "history": source, "column": column}
    return tell_identify(plain(facts), {SWINGS: swing_table(found)})


def _facts(found: Identified) -> dict[str, Any]:
    rate = found.frequency_parameter
    return {
        "angular_restitution": found.restitution.value,
        "angular_restitution_error": found.restitution.error,
        "angular_restitution_spread": found.spread,
        FORMULA: found.formula,
        "one_sided": found.one_sided,
        "swings": found.swings.count,
        "fits": list(found.fits),
        "slenderness_angle_rad": found.slenderness_angle.value,
        "slenderness_angle_error_rad": found.slenderness_angle.error,
        "given_slenderness_angle_rad": found.given_slenderness,
        "frequency_parameter_rad_s": None if rate is None else rate.value,
        "frequency_parameter_error_rad_s": None if rate is None else rate.error,
        "given_frequency_parameter_rad_s": found.given_frequency,
        "duration_misfit": found.misfit,
        "duration_scatter": found.scatter,
        "noise_rad": found.swings.noise,
    }


def swing_table(found: Identified) -> pd.DataFrame:
    """The swings of a history, a row each."""
    swings, durations = found.swings, found.durations
    table = pd.DataFrame(
        {
            "swing": np.arange(1, swings.count + 1),
            "side": np.where(swings.side < 0.0, "left", "right"),
            "peak_time_s": swings.peak_time,
            "peak_rotation_rad": swings.peak,
            "peak_rotation_error_rad": swings.peak_error,
            "duration_s": swings.duration,
            "duration_error_s": swings.duration_error,
            "duration_by_housner_s": np.nan if durations is None else durations,
            "angular_restitution": np.concatenate([[np.nan], found.ratios]),
        }
    )
    return declared(table, COLUMNS)


def tell_identify(facts: Facts, tables: Tables) -> Finding:
    """What a history came to, of its facts and its swings."""
    found = facts["identified"]
    return Finding(
        kind="Identification",
        title=f"A block from its free rocking: {facts['history']}",
        facts=facts,
        tables=tables,
        sentences=[_restitution(found), _spread(found), *_fitted(found), _noise(found)],
        sheets=[sheet_of("Swings between impacts", tables[SWINGS], file=f"{SWINGS}.csv")],
        rows={"rows": SWINGS},
        pictures=["identification.png"],
    )


_NUMBER = (float, None)
IDENTIFIED = Kind(
    (SWINGS,),
    tell_identify,
    "identified",
    {
        "identified": {
            **dict.fromkeys(
                (
                    "angular_restitution",
                    "angular_restitution_error",
                    "angular_restitution_spread",
                    FORMULA,
                    "slenderness_angle_rad",
                    "slenderness_angle_error_rad",
                    "noise_rad",
                ),
                float,
            ),
            **dict.fromkeys(
                (
                    "given_slenderness_angle_rad",
                    "frequency_parameter_rad_s",
                    "frequency_parameter_error_rad_s",
                    "given_frequency_parameter_rad_s",
                    "duration_misfit",
                    "duration_scatter",
                ),
                _NUMBER,
            ),
            "one_sided": bool,
            "swings": int,
            "fits": [str],
        },
        "history": str,
        "column": str,
    },
)


def _restitution(found: Facts) -> str:
    """What the block keeps at an impact, beside what is computed."""
    value = with_error(found["angular_restitution"], found["angular_restitution_error"])
    impacts = counted(found["swings"] - 1, "impact")
    formula = value_of(found, FORMULA)
    if found["one_sided"]:
        return (
            f"The block leaves its wall with {value} of the angular velocity with which it came, "
            f"by {impacts}; the formula of three impacts gives {formula}."
        )
    return (
        f"The block keeps {value} of its angular velocity at an impact, by {impacts}; Housner's "
        f"formula gives {formula}."
    )


def _spread(found: Facts) -> str:
    """How much impacts differ from one another."""
    spread = found["angular_restitution_spread"]
    if spread < 0.1 * found["angular_restitution_error"]:
        return "Impacts differ by no more than the noise of their peaks."
    return f"From impact to impact it differs by {three(spread)} (standard deviation)."


def _fitted(found: Facts) -> list[str]:
    """What follows from how long swings last."""
    said = []
    if SLENDERNESS in found["fits"]:
        angle = [found[f"slenderness_angle{end}_rad"] / DEGREE for end in ("", "_error")]
        given = _given(found, "slenderness_angle_rad")
        said.append(f"The slenderness angle is {with_error(*angle)} deg by the swings{given}.")
    if FREQUENCY in found["fits"]:
        rate = [found[f"frequency_parameter{end}_rad_s"] for end in ("", "_error")]
        given = _given(found, "frequency_parameter_rad_s")
        said.append(f"The frequency parameter is {with_error(*rate)} rad/s by the swings{given}.")
    misfit, scatter = found["duration_misfit"], found["duration_scatter"]
    if misfit is not None and misfit > FINE and scatter > NOTED:
        said.append(
            f"With that, the swings last {number_of('duration_misfit', misfit)} times their time "
            "longer or shorter than by Housner's equation, more than noise explains; the errors "
            "above account for it."
        )
    return said


def _given(found: Facts, name: str) -> str:
    """What the user gave of a quantity; empty where nothing was given."""
    given = found[f"given_{name}"]
    return "" if given is None else f"; it was given as {quantity_of(f'given_{name}', given)}"


def _noise(found: Facts) -> str:
    noise = three(found["noise_rad"] / DEGREE)
    return f"± is a standard error; the noise of a sample is {noise} deg."
