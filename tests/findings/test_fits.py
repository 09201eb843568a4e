"""Fits in sentences and cells."""

from __future__ import annotations

import pandas as pd

from warprock.findings.fits import fit_cells, fit_sentences


def test_lanes_in_doubt_at_one_intensity_are_not_said_to_be_parted() -> None:
    # Arches of ten thicknesses under one motion: "all from 0.2 g up and none up to 0.2 g" is false.
    one = {
        "limit_state": "overturning",
        "verdict": "separated",
        "none_up_to": 2.0,
        "all_from": 2.0,
    }
    rows = pd.DataFrame([one, one | {"all_from": 3.0}])
    mixed, parted = fit_sentences(rows, [], "peak_acceleration_m_s2")
    assert "some lanes reach overturning and some do not" in mixed
    assert mixed.count("0.204 g") == 1
    assert "from a peak base acceleration of 0.306 g up and none up to 0.204 g" in parted
    assert fit_cells(rows.iloc[0])[0].startswith("about 2")
    assert fit_cells(rows.iloc[1])[0].startswith("between 2")
