"""Prints the polynomial coefficients of kernels/algebra/scalar.py, fitted in extended precision.

sin(x) = x P(x^2) and cos(x) = Q(x^2) on |x| <= limit, exp(x) = R(x) on [-limit, 0]; each by
interpolation at Chebyshev points with mpmath, so that round-off of the fit stays out.
"""

import mpmath as mp

mp.mp.dps = 60


def chebyshev_fit(function, low, high, degree):
    """Monomial coefficients of the interpolant at the Chebyshev points of [low, high]."""
    count = degree + 1
    nodes = [
        (low + high) / 2 + (high - low) / 2 * mp.cos(mp.pi * (2 * k + 1) / (2 * count))
        for k in range(count)
    ]
    matrix = mp.matrix(count, count)
    for i, node in enumerate(nodes):
        for j in range(count):
            matrix[i, j] = node**j
    return list(mp.lu_solve(matrix, mp.matrix([function(node) for node in nodes])))


def worst(function, coefficients, low, high):
    """Largest error of a polynomial on [low, high]."""
    points = [low + (high - low) * k / 2000 for k in range(2001)]
    return max(abs(mp.polyval(coefficients[::-1], x) - function(x)) for x in points)


def main():
    """Fits and prints."""
    limit = mp.mpf("1.65")
    tiny = mp.mpf("1e-40")
    jobs = {
        "SINE": (lambda u: mp.sin(mp.sqrt(u)) / mp.sqrt(u), tiny, limit**2, 7),
        "COSINE": (lambda u: mp.cos(mp.sqrt(u)), tiny, limit**2, 8),
        "EXPONENTIAL": (mp.exp, -mp.mpf("0.7"), tiny, 12),
    }
    for name, (function, low, high, degree) in jobs.items():
        found = chebyshev_fit(function, low, high, degree)
        print(f"# {name}: remainder {mp.nstr(worst(function, found, low, high), 3)}")
        print(f"{name} = (")
        for value in found:
            print(f"    {float(value)!r},")
        print(")")


if __name__ == "__main__":
    main()
