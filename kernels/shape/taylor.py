"""Taylor polynomials of degree 10 in time, and their first root in a step.

A polynomial is a struct of eleven scalars, so that the compiler keeps it in registers; a vector
would prevent vector code of the loop over lanes.
"""

import warp as wp

NEWTON_STEPS = 6
CONVERGED = by_precision(1.0e-8, 3.0e-4)
"""If the last Newton change is below this part of the root, the error, its square, is round-off."""


@wp.struct
class Polynomial:
    """A quantity as a polynomial in time: ck is the coefficient of the k-th power."""

    c0: real
    c1: real
    c2: real
    c3: real
    c4: real
    c5: real
    c6: real
    c7: real
    c8: real
    c9: real
    c10: real


@wp.func
def scale(s: real, p: Polynomial) -> Polynomial:
    """The product s p."""
    return Polynomial(
        s * p.c0, s * p.c1, s * p.c2, s * p.c3, s * p.c4, s * p.c5, s * p.c6, s * p.c7, s * p.c8,
        s * p.c9, s * p.c10,
    )  # fmt: skip


@wp.func
def choose(condition: bool, p: Polynomial, q: Polynomial) -> Polynomial:
    """The polynomial p where a condition holds, else q."""
    return Polynomial(
        wp.where(condition, p.c0, q.c0),
        wp.where(condition, p.c1, q.c1),
        wp.where(condition, p.c2, q.c2),
        wp.where(condition, p.c3, q.c3),
        wp.where(condition, p.c4, q.c4),
        wp.where(condition, p.c5, q.c5),
        wp.where(condition, p.c6, q.c6),
        wp.where(condition, p.c7, q.c7),
        wp.where(condition, p.c8, q.c8),
        wp.where(condition, p.c9, q.c9),
        wp.where(condition, p.c10, q.c10),
    )


@wp.func
def value_at(p: Polynomial, x: real) -> real:
    """Value of a polynomial."""
    high = fused(x, fused(x, fused(x, fused(x, fused(x, p.c10, p.c9), p.c8), p.c7), p.c6), p.c5)
    return fused(x, fused(x, fused(x, fused(x, fused(x, high, p.c4), p.c3), p.c2), p.c1), p.c0)


@wp.func
def slope_at(p: Polynomial, x: real) -> real:
    """First derivative of a polynomial."""
    d8 = fused(x, fused(x, real(10.0) * p.c10, real(9.0) * p.c9), real(8.0) * p.c8)
    d5 = fused(x, fused(x, fused(x, d8, real(7.0) * p.c7), real(6.0) * p.c6), real(5.0) * p.c5)
    d2 = fused(x, fused(x, fused(x, d5, real(4.0) * p.c4), real(3.0) * p.c3), real(2.0) * p.c2)
    return fused(x, d2, p.c1)


@wp.func
def root(g: Polynomial, end: real, at_end: real):
    """Root in (0, end) of a polynomial that changes its sign there.

    Newton's method inside a shrinking bracket, from the root of the first three terms where
    that lies inside, else from the secant.

    Returns:
        The root; whether it is exact to round-off; the bracket, a time before and one after it.
    """
    zero = real(0.0)
    sign = wp.where(g.c0 < zero, real(-1.0), real(1.0))
    b = sign * g.c1
    square = fused(b, b, real(-4.0) * g.c0 * g.c2)
    x = real(2.0) * sign * g.c0 / (wp.sqrt(wp.where(square > zero, square, zero)) - b)
    x = wp.where(square >= zero and x > zero and x < end, x, end * g.c0 / (g.c0 - at_end))
    low = zero
    high = end
    change = end
    for _ in range(NEWTON_STEPS):
        f = value_at(g, x)
        d = slope_at(g, x)
        before = f * sign > zero
        low = wp.where(before, x, low)
        high = wp.where(before, high, x)
        newton = f / d
        y = x - newton
        # Close to the root round-off may put Newton's value just outside the bracket.
        small = newton * newton <= CONVERGED * CONVERGED * x * x
        y = wp.where((y >= low and y <= high) or small, y, real(0.5) * (low + high))
        change = wp.where(y < x, x - y, y - x)
        x = y
    return x, change <= CONVERGED * x, low, high
