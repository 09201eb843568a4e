"""Chapters of the analyses of a case: overturning maps, spectra, Sobol' indices, studies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from warprock.report import asked
from warprock.report.content import Chapter, Picture, Sheet
from warprock.report.folder import ResultFolder
from warprock.report.lanes import lane_sheet
from warprock.report.numbers import counted, heading, listed, sheet_of, three
from warprock.report.sentences import accuracy_sentences
from warprock.running.lane_table import LANE_TABLE

Scenes = Mapping[str, Any]


def chapter_of_case(
    folder: ResultFolder,
    kind: str,
    found: Sequence[str],
    *,
    pictures: Sequence[Picture],
    sheets: Sequence[Sheet],
    scenes: Scenes | None = None,
    more: Sequence[tuple[str, str]] = (),
) -> Chapter:
    """A chapter of what one case, run by one engine, gave.

    Args:
        folder: Its folder, which holds `run.json`.
        kind: What it is.
        found: What came out.
        pictures: Its figures.
        sheets: Its tables.
        scenes: Lanes to play; None where there are none.
        more: What was asked besides.
    """
    facts = folder.facts
    case, engine = facts["case"], facts.get("engine")
    name = engine.get("name", "") if isinstance(engine, Mapping) else engine
    return Chapter(
        kind=f"{kind}, {name}" if name else kind,
        title=case["title"],
        found=found,
        asked=[*asked.asked(facts), *more],
        background=[case["source"]] if case.get("source") else [],
        scenes=scenes,
        pictures=pictures,
        sheets=sheets,
        words=asked.words(facts),
        provenance=asked.provenance_pairs(facts),
        citations=asked.citations(facts),
    )


def map_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of an overturning map."""
    facts, boundaries = folder.facts, folder.table("boundaries.parquet")
    grid = folder.table("grid.parquet")
    modes = facts["modes"]
    counts = [
        f"{modes.get('safe', 0):,} leave the block standing",
        f"{modes.get('without impact', 0):,} overturn it without an impact",
        f"{modes.get('with impact', 0):,} overturn it after an impact",
    ]
    found = [f"Of the {facts['grid_lanes']:,} pulses of the grid {listed(counts)}."]
    weakest = [_weakest(name, rows) for name, rows in boundaries.groupby("group")]
    if any(weakest):
        found.append(f"The weakest pulse that overturns: {'; '.join(filter(None, weakest))}.")
    more = facts["lanes_run"] - facts["grid_lanes"]
    found.append(
        f"{counted(facts['boundaries'], 'boundary', 'boundaries')} between standing and falling "
        f"were found, each to {facts['tolerance']:g} of its strength, by {more:,} more lanes."
    )
    if modes.get("undecided"):
        found[-1] += f" Undecided when the run ended: {counted(modes['undecided'], 'lane')}."
        if facts.get("decided_after_s"):
            found[-1] += f" A run.duration of {facts['decided_after_s']:g} s decides all."
    return chapter_of_case(
        folder,
        "Overturning map",
        found,
        pictures=folder.pictures("map*.png"),
        sheets=[
            sheet_of(
                "Boundaries, where the mode changes",
                boundaries,
                boundaries.attrs["columns"],
                file="boundaries.csv",
            ),
            lane_sheet(
                facts, grid, besides=("frequency_ratio", "mode"), file="grid.csv", folded=True
            ),
        ],
        scenes=scenes,
        more=[("Boundaries", f"to {facts['tolerance']:g} of their strength")],
    )


def _weakest(group: object, boundaries: pd.DataFrame) -> str:
    """The weakest overturning pulse of a group, in words; empty where none overturns."""
    falls = boundaries[boundaries["above"].isin(["with impact", "without impact"])]
    if falls.empty:
        return ""
    row = falls.iloc[int(falls["acceleration_ratio"].argmin())]
    name = f"{group}: " if group else ""
    return (
        f"{name}{three(float(row['acceleration_ratio']))} g tan(slenderness angle) at "
        f"{three(float(row['frequency_ratio']))} times the frequency parameter "
        f"({three(float(row['frequency_hz']))} Hz), {row['above']}"
    )


