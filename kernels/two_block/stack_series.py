"""Taylor series of the motion of two stacked blocks, and the first root of a series in a step.

In a pattern every coefficient of both rotations follows from lower ones. With S = sin(theta) and
C = cos(theta), S' = theta' C and C' = -theta' S; products in the equations of motion (head of
two_block/stack_mechanics.py) are sums by Leibniz's rule. The acceleration of the base is known to
degree 8, so the rotations are known to degree 10 and the contact forces to degree 8.

`wp.static` in a loop unrolls it, which keeps coefficients out of memory: the run is three times as
fast.
"""

import warp as wp

from warprock.kernels.motion.kinds import LINEAR
from warprock.kernels.motion.series import DEGREE, Series, slope_of, value_of
from warprock.kernels.two_block.stack_mechanics import (
    Pair,
    Stack,
    equations,
    inverse,
    solve,
)

ORDERS = DEGREE - 1
"""Number of Taylor coefficients of an acceleration."""
GIVEN = 2 if LINEAR else ORDERS
"""Number of coefficients of the acceleration of the base that are not zero."""

LOOKS = 4
"""Number of parts of a step; in each a watched quantity has at most one turning point."""
PART = real(1.0 / LOOKS)
ROOT_STEPS = 60
"""Largest number of steps towards a root; Newton's method takes some four, bisection alone 53."""
RESOLVED = by_precision(4.0e-16, 2.0e-7)
"""Relative change of a root that ends the search."""


@wp.func
def integrate(first: real, p: Series) -> Series:
    """Integral of a series from a first term."""
    found = Series()
    found[0] = first
    for k in range(DEGREE):
        found[wp.static(k + 1)] = p[k] * wp.static(real(1.0 / (k + 1)))
    return found


@wp.func(inline=False)
def expand_circle(x: Series):
    """Sine and cosine of a rotation."""
    s, c = Series(), Series()
    s[0] = sine(x[0])
    c[0] = cosine(x[0])
    for n in range(DEGREE):
        sn, cn = real(0.0), real(0.0)
        for i in range(wp.static(n + 1)):
            part = x[i + 1] * wp.static(real((i + 1) / (n + 1)))
            sn = fused(part, c[wp.static(n - i)], sn)
            cn = fused_less(part, s[wp.static(n - i)], cn)
        s[n + 1] = sn
        c[n + 1] = cn
    return s, c


@wp.func
def add_turn(w: real, s: real, c: real, u: Pair) -> Pair:
    """The pair u + w (c, -s): adds a term of the derivative of a sine and a cosine at a rate w."""
    return Pair(fused(w, c, u[0]), fused_less(w, s, u[1]))


