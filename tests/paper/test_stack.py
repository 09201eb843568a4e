"""Section 6 of the paper, two stacked blocks: its tables and figures, with a few members a cell."""

from __future__ import annotations

import functools
import io
import json

import numpy as np
import pandas as pd
import pytest

from warprock.case.load import load_case
from warprock.model.lanes import Lanes
from warprock.model.motion import harmonic_motions
from warprock.model.response import Outcome, SampleTimes
from warprock.paper import reproduce as module
from warprock.paper.conflicts_stack import (
    CEILING,
    FITTED,
    MISFITS,
    OVERTURNED,
    StackEvidence,
    centre_height,
    stack_conflicts_of,
)
from warprock.paper.print_tables import print_reproduction
from warprock.paper.printed import BLOCKS, PAPER_COLUMNS, paper_table
from warprock.paper.reproduce import reproduce
from warprock.paper.stack import STACK_ENGINES_OF, STACK_MAKERS
from warprock.paper.stack_runs import REFERENCE_ANGLE, Cells, cell_rows, input_keys
from warprock.running.batch import run_batch
from warprock.running.case_run import run_case
from warprock.tables.terminal import plain_console

MEMBERS = 4
KEYS = {"target", "frequency_hz", "amplitude_mm", "reading", "source", "peak_rotation_ratio"}
STACK_KEYS = KEYS | {"block", "geometry", "edges"}
ORACLE = {
    "top": (0.2293, 0.5826, 0.2305, 0.5135, 0.2192),
    "bottom": (0.1097, 0.1261, 0.0597, 0.0503, 0.0262),
}
"""Peaks / 9.85 deg of the SciPy oracle for `FITTED` (equal depths, chamfers, acceleration)."""
ANALYTICAL_ERROR = {"top": (0.03, 0.03, 0.08, 0.08, 0.04), "bottom": (0.05, 0.02, 0.10, 0.19, 0.03)}
"""How far the paper's analytical columns may be from ours for `FITTED`, as a share of theirs.

Its model is unknown in its details (mass taken off by chamfers, event tolerance, time step), and a
third of a per cent of amplitude moves the peak at 4 Hz, 4 mm by a quarter; half a printed digit
alone is 2 % of the smallest.
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Each target once, and each case that several of them need."""
    made, runs = {}, functools.cache(module.PaperRuns)

    def get(target: str) -> dict:
        if target not in made:
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(module, "PaperRuns", runs)
                if target in ("fig13", "fig15"):
                    # Drawn as figures 12 and 14 are.
                    patch.setattr("warprock.figures.drawing.Drawing.png", lambda _: b"")
                made[target] = reproduce(target, tmp_path_factory.mktemp(target), members=MEMBERS)
        return made[target]

    return get


def rows_of(reproduction, **chosen) -> list[dict]:
    return [r for r in reproduction["rows"] if all(r[key] == v for key, v in chosen.items())]


def peak_of(reproduction, key, source, reading, geometry, edges="chamfered") -> float:
    (row,) = rows_of(
        reproduction,
        frequency_hz=key[0],
        amplitude_mm=key[1],
        source=source,
        reading=reading,
        geometry=geometry,
        edges=edges,
    )
    return row["peak_rotation_ratio"]


def analytical(reproduction, inputs) -> np.ndarray:
    which = ("two-block", "acceleration", "equal-depths")
    return np.array([peak_of(reproduction, key, *which) for key in inputs])


def test_table_8_is_the_acceleration_of_its_own_sine():
    table = paper_table("table8")
    frequency, amplitude = table["frequency_hz"], table["amplitude_mm"]
    acceleration = 1e-3 * amplitude * (2.0 * np.pi * frequency) ** 2
    # 4 Hz, 5 mm is 3.158, printed as 3.15: cut off, not rounded.
    assert np.all(np.abs(acceleration - table["peak_acceleration_m_s2"]) < 0.01)
    ratio = table["peak_acceleration_m_s2"] / (9.81 * np.tan(np.deg2rad(9.85)))
    assert np.all(np.abs(ratio - table["normalised_acceleration"]) < 0.01)


