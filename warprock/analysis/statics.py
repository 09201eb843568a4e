"""What single blocks bear that are led outwards, lane by lane and side by side."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.errors import InputError, Said
from warprock.model.hold import SIDES
from warprock.model.lanes import Lanes
from warprock.model.statics import Capacity, Curve, Leaning, capacity, curve, leaning

AT_ONCE = 2048
"""Lanes at once: 33 points of up to 37 pieces each, 20 MB an array."""
EITHER = "either"
"""The side of blocks that are the same to both."""


@dataclasses.dataclass(frozen=True)
class Statics:
    """What the blocks of a case bear, a row a lane and side.

    Attributes:
        case: The case.
        lane_set: Its lanes.
        lane: Number of the lane, shape [row].
        side: Side to which it leans, "left" or "right"; "either" where it does not matter.
        found: What it bears.
    """

    case: Case
    lane_set: LaneSet
    lane: npt.NDArray[np.intp]
    side: npt.NDArray[np.str_]
    found: Capacity

    def curve_of(self, row: int, most: float) -> Curve:
        """Moment over lean of a row up to a lean [rad]."""
        return curve(self._leaning(row), most)

    def curve_without_ties(self, row: int, most: float) -> Curve | None:
        """Moment over lean of a block without its ties; None of a block that has none."""
        box = self._leaning(row)
        return None if box.ties is None else curve(dataclasses.replace(box, ties=None), most)

    def _leaning(self, row: int) -> Leaning:
        """The block of a row, alone."""
        lane = self.lane[row : row + 1]
        return leaning(self.lane_set.lanes.take(lane), SIDES.get(str(self.side[row]), 1.0))


def run_statics(case: Case) -> Statics:
    """What the blocks of a case bear.

    Args:
        case: A case of single boxes in the plane.

    Raises:
        InputError: It has others.
    """
    lane_set = expand_lanes(case)
    lanes = lane_set.lanes
    for wrong, key, got in (
        (lanes.assembly is not None, "assembly", "an assembly"),
        (lanes.stacked, "block", "a stack"),
        (lanes.bodies, "block", "a body that is no box"),
        (lanes.spatial, "block", "a block in space"),
        (lanes.held == ("strip",), "strip", "a strip of wall"),
        (lanes.held == ("ground",), "ground", "compliant ground"),
    ):
        if wrong:
            allowed = "must be a single box in the plane"
            if key == "ground":
                allowed = "must be left out: statics are those of a block on a rigid base"
            if key == "assembly":
                allowed += "; warprock limit finds what an assembly bears"
            raise InputError(case.source_of(key), key, Said(got), allowed)
    numbers = np.arange(lanes.lane_count)
    sides = ("right",) if lanes.hold is None or lanes.hold.frame is not None else tuple(SIDES)
    parts = [
        (numbers[free], np.full(int(free.sum()), side), _capacity(lanes, numbers[free], side))
        for side in sides
        if (free := _may_turn(lanes, side)).any()
    ]
    lane = np.concatenate([part[0] for part in parts])
    order = np.argsort(lane, kind="stable")
    side = np.concatenate([part[1] for part in parts])
    whole = [np.concatenate(each)[order] for each in zip(*(part[2] for part in parts), strict=True)]
    named = side[order] if len(sides) > 1 else np.full(len(lane), EITHER)
    return Statics(case, lane_set, lane[order], named, Capacity(*whole))


def _may_turn(lanes: Lanes, side: str) -> npt.NDArray[np.bool_]:
    """Whether no wall stands at a side, shape [lane]."""
    if lanes.hold is None or lanes.hold.wall is None:
        return np.ones(lanes.lane_count, dtype=bool)
    return np.asarray(lanes.hold.wall != SIDES[side])


def _capacity(lanes: Lanes, numbers: npt.NDArray[np.intp], side: str) -> Capacity:
    """What some of the lanes bear that are led to a side."""
    parts = [
        capacity(leaning(lanes.take(numbers[at : at + AT_ONCE]), SIDES[side]))
        for at in range(0, len(numbers), AT_ONCE)
    ]
    return Capacity(*(np.concatenate(each) for each in zip(*parts, strict=True)))
