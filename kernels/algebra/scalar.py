"""Scalar functions that the compiler can turn into vector code.

The C library's sine, cosine and exponential are calls, which prevent vector code of a loop over
lanes. Here they are polynomials (coefficients: tools/fit_polynomials.py). Comparisons use
`wp.where`, one instruction; `wp.min` and `wp.max` take several because they test for NaN.
"""

import warp as wp


def by_precision(float64: float, float32: float) -> real:
    """A constant that depends on the round-off: the value for the scalar type of this instance."""
    return real({"float64": float64, "float32": float32}[PRECISION])


FARTHEST = real(1.65)
"""Largest |x| for which `sine` and `cosine` are exact to round-off."""

# sin(x) = x P(x^2) on |x| <= 1.65, remainder below 3e-16.
_S0, _S1, _S2, _S3, _S4, _S5, _S6, _S7 = (
    real(value)
    for value in (
        0.9999999999999998,
        -0.16666666666665486,
        0.008333333333242331,
        -0.0001984126981451276,
        2.755731535892851e-06,
        -2.5051805002224982e-08,
        1.6045834341768828e-10,
        -7.34671598500818e-13,
    )
)

# cos(x) = Q(x^2) on |x| <= 1.65, remainder below 2e-17.
_C0, _C1, _C2, _C3, _C4, _C5, _C6, _C7, _C8 = (
    real(value)
    for value in (
        1.0,
        -0.49999999999999944,
        0.04166666666666114,
        -0.001388888888868036,
        2.4801587262168472e-05,
        -2.7557315036615134e-07,
        2.087649552595522e-09,
        -1.1461218483778099e-11,
        4.591679057249305e-14,
    )
)

# exp(x) on -0.7 <= x <= 0, remainder below 1e-19.
_E0, _E1, _E2, _E3, _E4, _E5, _E6, _E7, _E8, _E9, _E10, _E11, _E12 = (
    real(value)
    for value in (
        1.0,
        1.0,
        0.4999999999999987,
        0.1666666666666258,
        0.04166666666599816,
        0.008333333326819436,
        0.0013888888481116627,
        0.0001984125271446425,
        2.480109397559491e-05,
        2.7547531546699247e-06,
        2.7425429135475096e-07,
        2.3891432215334176e-08,
        1.4743816503730166e-09,
    )
)


HALF = real(0.5)
TWO = real(2.0)
HALF_PI = real(1.5707963267948966)
TINY = real(1.0e-30)
"""Keeps a quotient by zero finite; a smaller vector has no direction."""
NEVER = real(1.0e30)
"""The time of an event that has not come."""

# Reciprocals are computed here: in a kernel 1.0 / 3.0 is a quotient of two float32.
OVER_2, OVER_3, OVER_4, OVER_5, OVER_6, OVER_7, OVER_8, OVER_9, OVER_10 = (
    real(1.0 / count) for count in range(2, 11)
)


_MULTIPLY_ADD = {"float64": "fma", "float32": "fmaf"}[PRECISION]


@wp.func_native(f"return {_MULTIPLY_ADD}(a, b, c);")
def fused(a: real, b: real, c: real) -> real:
    """The sum a b + c by one instruction, rounded once.

    The compiler fuses nothing by itself (kernels/launch/instance.py): its choice of a product would
    depend on the code around it and on the processor. So a sum has the same bits in every form of a
    kernel. A kernel says `fused` where that makes it faster.
    """


@wp.func_native(f"return {_MULTIPLY_ADD}(-a, b, c);")
def fused_less(a: real, b: real, c: real) -> real:
    """The difference c - a b, likewise; `fused(-a, b, c)` would first take a from zero."""


@wp.func
def dot(ax: real, az: real, bx: real, bz: real) -> real:
    """The scalar product ax bx + az bz."""
    return fused(az, bz, ax * bx)


@wp.func
def wedge(ax: real, az: real, bx: real, bz: real) -> real:
    """The difference ax bz - az bx: the part of a across b, for a unit vector b."""
    return fused_less(az, bx, ax * bz)


@wp.func
def less_three(u: real, a1: real, x1: real, a2: real, x2: real, a3: real, x3: real) -> real:
    """The difference u - a1 x1 - a2 x2 - a3 x3; the term that is known last comes last."""
    return fused_less(a3, x3, fused_less(a2, x2, fused_less(a1, x1, u)))


@wp.func
def smaller(a: real, b: real) -> real:
    """The smaller of two numbers; b where a is NaN."""
    return wp.where(a < b, a, b)


@wp.func
def larger(a: real, b: real) -> real:
    """The larger of two numbers; b where a is NaN."""
    return wp.where(a > b, a, b)


@wp.func
def size(a: real) -> real:
    """Absolute value."""
    return wp.where(a < real(0.0), -a, a)


@wp.func
def sign_of(a: real) -> real:
    """-1 where a is negative, else 1."""
    return wp.where(a < real(0.0), real(-1.0), real(1.0))


@wp.func
def sine(x: real) -> real:
    """Sine for |x| <= 1.65."""
    u = x * x
    high = fused(u, fused(u, fused(u, _S7, _S6), _S5), _S4)
    return x * fused(u, fused(u, fused(u, fused(u, high, _S3), _S2), _S1), _S0)


@wp.func
def cosine(x: real) -> real:
    """Cosine for |x| <= 1.65."""
    u = x * x
    high = fused(u, fused(u, fused(u, fused(u, _C8, _C7), _C6), _C5), _C4)
    return fused(u, fused(u, fused(u, fused(u, high, _C3), _C2), _C1), _C0)


@wp.func
def in_range(x: real) -> real:
    """The nearest number in the range of `sine` and `cosine`.

    In the step in which a block overturns its rotation leaves this range, by any angle.
    """
    return larger(smaller(x, FARTHEST), -FARTHEST)


@wp.func
def cycle(turns: real):
    """Sine and cosine of 2 pi turns for any number of turns, through the half angle."""
    half_angle = real(3.141592653589793) * (turns - wp.floor(turns + real(0.5)))
    s = sine(half_angle)
    c = cosine(half_angle)
    return real(2.0) * s * c, fused(real(-2.0) * s, s, real(1.0))


@wp.func
def decay(x: real) -> real:
    """exp(-x) for 0 <= x <= 44, from exp(-x / 64) by six squarings."""
    y = x * real(-0.015625)
    e = fused(y, fused(y, fused(y, fused(y, _E12, _E11), _E10), _E9), _E8)
    e = fused(y, fused(y, fused(y, fused(y, e, _E7), _E6), _E5), _E4)
    e = fused(y, fused(y, fused(y, fused(y, e, _E3), _E2), _E1), _E0)
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    return e * e