@wp.func(inline=False)
def motion_series(stack: Stack, s1: real, s2: real, rotation: Pair, rate: Pair, a: Series):
    """Both rotations in the pattern (s1, s2), from the series of the acceleration of the base."""
    eq, g = equations(stack, s1, s2), stack.lane.gravity
    w1, w2, bend1, bend2 = Series(), Series(), Series(), Series()
    sin1, cos1, sin2, cos2 = Series(), Series(), Series(), Series()
    sind, cosd, mixed, turn = Series(), Series(), Series(), Series()
    square1, square2 = Series(), Series()
    w1[0] = rate[0]
    w2[0] = rate[1]
    sin1[0] = sine(rotation[0])
    cos1[0] = cosine(rotation[0])
    sin2[0] = sine(rotation[1])
    cos2[0] = cosine(rotation[1])
    sind[0] = fused_less(cos1[0], sin2[0], sin1[0] * cos2[0])
    cosd[0] = fused(cos1[0], cos2[0], sin1[0] * sin2[0])
    over = inverse(s1, s2, eq.m11, fused_less(eq.odd, sind[0], eq.even * cosd[0]), eq.m22)
    for n in range(ORDERS):
        mixed[n] = fused_less(eq.odd, sind[n], eq.even * cosd[n])
        turn[n] = fused(eq.even, sind[n], eq.odd * cosd[n])
        # Load by the base and by gravity: a sin + g cos and g sin - a cos, of both blocks.
        load1, load2 = Pair(g * cos1[n], g * sin1[n]), Pair(g * cos2[n], g * sin2[n])
        for i in range(wp.static(min(n + 1, GIVEN))):
            load1 = add_turn(a[i], cos1[wp.static(n - i)], sin1[wp.static(n - i)], load1)
            load2 = add_turn(a[i], cos2[wp.static(n - i)], sin2[wp.static(n - i)], load2)
        # theta' times the cosine is the derivative of the sine.
        u1, u2, ud, square = Pair(), Pair(), Pair(), Pair()
        for i in range(wp.static(n + 1)):
            j = wp.static(n - i)
            square = Pair(fused(w1[i], w1[j], square[0]), fused(w2[i], w2[j], square[1]))
            u1 = add_turn(w1[i], sin1[j], cos1[j], u1)
            u2 = add_turn(w2[i], sin2[j], cos2[j], u2)
            ud = add_turn(w1[i] - w2[i], sind[j], cosd[j], ud)
        square1[n] = square[0]
        square2[n] = square[1]
        r1 = fused_less(eq.arm_1, load1[0], eq.height_1 * load1[1])
        r2 = fused_less(eq.arm_2, load2[0], eq.height_2 * load2[1])
        # Separate sums do not wait for one another. The term that is known last comes last.
        e1, e2 = real(0.0), real(0.0)
        for i in range(wp.static(n + 1)):
            j = wp.static(n - i)
            r1 = fused_less(turn[i], square2[j], r1)
            r2 = fused(turn[i], square1[j], r2)
            e1 = fused_less(mixed[j], bend2[i], e1)
            e2 = fused_less(mixed[j], bend1[i], e2)
        bend = solve(over, r1 + e1, r2 + e2)
        part = wp.static(real(1.0 / (n + 1)))
        bend1[n] = bend[0]
        bend2[n] = bend[1]
        w1[n + 1] = bend[0] * part
        w2[n + 1] = bend[1] * part
        sin1[n + 1] = u1[0] * part
        cos1[n + 1] = u1[1] * part
        sin2[n + 1] = u2[0] * part
        cos2[n + 1] = u2[1] * part
        sind[n + 1] = ud[0] * part
        cosd[n + 1] = ud[1] * part
    return integrate(rotation[0], w1), integrate(rotation[1], w2)


@wp.func
def bearing_series(stack: Stack, s1: real, s2: real, x1: Series, x2: Series, a: Series):
    """Normal force and moment about the middle of each closed contact, degrees 0 to 8.

    Args:
        stack: The stack.
        s1: Ground pivot.
        s2: Interface pivot.
        x1: Rotation of the lower block.
        x2: Rotation of the upper block.
        a: Acceleration of the base.

    Returns:
        Normal force and moment at the ground, for s1 = 0; the same at the interface, for s2 = 0.
    """
    zero = real(0.0)
    sin1, cos1 = expand_circle(x1)
    sin2, cos2 = expand_circle(x2)
    edge = s2 * stack.lane.interface
    across = edge - s1 * stack.lane.ground
    rise = stack.lower.half_height + stack.lower.half_height
    h2 = stack.upper.half_height
    px = slope_of(slope_of(across * cos1 + rise * sin1 + h2 * sin2 - edge * cos2))
    pz = slope_of(slope_of(rise * cos1 - across * sin1 + h2 * cos2 + edge * sin2))
    pz[0] = pz[0] + stack.lane.gravity
    fx = stack.upper.mass * (px + a)
    fz = stack.upper.mass * pz
    bend2 = slope_of(slope_of(x2))
    normal = Series()
    moment = Series()
    for n in range(ORDERS):
        pressed, turned = real(0.0), real(0.0)
        for i in range(wp.static(n + 1)):
            j = wp.static(n - i)
            pressed = fused(sin2[i], fx[j], fused(cos2[i], fz[j], pressed))
            turned = fused(cos2[i], fx[j], fused_less(sin2[i], fz[j], turned))
        normal[n] = pressed
        moment[n] = fused(stack.upper.inertia, bend2[n], h2 * turned)
    ground_load = Series(fz)
    ground_load[0] = ground_load[0] + stack.lower.mass * stack.lane.gravity
    tilt = stack.lower.half_height * stack.lower.mass * a + rise * fx
    for k in range(DEGREE - 1):
        tilt[k] = tilt[k] + wp.where(s2 == zero, moment[k], -edge * fz[k])
    return ground_load, tilt, normal, moment