@pytest.mark.parametrize("name", ["table9", "table10", "table11", "table12"])
def test_the_tables_have_the_inputs_of_table_8(name: str):
    keys = ["frequency_hz", "amplitude_mm"]
    pd.testing.assert_frame_equal(paper_table(name)[keys], paper_table("table8")[keys])
    assert set(PAPER_COLUMNS) < set(paper_table(name).columns)


@pytest.mark.thorough
@pytest.mark.parametrize("target", ["table9", "table10"])
def test_printed_values_stay_as_printed(target: str, found):
    for name in PAPER_COLUMNS:
        rows = rows_of(found(target), source=f"paper-{name}")
        ours = [np.nan if (v := r["peak_rotation_ratio"]) is None else v for r in rows]
        np.testing.assert_array_equal(ours, paper_table(target)[name])
        assert all(
            (r["percentile_printed"] is None) == np.isnan(v)
            for r, v in zip(rows, ours, strict=True)
        )


@pytest.mark.thorough
@pytest.mark.parametrize(("target", "block"), [("table9", "top"), ("table10", "bottom")])
def test_the_analytical_columns_cell_by_cell(target: str, block: str, found):
    ours = analytical(found(target), FITTED)
    np.testing.assert_allclose(ours, ORACLE[block], atol=5e-5)
    table = paper_table(target).set_index(["frequency_hz", "amplitude_mm"])["analytical"]
    off = np.abs(ours / table.loc[list(FITTED)].to_numpy() - 1.0)
    assert np.all(off <= ANALYTICAL_ERROR[block]), off


@pytest.mark.thorough
@pytest.mark.parametrize("target", ["table9", "table10"])
def test_two_analytical_values_fit_no_reading_and_are_named(target: str, found):
    """No reading of the stack under the acceleration comes near; the drive of the engines neither.

    The printed ratio is the same in both blocks, so that the stack rocks as one; ours does so too,
    at less than half of it.
    """
    ours = analytical(found(target), MISFITS)
    assert np.all(ours < 0.5 * 0.022)
    text = {c["title"]: c["text"] for c in found(target)["conflicts"]}
    assert "4/3 and 5/2 Hz/mm" in text["two analytical values that do not fit"]
    assert "These two do not fit" in text["two analytical values that do not fit"]


@pytest.fixture(scope="module")
def scanned() -> pd.DataFrame:
    """Peaks / 9.85 deg of the top block under the acceleration, over depths and chamfers."""
    ratios, chamfers = np.arange(0.75, 1.55, 0.125), np.array([0.0, 2.5e-3, 5e-3])
    ratio, chamfer, index = (
        a.ravel() for a in np.meshgrid(ratios, chamfers, np.arange(8), indexing="ij")
    )
    frequency, amplitude = np.array(input_keys())[index.astype(int)].T
    one = np.ones_like(ratio)

    def pair(lower, upper):
        return np.stack([lower * one, upper * one], axis=1)

    lanes = Lanes(
        width=pair(0.20, 0.15),
        height=pair(0.60, 0.60),
        depth=pair(0.40, 0.40 * ratio),
        density=pair(2670.0, 2670.0),
        friction=pair(1.0, 1.0),
        chamfer=pair(chamfer, chamfer),
        offset=pair(0.0, 0.0),
        rotation_start=pair(0.0, 0.0),
        angular_restitution=one,
    )
    rate = 2.0 * np.pi * frequency
    motions = harmonic_motions(
        ["sine"] * len(one),
        np.array(["acceleration"] * len(one)),
        1e-3 * amplitude * rate**2,
        frequency,
        0.0 * one,
        1.0 / frequency,
    )
    peak = run_batch("two-block", lanes, motions, SampleTimes(5.0))["peak_rotation"][:, 1]
    return pd.DataFrame(
        {
            "depths": ratio,
            "chamfer": chamfer,
            "input": list(zip(frequency, amplitude, strict=True)),
            "peak": peak / REFERENCE_ANGLE,
        }
    ).pivot(index=["depths", "chamfer"], columns="input", values="peak")


