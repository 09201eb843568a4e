"""Numbers as a reader wants them, on the terminal, on a page and in a notebook."""

from __future__ import annotations

import pytest

from warprock.findings.numbers import three


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.5, "0.500"),
        (123.4, "123"),
        (1234.5, "1,234"),
        (1.29979e7, "1.30e7"),
        (1.06e-5, "1.06e-5"),
        (999.7, "1,000"),
        (0.0, "0"),
        (3, "3"),
        (True, "yes"),
        (float("nan"), "-"),
        (float("inf"), "infinite"),
    ],
)
def test_numbers_have_three_digits(value: float, text: str):
    assert three(value) == text
