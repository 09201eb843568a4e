"""What a verdict came to: whether a block stands, and by how much."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from warprock.analysis.verdict import Verdict
from warprock.findings.digits import number_of, quantity_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.intensities import measure
from warprock.findings.numbers import counted, three
from warprock.findings.sheets import Heading, Sheet, sheet_of
from warprock.model.ratios import NO_TURN
from warprock.model.response import FALLEN_NAMES, USABLE_NAMES
from warprock.running.provenance import case_facts, surroundings
from warprock.running.run_file import CASE, ENGINE

LADDER = "verdict-factors"
NEIGHBOURS = "verdict-neighbours"
WIDTHS = "verdict-widths"

_NUMBER = (float, None)


def find_verdict(found: Verdict) -> Finding:
    """What a verdict came to."""
    case = found.run.case
    content = found.ladder.plan.content
    kept = ("engine", "precision", "device", "estimate", "tolerance")
    facts = {
        "case": case_facts(case),
        "verdict": _facts(found),
        **{name: content[name] for name in kept},
        **surroundings(case),
    }
    curves = found.ladder.curves.drop(columns="lane").sort_values("factor", ignore_index=True)
    tables = {LADDER: curves, NEIGHBOURS: found.neighbours}
    if found.widths is not None:
        tables[WIDTHS] = found.widths.table.reset_index(drop=True)
    return tell_verdict(facts, tables)


def _facts(found: Verdict) -> dict[str, Any]:
    """The answers, as numbers."""
    lane, capacity = found.lane, found.capacity
    fell, usable, (low, high) = found.fallen
    answers: dict[str, Any] = {
        "outcome": str(lane["outcome"]),
        "status": str(lane["status"]),
        "undecided": bool(lane.get("undecided", False)),
        "peak_rotation_ratio": float(lane["peak_rotation_ratio"]),
        "peak_rotation_ratio_error": _ratio_error(lane),
        "peak_slide_m": _number(lane.get("peak_slide_m")),
        "peak_slide_error_m": _number(lane.get("peak_slide_error_m")),
        "peak_acceleration_m_s2": _number(lane.get("peak_acceleration_m_s2")),
        "peak_velocity_m_s": _number(lane.get("peak_velocity_m_s")),
        "lowest_factor": float(found.ladder.curves["factor"].min()),
        "highest_factor": float(found.ladder.curves["factor"].max()),
        "standing_factor": float(capacity["standing_factor"]),
        "overturning_factor": float(capacity["overturning_factor"]),
        "resurrections": int(capacity["resurrections"]),
        "unusable": int(capacity["unusable"]),
        "neighbours": len(found.neighbours),
        "neighbours_usable": usable,
        "neighbours_fallen": fell,
        "fallen_low": low,
        "fallen_high": high,
        "spread_size": found.spread.size if found.widths is not None else 0.0,
        "spread_friction": found.spread.friction,
        "spread_motion": found.spread.motion,
        "margin": found.margin,
        "slides": found.slides,
    }
    if found.widths is not None:
        widths = found.widths
        answers |= {"width_m": widths.own, "width_low_m": widths.low, "width_high_m": widths.high}
    return {name: None if _is_no_number(each) else each for name, each in answers.items()}


def _is_no_number(value: Any) -> bool:
    return isinstance(value, float) and not math.isfinite(value)


def _number(value: Any) -> float | None:
    return None if value is None or not np.isfinite(value) else float(value)


def _ratio_error(lane: Any) -> float | None:
    """Estimated error of the peak rotation over the slenderness angle."""
    error, angle = lane.get("peak_rotation_error_rad"), lane.get("slenderness_angle_rad")
    known = error is not None and angle is not None and np.isfinite(error)
    return float(error / angle) if known else None


def tell_verdict(facts: Facts, tables: Tables) -> Finding:
    """What a verdict came to, of its facts and tables."""
    answers = facts["verdict"]
    sentences = [_stands(answers), _falls_from(answers), _neighbours(answers)]
    sentences += _slides(answers) + _width(answers) + _unsure(answers)
    return Finding(
        kind="Verdict",
        facts=facts,
        tables=tables,
        sentences=sentences,
        sheets=[
            _answers_sheet(answers),
            sheet_of("Factors on the motion", tables[LADDER], file=f"{LADDER}.csv", folded=True),
            *(
                [sheet_of("Widths", tables[WIDTHS], file=f"{WIDTHS}.csv", folded=True)]
                if WIDTHS in tables
                else []
            ),
        ],
        rows={"factors": LADDER},
        said={"verdict": answers, "engine": facts["engine"]["name"]},
        asked=[
            (
                "Neighbours",
                f"{answers['neighbours']:,}: width and height -+{_spread(answers, 'size')}"
                f", friction -+{_spread(answers, 'friction')}, strength of the motion "
                f"-+{_spread(answers, 'motion')}, each even over its range",
            ),
            ("Margin", f"{value_of(answers, 'margin')} times the motion"),
        ],
        pictures=["verdict*.png"],
    )


VERDICT = Kind(
    (LADDER, NEIGHBOURS),
    tell_verdict,
    "verdict",
    {
        "case": CASE,
        "engine": ENGINE,
        "verdict": {
            **dict.fromkeys(("outcome", "status"), str),
            **dict.fromkeys(("neighbours", "neighbours_usable", "neighbours_fallen"), int),
            **dict.fromkeys(("resurrections", "unusable"), int),
            **dict.fromkeys(("peak_rotation_ratio", "peak_slide_m", "standing_factor"), _NUMBER),
            **dict.fromkeys(("overturning_factor", "highest_factor", "lowest_factor"), _NUMBER),
            **dict.fromkeys(("fallen_low", "fallen_high", "margin"), float),
            **dict.fromkeys(("spread_size", "spread_friction", "spread_motion"), float),
            **dict.fromkeys(("undecided", "slides"), bool),
            "width_m?": float,
            "width_low_m?": _NUMBER,
            "width_high_m?": _NUMBER,
        },
    },
)


def fell(answers: Facts) -> bool:
    """Whether the block fell under the motion as it is."""
    return answers["outcome"] in FALLEN_NAMES


def _stands(answers: Facts) -> str:
    """Whether it stands, and how far it rocked."""
    if answers["status"] not in USABLE_NAMES:
        return f"There is no verdict: the numbers of the run cannot be used ({answers['status']})."
    if fell(answers):
        what = "overturns" if answers["outcome"] == "overturned" else "slides off"
        return f"It does not stand: under this motion the block {what}."
    still = "It stands"
    if answers["undecided"]:
        still = "It stands so far, though the run ends before that is decided"
    ratio = answers["peak_rotation_ratio"]
    if ratio <= NO_TURN:
        return f"{still}: the motion does not lift the block."
    error = answers["peak_rotation_ratio_error"]
    more = "" if error is None else f" (error about {three(error)})"
    return f"{still}: its largest rotation is {three(ratio)} of its slenderness angle{more}."


def _at(answers: Facts, factor: float) -> str:
    """A factor on the motion as its peaks."""
    found = []
    for column, name in (("peak_acceleration_m_s2", "PGA"), ("peak_velocity_m_s", "PGV")):
        if answers.get(column) is not None:
            found.append(f"{name} {measure(column).text(factor * answers[column])}")
    return f" ({', '.join(found)})" if found else ""


def _falls_from(answers: Facts) -> str:
    """The factor on the motion at which it first falls."""
    low, high = answers["standing_factor"], answers["overturning_factor"]
    if high is None:
        top = answers["highest_factor"]
        return f"It does not fall up to {three(top)} times the motion{_at(answers, top)}."
    if not low:
        least = answers["lowest_factor"]
        return f"It falls already at {three(least)} times the motion{_at(answers, least)}."
    ends = f"{number_of('standing_factor', low)} and {number_of('overturning_factor', high)}"
    text = f"It first falls between {ends} times the motion{_at(answers, high)}"
    again = answers["resurrections"]
    if again:
        text += f"; at {again:,} of the stronger motions that were tried it stands again"
    return f"{text}."


def _spread(answers: Facts, of: str) -> str:
    """By how much neighbours differ."""
    return quantity_of(f"spread_{of}", answers[f"spread_{of}"])


def _neighbours(answers: Facts) -> str:
    """How many of its neighbours fall."""
    count, fallen = answers["neighbours_usable"], answers["neighbours_fallen"]
    if not count:
        return "None of its neighbours has numbers that can be used."
    ends = " to ".join(number_of("chance", answers[f"fallen_{end}"]) for end in ("low", "high"))
    text = (
        f"Of {counted(count, 'neighbour')} that differ a little in size, friction and strength of "
        f"the motion {fallen:,} fall: {quantity_of('chance', fallen / count)} "
        f"(95 % interval {ends} %)"
    )
    left = answers["neighbours"] - count
    return f"{text}; {left:,} more cannot be judged." if left else f"{text}."


def _slides(answers: Facts) -> list[str]:
    """Whether it slides, and how far."""
    slide, error = answers["peak_slide_m"], answers["peak_slide_error_m"]
    if slide is None or fell(answers):
        return []
    if not answers["slides"]:
        return ["Sliding is left out by this engine; a lane that would slide says outside_model."]
    if slide < 1e-6:
        return ["It does not slide."]
    more = "" if error is None else f" (error about {quantity_of('peak_slide_m', error)})"
    return [f"It slides {quantity_of('peak_slide_m', slide)} at most{more}."]


def _width(answers: Facts) -> list[str]:
    """How wide it must be."""
    if "width_m" not in answers:
        return []
    own, low, high = (answers[name] for name in ("width_m", "width_low_m", "width_high_m"))
    margin = f"{value_of(answers, 'margin')} times the motion"
    if high is None:
        return [
            f"To bear {margin} it must be wider than {quantity_of('width_m', low)}, "
            f"{number_of('width_ratio', low / own)} times as wide, the widest that was tried."
        ]
    if low is None:
        return [f"It bears {margin} as wide as it is, and so does every greater width tried."]
    ends = f"{quantity_of('width_m', low)} and {quantity_of('width_m', high)}"
    return [
        f"To bear {margin} it must be between {ends} wide, "
        f"{number_of('width_ratio', high / own)} times as wide."
    ]


def _unsure(answers: Facts) -> list[str]:
    """What is to be known of these answers."""
    found = []
    if answers["status"] in USABLE_NAMES and answers["status"] != "ok":
        found.append(f"Note: the status of the run is {answers['status'].replace('_', ' ')}.")
    if answers["unusable"]:
        runs = counted(answers["unusable"], "run")
        found.append(f"Note: {runs} at other factors had no numbers that can be used.")
    return found


def _answers_sheet(answers: Facts) -> Sheet:
    """The answers one by one."""
    slide = answers["peak_slide_m"]
    rows = [
        ["peak rotation / slenderness angle", three(answers["peak_rotation_ratio"]),
         three(answers["peak_rotation_ratio_error"])],
        ["peak slide [mm]", number_of("peak_slide_m", slide),
         number_of("peak_slide_m", answers["peak_slide_error_m"])],
        ["factor at which it first falls", three(answers["overturning_factor"]),
         three(_gap(answers["standing_factor"], answers["overturning_factor"]))],
        ["share of neighbours that fall [%]",
         three(_share(answers)), f"{number_of('chance', answers['fallen_low'])} to "
         f"{number_of('chance', answers['fallen_high'])}"],
    ]  # fmt: skip
    if "width_m" in answers:
        high = answers["width_high_m"]
        margin = value_of(answers, "margin")
        gap = three(_gap(answers["width_low_m"], high))
        rows.append([f"width for {margin} times the motion [m]", three(high), gap])
    heads = [Heading("answer"), Heading("value"), Heading("error")]
    return Sheet("Answers", heads, rows, "Error: of a factor and a width that of their brackets.")


def _share(answers: Facts) -> float | None:
    count = answers["neighbours_usable"]
    return 100.0 * answers["neighbours_fallen"] / count if count else None


def _gap(low: float | None, high: float | None) -> float | None:
    return None if low is None or high is None else high - low
