"""The acceleration of the base above rotation histories: that of the lanes shown, in g."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.figures.palette import DARK, DASHES
from warprock.model.motion import MotionKind
from warprock.running.case_run import CaseRun
from warprock.units import GRAVITY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS = 4001
STRIP = 0.85
"""Height of a strip [inch]."""


@dataclasses.dataclass(frozen=True)
class Bases:
    """The bases of the lanes shown.

    Attributes:
        run: The run.
        lanes: Numbers of lanes with different motions, shape [panel][curve]; one panel where all
            lanes share one motion, none where the base is still.
        shared: Whether all lanes share one motion.
    """

    run: CaseRun
    lanes: tuple[tuple[int, ...], ...]
    shared: bool

    @classmethod
    def of(cls, run: CaseRun, lanes: npt.NDArray[np.intp]) -> Bases:
        """The bases of lanes, shape [panel, curve]."""
        if run.lane_set.motions.kind is MotionKind.STILL:
            return cls(run, (), shared=True)
        times = np.linspace(0.0, run.case.sample_times.duration, POINTS)
        motions = run.lane_set.motions.components[0]
        seen: dict[bytes, int] = {}
        first = {}
        for lane in np.unique(lanes):
            values = motions.acceleration(times, int(lane))
            key = values.tobytes() + motions.velocity_steps[0][lane].tobytes()
            first[int(lane)] = seen.setdefault(key, int(lane))
        rows = tuple(tuple(dict.fromkeys(first[int(lane)] for lane in row)) for row in lanes)
        return cls(run, rows[:1] if len(seen) == 1 else rows, shared=len(seen) == 1)

    def heights(self, rows: int) -> list[float]:
        """Heights of all rows of axes for some rows of panels [inch]."""
        panel = 3.2 if rows == 1 else 1.8 if rows <= 4 else 1.4
        if self.shared:
            return [STRIP + 0.3] * len(self.lanes) + [panel] * rows
        return [STRIP, panel] * rows

    def split(self, grid: Any, windows: int) -> tuple[Any, Any]:
        """Axes of the strips and of the panels, shape [panel, window]; others are hidden."""
        if self.shared:
            head, rest = grid[: len(self.lanes)], grid[len(self.lanes) :]
            for axes in head[:, windows:].flat:
                axes.set_visible(False)
            return head[:, :windows], rest.reshape(-1, windows)
        strips, panels = (grid[start::2].reshape(-1, windows) for start in (0, 1))
        for axes in strips[len(self.lanes) :].flat:
            axes.set_visible(False)
        return strips[: len(self.lanes)], panels

    def draw(self, axes: Axes, panel: int, window: tuple[float, float]) -> None:
        """One strip."""
        motions = self.run.lane_set.motions.components[0]
        times = np.linspace(*window, POINTS)
        for number, lane in enumerate(self.lanes[panel]):
            values = motions.acceleration(times, lane) / GRAVITY
            axes.plot(times, values, color=DARK, linewidth=0.9, linestyle=DASHES[number])
        axes.set_xlim(*window)
        axes.margins(y=0.1)
        axes.locator_params(axis="y", nbins=3)
        if window[0] == 0.0:
            several = len(self.run.lane_set.motions.axes) > 1
            axes.set_ylabel("base x [g]" if several else "base [g]")

    def start(self, panel: int) -> str:
        """What no curve can show: the velocity steps that the bases of a panel start with."""
        motions = self.run.lane_set.motions.components[0]
        lanes = self.lanes[0 if self.shared else panel] if self.lanes else ()
        steps = [float(motions.velocity_steps[0][lane]) for lane in lanes]
        if not any(steps):
            return ""
        return f"base after a velocity step of {' / '.join(f'{step:.3g}' for step in steps)} m/s"
