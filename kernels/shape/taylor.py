"""Taylor polynomials of degree 10 in time, and their first root in a step.

A polynomial is eleven scalars, so that the compiler keeps it in registers: a vector argument
would keep the loop over lanes from being vectorised.
"""

import warp as wp

NEWTON_STEPS = 6
CONVERGED = by_precision(1.0e-8, 3.0e-4)
"""A last Newton change below this part of the root leaves an error of its square: round-off."""


@wp.func
def value_at(
    t0: real, t1: real, t2: real, t3: real, t4: real, t5: real,
    t6: real, t7: real, t8: real, t9: real, t10: real, x: real,
) -> real:  # fmt: skip
    """Value of a polynomial."""
    high = fused(x, fused(x, fused(x, fused(x, fused(x, t10, t9), t8), t7), t6), t5)
    return fused(x, fused(x, fused(x, fused(x, fused(x, high, t4), t3), t2), t1), t0)


@wp.func
def slope_at(
    t1: real, t2: real, t3: real, t4: real, t5: real,
    t6: real, t7: real, t8: real, t9: real, t10: real, x: real,
) -> real:  # fmt: skip
    """First derivative of a polynomial."""
    d8 = fused(x, fused(x, real(10.0) * t10, real(9.0) * t9), real(8.0) * t8)
    d5 = fused(x, fused(x, fused(x, d8, real(7.0) * t7), real(6.0) * t6), real(5.0) * t5)
    d2 = fused(x, fused(x, fused(x, d5, real(4.0) * t4), real(3.0) * t3), real(2.0) * t2)
    return fused(x, d2, t1)


@wp.func
def root(
    g0: real, g1: real, g2: real, g3: real, g4: real, g5: real,
    g6: real, g7: real, g8: real, g9: real, g10: real, end: real, at_end: real,
):  # fmt: skip
    """Root in (0, end) of a polynomial that changes its sign there.

    Newton's method inside a shrinking bracket, from the root of the first three terms where
    that lies inside, else from the secant.

    Returns:
        The root; whether it is exact to round-off; the bracket, a time before and one after it.
    """
    zero = real(0.0)
    sign = wp.where(g0 < zero, real(-1.0), real(1.0))
    b = sign * g1
    square = fused(b, b, real(-4.0) * g0 * g2)
    x = real(2.0) * sign * g0 / (wp.sqrt(wp.where(square > zero, square, zero)) - b)
    x = wp.where(square >= zero and x > zero and x < end, x, end * g0 / (g0 - at_end))
    low = zero
    high = end
    change = end
    for _ in range(NEWTON_STEPS):
        f = value_at(g0, g1, g2, g3, g4, g5, g6, g7, g8, g9, g10, x)
        d = slope_at(g1, g2, g3, g4, g5, g6, g7, g8, g9, g10, x)
        before = f * sign > zero
        low = wp.where(before, x, low)
        high = wp.where(before, high, x)
        newton = f / d
        y = x - newton
        # At the root itself round-off may put Newton's value a hair outside.
        small = newton * newton <= CONVERGED * CONVERGED * x * x
        y = wp.where((y >= low and y <= high) or small, y, real(0.5) * (low + high))
        change = wp.where(y < x, x - y, y - x)
        x = y
    return x, change <= CONVERGED * x, low, high