def spectrum_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of rocking spectra."""
    facts, table = folder.facts, folder.table("spectrum.parquet")
    fell = (table["outcome"] == "overturned").to_numpy()
    found = [f"Of {len(table):,} blocks {asked.outcome_words(facts['outcome'])}."]
    curve = "slenderness" if "slenderness" in table else ""
    if curve and fell.any():
        longest = table[fell].groupby(curve, sort=False)["period_s"].max()
        texts = [f"{three(float(t))} s at {name}" for name, t in longest.items()]
        stood = [name for name in facts["curves"] if name not in longest.index]
        text = f"The largest block that falls has a period 2 pi / p of {listed(texts)}"
        found.append(f"{text}; none falls at {listed(stood)}." if stood else f"{text}.")
    up = table[~fell & table["peak_rotation_ratio"].notna()]
    if len(up):
        top = up.iloc[int(up["peak_rotation_ratio"].argmax())]
        found.append(
            f"Of those that stand the largest rotation is "
            f"{three(float(top['peak_rotation_ratio']))} of the slenderness angle, at a period of "
            f"{three(float(top['period_s']))} s"
            + (f" and a slenderness of {top[curve]}." if curve else ".")
        )
    return chapter_of_case(
        folder,
        "Rocking spectrum",
        [*found, *accuracy_sentences(facts)],
        pictures=folder.pictures("spectrum*.png"),
        sheets=[lane_sheet(facts, table, besides=("slenderness", "period_s"), file="spectrum.csv")],
        scenes=scenes,
    )


def sensitivity_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of Sobol' indices."""
    facts, table = folder.facts, folder.table("sensitivity.parquet")
    found = [_indices(str(name), rows, facts["of"]) for name, rows in table.groupby("group")]
    groups = {group["group"]: group for group in facts["groups"]}
    for name, group in groups.items():
        of = f" of {name}" if name else ""
        found.append(
            f"Over the {group['lanes']:,} lanes{of} the mean is {three(group['mean'])} and the "
            f"standard deviation {three(group['standard_deviation'])}"
            + (f"; {group['overturned']:,} overturned." if group["overturned"] else ".")
        )
        if group.get("censored"):
            found.append(
                "The peak is counted up to the point of balance: "
                f"{counted(group['censored'], 'lane')} that fell or went beyond it count as 1."
            )
    return chapter_of_case(
        folder,
        "Sensitivity",
        [*found, *accuracy_sentences(facts)],
        pictures=folder.pictures("sensitivity*.png"),
        sheets=[
            sheet_of("Sobol' indices", table, table.attrs["columns"], file="sensitivity.csv"),
        ],
        scenes=scenes,
        more=[("Result", facts["of"])],
    )


def _indices(group: str, rows: pd.DataFrame, of: str) -> str:
    """Which inputs of a group matter, and which do not."""
    ranked = rows.sort_values("total", ascending=False)
    first = ranked.iloc[0]
    name = f"For {group}: " if group else ""
    text = (
        f"{name}{first['input']} explains most of the variance of {of.replace('_', ' ')}: "
        f"{three(100.0 * float(first['total']))} % with its interactions, "
        f"{three(100.0 * float(first['first_order']))} % alone"
    )
    idle = [str(each) for each in ranked[ranked["total"] < 0.01]["input"]]
    return f"{text}; {listed(idle)} changes less than 1 % of it." if idle else f"{text}."


def study_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of a study of settings."""
    facts, table = folder.facts, folder.table("study.parquet")
    found = []
    for engine, rows in table.groupby("engine", sort=False):
        error = rows["error_run_ratio"]
        own, worst = rows[rows["baseline"]], rows.iloc[int(error.argmax())]
        unit = "" if worst["unit"] == "-" else f" {worst['unit']}"
        found.append(
            f"{engine} at the case's own settings differs from Housner by at most "
            f"{three(float(own['error_run_ratio'].max()))} of the slenderness angle; the largest "
            f"error of all, {three(float(error.max()))}, is that of {worst['setting']} "
            f"{three(float(worst['value']))}{unit}."
        )
    cost = table["cpu_s"]
    dear, cheap = (table.iloc[int(at)] for at in (cost.argmax(), cost.argmin()))
    found.append(
        f"The dearest run, {dear['setting']} {dear['value']:g} of {dear['engine']}, took "
        f"{three(float(dear['cpu_s'] / cheap['cpu_s']))} times the CPU time of the cheapest, "
        f"{cheap['setting']} {cheap['value']:g} of {cheap['engine']}."
    )
    wanted = ["engine", "setting", "value", "unit", "baseline", "lane_name", "time_step_s"]
    wanted += ["error_5s_ratio", "error_run_ratio", "baseline_difference_ratio"]
    wanted += ["peak_rotation_ratio", "rest_time_error_s", "cpu_s", "status", "why"]
    shown = table[[name for name in wanted if name in table]]
    sheets = [sheet_of("Runs", shown, table.attrs["columns"], file="study.csv")]
    plans = [
        (
            f"Settings of {plan['engine']}" if "engine" in plan else "Settings",
            ", ".join(f"{row['setting']} {row['baseline']:g}" for row in plan["vary"])
            + ", one varied at a time",
        )
        for plan in facts["study"]
    ]
    return chapter_of_case(
        folder,
        "Study",
        found,
        pictures=folder.pictures("study*.png", "histories*.png"),
        sheets=sheets,
        scenes=scenes,
        more=plans,
    )


def fragility_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of fragility functions that were fitted to a lane table."""
    table = folder.table("fragility.csv")
    names = folder.table("fragility-p58.csv")
    intensity = str(names["Demand-Type"].iloc[0]) if len(names) else "the intensity measure"
    groups = list(table.columns[: list(table.columns).index("limit_state")])
    found = [_fit_text(row, groups, intensity) for _, row in table.head(MOST_FITS).iterrows()]
    if len(table) > MOST_FITS:
        found.append(f"{len(table) - MOST_FITS:,} more are in the table below.")
    doubt = int(table["in_doubt"].max())
    if doubt:
        found.append(
            f"Up to {doubt:,} lanes are in doubt; they count by their finest run, and the bands "
            "reach around what they could change."
        )
    shown = table.dropna(axis="columns", how="all")
    return Chapter(
        kind="Fragility functions",
        title=f"Fragility over {heading(intensity).text}",
        found=found,
        asked=[
            ("Intensity measure", intensity),
            ("Limit states", listed([str(name) for name in table["limit_state"].unique()])),
            ("Function", "lognormal, of greatest likelihood; bands over records"),
        ],
        pictures=folder.pictures("fragility*.png"),
        # Beside a run the player is that of the run.
        scenes=None if folder.has(LANE_TABLE) else scenes,
        sheets=[
            sheet_of(
                "Fits: a row for each group and limit state",
                shown,
                note="p05 and p95: 5th and 95th percentile over records.",
                file="fragility.csv",
            )
        ],
        citations=asked.citations(folder.facts),
    )


