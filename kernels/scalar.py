"""Scalar functions that the compiler can turn into vector code, for one precision.

The C library's sine, cosine and exponential are calls, which keep a loop over lanes from being
vectorised; these are polynomials (coefficients: tools/fit_polynomials.py). Comparisons are
written with `wp.where`: one instruction, where `wp.min` and `wp.max` take several because they
look for NaN.
"""

from typing import Any

import warp as wp

from warprock.kernels.instance import module_options

real: Any
"""Scalar type; set by `instance.kernel_module`."""

wp.set_module_options(module_options())

FARTHEST = real(1.65)
"""Largest |x| of which `sine` and `cosine` are right."""

# sin(x) = x P(x^2) on |x| <= 1.65, remainder below 3e-16.
S0, S1, S2, S3, S4, S5, S6, S7 = (
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
C0, C1, C2, C3, C4, C5, C6, C7, C8 = (
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
E0, E1, E2, E3, E4, E5, E6, E7, E8, E9, E10, E11, E12 = (
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


# Reciprocals, divided here and not in a kernel: there 1.0 / 3.0 is a quotient of two float32.
OVER_2, OVER_3, OVER_4, OVER_5, OVER_6, OVER_7, OVER_8, OVER_9, OVER_10 = (
    real(1.0 / count) for count in range(2, 11)
)


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
    return x * (S0 + u * (S1 + u * (S2 + u * (S3 + u * (S4 + u * (S5 + u * (S6 + u * S7)))))))


@wp.func
def cosine(x: real) -> real:
    """Cosine for |x| <= 1.65."""
    u = x * x
    return C0 + u * (C1 + u * (C2 + u * (C3 + u * (C4 + u * (C5 + u * (C6 + u * (C7 + u * C8)))))))


@wp.func
def in_range(x: real) -> real:
    """The nearest number of which `sine` and `cosine` are right.

    A rotation leaves their range in the step in which a block overturns, and by any angle.
    """
    return larger(smaller(x, FARTHEST), -FARTHEST)


@wp.func
def cycle(turns: real):
    """Sine and cosine of 2 pi turns for any number of turns, through the half angle."""
    half_angle = real(3.141592653589793) * (turns - wp.floor(turns + real(0.5)))
    s = sine(half_angle)
    c = cosine(half_angle)
    return real(2.0) * s * c, real(1.0) - real(2.0) * s * s


@wp.func
def decay(x: real) -> real:
    """exp(-x) for 0 <= x <= 44, from exp(-x / 64) by six squarings."""
    y = x * real(-0.015625)
    e = E0 + y * (
        E1
        + y
        * (
            E2
            + y
            * (
                E3
                + y
                * (
                    E4
                    + y
                    * (
                        E5
                        + y
                        * (E6 + y * (E7 + y * (E8 + y * (E9 + y * (E10 + y * (E11 + y * E12))))))
                    )
                )
            )
        )
    )
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    e = e * e
    return e * e
