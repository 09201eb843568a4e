"""Peak rotations of a run and what became of its lanes: as marks in figures, and in words."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.model.response import USABLE, Outcome
from warprock.run.case_run import CaseRun

Array = npt.NDArray[np.float64]

UNUSABLE, FAR = -1, 9
"""Codes beside those of `Outcome`: no usable number; beyond `FARTHEST`, yet not overturned."""
FARTHEST = 2.0
"""Rotation ratio beyond which a block that has not overturned is falling when its run ends."""
OVERTURNED_AT = 1.15
"""Rotation ratio at which overturned lanes are marked, unless a standing one went as far."""
OUTCOMES: dict[int, tuple[str, str, bool]] = {
    Outcome.AT_REST: ("at rest at the end", "o", True),
    Outcome.ROCKING: ("still rocking at the end", "o", False),
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
    """

    ratio: Array
    outcome: npt.NDArray[np.intp]

    @property
    def raised(self) -> npt.NDArray[np.bool_]:
        """Which lanes are marked above all others."""
        return np.isin(self.outcome, RAISED)

    @property
    def top(self) -> float:
        """Upper end of the ordinate."""
        return 1.07 * (self.raised_at if self.raised.any() else self.largest_standing)

    @property
    def raised_at(self) -> float:
        """Where overturned lanes are marked, whatever they reached."""
        return max(OVERTURNED_AT, round(1.1 * self.largest_standing, 2))

    @property
    def largest_standing(self) -> float:
        """Largest ratio of the other lanes; a little above 0 without any."""
        standing = self.ratio[~self.raised]
        return float(np.nanmax(standing, initial=1e-6))

    def message(self, block: int | None = None) -> str:
        """What became of the lanes, and how far those rotated that stand; one line.

        Args:
            block: Which block of stacks the peaks are of, the lowest is 0; None for single blocks.
        """
        count = len(self.outcome)
        of = "the block" if block is None else f"block {block + 1}"
        largest = f"{self.largest_standing:.3g} of the slenderness angle"
        if count == 1:
            return _alone(int(self.outcome[0]), largest, of)
        parts = [
            f"{int(np.sum(self.outcome == code)):,} {verb}"
            for code, verb in LOST.items()
            if np.any(self.outcome == code)
        ]
        if not np.any(~self.raised & (self.outcome != UNUSABLE)):
            return f"Of {count:,} lanes none stands at the end: {', '.join(parts)}"
        if not parts:
            return f"All {count:,} lanes stand; the largest rotation of {of} is {largest}"
        return (
            f"Of {count:,} lanes {', '.join(parts)}; in the others {of} rotates by up to {largest}"
        )


def _alone(outcome: int, largest: str, block: str) -> str:
    """What is said of the one lane of a run."""
    if outcome == UNUSABLE:
        return "The one lane has no usable number"
    said = {
        Outcome.OVERTURNED: "overturns",
        Outcome.SLID_OFF: "slides off",
        FAR: f"is beyond {FARTHEST:g} x its slenderness angle when the run ends",
    }
    if outcome not in said:
        return f"The lane stands; the largest rotation of {block} is {largest}"
    return f"The {'block' if block == 'the block' else 'stack'} {said[outcome]}"


def read_peaks(run: CaseRun, block: int | None = None) -> Peaks:
    """The peaks of a run.

    Args:
        run: The run.
        block: Which block of stacks, the lowest is 0; None for single blocks, and for that block of
            each stack which rotates furthest.
    """
    response = run.response
    ratio = response["peak_rotation"] / run.lane_set.lanes.slenderness_angle
    if block is not None:
        ratio = ratio[:, block]
    elif run.lane_set.lanes.stacked:
        ratio = ratio.max(axis=1)
    usable = np.isin(response["status"], USABLE) & np.isfinite(ratio)
    outcome = np.asarray(response["outcome"], dtype=np.intp)
    outcome = np.where((outcome == Outcome.ROCKING) & (ratio > FARTHEST), FAR, outcome)
    return Peaks(np.where(usable, ratio, np.nan), np.where(usable, outcome, UNUSABLE))
