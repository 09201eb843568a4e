"""Impacts of a stack in the plane that sticks at all its contacts before and after.

Such a stack is a chain (event/stack/links.py) on both sides of the impact. The guess and its
corrections are those of `solve` in event/stack/contact.py; angular velocities of the chain take the
place of the impulses at its interfaces, and its factors serve the step that follows. Where a
contact slides or lets go no such state obeys the law, and `solve` finds one.
"""

import warp as wp

from warprock.kernels.event.stack.contact import CORRECTIONS, RoundOff
from warprock.kernels.event.stack.links import hold_together, link, sum_moments
from warprock.kernels.event.stack.rocking_end import Loads, face_load, reach_of
from warprock.kernels.event.stack.state import State, Trial
from warprock.kernels.shape.stack import (
    CLOSED,
    MINUS,
    OPEN,
    PLUS,
    Blocks,
    Counts,
    Triples,
    side_of,
)


@wp.func
def impulses_of(
    blocks: wp.ref[Blocks], n: wp.ref[State], before: Triples, after: Triples
) -> Loads:  # fmt: skip
    """Impulses and moments of them at the interfaces [N s, N m s] that change velocities."""
    loads = Loads()
    fx, fz, moments = sum_moments(blocks, n.chain, after - before)
    loads.fx = fx
    loads.fz = fz
    loads.sine = n.pose.sine
    loads.cosine = n.pose.cosine
    above = real(0.0)
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        above = above + moments[k]
        loads.moment[k] = above
    return loads


@wp.func
def correct_ends(
    blocks: wp.ref[Blocks], n: wp.ref[State], before: Triples, hold: Counts, dust: RoundOff
):  # fmt: skip
    """Ends held after an impact that break the law no more, see `correct` in contact.py.

    Args:
        blocks: The blocks.
        n: State with the pose and the ends that touch in the impact, and the velocities after it.
        before: Velocities before it.
        hold: Ends held in it.
        dust: What counts as round-off.

    Returns:
        Held ends; whether they are others; whether a contact slides or lets go.
    """
    ends = hold
    loads = impulses_of(blocks, n, before, n.velocity)
    changes = bool(False)
    fails = bool(False)
    for k in range(BLOCKS):
        normal, along = face_load(blocks, n.chain.under, loads, k)
        behind, ahead = reach_of(blocks, n.pose, k)
        wide = ahead + behind
        if hold[k] == CLOSED:
            plus = fused(behind, normal, -loads.moment[k]) < -dust.impulse * wide
            minus = fused(ahead, normal, loads.moment[k]) < -dust.impulse * wide
            fails = fails or (plus and minus)
            ends[k] = wp.where(plus, MINUS, wp.where(minus, PLUS, CLOSED))
        else:
            fails = fails or normal < -dust.impulse
            if n.pose.touch[k] == CLOSED:
                rise = n.velocity[3 * k + 2]
                if k > 0:
                    rise = rise - n.velocity[3 * k - 1]
                if side_of(hold[k]) * rise * wide < -dust.velocity:
                    ends[k] = CLOSED
        changes = changes or ends[k] != hold[k]
        slides = fused(blocks.friction[k], normal, -size(along)) < -dust.impulse
        fails = fails or (slides and ends[k] == hold[k])
    return ends, changes, fails


@wp.func(inline=False)
def strike(
    blocks: wp.ref[Blocks], t: wp.ref[Trial], guess: Counts, dust: RoundOff, n: wp.ref[State]
) -> bool:  # fmt: skip
    """Finds an impact in which all contacts stick.

    Args:
        blocks: The blocks.
        t: The step, along which they stick.
        guess: Ends that are likely to be held.
        dust: What counts as round-off.
        n: State with the pose at its end and the ends that touch; with those held, the chain and
            the velocities after the impact, if there is one.

    Returns:
        Whether there is one.
    """
    hold = guess
    left = int(CORRECTIONS + 1)
    for k in range(BLOCKS):
        left = wp.where(hold[k] == OPEN, 0, left)
    obeys = bool(False)
    while left > 0:
        left -= 1
        link(blocks, n.pose, hold, n.chain)
        n.velocity = hold_together(blocks, n.chain, t.velocity)
        ends, changes, fails = correct_ends(blocks, n, t.velocity, hold, dust)
        obeys = not (changes or fails)
        left = wp.where(obeys or fails, 0, left)
        if not obeys:
            hold = ends
    if obeys:
        n.pose.touch = hold
    return obeys
