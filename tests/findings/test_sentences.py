"""What a page says of a run in words."""

from __future__ import annotations

import pandas as pd

from warprock.findings.sentences import peak_sentences


def test_of_thrown_blocks_the_page_says_how_far_they_went() -> None:
    """They lie on any side, so that a peak rotation beyond the slenderness angle is no fall."""
    table = pd.DataFrame(
        {
            "lane": [0, 1],
            "outcome": ["at_rest", "at_rest"],
            "status": ["ok", "ok"],
            "peak_rotation_ratio": [4.5, 2.1],
            "peak_slide_m": [0.25, 0.75],
            "rest_time_s": [0.5, 1.25],
            "attitude_w_start": [1.0, 0.0],
        }
    )
    facts = {"case": {"resolved": {}}}
    (said,) = peak_sentences(facts, table)
    assert said.startswith("The farthest goes 0.750 m along the base, lane 1")
    assert said.endswith("lies still after 1.25 s.")
    (alone,) = peak_sentences(facts, table.iloc[:1])
    assert alone == "It goes 0.250 m along the base and lies still after 0.500 s."
    standing = table.drop(columns="attitude_w_start").assign(peak_rotation_ratio=[0.5, 0.25])
    assert "stayed up" in peak_sentences(facts, standing)[0]
