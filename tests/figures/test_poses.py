"""The figure and the table of engines beside observed poses."""

from __future__ import annotations

import io

import pytest

from warprock.figures.poses import draw_poses
from warprock.tables.poses import print_pose_comparison
from warprock.tables.terminal import plain_console

ROW = {
    "position_error_mm": 10.0, "rotation_error_deg": 5.0, "position_error_at_end_mm": 20.0,
    "rotation_error_at_end_deg": 8.0, "same_face": True,
}  # fmt: skip
TIMES = {"time_s": [0.0, 0.1, 0.2], "lanes": [2, 2, 0],
         "position_error_mm": [0.0, 10.0, 30.0], "rotation_error_deg": [0.0, 5.0, 9.0]}  # fmt: skip


@pytest.fixture
def found():
    far = ROW | {"position_error_mm": 30.0, "same_face": False}
    rows = [ROW | {"engine": "event"}, far | {"engine": "event"}]
    rows += [far | {"engine": "bullet"}, far | {"engine": "bullet", "rotation_error_deg": None}]
    return {
        "case": "made-up", "engines": ["event", "bullet"], "rows": rows,
        "over_time": {"event": TIMES, "bullet": TIMES},
    }  # fmt: skip


def test_a_curve_ends_where_less_than_half_of_the_lanes_are_seen(found):
    (drawing,) = draw_poses(found)
    assert drawing.title == "event is 20 mm from what was seen, in the mean; bullet is 30 mm"
    places, turns = drawing.figure.axes
    assert [list(line.get_xdata()) for line in places.lines] == [[0.0, 0.1]] * 2
    assert list(turns.lines[0].get_ydata()) == [0.0, 5.0]


def test_the_table_has_means_and_medians_and_how_often_the_face_is_right(found):
    text = io.StringIO()
    print_pose_comparison(found, plain_console(file=text, width=120))
    lines = text.getvalue().splitlines()
    event = next(line for line in lines if line.strip().startswith("event "))
    assert event.split() == ["event", "20.0", "(20.0)", "5.0", "(5.0)", "20.0", "(20.0)", "8.0",
                             "(8.0)", "50%"]  # fmt: skip
    # A lane without a number has no mean.
    bullet = next(line for line in lines if line.strip().startswith("bullet "))
    assert "- (5.0)" in bullet
    assert "event is nearest to what was seen, 20.0 mm off." in text.getvalue()
