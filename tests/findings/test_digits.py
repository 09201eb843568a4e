"""Digits, scale and unit of a number are declared with its column, and not where it is said."""

from __future__ import annotations

import ast
import math
import pathlib

import pytest

import warprock.findings
from warprock.findings.digits import DIGITS, number_of, quantity_of

ROOM = pathlib.Path(warprock.findings.__path__[0])
DECLARED = {"numbers.py", "digits.py"}
"""Where digits are declared."""
COUNTS = {",", ".0f", ",.0f", "02d"}
"""Formats of whole numbers."""


def _formats(file: pathlib.Path) -> list[str]:
    """Formats in texts that say how many digits a number has, with their lines."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    specs = [
        (node.lineno, ast.unparse(node.format_spec)[2:-1])
        for node in ast.walk(tree)
        if isinstance(node, ast.FormattedValue) and isinstance(node.format_spec, ast.JoinedStr)
    ]
    return [f"{file.name}:{line}: {spec}" for line, spec in specs if spec not in COUNTS]


@pytest.mark.parametrize("file", sorted(ROOM.glob("*.py")), ids=lambda file: file.stem)
def test_a_sentence_formats_no_number_itself(file: pathlib.Path):
    if file.name not in DECLARED:
        assert not _formats(file)


@pytest.mark.parametrize("column", DIGITS)
def test_a_declared_column_says_a_number_and_a_dash(column: str):
    # 2 is the same number in every count of digits.
    assert float(number_of(column, 2.0).replace(",", "")) == pytest.approx(
        2.0 * DIGITS[column].size, rel=0.5e-2
    )
    assert number_of(column, None) == quantity_of(column, math.nan) == "-"
