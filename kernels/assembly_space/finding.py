"""The contacts of a step of an assembly in space: of its joints, and of pairs without one."""

import warp as wp

from warprock.kernels.assembly.block import Seen, Track, observe_gap
from warprock.kernels.assembly.joint import Impulse as Pressed
from warprock.kernels.assembly.meeting import BLOCK_COUNT, JOINT_COUNT, NONE, SLIP, Near
from warprock.kernels.assembly_space.contact import inner
from warprock.kernels.assembly_space.meeting import (
    DEEP,
    FLUSH,
    Joined,
    Laid,
    Mark,
    Met,
    Pair,
    Spot,
    Step,
    add_contact,
    crossing_spot,
    cut,
    is_new,
    meet,
    meet_joint,
    own_spot,
    take_known,
)
from warprock.kernels.contact.parting import slack


@wp.struct
class Search:
    """Two bodies whose contacts are looked for.

    Attributes:
        a, b: The bodies.
        first, count: Their contacts in the list of the last step.
        friction: Coulomb friction coefficient.
        joint: 1 at a joint, else 0.
        start, corners: The polygon that they have in common, in `scratch`.
        range: Gap up to which its corners are contacts [m].
    """

    a: int
    b: int
    first: int
    count: int
    friction: real
    joint: int
    start: int
    corners: int
    range: real


@wp.func
def add_spot(
    laid: Laid, lane: int, search: Search, spot: Spot, step: wp.ref[Step],
    joined: wp.ref[Joined], seen: wp.ref[Seen], near: wp.ref[Near],
):  # fmt: skip
    """Adds a contact that has been found, and sees what became of it since the last step.

    Args:
        laid: Where the blocks are.
        lane: The lane.
        search: The two bodies.
        spot: The contact.
        step: The step.
        joined: Their joint, if they have one.
        seen: What is seen of the lane.
        near: Its pairs.
    """
    zero = real(0.0)
    va, vb = laid.moves[lane, spot.a], laid.moves[lane, spot.b]
    place = own_spot(laid, lane, spot.a, spot.at)
    was = take_known(laid, lane, step, search.first, search.count, place)
    mark = Mark(place, spot.gap, NEVER, 0)
    if search.joint > 0:
        ra, rb = (
            spot.at - laid.places[lane, spot.a].at,
            spot.at - laid.places[lane, spot.b].at,
        )
        reach = wp.sqrt(inner(ra, ra)) + wp.sqrt(inner(rb, rb))
        reach = wp.where(laid.solids[lane, spot.b].corners > 0, reach, wp.sqrt(inner(ra, ra)))
        turning = inner(va.o, va.o) + inner(vb.o, vb.o)
        limit = slack(step.dt, step.gravity, reach, turning, zero)
        track = Track(zero, zero, joined.opening, NEVER, 0)
        if was.place != NONE:
            track.since = laid.marks[lane, was.place].since
            track.parted = laid.marks[lane, was.place].parted
        pressed = Pressed()
        pressed.n = was.n
        observe_gap(step.live > 0, step.time, spot.gap, limit, pressed, track, seen)
        joined.opening = track.opening
        mark.since = track.since
        mark.parted = track.parted
    else:
        parted = wp.where(step.live > 0, 1, 0)
        if was.place != NONE:
            parted = laid.marks[lane, was.place].parted
        carried = was.n > zero
        if carried:
            near.carries = 1
            near.landed += parted
        away = spot.gap > near.limit or (parted > 0 and not carried)
        mark.parted = wp.where(away, 1, 0)
        near.deepest = larger(-spot.gap, near.deepest)
    if spot.gap <= search.range:
        add_contact(laid, lane, spot, mark, was, step)


@wp.func
def add_polygon(
    laid: Laid, lane: int, search: Search, met: Met, step: wp.ref[Step],
    joined: wp.ref[Joined], seen: wp.ref[Seen], near: wp.ref[Near],
):  # fmt: skip
    """Adds the contacts of two bodies that meet on a face, see `add_spot`."""
    k = wp.where(met.how == 0, search.a, search.b)
    n = met.normal
    out = wp.where(met.how == 0, -n, n)
    level = inner(out, laid.places[lane, k].at)
    level = level + laid.faces[lane, laid.solids[lane, k].face + met.own].level
    for i in range(search.corners):
        if is_new(laid, lane, search.start, i, search.corners):
            at = laid.scratch[lane, search.start + i]
            spot = Spot(search.a, search.b, n, at, inner(out, at) - level, search.friction)
            if search.joint > 0 or spot.gap <= search.range:
                add_spot(laid, lane, search, spot, step, joined, seen, near)


@wp.func
def depth_of(laid: Laid, lane: int, search: Search, met: Met) -> real:
    """How deep the polygon of two bodies is below the face that they meet on [m]."""
    k = wp.where(met.how == 0, search.a, search.b)
    out = wp.where(met.how == 0, -met.normal, met.normal)
    level = inner(out, laid.places[lane, k].at)
    level = level + laid.faces[lane, laid.solids[lane, k].face + met.own].level
    found = real(0.0)
    for i in range(search.corners):
        found = larger(level - inner(out, laid.scratch[lane, search.start + i]), found)
    return found


