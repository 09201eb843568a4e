"""Digits, scale and unit of a number are declared with its column, and not where it is said."""

from __future__ import annotations

import ast
import math
import pathlib

import pytest

import warprock.findings
import warprock.tables
from warprock.findings.digits import DIGITS, number_of, quantity_of

ROOMS = [pathlib.Path(room.__path__[0]) for room in (warprock.findings, warprock.tables)]
DECLARED = {"numbers.py", "digits.py", "swept.py", "terminal.py"}
"""Where digits are declared: of columns, and of inputs, which are written as they were typed."""
COUNTS = {",", ".0f", ",.0f", "02d", ".0%", "<{width}", "<30"}
"""Formats of whole numbers, and widths of texts."""


def _formats(file: pathlib.Path) -> list[str]:
    """Formats in texts that say how many digits a number has, with their lines."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    specs = [
        (node.lineno, ast.unparse(node.format_spec)[2:-1])
        for node in ast.walk(tree)
        if isinstance(node, ast.FormattedValue) and isinstance(node.format_spec, ast.JoinedStr)
    ]
    return [f"{file.name}:{line}: {spec}" for line, spec in specs if spec not in COUNTS]


FILES = [file for room in ROOMS for file in sorted(room.glob("*.py"))]


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_a_sentence_or_a_table_formats_no_number_itself(file: pathlib.Path):
    if file.name not in DECLARED:
        assert not _formats(file)


@pytest.mark.parametrize("column", DIGITS)
def test_a_declared_column_says_a_number_and_a_dash(column: str):
    # 2 is the same number in every count of digits.
    text = number_of(column, 2.0 / DIGITS[column].size)
    assert float(text.replace(",", "")) == 2.0
    assert number_of(column, None) == quantity_of(column, math.nan) == "-"
