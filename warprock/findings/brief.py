"""A brief: what a decision about one object wants to know, in words and digits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.brief import Brief, Slide
from warprock.analysis.incremental import Ladder
from warprock.analysis.risk import Risk, chance_within
from warprock.findings.digits import number_of, quantity_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.intensities import measure
from warprock.findings.measures import (
    RATE_SHAPE,
    TABLE,
    best_measure,
    effect_rows,
    effect_sheet,
    factor_range,
    known,
    rate_facts,
    target_sentences,
)
from warprock.findings.numbers import counted, three
from warprock.findings.risk import once_in, percent_text
from warprock.running.provenance import case_facts, surroundings
from warprock.running.run_file import CASE

YEARS = (1.0, 50.0)
"""Within which chances are told [years]."""
SAID = (
    (0.99, "virtually certain"),
    (0.90, "very likely"),
    (0.66, "likely"),
    (0.33, "about as likely as not"),
    (0.10, "unlikely"),
    (0.01, "very unlikely"),
    (0.0, "exceptionally unlikely"),
)
"""Least chance that a word stands for: those of the IPCC's guidance (Mastrandrea and others 2010,
table 1)."""
_NUMBER = (float, None)


def chance_word(chance: float) -> str:
    """A chance in a word.

    >>> chance_word(0.035), chance_word(0.5)
    ('very unlikely', 'about as likely as not')
    """
    return next(word for least, word in SAID if chance >= least)


def one_in(chance: float) -> str:
    """A chance as one in so many, two digits.

    >>> one_in(0.0345), one_in(7e-4), one_in(0.9)
    ('1 in 29', '1 in 1,400', '9 in 10')
    """
    if chance > 0.5:
        return f"{10.0 * chance:.0f} in 10"
    return f"1 in {float(number_of('odds', 1.0 / chance)):,.0f}"


def times(factor: float) -> str:
    """A factor on a chance: below 1 as a fraction.

    >>> times(0.0768), times(0.998), times(1.5), times(float("nan"))
    ('1/13', '1', '1.5', '-')
    """
    if not factor > 0.0:
        return "-"
    text = number_of("odds", max(factor, 1.0 / factor))
    return text if text == "1" or factor > 1.0 else f"1/{text}"


def find_brief(found: Brief, ladder: Ladder) -> Finding:
    """What a decision wants to know."""
    facts = {
        "case": case_facts(found.measures.case),
        "engine": found.measures.engine,
        "brief": {**rate_facts(found.measures, ladder), **_facts(found)},
        **surroundings(found.measures.case),
    }
    return tell_brief(facts, {TABLE: effect_rows(found.measures)})


def _facts(found: Brief) -> dict[str, Any]:
    """The object, what it takes, how far it slides, and how sure that is."""
    base, lanes = found.base, found.lane_set.lanes
    median = base.function.fit.median
    inputs = found.lane_set.inputs.iloc[0]
    exceeded = float(base.hazard.rate(np.array([median]))[0])
    facts: dict[str, Any] = {
        "object": found.measures.case.title,
        "object_width_m": float(lanes.width[0, 0] if lanes.width.ndim > 1 else lanes.width[0]),
        "object_height_m": float(lanes.height[0, 0] if lanes.height.ndim > 1 else lanes.height[0]),
        "object_mass_kg": known(_mass(inputs)),
        "records": found.records,
        "lanes": found.lane_set.lanes.lane_count,
        "band": base.function.band is not None,
        "rate_fit_p05_per_year": known(base.fit_band[0]),
        "rate_fit_p95_per_year": known(base.fit_band[1]),
        "share_outside": base.below + base.beyond,
        "median_exceeded_per_year": exceeded,
        **{f"intensity_p{p:02d}": _intensity(base, 0.01 * p) for p in (5, 95)},
    }
    return facts | _slide_facts(found.slide)


def _intensity(risk: Risk, share: float) -> float:
    return risk.intensity_at(share)


def _mass(inputs: pd.Series) -> float:
    """Mass of the object [kg]; NaN where its inputs do not say it."""
    if "mass_kg" in inputs:
        return float(inputs["mass_kg"])
    sizes = ("density_kg_m3", "width_m", "height_m", "depth_m")
    if any(name not in inputs for name in sizes):
        return float("nan")
    return float(np.prod([float(inputs[name]) for name in sizes]))


def _slide_facts(slide: Slide | None) -> dict[str, Any]:
    if slide is None:
        return {"slides": False, "standing_slide_m": None, "clearance_m": None}
    facts: dict[str, Any] = {
        "slides": True,
        "standing_slide_m": slide.standing,
        "clearance_m": known(slide.clearance),
    }
    if slide.risk is not None:
        verdict = slide.risk.function.fit.verdict.value
        facts |= {
            "slide_rate_per_year": known(slide.risk.rate),
            "slide_verdict": verdict,
            "slid_before": slide.before,
        }
    return facts


def tell_brief(facts: Facts, tables: Tables) -> Finding:
    """What a decision wants to know, of its facts and table."""
    rows, base = tables[TABLE], facts["brief"]
    return Finding(
        kind="Brief",
        facts=facts,
        tables=tables,
        sentences=[
            chance_sentence(base),
            takes_sentence(base),
            slide_sentence(base),
            best_measure(rows, base),
            *target_sentences(base),
            *sure_sentences(base),
        ],
        sheets=[effect_sheet(rows)],
        rows={"rows": TABLE},
        said={"brief": base, "engine": facts["engine"]},
        asked=[
            ("Hazard", base["hazard"]),
            ("Intensity measure", measure(base["intensity"]).name),
            ("Records", f"{base['records']}, each {factor_range(base)} times as strong"),
        ],
        pictures=["object.png", "measures*.png", "risk*.png"],
    )  # fmt: skip


BRIEF = Kind(
    (TABLE,),
    tell_brief,
    "brief",
    {
        "case": CASE,
        "engine": str,
        "brief": {
            **RATE_SHAPE,
            "object": str,
            **dict.fromkeys(("records", "lanes"), int),
            **dict.fromkeys(("band", "slides"), bool),
            **dict.fromkeys(("object_width_m", "object_height_m", "share_outside"), float),
            **dict.fromkeys(("median_exceeded_per_year", "intensity_p05", "intensity_p95"), float),
            **dict.fromkeys(("object_mass_kg", "standing_slide_m", "clearance_m"), _NUMBER),
            **dict.fromkeys(("rate_fit_p05_per_year", "rate_fit_p95_per_year"), _NUMBER),
            "slide_rate_per_year?": _NUMBER,
            "slide_verdict?": str,
            "slid_before?": int,
        },
    },
)


def chances(base: Facts) -> list[dict[str, str]]:
    """The chances within `YEARS`: in percent, as one in so many, in a word, with their bands."""
    found = []
    for years in YEARS:
        chance = chance_within(base["rate_per_year"], years)
        low, high = (base[f"rate_{end}_per_year"] for end in ("p05", "p95"))
        band = ""
        if low is not None and high is not None:
            ends = (percent_text(chance_within(each, years)) for each in (low, high))
            band = " to ".join(ends)
        span = "a year" if years == 1.0 else f"{number_of('years', years)} years"
        found.append(
            {
                "span": span,
                "percent": percent_text(chance),
                "one_in": one_in(chance),
                "word": chance_word(chance),
                "band": band,
            }
        )
    return found


def chance_sentence(base: Facts) -> str:
    """The chance within 50 years."""
    year, long = chances(base)
    band = f" (5 to 95 % over records: {long['band']})" if long["band"] else ""
    return (
        f"It falls within {long['span']} with a chance of {long['percent']}, {long['one_in']}{band}"
        f": {long['word']}; within {year['span']} with {year['percent']}, {year['one_in']}."
    )


def takes_sentence(base: Facts) -> str:
    """What it takes, and how often that comes."""
    measured = measure(base["intensity"])
    low, high = (measured.text(base[f"intensity_p{end}"]) for end in ("05", "95"))
    return (
        f"At a {measured.name} of {measured.text(base['median'])} every second motion topples it; "
        f"that comes {once_in(1.0 / base['median_exceeded_per_year'])}. Nine tenths of the chance "
        f"come from motions of {low} to {high}."
    )


def slide_sentence(base: Facts) -> str:
    """Whether it slides into something first."""
    if not base["slides"]:
        return "Whether it slides into something first is not told: this engine leaves sliding out."
    most = quantity_of("peak_slide_m", base["standing_slide_m"])
    clearance = base["clearance_m"]
    if clearance is None:
        if base["standing_slide_m"] < 1e-6:
            return "It does not slide before it falls."
        return (
            f"Up to the motions that topple it it slides {most} at most: what it must not touch "
            "should be farther away."
        )
    far = quantity_of("clearance_m", clearance)
    rate = base["slide_rate_per_year"]
    if rate is None:
        known = "none reached" in base["slide_verdict"]
        return (
            f"It does not slide {far} under any motion that was tried."
            if known
            else f"How often it slides {far} is not known: {base['slide_verdict']}."
        )
    if base["standing_slide_m"] < 1e-6:
        return f"Under none of {counted(base['lanes'], 'record')} it slides before it falls."
    before, lanes = base["slid_before"], counted(base["lanes"], "record")
    if not before:
        return f"Under none of {lanes} it slides {far} before it falls; {most} are the most."
    return (
        f"Under {before} of {lanes} it slides {far} before it falls. It slides so far "
        f"{once_in(1.0 / rate)}."
    )


def sure_sentences(base: Facts) -> list[str]:
    """How sure it is."""
    count = counted(base["records"], "record")
    if not base["band"]:
        return [f"{count}: too few for a band; take these chances as rough."]
    low, high = base["rate_p05_per_year"], base["rate_p95_per_year"]
    found = [
        f"With other records like these {count} the chance could be "
        f"{three(low / base['rate_per_year'])} to {three(high / base['rate_per_year'])} times what "
        "is said here (nine times in ten)."
    ]
    if base["records"] < 10:
        found.append("They are few: more of them would tell most.")
    if base["share_outside"] >= 5e-4:
        found.append(
            f"{percent_text(base['share_outside'])} of the rate come from motions beyond the ends "
            "of the hazard curve."
        )
    return found


LEFT_OUT = (
    "How uncertain the hazard curve itself is: run this again with its fractiles.",
    "Whether these records are like those that the site will see.",
    "The ground or the floor: it moves as the records do, is rigid and does not tilt.",
    "Cracks and crushed edges: the object is one rigid piece.",
    "Neighbours that it strikes, and what a fall does to people and things near it.",
)
"""What a brief says that was left out."""


def object_text(base: Facts) -> str:
    """The object in numbers."""
    text = f"{three(base['object_width_m'])} m wide, {three(base['object_height_m'])} m high"
    mass = base["object_mass_kg"]
    return text if mass is None else f"{text}, {number_of('object_mass_kg', mass)} kg"
