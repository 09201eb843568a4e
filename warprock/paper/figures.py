"""The paper's figures from the shipped cases' runs: which curves go on which panel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.figures.drawing import Drawing
from warprock.paper import plots_forced, plots_free
from warprock.paper.conflicts import BLOCK, inferred_experiment, peak_acceleration
from warprock.paper.printed import INFERRED_NAMES, PAPER_COLUMNS, READING_NAMES, paper_columns
from warprock.paper.runs import (
    B0,
    B123,
    ENGINES,
    PULSE,
    READINGS,
    SINE,
    PaperRuns,
    lane_evidence,
)
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

PULSE_WINDOWS = ((0.0, 10.0), (0.0, 5.0))
SINE_WINDOWS = ((0.0, 2.0), (8.0, 10.0), (53.0, 55.0))
"""Windows of time [s] that Figs. 7 and 10 of the paper show."""


def ratios(runs: PaperRuns, case: str, engine: str, *overrides: str) -> tuple[Array, Array]:
    """Sample times [s], shape [sample], and rotation ratios, shape [lane, sample]."""
    responses = runs.case(case, *overrides)
    response = responses[engine]
    slenderness = responses.lane_set.lanes.slenderness_angle
    return response.times, np.asarray(response["rotation"] / slenderness[:, None])


def figure4(runs: PaperRuns) -> list[Drawing]:
    """B0 free, both heights."""
    lanes = runs.case(B0).lane_set.lanes
    curves = {engine: ratios(runs, B0, engine) for engine in ENGINES}
    panels = [
        (
            f"B0, {lanes.width[lane]:.1f} m x {lanes.height[lane]:.1f} m, released at 0.5 of "
            f"{lanes.slenderness_angle[lane]:.4f} rad",
            {engine: curve[lane] for engine, (_, curve) in curves.items()},
        )
        for lane in range(lanes.lane_count)
    ]
    return [plots_free.draw_free_response("fig4", curves["housner"][0], panels)]


def figure5(runs: PaperRuns) -> list[Drawing]:
    """B1 to B3 free from three rotations, with residuals."""
    lane_set = runs.case(B123).lane_set
    curves = {engine: ratios(runs, B123, engine) for engine in ENGINES}
    panels = [
        (
            f"{block}, from {start:g} of {angle:.3f} rad",
            {engine: curve[lane] for engine, (_, curve) in curves.items()},
        )
        for lane, (block, start, angle) in enumerate(
            zip(
                lane_set.inputs["block"].astype(str),
                lane_set.inputs["rotation_ratio_start"],
                lane_set.lanes.slenderness_angle,
                strict=True,
            )
        )
    ]
    return [plots_free.draw_free_panels("fig5", curves["housner"][0], panels)]


def _histories(
    runs: PaperRuns,
    case: str,
    stem: str,
    title: str,
    windows: Sequence[tuple[float, float]],
    levels: Sequence[float] | None = None,
) -> list[Drawing]:
    """One figure a reading with the engines over each other, and one with all readings."""
    inputs = runs.case(case).lane_set.inputs
    curves = {engine: ratios(runs, case, engine) for engine in ENGINES}
    times = curves["housner"][0]
    windows = [(first, min(last, float(times[-1]))) for first, last in windows]
    lanes_of = {
        reading: np.flatnonzero(inputs["reading"].astype(str) == reading) for reading in READINGS
    }
    names = [
        f"{row.frequency_hz:g} Hz, {row.amplitude_mm:g} mm"
        for row in inputs.iloc[lanes_of[READINGS[0]]].itertuples()
    ]
    drawings = []
    for reading, lanes in lanes_of.items():
        panels = [
            (name, {engine: curve[lane] for engine, (_, curve) in curves.items()})
            for name, lane in zip(names, lanes, strict=True)
        ]
        drawings.append(
            plots_forced.draw_windows(
                f"{stem}-{reading}",
                f"{title}: {READING_NAMES[reading]}",
                times,
                panels,
                windows,
                levels,
            )
        )
    panels = [
        (name, {reading: curves["housner"][1][lanes_of[reading][index]] for reading in READINGS})
        for index, name in enumerate(names)
    ]
    overview = plots_forced.draw_readings(
        stem,
        f"{title}: Housner's equation under the three readings of the paper",
        times,
        panels,
        windows,
    )
    return [overview, *drawings]


def figure7(runs: PaperRuns) -> list[Drawing]:
    """Histories under one cycle of sine, full and first 5 s."""
    return _histories(runs, PULSE, "fig7", "One cycle of sine", PULSE_WINDOWS)


def figure10(runs: PaperRuns) -> list[Drawing]:
    """Histories under continuous sine: start, transient, steady."""
    levels = np.mean(inferred_experiment(lane_evidence(runs, SINE)), axis=0)
    return _histories(runs, SINE, "fig10", "Continuous sine", SINE_WINDOWS, levels)


def _trends(
    runs: PaperRuns, case: str, name: str, title: str, printed: dict[str, Array]
) -> list[Drawing]:
    evidence = lane_evidence(runs, case).frame
    peaks = pd.concat(
        [
            evidence[["reading"]].assign(source=engine, peak_rotation_ratio=evidence[engine])
            for engine in ENGINES
        ]
    )
    width, height = BLOCK[:2]
    acceleration = peak_acceleration()
    panels = [
        (
            "peak acceleration / (g tan(slenderness)) [-]\nas printed: block 0.75 m high",
            paper_columns("table4")["normalised_acceleration"],
        ),
        (
            "peak acceleration / (g tan(slenderness)) [-]\nthe true block, 1.0 m high",
            acceleration / (GRAVITY * width / height),
        ),
    ]
    return [plots_forced.draw_trends(name, title, peaks, printed, panels)]


def figure8(runs: PaperRuns) -> list[Drawing]:
    """Peaks under one cycle of sine over normalised acceleration."""
    table = paper_columns("table6")
    printed = {name: table[name] for name in PAPER_COLUMNS}
    return _trends(runs, PULSE, "fig8", "Peaks under one cycle of sine", printed)


def figure11(runs: PaperRuns) -> list[Drawing]:
    """Peaks under continuous sine over normalised acceleration."""
    inferred = dict(
        zip(INFERRED_NAMES, inferred_experiment(lane_evidence(runs, SINE)), strict=True)
    )
    return _trends(runs, SINE, "fig11", "Peaks under continuous sine", inferred)
