"""Taylor series of the motion of two stacked blocks, and the first root of a series in a step.

In a pattern every coefficient of both rotations follows from lower ones: with S = sin(theta) and
C = cos(theta), S' = theta' C and C' = -theta' S, and the products in the equations of motion (head
of two_block/stack_mechanics.py) are sums by Leibniz's rule. The base's acceleration is known to
degree 8, so the rotations are to degree 10, and with them what the contacts bear to degree 8.
"""

import warp as wp

from warprock.kernels.two_block.stack_mechanics import Block, Pair, Stack, equations, solved

DEGREE = 10
Series = wp.types.vector(length=DEGREE + 1, dtype=real)
"""Coefficients of powers of the time since the start of a step."""

LOOKS = 4
"""Parts of a step in each of which a watched quantity turns at most once."""
PART = real(1.0 / LOOKS)
ROOT_STEPS = 60
"""Most steps towards a root; Newton's method takes some four, halving alone 53."""
RESOLVED = by_precision(4.0e-16, 2.0e-7)
"""Relative change of a root that ends the search."""


@wp.func
def value(p: Series, x: real) -> real:
    """Value of a series."""
    found = p[DEGREE]
    for k in range(DEGREE):
        found = found * x + p[DEGREE - 1 - k]
    return found


@wp.func
def derived(p: Series) -> Series:
    """Derivative of a series."""
    found = Series()
    for k in range(DEGREE):
        found[k] = real(k + 1) * p[k + 1]
    return found


@wp.func
def product(p: Series, q: Series, n: int) -> real:
    """Coefficient n of a product of series."""
    found = real(0.0)
    for j in range(n + 1):
        found = found + p[j] * q[n - j]
    return found


@wp.func
def turned(angle: Series, other: Series, n: int) -> real:
    """Coefficient n > 0 of the integral of angle' times another series."""
    found = real(0.0)
    for j in range(1, n + 1):
        found = found + real(j) * angle[j] * other[n - j]
    return found / real(n)


@wp.func
def pulled(g: real, arm: real, height: real, a: Series, s: Series, c: Series, n: int) -> real:
    """Coefficient n of the moment of gravity and of the base's acceleration about a pivot."""
    fall = g * (height * s[n] - arm * c[n])
    return fall - arm * product(a, s, n) - height * product(a, c, n)


@wp.func
def motion_series(
    lower: Block, upper: Block, stack: Stack, s1: real, s2: real, rotation: Pair, rate: Pair,
    a: Series,
):  # fmt: skip
    """Both rotations in the pattern (s1, s2), from the series of the base's acceleration."""
    eq = equations(lower, upper, stack, s1, s2)
    x1 = Series()
    x2 = Series()
    w1 = Series()
    w2 = Series()
    bend1 = Series()
    bend2 = Series()
    sin1 = Series()
    cos1 = Series()
    sin2 = Series()
    cos2 = Series()
    sind = Series()
    cosd = Series()
    square1 = Series()
    square2 = Series()
    cross = Series()
    turn = Series()
    x1[0] = rotation[0]
    x2[0] = rotation[1]
    x1[1] = rate[0]
    x2[1] = rate[1]
    w1[0] = rate[0]
    w2[0] = rate[1]
    for n in range(DEGREE - 1):
        if n == 0:
            sin1[0] = sine(rotation[0])
            cos1[0] = cosine(rotation[0])
            sin2[0] = sine(rotation[1])
            cos2[0] = cosine(rotation[1])
            sind[0] = sin1[0] * cos2[0] - cos1[0] * sin2[0]
            cosd[0] = cos1[0] * cos2[0] + sin1[0] * sin2[0]
        else:
            sin1[n] = turned(x1, cos1, n)
            cos1[n] = -turned(x1, sin1, n)
            sin2[n] = turned(x2, cos2, n)
            cos2[n] = -turned(x2, sin2, n)
            sind[n] = turned(x1, cosd, n) - turned(x2, cosd, n)
            cosd[n] = turned(x2, sind, n) - turned(x1, sind, n)
        square1[n] = product(w1, w1, n)
        square2[n] = product(w2, w2, n)
        cross[n] = eq.even * cosd[n] - eq.odd * sind[n]
        turn[n] = eq.even * sind[n] + eq.odd * cosd[n]
        r1 = pulled(stack.gravity, eq.arm_1, eq.height_1, a, sin1, cos1, n)
        r1 = r1 - product(turn, square2, n) - product(cross, bend2, n)
        r2 = pulled(stack.gravity, eq.arm_2, eq.height_2, a, sin2, cos2, n)
        r2 = r2 + product(turn, square1, n) - product(cross, bend1, n)
        bend = solved(s1, s2, eq.m11, cross[0], eq.m22, r1, r2)
        bend1[n] = bend[0]
        bend2[n] = bend[1]
        w1[n + 1] = bend[0] / real(n + 1)
        w2[n + 1] = bend[1] / real(n + 1)
        x1[n + 2] = w1[n + 1] / real(n + 2)
        x2[n + 2] = w2[n + 1] / real(n + 2)
    return x1, x2


