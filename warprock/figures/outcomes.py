"""Peak rotations of a run and what became of its lanes: as marks in figures, and in words."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.figures.palette import DARK
from warprock.figures.scales import three_digits
from warprock.model.ratios import NO_TURN, peak_ratio
from warprock.model.response import USABLE, Outcome
from warprock.model.words import ASSEMBLY, BLOCK, Thing, thing_of
from warprock.running.case_run import CaseRun

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

UNUSABLE, FAR = -1, 9
"""Codes beside those of `Outcome`: no usable number; beyond `FARTHEST`, yet not overturned."""
FARTHEST = 2.0
"""Rotation ratio beyond which a block that has not overturned is falling when its run ends."""
OVERTURNED_AT = 1.15
"""Rotation ratio at which overturned lanes are marked, unless a standing one went as far."""
SMALL, SEVERAL = 1e-3, 4
"""Rotation ratio below which a logarithmic scale is linear, and lanes that ask for such a scale."""
OUTCOMES: dict[int, tuple[str, str, bool]] = {
    Outcome.AT_REST: ("at rest at the end", "o", True),
    Outcome.ROCKING: ("still moving at the end", "o", False),
    Outcome.OVERTURNED: ("overturned", "^", True),
    Outcome.SLID_OFF: ("a block slid off", "v", True),
    FAR: (f"beyond {FARTHEST:g}, not overturned", "^", False),
}
"""Outcome -> name, marker, and whether it is filled."""
RAISED = (Outcome.OVERTURNED, Outcome.SLID_OFF, FAR)
"""Outcomes that are marked above all others, whatever rotation they reached."""
LOST: dict[int, str] = {
    Outcome.OVERTURNED: "overturn",
    Outcome.SLID_OFF: "slide off",
    FAR: f"are beyond {FARTHEST:g} x slenderness angle when the run ends",
    UNUSABLE: "have no usable number",
}
"""What is said of lanes that do not stand at the end."""


@dataclasses.dataclass(frozen=True)
class Peaks:
    """Peaks to draw, shape [lane] each.

    Attributes:
        ratio: Largest rotation / slenderness angle; NaN where it may not be used.
        outcome: Codes of `Outcome`, `FAR` or `UNUSABLE`.
        thing: What they are of.
    """

    ratio: Array
    outcome: npt.NDArray[np.intp]
    thing: Thing = BLOCK

    @property
    def outcomes(self) -> Mapping[int, tuple[str, str, bool]]:
        """Outcome -> name, marker, and whether it is filled."""
        _, marker, filled = OUTCOMES[Outcome.OVERTURNED]
        return {**OUTCOMES, Outcome.OVERTURNED: (self.thing.fallen, marker, filled)}

    @property
    def raised(self) -> npt.NDArray[np.bool_]:
        """Which lanes are marked above all others."""
        return np.isin(self.outcome, RAISED)

    @property
    def top(self) -> float:
        """Upper end of the ordinate."""
        beyond = 1.35 if self.logarithmic else 1.07
        return beyond * (self.raised_at if self.raised.any() else max(self.largest_standing, SMALL))

    @property
    def raised_at(self) -> float:
        """Where overturned lanes are marked, whatever they reached."""
        if self.logarithmic:
            return max(2.0, round(1.6 * self.largest_standing, 2))
        return max(OVERTURNED_AT, round(1.1 * self.largest_standing, 2))

    @property
    def logarithmic(self) -> bool:
        """Whether a quarter of what moved is so small that few large peaks would hide it."""
        moved = self.ratio[~self.raised & (self.ratio > SMALL)]
        return len(moved) >= SEVERAL and bool(
            np.quantile(moved, 0.25) < 0.05 * self.largest_standing
        )

    def scale(self, axes: Axes) -> None:
        """Scales the ordinate of a panel, with a strip for what fell above all others.

        Args:
            axes: The panel.
        """
        from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

        ticks = None
        if self.logarithmic:
            axes.set_yscale("symlog", linthresh=SMALL, linscale=0.35)
            decades = [0.0, SMALL, 0.01, 0.1, 1.0]
            ticks = [tick for tick in decades if tick <= max(self.largest_standing, 0.1)]
        axes.set_ylim(-0.2 * SMALL if self.logarithmic else -0.03 * self.top, self.top)
        if ticks is None:
            ends = axes.get_yticks()
            ticks = [tick for tick in ends if 0.0 <= tick < 0.97 * self.highest_tick]
        names = {tick: f"{tick:.4g}" for tick in ticks}
        if self.raised.any():
            names[self.raised_at] = self.thing.fallen if self.only_overturned else "fallen"
            axes.axhline(1.0, color=DARK, linewidth=0.8, linestyle=":")
        axes.yaxis.set_major_locator(FixedLocator(list(names)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: names.get(value, "")))
        axes.yaxis.set_minor_locator(NullLocator())

    @property
    def only_overturned(self) -> bool:
        """Whether all lanes that are marked above the others overturned."""
        return bool(np.all(self.outcome[self.raised] == Outcome.OVERTURNED))

    @property
    def highest_tick(self) -> float:
        """Where the numbers of the ordinate end."""
        return self.raised_at if self.raised.any() else np.inf

    @property
    def largest_standing(self) -> float:
        """Largest ratio of the other lanes; a little above 0 without any."""
        standing = self.ratio[~self.raised]
        return float(np.nanmax(standing, initial=NO_TURN))

    def message(self, block: int | None = None) -> str:
        """What became of the lanes, and how far those rotated that stand; one line.

        Args:
            block: Which block of stacks the peaks are of, the lowest is 0; None for single blocks.
        """
        count = len(self.outcome)
        of = "the block" if block is None else f"block {block + 1}"
        if self.thing is ASSEMBLY:
            of = "a block"
        largest = f"{three_digits(self.largest_standing)} of the slenderness angle"
        if count == 1:
            turn = f"the largest rotation of {of} is {largest}"
            if self.largest_standing <= NO_TURN:
                turn = f"{of} does not rotate"
            return _alone(int(self.outcome[0]), turn, self.thing)
        parts = [
            f"{int(np.sum(self.outcome == code)):,} {verb}"
            for code, verb in {**LOST, Outcome.OVERTURNED: self.thing.fall}.items()
            if np.any(self.outcome == code)
        ]
        if not np.any(~self.raised & (self.outcome != UNUSABLE)):
            return f"Of {count:,} lanes none stands at the end: {', '.join(parts)}"
        if not parts:
            who = "Both lanes" if count == 2 else f"All {count:,} lanes"
            if self.largest_standing <= NO_TURN:
                return f"{who} stand; none rotates"
            return f"{who} stand; the largest rotation of {of} is {largest}"
        least = largest.startswith("below")
        return (
            f"Of {count:,} lanes {', '.join(parts)}; in the others {of} rotates by "
            f"{'' if least else 'up to '}{largest}"
        )


def _alone(outcome: int, turn: str, thing: Thing) -> str:
    """What is said of the one lane of a run; `turn` is how far it rotates."""
    if outcome == UNUSABLE:
        return "The one lane has no usable number"
    said = {
        Outcome.OVERTURNED: f"{thing.fall}s",
        Outcome.SLID_OFF: "slides off",
        FAR: f"is beyond {FARTHEST:g} x its slenderness angle when the run ends",
    }
    if outcome not in said:
        return f"The lane stands; {turn}"
    return f"The {thing.noun} {said[outcome]}"


def read_peaks(run: CaseRun, block: int | None = None) -> Peaks:
    """The peaks of a run.

    Args:
        run: The run.
        block: Which block of stacks, the lowest is 0; None for single blocks, and for that block of
            each stack which rotates furthest.
    """
    response = run.response
    ratio = peak_ratio(response, run.lane_set.lanes)
    if block is not None:
        ratio = ratio[:, block]
    elif run.lane_set.lanes.stacked:
        ratio = ratio.max(axis=1)
    usable = np.isin(response["status"], USABLE) & np.isfinite(ratio)
    outcome = np.asarray(response["outcome"], dtype=np.intp)
    outcome = np.where((outcome == Outcome.ROCKING) & (ratio > FARTHEST), FAR, outcome)
    return Peaks(
        np.where(usable, ratio, np.nan),
        np.where(usable, outcome, UNUSABLE),
        thing_of(run.lane_set.lanes),
    )
