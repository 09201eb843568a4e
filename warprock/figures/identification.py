"""The figure of a block that was identified from its free rocking."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.analysis.identification import Identified, durations_of
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLUE, DARK, GREY, ORANGE
from warprock.figures.sheet import TIME_LABEL, headline, style, subplots

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

DEGREES = 180.0 / np.pi
POINTS = 200
"""Points of the curve of durations."""


def draw_identified(found: Identified, times: Array, rotations: Array, title: str) -> list[Drawing]:
    """Draws the history with its peaks, what impacts left, and how long swings last.

    Args:
        found: What the history tells.
        times: Of the history [s], shape [sample].
        rotations: [rad], shape [sample].
        title: What it says: the first sentence of its finding.

    Returns:
        One drawing.
    """
    timed = found.frequency_parameter is not None
    with style():
        figure, panels = subplots(1, 3 if timed else 2, (11.4 if timed else 8.0, 3.4))
        _draw_history(panels[0, 0], found, times, rotations)
        _draw_ratios(panels[0, 1], found)
        if timed:
            _draw_durations(panels[0, 2], found)
        about = (
            f"{found.swings.count} swings between impacts, of which each peak and duration is that "
            "of a polynomial through its samples; bars: standard errors"
        )
        headline(figure, title, about)
    return [Drawing("identification", figure, title, f"A history of free rocking. {title}.")]


def _draw_history(axes: Axes, found: Identified, times: Array, rotations: Array) -> None:
    swings = found.swings
    axes.plot(times, rotations * DEGREES, color=GREY, linewidth=0.9)
    peaks = swings.side * swings.peak * DEGREES
    axes.plot(swings.peak_time, peaks, ".", color=BLUE, label="peaks that count")
    axes.set(xlabel=TIME_LABEL, ylabel="rotation [deg]", title="History")
    axes.legend()


def _draw_ratios(axes: Axes, found: Identified) -> None:
    before = found.swings.peak[:-1] * DEGREES
    value, error = found.restitution.value, found.restitution.error
    axes.errorbar(
        before, found.ratios, yerr=found.ratio_errors, fmt=".", color=BLUE, elinewidth=0.9
    )
    axes.axhspan(value - 2.0 * error, value + 2.0 * error, color=BLUE, alpha=0.25, linewidth=0.0)
    axes.axhline(value, color=BLUE, label="all impacts, with two standard errors")
    name = "three impacts" if found.one_sided else "Housner's formula"
    axes.axhline(found.formula, color=ORANGE, linestyle="--", label=name)
    low, high = axes.get_ylim()
    if high - low < 0.02:
        axes.set_ylim(0.5 * (low + high) - 0.01, 0.5 * (low + high) + 0.01)
    axes.set(xlabel="peak before the impact [deg]", ylabel="angular velocity after / before [-]")
    axes.set_title("What an impact leaves")
    axes.legend()


def _draw_durations(axes: Axes, found: Identified) -> None:
    swings = found.swings
    assert found.frequency_parameter is not None
    angle, rate = found.slenderness_angle.value, found.frequency_parameter.value
    highest = min(1.1 * swings.peak.max(), 0.999 * angle)
    peaks = np.linspace(0.3 * swings.peak.min(), highest, POINTS)
    axes.plot(
        peaks * DEGREES,
        durations_of(peaks, angle, rate),
        color=DARK,
        linewidth=1.0,
        label="Housner's equation",
    )
    axes.errorbar(
        swings.peak * DEGREES,
        swings.duration,
        yerr=swings.duration_error,
        fmt=".",
        color=BLUE,
        elinewidth=0.9,
    )
    axes.set(xlabel="peak [deg]", ylabel="time from impact to impact [s]", title="Durations")
    axes.legend()