@wp.func
def bearing_series(
    lower: Block, upper: Block, stack: Stack, s1: real, s2: real, x1: Series, x2: Series,
    a: Series,
):  # fmt: skip
    """What closed contacts bear: normal force and moment about the middle of each, 0 to degree 8.

    Args:
        lower: Lower block.
        upper: Upper block.
        stack: Both.
        s1: Ground pivot.
        s2: Interface pivot.
        x1: Rotation of the lower block.
        x2: Rotation of the upper block.
        a: Acceleration of the base.

    Returns:
        Normal force and moment at the ground, for s1 = 0; the same at the interface, for s2 = 0.
    """
    zero = real(0.0)
    sin1 = Series()
    cos1 = Series()
    sin2 = Series()
    cos2 = Series()
    sin1[0] = sine(x1[0])
    cos1[0] = cosine(x1[0])
    sin2[0] = sine(x2[0])
    cos2[0] = cosine(x2[0])
    n = int(1)
    while n <= DEGREE:
        sin1[n] = turned(x1, cos1, n)
        cos1[n] = -turned(x1, sin1, n)
        sin2[n] = turned(x2, cos2, n)
        cos2[n] = -turned(x2, sin2, n)
        n += 1
    edge = s2 * stack.interface
    across = edge - s1 * stack.ground
    rise = lower.half_height + lower.half_height
    h2 = upper.half_height
    px = derived(derived(across * cos1 + rise * sin1 + h2 * sin2 - edge * cos2))
    pz = derived(derived(rise * cos1 - across * sin1 + h2 * cos2 + edge * sin2))
    pz[0] = pz[0] + stack.gravity
    fx = upper.mass * (px + a)
    fz = upper.mass * pz
    bend2 = derived(derived(x2))
    normal = Series()
    moment = Series()
    n = int(0)
    while n <= DEGREE - 2:
        normal[n] = product(sin2, fx, n) + product(cos2, fz, n)
        moment[n] = upper.inertia * bend2[n]
        moment[n] = moment[n] + h2 * (product(cos2, fx, n) - product(sin2, fz, n))
        n += 1
    whole = Series(fz)
    whole[0] = whole[0] + lower.mass * stack.gravity
    tilt = lower.half_height * lower.mass * a + rise * fx
    for k in range(DEGREE - 1):
        tilt[k] = tilt[k] + wp.where(s2 == zero, moment[k], -edge * fz[k])
    return whole, tilt, normal, moment


@wp.func
def root(p: Series, low: real, high: real) -> real:
    """Root of a series between two times at which its signs differ: Newton's method, bracketed."""
    slope = derived(p)
    at_low = value(p, low)
    at_high = value(p, high)
    a = real(low)
    b = real(high)
    x = real(low + (high - low) * at_low / (at_low - at_high))
    left = int(ROOT_STEPS)
    while left > 0:
        f = value(p, x)
        if (f < real(0.0)) == (at_low < real(0.0)):
            a = x
        else:
            b = x
        y = x - f / value(slope, x)
        if not (y > a and y < b):
            y = wp.where(size(x - y) <= RESOLVED * x, x, real(0.5) * (a + b))
        left = wp.where(size(y - x) <= RESOLVED * x, 0, left - 1)
        x = y
    return x


@wp.func
def first_crossing(p: Series, h: real) -> real:
    """First time in (0, h] at which a series becomes <= 0 from above; NEVER if it does not.

    Seen is also one that crosses and comes back within a part of the step.
    """
    zero = real(0.0)
    slope = derived(p)
    part = PART * h
    low = real(0.0)
    at_low = real(p[0])
    down = real(p[1])
    found = NEVER
    look = int(1)
    while look <= LOOKS:
        high = wp.where(look == LOOKS, h, real(look) * part)
        at_high = value(p, high)
        down_high = value(slope, high)
        end = real(high)
        if at_low > zero and at_high > zero and down < zero and down_high > zero:
            end = root(slope, low, high)
        at_end = value(p, end)
        if at_low > zero and not at_end > zero:
            found = wp.where(at_end == zero, end, root(p, low, end))
            look = int(LOOKS)
        low = high
        at_low = at_high
        down = down_high
        look += 1
    return found


@wp.func
def closing(gap: Series, h: real) -> real:
    """First time in (0, h] at which a gap closes; the zeros that it starts with are divided out."""
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
    """Step over which the last two terms of both rotations stay below a tolerance [rad]."""
    even = size(x1[DEGREE]) + size(x2[DEGREE])
    odd = size(x1[DEGREE - 1]) + size(x2[DEGREE - 1])
    of_even = wp.pow(tolerance / (even + TINY), OVER_10)
    of_odd = wp.pow(tolerance / (odd + TINY), OVER_9)
    return wp.where(of_even < of_odd, of_even, of_odd)
