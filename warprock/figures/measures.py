"""The figure of measures: the factor of each on the yearly rate, with its band."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warprock.analysis.measures import Measures
from warprock.figures.drawing import Drawing
from warprock.figures.palette import BLACK, BLUE
from warprock.figures.scales import logarithmic
from warprock.figures.sheet import headline, style, subplots

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_measures(found: Measures, title: str) -> list[Drawing]:
    """Draws the factor of each measure, the one that lowers the rate most above.

    Args:
        found: The measures.
        title: What it says: the first sentence of their finding.

    Returns:
        One drawing; none where no factor is known.
    """
    known = [each for each in found.effects if np.isfinite(each.factor)]
    if not known:
        return []
    with style():
        figure, panels = subplots(1, 1, (7.2, 0.9 + 0.34 * len(known)))
        plot_measures(panels[0, 0], found)
        about = f"{found.case.title}; {found.engine}. Line: 5th to 95th percentile over records"
        headline(figure, title, about)
    texts = "; ".join(f"{each.measure.name}: {each.factor:.3g}" for each in known)
    return [Drawing("measures", figure, title, f"Factors on the yearly rate. {title}. {texts}.")]


def bare_measures(found: Measures) -> Drawing | None:
    """The factors without a title, for a page that has one; None where no factor is known."""
    known = [each for each in found.effects if np.isfinite(each.factor)]
    if not known:
        return None
    with style():
        figure, panels = subplots(1, 1, (7.2, 0.6 + 0.3 * len(known)))
        plot_measures(panels[0, 0], found)
    return Drawing("measures", figure, "Measures", "Factors of measures on the yearly rate.")


def plot_measures(axes: Axes, found: Measures, group: int = 0) -> None:
    """Draws the factor of each measure.

    Args:
        axes: Where to.
        found: The measures.
        group: Number of the group: 0, there is one.
    """
    assert group == 0
    known = [each for each in found.effects if np.isfinite(each.factor)]
    for number, each in enumerate(known):
        if np.isfinite(each.band[0]):
            axes.plot(each.band, (number, number), color=BLUE, linewidth=1.6)
        axes.plot(each.factor, number, "o", color=BLUE, markersize=6.0)
    axes.axvline(1.0, color=BLACK, linestyle=":", linewidth=1.0)
    logarithmic(axes.xaxis)
    axes.set_yticks(range(len(known)), [each.measure.name for each in known])
    axes.set_ylim(len(known) - 0.5, -0.5)
    axes.set(xlabel="factor on the yearly rate [-]", ylabel="")
