"""Velocity-level contact step of a stack in the plane with bodies among its blocks.

As impulse/stack.py, but an interface has up to three points (see shape/stack_body.py). They are
visited from the one away from the side to which the interface leans, so that a mirrored scene is
visited in mirrored order. Data of points from the last step move along with the window.
"""

import warp as wp

from warprock.kernels.contact.parting import slack
from warprock.kernels.impulse.stack import drop_round_off
from warprock.kernels.shape.body_seen import (
    CornerParting,
    Corners,
    observe_corners,
    shift_corners,
)
from warprock.kernels.shape.interface import Impulse, Pose, Velocity
from warprock.kernels.shape.stack_body import Block, Top, Window, find_foot
from warprock.kernels.shape.stack_found import Peaks, Seen
from warprock.kernels.shape.stack_run import Slide, Step, View, observe_block, observe_slide


@wp.func
def move_impulses(
    way: int, lean: real, same: bool, one: wp.ref[Impulse], two: wp.ref[Impulse],
    three: wp.ref[Impulse],
):  # fmt: skip
    """Moves the impulses of the points of an interface along with its window.

    Args:
        way: By how many corners to +x the window has moved.
        lean: Side to which the interface leans in this step.
        same: Whether it leaned there in the last step; else the impulses are swapped.
        one, two, three: Impulses of its points, from the one away from the side to which it leans.
    """
    ahead = wp.where(lean > real(0.0), way, -way)
    a, b, d = shift_corners(
        ahead, wp.where(same, one.n, three.n), two.n, wp.where(same, three.n, one.n)
    )
    e, f, g = shift_corners(
        ahead, wp.where(same, one.t, three.t), two.t, wp.where(same, three.t, one.t)
    )
    one.n = a
    two.n = b
    three.n = d
    one.t = e
    two.t = f
    three.t = g


@wp.func
def balance(
    even: real, place: real, one: wp.ref[Impulse], two: wp.ref[Impulse], three: wp.ref[Impulse],
    u: wp.ref[Velocity],
):  # fmt: skip
    """As `balance` in shape/stack_run.py, for three points from -x to +x.

    The mirror image of the second point, which lies at `place` along the face [m], is the point on
    the other side of the centre.
    """
    zero, side = real(0.0), drop_round_off(place)
    is_even, first, last = even > zero, side >= zero, side <= zero
    n = HALF * (wp.where(first, one.n, two.n) + wp.where(last, three.n, two.n))
    t = HALF * (wp.where(first, one.t, two.t) - wp.where(last, three.t, two.t))
    one.n = wp.where(is_even and first, n, one.n)
    one.t = wp.where(is_even and first, t, one.t)
    two.n = wp.where(is_even and side != zero, n, two.n)
    two.t = wp.where(is_even, wp.where(first and last, zero, wp.where(first, -t, t)), two.t)
    three.n = wp.where(is_even and last, n, three.n)
    three.t = wp.where(is_even and last, -t, three.t)
    u.x = wp.where(is_even, zero, u.x)
    u.omega = wp.where(is_even, zero, u.omega)


@wp.func
def view_block(
    step: Step, block: Block, at: Pose, below: Pose, place: real, overlap: real, u: Velocity,
    low_omega: real,
) -> View:  # fmt: skip
    """The interface below a block after a step, see `view_interface` in shape/stack_run.py."""
    square = u.omega * u.omega + low_omega * low_omega
    length = block.centre_height + size(at.z)
    limit = slack(step.dt, step.gravity, block.reach, square, length)
    total = at.theta + u.x + u.z + u.omega + overlap
    return View(at.theta, at.theta - below.theta, place, overlap, limit, total)


@wp.func
def find_corners(
    window: Window, at: Pose, below: Pose, top: Top, lean: real, n1: real, n2: real, n3: real
):
    """Normal impulses and gaps of the points of an interface, and the place of its block [m].

    Args:
        window: See `find_foot` in shape/stack_body.py, like all arguments up to `top`.
        lean: Side to which the interface leaned in the step.
        n1, n2, n3: Normal impulses of its points, from the one away from that side.
    """
    forward = lean > real(0.0)
    has_l, _one, gap_l, _place1 = find_foot(window, -1, at, below, top)
    has_m, _two, gap_m, place = find_foot(window, 0, at, below, top)
    has_r, _three, gap_r, _place3 = find_foot(window, 1, at, below, top)
    corners = Corners(
        wp.where(has_l, 1, 0), wp.where(has_r, 1, 0),
        wp.where(forward, n1, n3), n2, wp.where(forward, n3, n1),
        gap_l, wp.where(has_m, gap_m, NEVER), gap_r,
    )  # fmt: skip
    return corners, place


@wp.func
def observe(
    step: Step, view: View, by: int, corners: Corners, parting: wp.ref[CornerParting],
    slide: wp.ref[Slide], peaks: wp.ref[Peaks], seen: wp.ref[Seen],
):  # fmt: skip
    """As `observe` in shape/stack_run.py, with the points of the window instead of two ends.

    `by` is the number of corners to +x by which the window has moved in the step.
    """
    zero = real(0.0)
    slips = observe_slide(step, view.place, slide)
    time = larger(step.time, zero)
    observe_corners(step.live > 0, by, time, view.limit, slips, corners, parting, seen)
    gap_l = wp.where(corners.has_left > 0, corners.gap_left, NEVER)
    gap_r = wp.where(corners.has_right > 0, corners.gap_right, NEVER)
    gap = smaller(smaller(gap_l, gap_r), corners.gap_middle)
    stands = larger(size(view.theta), size(view.turn)) < HALF_PI
    observe_block(step, view, wp.where(stands, -gap, zero), slide.now, peaks, seen)
