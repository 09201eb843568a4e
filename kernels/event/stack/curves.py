"""Polynomials in time that a stack follows while its contacts stick; event/stack/rocking.py."""

import warp as wp

DEGREE = 6
ORDERS = DEGREE - 1
"""Coefficients of an acceleration."""

Curves = wp.types.matrix(shape=(BLOCKS, DEGREE + 1), dtype=real)
"""A polynomial in time a block or an interface, its constant term first."""
Curve = wp.types.vector(length=DEGREE + 1, dtype=real)
"""One polynomial."""


@wp.func
def value_of(p: Curve, tau: real) -> real:
    """Value of a polynomial."""
    found = p[DEGREE]
    for i in range(DEGREE):
        found = fused(found, tau, p[wp.static(DEGREE - 1 - i)])
    return found


@wp.func
def rate_of(p: Curve, tau: real) -> real:
    """Derivative of a polynomial."""
    found = real(0.0)
    for i in range(DEGREE):
        found = fused(found, tau, real(DEGREE - i) * p[wp.static(DEGREE - i)])
    return found


@wp.func
def load_of(p: Curve, tau: real) -> real:
    """Value of a polynomial of the degree to which loads are known."""
    found = p[ORDERS - 1]
    for i in range(wp.static(ORDERS - 1)):
        found = fused(found, tau, p[wp.static(ORDERS - 2 - i)])
    return found


@wp.func
def turning_time(p: Curve, first: real, last: real, d: real) -> real:
    """Time at which a rotation turns back in a step of length d, from its rates at both ends."""
    at = d * first / (first - last)
    rate = rate_of(p, at)
    # The secant again, in the part in which the sign of the rate changes.
    if rate * first > real(0.0):
        at = at + (d - at) * rate / (rate - last)
    else:
        at = at * first / (first - rate)
    return at
