"""The figure of engines beside poses that were observed: errors over time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from warprock.figures.drawing import Drawing
from warprock.figures.palette import DASHES, SERIES
from warprock.figures.sheet import headline, legend_below, style, subplots

PANELS = (
    ("position_error_mm", "error of the position [mm]"),
    ("rotation_error_deg", "error of the rotation [deg]"),
)
"""What a panel shows, and its label."""
SIZE = (9.6, 3.8)
"""Width and height [inch]."""
MOST_GONE = 0.5
"""Part of the lanes that must still be seen for a mean over them to be drawn."""


def draw_poses(found: Mapping[str, Any]) -> list[Drawing]:
    """Draws the mean errors of every engine over time.

    Args:
        found: What `verification.checks.compare` returned of a case with observed poses.

    Returns:
        One drawing.
    """
    with style():
        figure, panels = subplots(1, len(PANELS), SIZE, sharex=True)
        for axes, (name, label) in zip(panels.flat, PANELS, strict=True):
            for number, engine in enumerate(found["engines"]):
                told = found["over_time"][engine]
                seen = np.array(told["lanes"]) >= MOST_GONE * max(told["lanes"])
                axes.plot(
                    np.array(told["time_s"])[seen],
                    np.array(told[name])[seen],
                    color=SERIES[number % len(SERIES)],
                    linestyle=DASHES[number % len(DASHES)],
                    label=engine,
                )
            axes.set_ylabel(label)
            axes.set_xlabel("time since the first sample [s]")
            axes.set_xlim(left=0.0)
            axes.set_ylim(bottom=0.0)
        legend_below(figure, panels.flat[0], columns=4)
        title = _message(found)
        lanes = len(found["rows"]) // len(found["engines"])
        about = f"{found['case']}: means over {lanes} lanes, as long as half of them are seen"
        headline(figure, title, about)
    return [Drawing("poses", figure, title, f"Errors over time. {title}. {about}.")]


def _message(found: Mapping[str, Any]) -> str:
    """How far the nearest and the farthest engine are from what was seen."""
    means = {
        engine: float(
            np.mean([row["position_error_mm"] for row in found["rows"] if row["engine"] == engine])
        )
        for engine in found["engines"]
    }
    best = min(means, key=lambda engine: means[engine])
    worst = max(means, key=lambda engine: means[engine])
    said = f"{best} is {means[best]:.3g} mm from what was seen, in the mean"
    return said if best == worst else f"{said}; {worst} is {means[worst]:.3g} mm"
