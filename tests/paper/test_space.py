"""The paper's Table 7 in space: what is counted, printed and said, from responses made by hand."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

from warprock.model.response import LANE_FIELDS, SPATIAL_FIELDS, Outcome, Response, Status
from warprock.paper import space as reproduce_space
from warprock.paper.print_space import print_space
from warprock.paper.reproduce import reproduce
from warprock.tables.terminal import plain_console
from warprock.verification.checks import CaseResponses

MEMBERS = 10


def answer(responses: CaseResponses, engine: str) -> Response:
    """Of every ten members of `dem` two fall, one wobbles and one has no numbers."""
    lanes = responses.lane_set.lanes
    names = (*LANE_FIELDS, *(SPATIAL_FIELDS if lanes.spatial else ()))
    fields = {name: np.zeros(lanes.lane_count) for name in names}
    fields["peak_rotation"] = 0.2 * lanes.slenderness_angle
    fields["status"] = np.full(lanes.lane_count, Status.OK)
    fields["outcome"] = np.full(lanes.lane_count, Outcome.ROCKING)
    if lanes.spatial and engine == "dem":
        member = np.arange(lanes.lane_count) % MEMBERS
        fields["outcome"][member < 2] = Outcome.OVERTURNED
        fields["peak_time"] = 30.0 + member
        # One that stands leans a tenth of its slenderness across, the fallen ones lie there.
        across = np.arctan2(0.502, 1.0)
        fields["peak_rotation_across"] = np.select([member < 2, member == 2], [1.5, 0.1 * across])
        fields["status"][member == 9] = Status.NONFINITE
    return Response(engine, fields, np.empty(0))


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> dict:
    monkeypatch.setattr(CaseResponses, "_run", answer)
    return reproduce("table7-spatial", tmp_path, members=MEMBERS)


def test_members_are_counted_cell_by_cell(found: dict):
    rows = [row for row in found["rows"] if row["source"] == "dem"]
    assert [(row["frequency_hz"], row["amplitude_mm"]) for row in rows] == [
        *((3.0, 8.0), (3.3, 6.0), (3.3, 8.0)),
        *((5.0, 4.0), (5.0, 5.0), (5.0, 6.0)),
    ]
    for row in rows:
        assert row["usable"] == MEMBERS - 1
        assert row["overturned"] == pytest.approx(2 / 9)
        assert row["wobbling"] == pytest.approx(1 / 9)
        assert row["fell_median_s"] == 30.5
        # The largest of those that stand.
        assert row["peak_rotation_across_deg_max"] == pytest.approx(2.665, abs=1e-3)
        assert row["peak_rotation_ratio_plane"] == pytest.approx(0.2)


def test_the_finding_follows_the_rows(found: dict):
    (conflict,) = found["conflicts"]
    assert conflict["item"] == 13
    assert "With rigid contacts 0 of 10 members fall" in conflict["text"]
    assert "2 of 9 do, the median after 30 s" in conflict["text"]
    assert "under the five other inputs 10 in all" in conflict["text"]


def test_the_table_holds_the_papers_numbers_too(found: dict):
    console = plain_console(width=140, record=True)
    print_space(console, found["rows"])
    text = console.export_text()
    assert "collapsed" in text
    assert "22.2 (" in text
    assert all(name in text for name in reproduce_space.VARIANTS)