def test_equal_depths_and_chamfers_are_what_the_analytical_column_fits_best(scanned):
    """Of upper blocks 0.75 to 1.5 times as deep as the lower one, with 0, 2.5 and 5 mm chamfers."""
    table = paper_table("table9").set_index(["frequency_hz", "amplitude_mm"])["analytical"]
    off = np.abs(scanned[list(FITTED)] / table.loc[list(FITTED)].to_numpy() - 1.0).mean(axis=1)
    assert off.idxmin() == (1.0, 5e-3)
    assert off.min() < 0.05


def test_the_misfits_belong_to_another_stack_that_misses_the_rest(scanned):
    """As the conflict says: 1.25 times as deep."""
    deeper = scanned.loc[(1.25, 5e-3)]
    np.testing.assert_allclose(deeper[list(MISFITS)], [0.020, 0.024], atol=5e-4)
    table = paper_table("table9").set_index(["frequency_hz", "amplitude_mm"])["analytical"]
    off = np.abs(deeper[list(FITTED)].to_numpy() / table.loc[list(FITTED)].to_numpy() - 1.0)
    assert np.mean(off) == pytest.approx(0.33, abs=0.02)


@pytest.mark.thorough
def test_where_the_paper_prints_a_dash_the_stack_hardly_lifts(found):
    assert analytical(found("table9"), [(3.3, 4.0)])[0] < 1e-3


def test_continuous_sine_agrees_with_the_oracle_until_chaos_parts_them():
    """Peaks of both blocks within 3 s; after 5 s differences of 1e-9 have grown to 1e-2.

    The oracle's six digits; half of the last one, doubled for what growth there is by then.
    """
    case = load_case("stack-continuous-sine", ["run.duration=3 s"])
    run = run_case(case, "two-block", histories=False)
    lanes = run.lane_set.select({"reading": "acceleration"})
    bottom = (0.000099, 0.084511, 0.093434, 0.208790, 0.053746, 0.047962, 0.159337, 0.077574)
    top = (0.000099, 0.288936, 0.319921, 0.470365, 0.191016, 0.205996, 0.351499, 0.186075)
    peaks = run.response["peak_rotation"][lanes] / REFERENCE_ANGLE
    np.testing.assert_allclose(peaks, np.transpose([bottom, top]), rtol=0.0, atol=1e-6)


@pytest.mark.thorough
@pytest.mark.parametrize("target", ["table9", "table10"])
def test_event_agrees_with_the_analytical_model_where_nothing_slides(target: str, found):
    """Of the inputs that are not sensitive: friction 1 holds, so both solve one problem.

    The largest difference is of the order of a located impact, (p dt)^2 = 3e-4 over five swings.
    """
    steady = [key for key in FITTED if key != (4.0, 4.0)]
    which = ("event", "acceleration", "equal-depths")
    other = [peak_of(found(target), key, *which) for key in steady]
    np.testing.assert_allclose(other, analytical(found(target), steady), rtol=0.02)


@pytest.mark.thorough
@pytest.mark.parametrize("target", ["table9", "table12"])
def test_an_ensemble_has_ordered_quantiles_and_all_its_members(target: str, found):
    rows = rows_of(found(target), source="event-ensemble")
    assert len(rows) == 2 * 8
    for row in rows:
        assert row["members"] == MEMBERS
        names = ("low_5", "quartile_low", "peak_rotation_ratio", "quartile_high", "high_95")
        values = [row[name] for name in names]
        assert values == sorted(values)
        assert 0.0 <= row["collapsed_low"] <= row["collapsed_share"] <= row["collapsed_high"] <= 1.0


