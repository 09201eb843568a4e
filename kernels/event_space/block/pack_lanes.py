"""Rows that a pack of lanes keeps for each of its places, besides the structs of other files."""

import warp as wp

from warprock.kernels.algebra.vectors import Quaternion, Vector
from warprock.kernels.event_space.block.trial import State


@wp.struct
class Before:
    """The part of the state before the last step taken that samples need; see `State`."""

    x: Vector
    q: Quaternion
    v: Vector
    w: Vector
    time: real
    stance: int


@wp.struct
class Place:
    """A place of a pack and the lane in it.

    Attributes:
        lane: Number of the lane.
        sample: Number of its next sample.
        steps: Steps that it has taken.
        step_limit, longest_step, rest_gap: See `Lane`.
        until: Time of its next sample [s].
        uplift_time, rest_time: See `Seen` of event_space/block/seen.py.
        due: Whether the scalar loop has to handle the lane.
        busy: Whether the lane needs a step of event_space/block/step.py.
    """

    lane: int
    sample: int
    steps: int
    step_limit: int
    longest_step: real
    rest_gap: real
    until: real
    uplift_time: real
    rest_time: real
    due: bool
    busy: bool


@wp.func(inline=True)
def keep_state(s: State) -> Before:
    """The part of a state that is kept."""
    return Before(s.x, s.q, s.v, s.w, s.time, s.stance)


@wp.func(inline=True)
def state_before(b: Before) -> State:
    """The state before the last step, with the fields that are kept."""
    s = State()
    s.x = b.x
    s.q = b.q
    s.v = b.v
    s.w = b.w
    s.time = b.time
    s.stance = b.stance
    return s
