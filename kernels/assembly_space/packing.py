"""The meetings of an assembly in space in the order in which a sweep takes them.

A meeting is a joint, or a pair without one, that has contacts in a step. Each has a colour that no
other one of its two blocks has, but for blocks that are fixed. WIDTH meetings of one colour make a
pack: a sweep takes them side by side, by vector code, and all contacts of theirs one after the
other, so that it reads and writes the velocities of a block once for them.

The contacts of a pack are rows: one contact of every meeting, all their numbers together. Where a
meeting has fewer contacts than others of its pack, or a pack fewer meetings, there are contacts of
zeros, in the latter case between two blocks that are none.
"""

import warp as wp

from warprock.kernels.assembly.meeting import BLOCK_COUNT, JOINT_COUNT, NONE, Near
from warprock.kernels.assembly_space.contact import (
    Apart,
    Given,
    couple_of,
    give,
    inner,
    push,
    relative,
    row_of,
)
from warprock.kernels.assembly_space.meeting import Laid, Pack, Sides, Step
from warprock.kernels.launch.address import address_of

WIDTH = 8
"""Meetings of a pack: a vector of 512 bits in float64."""

COUPLE = 60
"""Numbers of two blocks as a sweep takes them, the fields of `Couple`."""

CONTACT = 13
"""Numbers of a contact as a sweep takes it, the fields of `Row`."""

CLOSING = (CONTACT - 1) * WIDTH
"""Where the last of them stands in a row: `closing` of each contact."""

IMPULSE = 6
"""Numbers of a contact's impulse, the fields of `Impulse`."""

NORMAL, ALONG, ACROSS = (number * WIDTH for number in range(CONTACT, CONTACT + 3))
"""Where the first three of them stand in a row: n, t and s of each contact."""

NUMBERS = (CONTACT + IMPULSE) * WIDTH
"""Numbers of a row: those of its contacts and of their impulses."""

FADES = real(0.99)
"""What is left of a contact's impulses where contacts are found anew.
Forces that are not unique drift from step to step: a wall with a return then falls at up to 5 %
less than its load. With friction above 1 they drift far: a column that rocks on an edge may come to
stand on one corner of it, and to bear on the opposite one of its upper edge. About the line through
both it is then free to turn. What fades drifts back."""

COLOURS = 62
"""Colours with packs of several meetings; what finds none left has a pack of its own."""


LEFT = NONE - 1
"""In `order` a contact of the last step that none has replaced; `NONE` where a row has zeros."""


@wp.func
def corner_at(turn: int, count: int) -> int:
    """The corner of a polygon that is taken at a turn: every second one, then the others."""
    half = (count + 1) / 2
    return wp.where(turn < half, 2 * turn, 2 * (turn - half) + 1)


@wp.func
def colour_of(laid: Laid, lane: int, a: int, b: int) -> int:
    """The first colour that neither of two blocks has, which they have from now on."""
    one, none = wp.int64(1), wp.int64(0)
    left = laid.colours[lane, a] | laid.colours[lane, b]
    colour = int(0)
    while colour < COLOURS and left & one != none:
        left = left >> one
        colour += 1
    mark = one << wp.int64(colour)
    # What is fixed does not move: all may touch it side by side.
    if laid.hefts[lane, a].root > real(0.0):
        laid.colours[lane, a] = laid.colours[lane, a] | mark
    if laid.hefts[lane, b].root > real(0.0):
        laid.colours[lane, b] = laid.colours[lane, b] | mark
    return colour


@wp.func
def place_of(laid: Laid, lane: int, sides: Sides, contacts: int, step: wp.ref[Step]) -> int:
    """A place for a meeting in the packs of a step; `NONE` where there is no room."""
    colour = colour_of(laid, lane, sides.a, sides.b)
    pack = laid.open[lane, colour]
    closed = pack == NONE or colour == COLOURS
    if not closed:
        closed = laid.packs[lane, pack].count == WIDTH
    if closed:
        if step.packs >= laid.packs.shape[1]:
            step.full = 1
            return NONE
        pack = step.packs
        step.packs += 1
        laid.packs[lane, pack] = Pack()
        laid.open[lane, colour] = pack
        none = int(laid.sizes[lane, BLOCK_COUNT]) + 1
        for i in range(WIDTH):
            laid.sides[lane, pack * WIDTH + i] = Sides(none, none)
    own = laid.packs[lane, pack]
    place = pack * WIDTH + own.count
    laid.sides[lane, place] = sides
    own.count += 1
    own.depth = wp.max(own.depth, contacts)
    laid.packs[lane, pack] = own
    return place


@wp.func
def pack_up(laid: Laid, lane: int, near: Near, step: wp.ref[Step]):
    """Puts the meetings of a step into packs."""
    for k in range(laid.sizes[lane, BLOCK_COUNT] + 1):
        laid.colours[lane, k] = wp.int64(0)
    for colour in range(COLOURS + 1):
        laid.open[lane, colour] = NONE
    step.packs = 0
    for joint in range(laid.sizes[lane, JOINT_COUNT]):
        link = laid.links[lane, joint]
        count = laid.joined[lane, joint].count
        if count > 0:
            place = place_of(laid, lane, Sides(link.a, link.b), count, step)
            laid.joined[lane, joint].place = place
    for p in range(near.pairs):
        pair = laid.pairs[lane, near.half + p]
        if pair.count > 0:
            place = place_of(laid, lane, Sides(pair.a, pair.b), pair.count, step)
            laid.pairs[lane, near.half + p].place = place
    total, room = int(0), laid.order.shape[1] // WIDTH
    for pack in range(step.packs):
        depth = laid.packs[lane, pack].depth
        if total + depth > room:
            depth = 0
            step.full = 1
            laid.packs[lane, pack].depth = 0
        laid.packs[lane, pack].first = total
        total += depth
    step.rows = total


