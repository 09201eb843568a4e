"""Taylor series in time of degree 10: their values, their slopes, and where they come to zero."""

import warp as wp

from warprock.kernels.motion.kinds import Ground, Motion, expand

DEGREE = 10
TICK = by_precision(4.4e-16, 2.4e-7)
"""Two roundings, relative."""
ROOT_STEPS = 80
"""Steps after which a bracketed Newton method has surely closed its bracket."""

Series = wp.types.vector(length=DEGREE + 1, dtype=real)
"""Taylor coefficients in time, the constant first."""


@wp.func
def value_of(p: Series, x: real) -> real:
    """Value of a series."""
    found = p[DEGREE]
    for k in range(DEGREE):
        found = fused(x, found, p[DEGREE - 1 - k])
    return found


@wp.func
def slope_of(p: Series) -> Series:
    """The series of the derivative."""
    found = Series()
    for k in range(DEGREE):
        found[k] = real(k + 1) * p[k + 1]
    return found


@wp.func
def term(p: Series, q: Series, n: int) -> real:
    """Coefficient n of a product."""
    found = real(0.0)
    for j in range(n + 1):
        found = found + p[j] * q[n - j]
    return found


@wp.func
def root_of(p: Series, end: real) -> real:
    """Root in (0, end) of a series that is positive at 0 and not at the end."""
    slope = slope_of(p)
    low = real(0.0)
    high = real(end)
    x = end * p[0] / (p[0] - value_of(p, end))
    for _ in range(ROOT_STEPS):
        f = value_of(p, x)
        change = f / value_of(slope, x)
        if f > real(0.0):
            low = x
        else:
            high = x
        y = x - change
        if size(change) <= TICK * x:
            break
        if not (y > low and y < high):
            y = HALF * (low + high)
        if y <= low or y >= high:
            break
        x = y
    return x


@wp.func
def first_root(p: Series, end: real) -> real:
    """First time in (0, end) at which a series that is positive at 0 comes to zero; NEVER if none.

    Its least value inside is looked up where its slope changes its sign.
    """
    found = NEVER
    slope = slope_of(p)
    if value_of(p, end) <= real(0.0):
        found = root_of(p, end)
    elif slope[0] < real(0.0) and value_of(slope, end) > real(0.0):
        least = root_of(-slope, end)
        if value_of(p, least) < real(0.0):
            found = root_of(p, least)
    return found


@wp.func
def pull_series(m: Motion, segment: int, time: real, ground: Ground) -> Series:
    """The acceleration of the base about a time [m/s^2]."""
    a = expand(m, segment, time, ground.value, ground.slope)
    zero = real(0.0)
    return Series(a.a0, a.a1, a.a2, a.a3, a.a4, a.a5, a.a6, a.a7, a.a8, zero, zero)
