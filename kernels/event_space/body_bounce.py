"""Impacts of a body in space that bounce: Newton's law for every point that strikes the base.

As in event/body_bounce.py: a point that comes down at a speed v leaves the base with at least e v,
e the restitution. All points that come down at once are solved together, by the law without rebound
for a shifted motion. The shift has the normal velocities -e v at these points and none along the
base, which is one motion of the body, since all of them lie on the plane of the base.

- Points that rise before the impact take no part in it. If the others make one of them sink, that
  is the next impact.
- If none comes down faster than `slow`, none bounces: the longest flight would last less than a
  part of the longest step. If one does, all bounce, the slower ones by less than that.
- An impact that would make energy is a mixture of those with and without rebound, see bounce.py.

Points that leave the base fly, and land when they are back.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.contact.bounce import kept_part
from warprock.kernels.event_space.block import NEARLY
from warprock.kernels.event_space.body_contact import (
    Carried,
    Pose,
    Shape,
    bit_of,
    touches_of,
)
from warprock.kernels.event_space.body_law import DUST, solve


@wp.struct
class Bounce:
    """The motion after an impact that bounces, and the points that touch then."""

    carried: Carried
    touch: wp.uint64


@wp.func
def rise_of(r: Vector, v: Vector, w: Vector) -> real:
    """Velocity upwards of a point at a lever [m/s]."""
    return v[2] + w[0] * r[1] - w[1] * r[0]


@wp.func
def product(pose: Pose, v: Vector, w: Vector, v1: Vector, w1: Vector) -> real:
    """Product of two motions by the mass [J/kg]: of one with itself twice its kinetic energy."""
    return wp.dot(v, v1) + wp.dot(w, pose.inertia * w1)


@wp.func(inline=False)
def bounce(s: Shape, pose: Pose, touch: wp.uint64, dust: real, v: Vector, w: Vector) -> Bounce:
    """The motion after an impact; `touch` has the points at the base, the rest is as of `solve`."""
    zero, one, e = real(0.0), real(1.0), s.rebound
    all = touches_of(s, pose.turn, touch)
    grain = DUST * (wp.length(v) + wp.length(w) * s.reach + dust)
    comes, low, fastest, total = wp.uint64(0), real(0.0), real(0.0), all.total
    for k in range(total):
        r = all.lever[k] + Vector()
        speed = -rise_of(r, v, w)
        fastest = larger(fastest, speed)
        low = smaller(low, r[2])
        if speed >= -grain:
            comes = comes | bit_of(all.which[k])
    b = Bounce()
    b.carried = solve(s, pose, all, dust, v, w)
    b.touch = touch
    if fastest > s.slow:
        c = b.carried
        shift_v = e * Vector(-w[1] * low, w[0] * low, v[2])
        shift_w = e * Vector(w[0], w[1], zero)
        free = solve(s, pose, touches_of(s, pose.turn, comes), dust, v + shift_v, w + shift_w)
        free.v = free.v - shift_v
        free.w = free.w - shift_w
        more_v, more_w = free.v - c.v, free.w - c.w
        square = HALF * product(pose, more_v, more_w, more_v, more_w)
        slope = product(pose, c.v, c.w, more_v, more_w)
        room = HALF * (product(pose, v, w, v, w) - product(pose, c.v, c.w, c.v, c.w))
        part = kept_part(square, slope, room)
        free.fits = free.fits and c.fits
        if part < one:
            free.v = c.v + part * more_v
            free.w = c.w + part * more_w
            free.held = free.held & c.held
        # A hop that lasts less than the tolerance of the time of an event is none.
        still = larger(NEARLY * e * s.slow, grain)
        b.touch = wp.uint64(0)
        for k in range(total):
            if size(rise_of(all.lever[k] + Vector(), free.v, free.w)) <= still:
                b.touch = b.touch | bit_of(all.which[k])
        free.held = free.held & b.touch
        b.carried = free
    return b