@wp.func
def fill_place(laid: Laid, lane: int, place: int, first: int, count: int):
    """Writes a meeting and its contacts in their rows, and adds what they bore in the last step.

    Args:
        laid: Where the blocks are.
        lane: The lane.
        place: Its place in the packs.
        first, count: Its contacts in the list.
    """
    if place == NONE:
        return
    side = place % WIDTH
    number = place // WIDTH
    pack = laid.packs[lane, number]
    at = laid.contacts[lane, first]
    couple = couple_of(at, laid.hefts[lane, at.a], laid.hefts[lane, at.b])
    laid.couple[lane] = couple
    numbers = wp.array(
        ptr=address_of(laid.couple.ptr, lane, COUPLE), shape=(COUPLE,), dtype=real
    )  # fmt: skip
    for i in range(COUPLE):
        laid.couples[lane, (number * COUPLE + i) * WIDTH + side] = numbers[i]
    apart, given = Apart(), Given()
    part = wp.where(at.friction < NEVER, FADES, real(1.0))
    for turn in range(wp.min(count, pack.depth)):
        listed = first + corner_at(turn, count)
        held = laid.impulses[lane, listed]
        held.n = part * held.n
        held.t = part * held.t
        held.s = part * held.s
        row = row_of(laid.contacts[lane, listed], couple)
        laid.row[lane] = row
        parts = wp.array(
            ptr=address_of(laid.row.ptr, lane, CONTACT), shape=(CONTACT,), dtype=real
        )  # fmt: skip
        begins = (pack.first + turn) * NUMBERS + side
        for i in range(CONTACT):
            laid.rows[lane, begins + i * WIDTH] = parts[i]
        laid.rows[lane, begins + NORMAL] = held.n
        laid.rows[lane, begins + ALONG] = held.t
        laid.rows[lane, begins + ACROSS] = held.s
        laid.order[lane, (pack.first + turn) * WIDTH + side] = listed
        push(couple, row, held.n, held.t, held.s, apart, given)
    ya = laid.weighted[lane, at.a]
    yb = laid.weighted[lane, at.b]
    give(couple, given, ya, yb)
    laid.weighted[lane, at.a] = ya
    laid.weighted[lane, at.b] = yb


@wp.func
def fill_packs(laid: Laid, lane: int, near: Near, step: Step):
    """Writes the contacts of a step into the rows of its packs; see `fill_place`."""
    for i in range(step.rows * WIDTH):
        laid.order[lane, i] = wp.where(laid.order[lane, i] == NONE, NONE, LEFT)
    for joint in range(laid.sizes[lane, JOINT_COUNT]):
        own = laid.joined[lane, joint]
        if own.count > 0:
            fill_place(laid, lane, own.place, step.half + own.first, own.count)
    for p in range(near.pairs):
        pair = laid.pairs[lane, near.half + p]
        if pair.count > 0:
            fill_place(laid, lane, pair.place, step.half + pair.first, pair.count)
    for i in range(step.rows * WIDTH):
        if laid.order[lane, i] == LEFT:
            laid.order[lane, i] = NONE
            at = (i // WIDTH) * NUMBERS + i % WIDTH
            for number in range(CONTACT + IMPULSE):
                laid.rows[lane, at + number * WIDTH] = real(0.0)


@wp.func
def keep_contacts(laid: Laid, lane: int, step: Step):
    """Lets the contacts of the last step go on: of blocks that hardly move only gaps change.

    The error of a gap is of second order in what they have moved since contacts were found.
    """
    for i in range(step.rows * WIDTH):
        listed = laid.order[lane, i]
        if listed != NONE:
            at = laid.contacts[lane, listed]
            mark = laid.marks[lane, listed]
            w = relative(at, laid.moves[lane, at.a], laid.moves[lane, at.b])
            mark.gap = fused(step.dt, inner(at.n, w), mark.gap)
            if laid.impulses[lane, listed].n > real(0.0):
                mark.since = step.time
            laid.marks[lane, listed] = mark
            place = (i // WIDTH) * NUMBERS + CLOSING + i % WIDTH
            laid.rows[lane, place] = larger(mark.gap, real(0.0)) / step.dt


@wp.func
def keep_impulses(laid: Laid, lane: int, step: Step):
    """Brings the impulses that a solve has found back into the list of contacts."""
    for i in range(step.rows * WIDTH):
        listed = laid.order[lane, i]
        if listed != NONE:
            at = (i // WIDTH) * NUMBERS + i % WIDTH
            held = laid.impulses[lane, listed]
            held.n = laid.rows[lane, at + NORMAL]
            held.t = laid.rows[lane, at + ALONG]
            held.s = laid.rows[lane, at + ACROSS]
            laid.impulses[lane, listed] = held
