"""Poses that were observed: read, and held against responses."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.case.text import data_folder
from warprock.errors import InputError
from warprock.model.pose import product, quaternion
from warprock.model.response import Response
from warprock.verification.checks import compare
from warprock.verification.observed_poses import pose_rows
from warprock.verification.poses import (
    compare_poses,
    face_up,
    histories_of_errors,
    interpolate,
    read_poses,
    rotation_between,
)

CASE = "cube-tosses"


@pytest.fixture(scope="module")
def case():
    return load_case(CASE)


@pytest.fixture(scope="module")
def lane_set(case):
    return expand_lanes(case)


@pytest.fixture(scope="module")
def seen(case, lane_set):
    return read_poses(case, lane_set, "observed.csv")


def echo(seen, times, *, shift=0.0, turn=0.0):
    """A response that repeats what was seen, moved along x and turned about z."""
    place, attitude = zip(
        *(interpolate(np.minimum(times, s.times[-1]), s.times, s.position, s.attitude)
          for s in seen), strict=True,
    )  # fmt: skip
    moved = np.array(place) + np.array([shift, 0.0, 0.0])
    turned = product(np.broadcast_to(quaternion(np.array([0.0, 0.0, turn])),
                                     np.shape(attitude)), np.array(attitude))  # fmt: skip
    fields = dict(zip("xyz", np.moveaxis(moved, -1, 0), strict=True))
    fields |= {f"attitude_{part}": turned[..., k] for k, part in enumerate("xyzw")}
    return Response("echo", fields, times)


def test_the_case_ships_what_was_seen_of_each_of_its_lanes(lane_set, seen):
    assert [each.lane for each in seen] == list(range(40))
    for each in seen:
        # It starts where the case lets it go, and comes to rest on one of its faces: the table
        # of the cameras is level to 3 mm.
        release = lane_set.lanes.release
        np.testing.assert_allclose(each.position[0, 2], release.height[each.lane], atol=1e-5)
        assert abs(np.sum(each.attitude[0] * release.attitude[each.lane])) > 1.0 - 1e-7
        assert each.position[-1, 2] == pytest.approx(0.0524, abs=3e-3)


def test_the_drops_start_as_they_were_seen_and_bounce():
    """They stay in their plane; the lowest corner of 60 mm comes to the table, to 5 mm."""
    drops = load_case("square-drops")
    lanes, low = expand_lanes(drops), []
    found = read_poses(drops, lanes, "observed.csv")
    assert [each.lane for each in found] == list(range(60))
    for each in found:
        release = lanes.lanes.release
        np.testing.assert_allclose(each.position[0, 2], release.height[each.lane], atol=1e-5)
        assert abs(np.sum(each.attitude[0] * release.attitude[each.lane])) > 1.0 - 1e-7
        assert not np.any(each.position[:, 1])
        assert not np.any(each.attitude[:, [0, 2]])
        angle = 2.0 * np.arctan2(each.attitude[:, 1], each.attitude[:, 3])
        reach = 0.03 * (np.abs(np.sin(angle)) + np.abs(np.cos(angle)))
        low.append(np.min(each.position[:, 2] - reach))
        assert each.times[-1] == 0.12
        # It has fallen, and rises again or has risen.
        assert np.diff(each.position[:, 2]).max() > 0.0
    assert np.abs(np.median(low)) < 5e-3


@pytest.mark.thorough
def test_bounces_take_event_to_the_drops():
    """The kernel is that of tests/engines/test_event_bounce.py; its fit has seen none of them."""
    drops = load_case("square-drops")
    found = compare(drops, ["event", "impulse"])
    errors = {
        (engine, name): np.mean([row[name] for row in found["rows"] if row["engine"] == engine])
        for engine in ("event", "impulse")
        for name in ("position_error_mm", "rotation_error_deg")
    }
    for check in drops.checks:
        assert errors[check.engine, "position_error_mm"] < 1e3 * check.position
        assert errors[check.engine, "rotation_error_deg"] < np.rad2deg(check.rotation)
    # Newton's law in two schemes: far nearer to one another than to what was seen.
    assert abs(np.subtract(*(errors[e, "position_error_mm"] for e in ("event", "impulse")))) < 0.2


def test_errors_of_what_is_moved_and_turned_are_that_way_and_that_angle(lane_set, seen):
    times = np.arange(0.0, 0.9, 1e-3)
    table = compare_poses(lane_set, echo(seen, times, shift=0.01, turn=0.2), seen)
    # Corners of what was seen lie up to half a sample of 1 ms from one of the response.
    np.testing.assert_allclose(table["position_error_mm"], 10.0, atol=0.5)
    np.testing.assert_allclose(table["rotation_error_deg"], np.rad2deg(0.2), atol=0.3)
    np.testing.assert_allclose(table["position_error_at_end_mm"], 10.0, atol=0.02)
    assert table["same_face"].all()
    told = histories_of_errors(echo(seen, times, shift=0.01), seen)
    np.testing.assert_allclose(told["position_error_mm"], 10.0, atol=0.5)
    assert (told["lanes"][0], told["lanes"][-1]) == (40, 1)


def test_the_angle_between_attitudes_is_right_for_small_and_large_ones():
    first = quaternion(np.array([0.3, -0.2, 0.9]))
    for angle in (0.0, 1e-9, 1e-3, 1.0, np.pi):
        second = product(quaternion(np.array([0.0, angle, 0.0])), first)
        assert rotation_between(first, -second) == pytest.approx(angle, abs=1e-15, rel=1e-7)


def test_the_face_at_the_top_has_a_number():
    turns = np.array([(0.0, 0.0, 1.0), (np.pi, 0.0, 0.0), (0.0, -0.5 * np.pi, 0.0)])
    assert [face_up(q) for q in quaternion(turns)] == [2, 5, 0]


def test_a_check_of_poses_fails_beyond_its_limits(case, lane_set, seen):
    check = case.checks[0]
    response = echo(seen, np.arange(0.0, 0.9, 5e-3), shift=0.02)
    place, turn = pose_rows(check, case, lane_set, response, "all")
    assert (place.ok, turn.ok) == (False, True)
    assert place.value == pytest.approx(20.0, abs=0.5)
    assert turn.limit == pytest.approx(25.0)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda s: s.replace("toss,", "cube,", 1), "must have a column for a label of the case"),
        (lambda s: s.replace("z_m,", "height,", 1), "z_m: got nothing, must be a column"),
        (lambda s: s.replace("\n0,0.0,0.0,", "\n0,0.0,oops,", 1), "x_m, row 1: got 'oops', must"),
        (lambda s: s.replace("\n0,0.0,", "\n0,0.2,", 1), "time_s, rows from 1: .* must rise"),
        (lambda s: s.replace("\n0,", "\n1000,", 1), "toss: got '1000', must be labels of a lane"),
        (lambda s: s.replace(",0.432\n", ",0.9\n", 1), "attitude, row 1: .* length 1"),
    ],
)
def test_a_file_that_tells_no_poses_is_refused(case, lane_set, tmp_path, change, text):
    file = data_folder(CASE, None) / "observed.csv"
    (tmp_path / "bad.csv").write_text(change(file.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(InputError, match=text):
        read_poses(case, lane_set, str(tmp_path / "bad.csv"))


@pytest.mark.parametrize("engine", ["impulse", pytest.param("event", marks=pytest.mark.thorough)])
def test_compare_holds_engines_against_what_was_seen(engine: str):
    """The kernels are those of tests/engines/test_thrown.py."""
    engines = [engine, f"{engine}@restitution=0" if engine == "impulse" else "impulse"]
    found = compare(load_case(CASE), engines)
    assert found["observed"] == "observed.csv"
    assert len(found["rows"]) == 80
    for name in engines:
        mine = [row for row in found["rows"] if row["engine"] == name]
        # Two rigid engines on one law of contact: most tosses end on the face that was seen.
        assert np.mean([row["same_face"] for row in mine]) > 0.7
        early = np.array(found["over_time"][name]["position_error_mm"])[:5]
        assert np.all(early < 3.0)
