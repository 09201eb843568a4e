"""Rows of a comparison as JSON holds them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np


def plain_row(row: Mapping[Any, object]) -> dict[str, object]:
    """A row whose values JSON can hold: Python numbers, and None for a missing one."""
    return {str(key): _plain(value) for key, value in row.items()}


def _plain(value: object) -> object:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
