"""Samples kept as a record: one motion, in the unit that is said, or a refusal."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
import pandas as pd
import pytest

import warprock as wr
from warprock.recordings.loading import load_record

TIMES = np.arange(200) * 0.01
PULSE = np.sin(2.0 * np.pi * TIMES)


@pytest.mark.parametrize(
    "samples",
    [
        np.column_stack([TIMES, PULSE]),
        np.vstack([TIMES, PULSE]),
        pd.DataFrame({"time_s": TIMES, "acceleration_g": PULSE}),
        PULSE[:, None],
        PULSE[None, None],
        3.0,
        PULSE + 1j,
        [[0.0, 1.0], [2.0]],
        ["0.1 g", "0.2 g"],
        None,
    ],
)
def test_what_is_no_single_motion_is_refused(samples: Any, tmp_path: pathlib.Path):
    with pytest.raises(wr.InputError, match=r"shape \[sample\]") as said:
        wr.save_record(tmp_path / "mine.csv", samples, interval="0.01 s", unit="g")
    assert "\n" not in str(said.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", [list, tuple, pd.Series, np.float32])
def test_the_samples_come_back(kind: Any, tmp_path: pathlib.Path):
    file = wr.save_record(tmp_path / "mine.csv", kind(PULSE), interval="0.01 s", unit="m/s^2")
    # Of eight digits, or of the seven of float32, half of the last may be rounded away.
    np.testing.assert_allclose(load_record(file).samples, PULSE, rtol=1e-6, atol=1e-7)
