"""How many times as fast one form of a kernel is as another, on a machine that others use, too."""

from __future__ import annotations

from collections.abc import Callable

import pytest

ROUNDS = 90
"""Pairs of measurements at most. The speed of one core was seen to change by a factor of two within
seconds, for both forms alike; what is no vector code is as fast as the plain form in every pair."""


def require_gain(plain: Callable[[], float], packed: Callable[[], float], least: float) -> None:
    """Fails unless, in some pair of measurements, the packed form is so many times as fast.

    Args:
        plain: Measures the plain form once: its CPU time for some work.
        packed: Measures the packed form once, for as much work.
        least: The gain that is expected.
    """
    found = 0.0
    for _ in range(ROUNDS):
        found = max(found, plain() / packed())
        if found >= least:
            return
    pytest.fail(f"plain / packed = {found:.2f}, expected {least}")
