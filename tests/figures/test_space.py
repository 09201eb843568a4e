"""Figures of blocks in space."""

from __future__ import annotations

import numpy as np

from warprock.figures.space import _message


def test_a_title_has_no_exponents() -> None:
    yaw = np.array([0.0, -123.4])
    said = _message([(yaw, np.array([0.0, 1.46]), yaw)], "")
    assert "up to 1.5 of" in said
    assert said.endswith("120 deg")