MOST_FITS = 4
"""Fits that are told in sentences."""


def _fit_text(row: pd.Series[Any], groups: Sequence[Any], intensity: str) -> str:
    """One fit in a sentence."""
    where = ", ".join(f"{str(name).replace('_', ' ')} {row[name]}" for name in groups)
    limit = str(row.get("limit_state", "overturning"))
    what = limit if limit in ("uplift", "overturning") else f"a limit of {limit}"
    lead = f"{where}: " if where else ""
    measure, verdict = heading(intensity), row["verdict"]
    name, unit = f"a {measure.text} of", f" {measure.unit}" if measure.unit else ""
    if verdict == "fitted":
        band = ""
        if np.isfinite(row["median_p05"]):
            band = f" (5 to 95 %: {three(row['median_p05'])} to {three(row['median_p95'])})"
        text = f"half of the lanes reach {what} at {name} {three(row['median'])}{unit}{band}"
        return _sentence(f"{lead}{text}, with a dispersion of {three(row['dispersion'])}")
    known = {
        "separated": f"every lane reaches {what} from {name} {three(row['all_from'])}{unit} up "
        f"and none up to {three(row['none_up_to'])}{unit}",
        "none reached": f"no lane reaches {what} up to {name} {three(row['none_up_to'])}{unit}",
        "all reached": f"every lane reaches {what} from {name} {three(row['all_from'])}{unit} on",
    }
    return _sentence(lead + known.get(verdict, f"no function of {what} could be fitted: {verdict}"))


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


def incremental_chapter(folder: ResultFolder, scenes: Scenes | None) -> Chapter:
    """The chapter of an incremental dynamic analysis."""
    facts, groups = folder.facts, folder.table("fragility.parquet")
    lanes = folder.table("capacities.parquet")
    names = list(groups.columns[: list(groups.columns).index("lanes")])
    name = str(facts["intensity"])
    found = [str(facts["sentence"])] if "sentence" in facts else []
    if len(lanes) > 1:
        found += [_fit_text(row, names, name) for _, row in groups.head(MOST_FITS).iterrows()]
    verdicts = lanes["verdict"].astype(str).value_counts()
    counts = [f"{count:,} {str(word).replace('_', ' ')}" for word, count in verdicts.items()]
    asked_for = facts["incremental"]
    found.append(
        f"Of {counted(len(lanes), 'lane')}: {listed(counts)}; {facts['runs']:,} runs between "
        f"{asked_for['lowest']:g} and {asked_for['highest']:g} times the motion."
    )
    again = int((lanes["resurrections"] > 0).sum())
    found.append(
        f"{counted(again, 'lane')} stood again at a stronger motion than the first that felled "
        "them."
        if again
        else "No lane stood again at a stronger motion than the first that felled it."
    )
    wanted = [*asked.swept_columns(facts, lanes), "standing_factor", "overturning_factor"]
    wanted += [each for each in map(str, lanes) if each.endswith(name)] + ["verdict", "runs"]
    shown = lanes[["lane", *dict.fromkeys(each for each in wanted if each in lanes)]]
    return chapter_of_case(
        folder,
        "Incremental dynamic analysis",
        found,
        pictures=folder.pictures("ida*.png"),
        scenes=scenes,
        sheets=[
            sheet_of("Capacities of groups", groups.dropna(axis="columns", how="all")),
            sheet_of("Capacities of lanes", shown, lanes.attrs["columns"], file="capacities.csv"),
        ],
        more=[
            ("Intensity measure", name),
            (
                "Factors",
                f"{asked_for['lowest']:g} to {asked_for['highest']:g}, "
                f"{asked_for['count']} at first, brackets to {asked_for['accuracy']:g}",
            ),
        ],
    )