@wp.func
def root(p: Series, low: real, high: real) -> real:
    """Root of a series between two times at which its signs differ: Newton's method, bracketed."""
    slope = slope_of(p)
    at_low = value_of(p, low)
    at_high = value_of(p, high)
    a = real(low)
    b = real(high)
    x = real(low + (high - low) * at_low / (at_low - at_high))
    left = int(ROOT_STEPS)
    while left > 0:
        f = value_of(p, x)
        if (f < real(0.0)) == (at_low < real(0.0)):
            a = x
        else:
            b = x
        y = x - f / value_of(slope, x)
        if not (y > a and y < b):
            y = wp.where(size(x - y) <= RESOLVED * x, x, real(0.5) * (a + b))
        left = wp.where(size(y - x) <= RESOLVED * x, 0, left - 1)
        x = y
    return x


@wp.func
def stays_above(p: Series, h: real) -> bool:
    """Whether the first term of a series exceeds the sum of all others in size on (0, h]."""
    rest = real(0.0)
    for k in range(DEGREE):
        rest = fused(rest, h, size(p[DEGREE - k]))
    return p[0] > rest * h


@wp.func
def first_crossing(p: Series, h: real) -> real:
    """First time in (0, h] at which a series becomes <= 0 from above; NEVER if it does not."""
    found = NEVER
    if not stays_above(p, h):
        found = crossing_in_parts(p, h)
    return found


@wp.func(inline=False)
def crossing_in_parts(p: Series, h: real) -> real:
    """`first_crossing`, which also finds a crossing that comes back within a part of the step."""
    zero = real(0.0)
    slope = slope_of(p)
    part = PART * h
    low = real(0.0)
    at_low = real(p[0])
    down = real(p[1])
    found = NEVER
    look = int(1)
    while look <= LOOKS:
        high = wp.where(look == LOOKS, h, real(look) * part)
        at_high = value_of(p, high)
        down_high = value_of(slope, high)
        end = real(high)
        if at_low > zero and at_high > zero and down < zero and down_high > zero:
            end = root(slope, low, high)
        at_end = value_of(p, end)
        if at_low > zero and not at_end > zero:
            found = wp.where(at_end == zero, end, root(p, low, end))
            look = int(LOOKS)
        low = high
        at_low = at_high
        down = down_high
        look += 1
    return found


@wp.func
def closing_time(gap: Series, h: real) -> real:
    """First time in (0, h] at which a gap closes; zeros at the start are divided out."""
    g = Series(gap)
    zeros = int(0)
    while zeros < 2 and not g[0] > real(0.0):
        for k in range(DEGREE):
            g[k] = g[k + 1]
        g[DEGREE] = real(0.0)
        zeros += 1
    return first_crossing(g, h)


@wp.func
def sure_step(x1: Series, x2: Series, tolerance: real) -> real:
    """Length of a step in which the last terms of both rotations stay below a tolerance [rad]."""
    even = size(x1[DEGREE]) + size(x2[DEGREE])
    odd = size(x1[DEGREE - 1]) + size(x2[DEGREE - 1])
    of_even = wp.pow(tolerance / (even + TINY), OVER_10)
    of_odd = wp.pow(tolerance / (odd + TINY), OVER_9)
    return wp.where(of_even < of_odd, of_even, of_odd)