@wp.func
def find_between(
    laid: Laid, lane: int, search: Search, step: wp.ref[Step],
    joined: wp.ref[Joined], seen: wp.ref[Seen], near: wp.ref[Near],
):  # fmt: skip
    """Finds the contacts of two bodies anywhere, see `add_spot`."""
    met = meet(laid, lane, search.a, search.b, near.range)
    own = search
    own.joint = 0
    own.friction = laid.friction[lane]
    own.range = near.range
    if met.how == 2:
        spot = Spot(search.a, search.b, met.normal, laid.scratch[lane, 0], met.gap, own.friction)
        spot = crossing_spot(laid, lane, spot, met)
        add_spot(laid, lane, own, spot, step, joined, seen, near)
    elif met.how != NONE:
        k = wp.where(met.how == 0, search.a, search.b)
        other = wp.where(met.how == 0, search.b, search.a)
        start, corners = cut(
            laid, lane, k, met.own, other, met.other, SLIP * laid.scale[lane]
        )  # fmt: skip
        own.start = start
        own.corners = corners
        add_polygon(laid, lane, own, met, step, joined, seen, near)


@wp.func
def find_joint(
    laid: Laid, lane: int, joint: int, step: wp.ref[Step], seen: wp.ref[Seen], near: wp.ref[Near]
):
    """Finds the contacts of a joint, or of its blocks elsewhere once it has ended."""
    link = laid.links[lane, joint]
    joined = laid.joined[lane, joint]
    search = Search(
        link.a, link.b, joined.first, joined.count, link.friction, 1, 0, 0, near.range
    )  # fmt: skip
    if BONDS:
        # Bonds set once the weight is borne: they begin without stress.
        bonded = joined.holds > 0 and step.live > 0
        search.friction = wp.where(bonded, NEVER, link.friction)
    begins = int(step.total)
    met = meet_joint(laid, lane, link)
    whole = int(0)
    if met.how != NONE:
        k = wp.where(met.how == 0, link.a, link.b)
        other = wp.where(met.how == 0, link.b, link.a)
        rim = -FLUSH * laid.scale[lane]
        start, corners = cut(laid, lane, k, met.own, other, met.other, rim)
        search.start = start
        search.corners = corners
        if corners > 0 and depth_of(laid, lane, search, met) < DEEP * laid.scale[lane]:
            whole = 1
    if whole > 0:
        add_polygon(laid, lane, search, met, step, joined, seen, near)
    else:
        find_between(laid, lane, search, step, joined, seen, near)
    joined.first = begins
    joined.count = step.total - begins
    laid.joined[lane, joint] = joined


@wp.func
def find_pairs(laid: Laid, lane: int, step: wp.ref[Step], seen: wp.ref[Seen], near: wp.ref[Near]):
    """Finds the contacts of the pairs of a lane that have no joint."""
    none = Joined()
    for p in range(near.pairs):
        pair = laid.pairs[lane, near.half + p]
        begins = int(step.total)
        search = Search(
            pair.a, pair.b, pair.first, pair.count, laid.friction[lane], 0, 0, 0, near.range
        )  # fmt: skip
        find_between(laid, lane, search, step, none, seen, near)
        laid.pairs[lane, near.half + p].first = begins
        laid.pairs[lane, near.half + p].count = step.total - begins


@wp.func
def list_pairs(laid: Laid, lane: int, near: Near) -> Near:
    """Lists the pairs of a lane without a joint that may touch soon, in the order of their blocks.

    Joints come in the order of their blocks, too, but for those on the ground, which come last.
    """
    count = int(laid.sizes[lane, BLOCK_COUNT])
    joints = int(laid.sizes[lane, JOINT_COUNT])
    room = laid.pairs.shape[1] // 2
    half = wp.where(near.half == 0, room, 0)
    found, old = int(0), int(0)
    for a in range(count):
        one = laid.solids[lane, a]
        joint = int(0)
        while joint < joints and laid.links[lane, joint].a < a:
            joint += 1
        for b in range(a + 1, count + 1):
            other = laid.solids[lane, b]
            linked = int(0)
            while (
                joint < joints
                and laid.links[lane, joint].a == a
                and (laid.links[lane, joint].b < b)
            ):
                joint += 1
            if joint < joints and laid.links[lane, joint].a == a and laid.links[lane, joint].b == b:
                linked = 1
            away = laid.places[lane, a].at - laid.places[lane, b].at
            reach = one.reach + other.reach + near.scope
            close = b < count and other.corners > 0 and inner(away, away) < reach * reach
            close = close or (b == count and away[2] < one.reach + near.scope)
            moves = one.moves > 0 or other.moves > 0
            if linked == 0 and one.corners > 0 and close and moves:
                met = meet(laid, lane, a, b, near.scope)
                if met.how != NONE:
                    while old < near.pairs and (
                        laid.pairs[lane, near.half + old].a < a
                        or (
                            laid.pairs[lane, near.half + old].a == a
                            and laid.pairs[lane, near.half + old].b < b
                        )
                    ):
                        old += 1
                    pair = Pair(a, b, 0, 0, 0)
                    if (
                        old < near.pairs
                        and laid.pairs[lane, near.half + old].a == a
                        and laid.pairs[lane, near.half + old].b == b
                    ):
                        pair = laid.pairs[lane, near.half + old]
                    if found < room:
                        laid.pairs[lane, half + found] = pair
                    found += 1
    listed = near
    listed.pairs = wp.min(found, room)
    listed.half = half
    listed.full = wp.where(found > room, 1, near.full)
    listed.travelled = real(0.0)
    return listed
