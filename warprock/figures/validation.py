"""Figures of engines held to tests: scores, reliability, fragility observed and predicted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.analysis.bands import LEAST_RECORDS
from warprock.analysis.lognormal import Observations
from warprock.analysis.scores import reliability
from warprock.figures.drawing import Drawing
from warprock.figures.fragility import gathered
from warprock.figures.palette import DARK, GREY, ORANGE, engine_marks
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, legend_below, style, subplots
from warprock.findings.intensities import measure
from warprock.running.cells import wilson_interval
from warprock.verification.settings import plain_name
from warprock.verification.validation import Judged, Shaking, Validation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

POINTS = 200
OBSERVED = ORANGE
"""Colour of what was observed."""
MOST_BANDS = 2
"""Engines up to which each has its band: of more, bands hide one another."""
DASHES = ("-", "--", ":", "-.")
"""Lines of engines that share a colour: one engine with several settings."""


def draw_validation(found: Validation, title: str) -> list[Drawing]:
    """Draws a validation.

    Args:
        found: The validation.
        title: What the scores say: the first sentence of its finding.

    Returns:
        The scores with the reliability diagram, and the fragility functions where there are any.
    """
    drawings = [_draw_scores(found, title)]
    if found.shakings:
        drawings.append(_draw_fragility(found))
    return drawings


def _draw_scores(found: Validation, title: str) -> Drawing:
    """Accuracy of every predictor with its band, beside the reliability diagram."""
    everyone = (*found.engines, *found.baselines)
    with style():
        figure, grid = subplots(1, 2, (8.4, max(2.6, 1.6 + 0.42 * len(everyone))))
        _draw_accuracy(grid[0, 0], everyone, len(found.engines))
        _draw_reliability(grid[0, 1], found)
        numbers = "; small numbers count tests" if len(found.engines) == 1 else ""
        about = (
            "Left, filled: accuracy; open: balanced accuracy; bars: 5th to 95th percentile over "
            f"ground motions\nRight: bars are 95 % intervals{numbers}; on the grey line as many "
            "fell as was said"
        )
        headline(figure, title, about)
    scores = "; ".join(
        f"{each.name}: accuracy {each.scores.values['accuracy']:.3f}, "
        f"Brier score {each.scores.values['brier']:.3f}"
        for each in everyone
    )
    return Drawing("validation", figure, title, f"Scores of predictions. {scores}.")


def _draw_accuracy(axes: Axes, everyone: Sequence[Judged], engines: int) -> None:
    """A dot a predictor, filled for accuracy and open for balanced accuracy."""
    for number, each in enumerate(everyone):
        color = engine_marks(plain_name(each.name))[0] if number < engines else DARK
        for name, aside, face in (
            ("accuracy", -0.12, color),
            ("balanced_accuracy", 0.12, "white"),
        ):
            value, band = each.scores.values[name], each.scores.bands[name]
            if np.isfinite(band[0]):
                axes.plot(band, [number + aside] * 2, color=color, linewidth=1.2)
            axes.plot(value, number + aside, "o", color=color, markerfacecolor=face, markersize=5)
    axes.set_yticks(range(len(everyone)), [each.name for each in everyone])
    axes.set_ylim(len(everyone) - 0.5, -0.5)
    axes.set_xlabel("share of tests [-]")
    axes.set_title("Right predictions")


def _draw_reliability(axes: Axes, found: Validation) -> None:
    """The share of tests that fell, over the probability that was given to them."""
    axes.plot([0.0, 1.0], [0.0, 1.0], color=GREY, linewidth=0.8)
    for number, each in enumerate(found.engines):
        rows = reliability(each.said.probability, found.tests.overturned[each.tests])
        fell, count = (np.array([int(row[n]) for row in rows]) for n in ("overturned", "tests"))
        low, high = wilson_interval(fell, count)
        at = np.array([row["predicted"] for row in rows])
        share = np.array([row["observed"] for row in rows])
        color, mark = engine_marks(plain_name(each.name))
        reach = np.clip([share - low, high - share], 0.0, None)
        axes.errorbar(
            at,
            share,
            yerr=reach,
            color=color,
            marker=mark,
            markersize=4.0,
            linewidth=1.0,
            linestyle=DASHES[number % len(DASHES)],
            label=each.name,
        )
        if len(found.engines) == 1:
            for x, top, tests in zip(at, high, count, strict=True):
                axes.annotate(
                    f"{tests:,}",
                    (x, top),
                    xytext=(0, 5),
                    textcoords="offset points",
                    ha="center",
                    fontsize=7,
                    color=DARK,
                )
    axes.set_xlim(-0.05, 1.05)
    axes.set_ylim(-0.05, 1.13)
    axes.set_xlabel("predicted probability of overturning [-]")
    axes.set_ylabel("share that overturned [-]")
    axes.set_title("Reliability")
    if len(found.engines) > 1:
        axes.legend(loc="lower right")


def _draw_fragility(found: Validation) -> Drawing:
    """Fragility functions over each intensity measure, a panel each."""
    with style():
        panels = len(found.shakings)
        figure, grid = subplots(1, panels, (1.2 + 4.0 * panels, 3.2), sharey=True)
        for number, (axes, shaking) in enumerate(zip(grid[0], found.shakings, strict=True)):
            _draw_panel(axes, found, shaking, number)
        grid[0, 0].set_ylabel("probability of overturning [-]")
        legend_below(figure, *grid[0])
        texts = [_medians(found, shaking, at) for at, shaking in enumerate(found.shakings)]
        title = texts[-1]
        about = "Lognormal functions of greatest likelihood; bands: 5th to 95th percentile over "
        about += "ground motions; dots: share of tests that overturned"
        headline(figure, title, about)
    return Drawing("validation-fragility", figure, title, f"{'. '.join(texts)}.")


def _draw_panel(axes: Axes, found: Validation, shaking: Shaking, number: int) -> None:
    """One intensity measure."""
    measured, seen = measure(shaking.column), shaking.seen
    low, high = float(seen.intensity.min()), float(seen.intensity.max())
    intensity = np.geomspace(low / 1.05, high * 1.05, POINTS)
    across = intensity * measured.size
    logarithmic(axes.xaxis)
    if shaking.band is not None and seen.record_count >= LEAST_RECORDS:
        ends = shaking.band.probabilities(intensity)
        axes.fill_between(across, *ends, color=OBSERVED, alpha=0.25, linewidth=0.0)
    if shaking.fit.dispersion > 0.0:
        axes.plot(
            across,
            shaking.fit.probability(intensity),
            color=OBSERVED,
            linewidth=2.2,
            label="observed",
        )
    _dots(axes, seen, measured.size)
    for at, each in enumerate(found.engines):
        fit, band = each.curves[number].fit, each.curves[number].band
        color = engine_marks(plain_name(each.name))[0]
        if band is not None and len(found.engines) <= MOST_BANDS:
            ends = band.probabilities(intensity)
            axes.fill_between(across, *ends, color=color, alpha=0.12, linewidth=0.0)
        if fit.dispersion > 0.0:
            axes.plot(
                across,
                fit.probability(intensity),
                color=color,
                linestyle=DASHES[at % len(DASHES)],
                label=each.name,
            )
    axes.set_xlim(across[0], across[-1])
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel(measured.label)


def _dots(axes: Axes, seen: Observations, size: float) -> None:
    """Tests of neighbouring intensities gathered, and the share of them that overturned."""
    at, share = gathered(seen)
    axes.plot(at * size, share, "o", color=OBSERVED, markersize=5.0, markeredgecolor="white")


def _medians(found: Validation, shaking: Shaking, number: int) -> str:
    """The median that was observed, and those that are predicted."""
    measured = measure(shaking.column)
    if not shaking.fit.dispersion > 0.0:
        return f"No fragility function over {measured.name}: {shaking.fit.verdict.value}"
    texts = [
        f"{each.name} {measured.text(each.curves[number].fit.median)}"
        for each in found.engines
        if each.curves[number].fit.dispersion > 0.0
    ]
    said = f"; predicted: {', '.join(texts)}" if texts else ""
    at = measured.text(shaking.fit.median)
    return f"Half of the blocks fell at a {measured.name} of {at}{said}"
