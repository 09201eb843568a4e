"""Impacts of a body in space that bounce: Newton's law or Poisson's, as in event/body/bounce.py.

By Newton's law a point that comes down at a speed v leaves the base with at least e v,
e the restitution. All points that come down at once are solved together, by the law without rebound
for a shifted motion. The shift has the normal velocities -e v at these points and none along the
base, which is one motion of the body, since all of them lie on the plane of the base.

By Poisson's law the impact without rebound is the compression. Each point then gets at least e
times its normal impulse, and all touching points are solved anew, point by point. How a face shares
out the normal impulses of the compression is not unique: as in body_face.py they are those of a bed
of equal springs.

- By Newton's law points that rise before the impact take no part in it. If the others make one of
  them sink, that is the next impact.
- If none comes down faster than `slow`, none bounces: the longest flight would last less than a
  part of the longest step. If one does, all bounce, the slower ones by less than that.
- An impact by Newton's law that would make energy is a mixture of those with and without rebound,
  see contact/bounce.py. One by Poisson's law makes none, as in the plane.
- An expansion that is not found is left out.

Points that leave the base fly, and land when they are back.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.contact.bounce import kept_part
from warprock.kernels.event_space.block.step import NEARLY
from warprock.kernels.event_space.body.contact import (
    ALL,
    Carried,
    PointNumbers,
    Pose,
    Shape,
    Touches,
    bit_of,
    spans_plane,
    touches_of,
)
from warprock.kernels.event_space.body.face import find_pressure
from warprock.kernels.event_space.body.law import DUST, ends_of, solve, solve_by_sweeps


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


@wp.func
def keep_energy(pose: Pose, v: Vector, w: Vector, c: Carried, bounced: Carried) -> Carried:
    """An impact by Newton's law that makes no energy, with c the one without rebound."""
    one = real(1.0)
    free = bounced
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
    return free


@wp.func(inline=False)
def share_impulse(s: Shape, t: Touches, p: Vector, h: Vector) -> PointNumbers:
    """Normal impulses of the points that push [m/s], from their sum and that of their moments."""
    zero, n, total, low = real(0.0), PointNumbers(), t.total, real(0.0)
    for k in range(total):
        low += t.lever[k][2] / real(total)
    along_x, along_y = low * p[0] - h[1], h[0] + low * p[1]
    if spans_plane(t, ALL):
        n3, _carried = find_pressure(s, t, p[2], along_x, along_y)
        n = n3
    elif total > 0:
        i, j = ends_of(t)
        wide_x, wide_y = t.lever[j][0] - t.lever[i][0], t.lever[j][1] - t.lever[i][1]
        off_x, off_y = along_x - p[2] * t.lever[i][0], along_y - p[2] * t.lever[i][1]
        square = wide_x * wide_x + wide_y * wide_y
        share = (off_x * wide_x + off_y * wide_y) / larger(square, TINY)
        share = wp.where(i == j, zero, larger(smaller(share, p[2]), zero))
        n[i] = p[2] - share
        n[j] = wp.where(i == j, p[2], share)
    return n


@wp.func(inline=False)
def expand(
    s: Shape, pose: Pose, all: Touches, v: Vector, w: Vector, compressed: Carried
) -> Carried:  # fmt: skip
    """The motion after the expansion that follows a compression; v and w are before both."""
    held = touches_of(s, pose.turn, compressed.held)
    push, turn = compressed.v - v, pose.inertia * (compressed.w - w)
    n, least, total, few = share_impulse(s, held, push, turn), PointNumbers(), all.total, held.total
    v1, w1 = compressed.v + Vector(), compressed.w + Vector()
    for k in range(total):
        for i in range(few):
            if held.which[i] == all.which[k]:
                least[k] = s.expansion * n[i]
        more = Vector(real(0.0), real(0.0), least[k])
        v1 = v1 + more
        w1 = w1 + pose.inverse * wp.cross(all.lever[k] + Vector(), more)
    return solve_by_sweeps(s, pose, all, least, v1, w1)


@wp.func(inline=False)
def bounce(s: Shape, pose: Pose, touch: wp.uint64, dust: real, v: Vector, w: Vector) -> Bounce:
    """The motion after an impact; `touch` has the points at the base, the rest is as of `solve`."""
    zero, e = real(0.0), s.rebound
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
        if s.expansion > zero:
            free = expand(s, pose, all, v, w, c)
            if not (free.fits and c.fits):
                free = c
        else:
            shift_v = e * Vector(-w[1] * low, w[0] * low, v[2])
            shift_w = e * Vector(w[0], w[1], zero)
            free = solve(s, pose, touches_of(s, pose.turn, comes), dust, v + shift_v, w + shift_w)
            free.v = free.v - shift_v
            free.w = free.w - shift_w
            free = keep_energy(pose, v, w, c, free)
        # A hop that lasts less than the tolerance of the time of an event is none.
        still = larger(NEARLY * larger(e, s.expansion) * s.slow, grain)
        b.touch = wp.uint64(0)
        for k in range(total):
            if size(rise_of(all.lever[k] + Vector(), free.v, free.w)) <= still:
                b.touch = b.touch | bit_of(all.which[k])
        free.held = free.held & b.touch
        b.carried = free
    return b