@pytest.mark.thorough
def test_the_engines_of_the_paper_are_nearer_to_equal_depths(found):
    """Vortex's column, the displacement drive: what the item on the depths says."""
    table = paper_table("table9")["vortex"].to_numpy()
    off = {
        geometry: np.mean(
            [
                abs(peak_of(found("table9"), key, "event", "displacement", geometry) / value - 1)
                for key, value in zip(input_keys(), table, strict=True)
            ]
        )
        for geometry in ("printed", "low-top")
    }
    assert off["low-top"] < 0.15 < 0.2 < off["printed"]


@pytest.mark.thorough
@pytest.mark.parametrize("target", ["table11", "table12"])
def test_printed_errors_stay_apart_from_peaks(target: str, found):
    for name in PAPER_COLUMNS:
        rows = rows_of(found(target), source=f"paper-{name}")
        assert all(row["peak_rotation_ratio"] is None for row in rows)
        theirs = pd.to_numeric(paper_table(target)[name], errors="coerce").tolist()
        ours = [np.nan if (v := row["abs_error_pct"]) is None else v for row in rows]
        np.testing.assert_array_equal(ours, theirs)
        for row, cell in zip(rows, paper_table(target)[name], strict=True):
            assert ("collapsed" in row.get("why", "")) is (cell == "collapsed")


@pytest.mark.thorough
@pytest.mark.parametrize("target", ["table11", "table12"])
def test_an_inferred_test_is_ours_over_one_minus_the_printed_error(target: str, found):
    rows = rows_of(found(target), source="inferred-experiment")
    assert len(rows) == 2 * 8
    table = paper_table(target).set_index(["frequency_hz", "amplitude_mm"])
    for row in rows:
        key = (row["frequency_hz"], row["amplitude_mm"])
        column = "analytical" if row["reading"] == "acceleration" else "bullet"
        error = 1e-2 * float(table.loc[key, column])
        if target == "table11" and key in OVERTURNED:
            assert row["peak_rotation_ratio"] == pytest.approx(CEILING, rel=1e-12)
            continue
        if row["peak_rotation_ratio"] is None:
            assert row["why"].startswith("none")
            continue
        assert error > 1.0 or error <= 0.9
        engine = "two-block" if column == "analytical" else "event-ensemble"
        geometry = "equal-depths" if column == "analytical" else "low-top"
        base = peak_of(found(target), key, engine, row["reading"], geometry)
        factor = 1.0 + error if error > 1.0 else 1.0 - error
        assert row["peak_rotation_ratio"] == pytest.approx(base / factor, rel=1e-12)
        assert "not measured" in row["why"]


@pytest.mark.thorough
@pytest.mark.parametrize("target", ["table11", "table12"])
def test_nothing_is_called_measured(target: str, found):
    assert not any("measured" in row["source"] for row in found(target)["rows"])


@pytest.mark.thorough
def test_the_collapse_grid_is_whole_and_calm_at_the_printed_amplitude(found):
    """In its plane the stack stays up as printed; twice as much takes the most chamfered down."""
    rows = rows_of(found("collapse"), block="top")
    assert len(rows) == 5 * 4 * 4
    as_printed = [row for row in rows if row["amplitude"] == "as printed"]
    assert len(as_printed) == 40
    assert all(row["collapsed_share"] == 0.0 for row in as_printed)
    doubled = rows_of(
        found("collapse"), block="top", amplitude="doubled", frequency_hz=4.0, chamfer_mm=7.5
    )
    assert max(row["collapsed_share"] for row in doubled) > 0.5


