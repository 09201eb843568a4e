"""What the words of a lane table mean, in one sentence each, as users read them."""

from __future__ import annotations

from typing import NamedTuple

from warprock.model.lanes import Lanes
from warprock.model.response import Outcome, Status

OUTCOMES: dict[Outcome, str] = {
    Outcome.AT_REST: "every block stands still when the run ends",
    Outcome.ROCKING: "a block still moves when the run ends",
    Outcome.OVERTURNED: "a block has fallen over; the lane ends there",
    Outcome.SLID_OFF: (
        "a block has left the face of the one below; in an assembly it has slid by more than its "
        "longest joint, in space until its largest joint lies nowhere over where it was; the lane "
        "ends there, or after `after_collapse`"
    ),
}
"""What has become of a lane when its run ends."""

STATUSES: dict[Status, str] = {
    Status.OK: "the engine's answer, with its estimated error",
    Status.SENSITIVE: (
        "the numbers depend on the time step: chaos, or close to overturning. They are those of "
        "the finest run; do not use one such lane alone"
    ),
    Status.OUTSIDE_MODEL: (
        "the engine's equations leave out something that happened: a contact had to pull, a block "
        "that cannot slide in this engine would have slid, or a prescribed impact needs more "
        "friction than there is"
    ),
    Status.AMBIGUOUS: (
        "one of several possible answers: the block slid with so much friction that rigid contact "
        "has no unique solution (Painleve)"
    ),
    Status.UNSTABLE: "not to be used: the lane gained energy, its time step is too long",
    Status.ITERATION_LIMIT: "not to be used: a contact solve did not settle",
    Status.EVENT_LIMIT: "not to be used: the lane took too many steps or events",
    Status.NONFINITE: "not to be used: the numbers left the range of numbers",
}
"""What a status says of the numbers of a lane."""


class Thing(NamedTuple):
    """What stands or falls, and the words for its fall.

    Attributes:
        noun: What it is.
        fall: What several do, as a verb: overturn.
        fallen: What they have done: overturned.
    """

    noun: str
    fall: str
    fallen: str


BLOCK = Thing("block", "overturn", "overturned")
STACK = BLOCK._replace(noun="stack")
ASSEMBLY = Thing("assembly", "collapse", "collapsed")


def thing_of(lanes: Lanes) -> Thing:
    """What lanes are of."""
    if lanes.assembly is not None:
        return ASSEMBLY
    return STACK if lanes.stacked else BLOCK


def lane_count_text(count: int) -> str:
    """A number of lanes in words: 1 lane, 1,200 lanes."""
    return f"{count:,} lane{'s' * (count != 1)}"
