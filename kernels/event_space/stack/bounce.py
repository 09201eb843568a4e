"""Impacts of a stack in space that bounce: Newton's law for every contact that closes.

A contact that closes at a speed v opens again with at least e v, e the restitution; all contacts of
the stack that touch take part at once, as in event/stack/bounce.py. So its gap in the law of
event_space/stack/contact.py is -e v.

- A contact slower than `slow` does not bounce, see event/body/bounce.py.
- An impact that would make energy is a mixture of those with and without rebound, see
  contact/bounce.py.
- Contacts that open leave, and land when they are back.

References:
    Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics.
"""

import warp as wp

from warprock.kernels.contact.bounce import kept_part
from warprock.kernels.event_space.stack.contact import Ints, Pose, Rebound, Touches, directions
from warprock.kernels.event_space.stack.look import NEARLY
from warprock.kernels.event_space.stack.solve import solve_impact
from warprock.kernels.shape_space.frame import relative_velocity
from warprock.kernels.shape_space.stack import Bodies, rows_of


@wp.func
def rise_of(t: Touches, i: int, pose: Pose, v: Bodies, w: Bodies) -> real:
    """Velocity at which a contact opens [m/s]."""
    k = t.body[i]
    u = relative_velocity(v[k], w[k], t.ru[i], v[k - 1], w[k - 1], t.rl[i])
    return wp.dot(directions(pose.axes, k, t.way[i])[2], u)


@wp.func
def product(pose: Pose, v: Bodies, w: Bodies, v1: Bodies, w1: Bodies) -> real:
    """Product of two motions by the mass [J]: of one with itself twice its kinetic energy."""
    total = real(0.0)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        total += wp.dot(v[k], v1[k]) / pose.light[k]
        total += wp.dot(w[k], rows_of(pose.inertia, k) * w1[k])
    return total


@wp.func(inline=False)
def bounce(rebound: Rebound, closing: Touches, pose: Pose, v: Bodies, w: Bodies, kick: real):
    """The impact that bounces.

    Args:
        rebound: How contacts bounce.
        closing, pose, v, w, kick: As of `solve_impact`.

    Returns:
        Velocities, angular velocities, bits of slots that leave, and whether it is solved.
    """
    t = closing
    _p, v0, w0, fits = solve_impact(t, pose, v, w, kick)
    left, some = Ints(), bool(False)
    for i in range(t.total):
        rise = rise_of(t, i, pose, v, w)
        if rise < -rebound.slow:
            t.gap[i] = rebound.kept * rise
            some = True
    if not some:
        return v0, w0, left, fits
    _q, v1, w1, bounces = solve_impact(t, pose, v, w, real(0.0))
    more_v, more_w = v1 - v0, w1 - w0
    room = HALF * (product(pose, v, w, v, w) - product(pose, v0, w0, v0, w0))
    square = HALF * product(pose, more_v, more_w, more_v, more_w)
    part = kept_part(square, product(pose, v0, w0, more_v, more_w), room)
    v1 = v0 + part * more_v
    w1 = w0 + part * more_w
    # A hop that lasts less than the tolerance of the time of an event is none.
    for i in range(t.total):
        leaves = rise_of(t, i, pose, v1, w1) > NEARLY * rebound.kept * rebound.slow
        k = t.body[i]
        left[k] = left[k] | wp.where(leaves, 1 << t.slot[i], 0)
    return v1, w1, left, fits and bounces