@pytest.mark.thorough
@pytest.mark.parametrize("target", STACK_ENGINES_OF)
def test_a_target_is_one_json_object_of_rows_with_the_agreed_keys(target: str, found):
    json.dumps(found(target), allow_nan=False)
    assert all(row.keys() >= STACK_KEYS for row in found(target)["rows"])
    assert {row["block"] for row in found(target)["rows"]} <= set(BLOCKS)
    assert {c["item"] for c in found(target)["conflicts"]} <= {9, 10, 11}
    names = {file.rsplit("/", 1)[1] for file in found(target)["files"]}
    drawn = set() if target.startswith("table") else {f"{target}.png"}
    # Single lanes have a figure a block.
    drawn |= {f"{target}-bottom.png"} if target in ("fig12", "fig14") else set()
    assert names == {f"{target}.csv"} | drawn


@pytest.mark.thorough
@pytest.mark.parametrize("target", STACK_ENGINES_OF)
def test_a_target_prints_within_130_columns(target: str, found):
    out = io.StringIO()
    print_reproduction(found(target), plain_console(file=out, width=130))
    text = out.getvalue()
    assert "…" not in text
    assert "Conflicts in the paper" in text
    if target.startswith("table"):
        assert "percentile" in text


def cells(ratio, outcome) -> Cells:
    """One cell of some members, both blocks alike."""
    inputs = pd.DataFrame({"geometry": ["printed"], "frequency_hz": [4.0], "amplitude_mm": [5.0]})
    both = np.stack([ratio, ratio], axis=1)[None]
    return Cells(inputs, both, np.asarray(outcome)[None])


def test_a_fall_ranks_above_every_number():
    up, fell = int(Outcome.ROCKING), int(Outcome.OVERTURNED)
    found = cells([0.1, 0.2, 0.3, 9.1], [up, up, up, fell])
    assert found.place("printed", (4.0, 5.0)) == 0
    assert found.percentile(0, "top", 0.25) == 50.0
    assert found.percentile(0, "top", 0.2) == 37.5
    assert found.percentile(0, "top", 20.0) == 75.0
    (row,) = cell_rows(found, "top").to_dict("records")
    assert (row["median"], row["high_95"]) == (0.2, np.inf)
    assert row["collapsed_share"] == 0.25
    np.testing.assert_array_equal(found.standing_ratio(0, "bottom"), [0.1, 0.2, 0.3])


def test_unusable_members_are_left_out_and_none_is_no_answer():
    up = int(Outcome.ROCKING)
    (row,) = cell_rows(cells([0.1, np.nan, 0.3], [up] * 3), "top").to_dict("records")
    assert (row["members"], row["median"]) == (2, 0.1)
    (row,) = cell_rows(cells([np.nan, np.nan], [up] * 2), "top").to_dict("records")
    assert row["members"] == 0
    assert np.isnan(row["median"])
    assert np.isnan(row["collapsed_share"])


def test_the_centre_of_mass_is_that_of_the_printed_sizes():
    """By hand: masses as .2 x .4 to .15 x .55, centres at 0.3 and 0.9 m."""
    assert centre_height(equal_depths=False) == pytest.approx((0.08 * 0.3 + 0.0825 * 0.9) / 0.1625)
    assert centre_height(equal_depths=True) == pytest.approx((0.2 * 0.3 + 0.15 * 0.9) / 0.35)


def test_conflicts_without_runs_say_what_can_be_calculated():
    """Worked out by hand from the printed tables."""
    text = {c.title: c.text for c in stack_conflicts_of(STACK_MAKERS, StackEvidence())}
    angle = text["the angle of the stack"]
    for number in ("9.39", "10.18", "8.93", "9.68", "9.87", "14.04"):
        assert number in angle
    averages = text["text against tables, Section 6"]
    for number in ("55.6", "57.9", "76.5", "81.5", "18.1 %", "25.4 %", "4/4 and 4/5", "96 and 8 %"):
        assert number in averages
    assert "9.14" in text["errors that are collapses"]
    assert "bullet 0.14 to 0.23" in text["errors that are collapses"]
    assert ".021 .021 .008 .015" in text["ratios called radians"]
