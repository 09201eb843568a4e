"""The comparison with Housner and the checks of a case, on responses whose errors are known."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from tests.shared import closed_forms
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.model import rocking
from warprock.model.response import (
    INTEGER_FIELDS,
    LANE_FIELDS,
    MODEL_FIELDS,
    Outcome,
    Response,
    Status,
)
from warprock.oracle.block_mechanics import PivotingBlock
from warprock.verification import checks
from warprock.verification import housner as comparison
from warprock.verification.checks import CaseResponses, run_checks
from warprock.verification.housner import compare_with_housner

ROUND_OFF = 1e-12


def swinging(lane_set, engine: str = "housner") -> Response:
    """A decaying cosine in every lane: not physics, but a history to be off from."""
    lane_count, times = lane_set.lanes.lane_count, lane_set.times.times
    angle = lane_set.lanes.slenderness_angle
    history = 0.5 * angle[:, None] * np.cos(7.0 * times) * np.exp(-times)
    fields = {
        name: np.zeros(lane_count, dtype=np.int64 if name in INTEGER_FIELDS else np.float64)
        for name in (*LANE_FIELDS, *MODEL_FIELDS)
    }
    fields |= {"peak_rotation": 0.5 * angle, "rest_time": np.full(lane_count, 4.0)}
    return Response(engine, fields | {"rotation": history}, times)


def changed(response: Response, **fields: np.ndarray) -> Response:
    return dataclasses.replace(response, engine="impulse", fields={**response.fields, **fields})


def bumped(response: Response, lane: int, time: float, by: float) -> Response:
    rotation = response["rotation"].copy()
    rotation[lane, int(np.argmin(np.abs(response.times - time)))] += by
    return changed(response, rotation=rotation)


@pytest.fixture(scope="module")
def free():
    return expand_lanes(load_case("free-b1-b3"))


@pytest.fixture(scope="module")
def pulse():
    return expand_lanes(load_case("single-sine-pulse"))


def test_an_equal_response_has_no_error_and_holds(free):
    reference = swinging(free)
    table = compare_with_housner(free, changed(reference), reference)
    assert len(table) == 9
    assert table["holds"].all()
    assert (table["why"] == "").all()
    columns = ["error_5s_ratio", "error_run_ratio", "peak_error", "rest_time_error_s"]
    assert (table[columns] == 0.0).all(axis=None)


@pytest.mark.parametrize(("time", "early"), [(2.0, True), (5.0, True), (5.02, False), (9.0, False)])
def test_a_known_shift_is_the_error(free, time: float, early: bool):
    reference = swinging(free)
    angle = free.lanes.slenderness_angle[4]
    table = compare_with_housner(free, bumped(reference, 4, time, -0.01 * angle), reference)
    run = table["error_run_ratio"].to_numpy()
    assert run[4] == pytest.approx(0.01, abs=ROUND_OFF)
    assert table["error_5s_ratio"].to_numpy()[4] == pytest.approx(
        0.01 if early else 0.0, abs=ROUND_OFF
    )
    assert np.count_nonzero(run) == 1


def test_peak_and_rest_errors_have_a_sign(free):
    reference = swinging(free)
    response = changed(
        reference,
        peak_rotation=0.98 * reference["peak_rotation"],
        rest_time=reference["rest_time"] + 0.25,
    )
    table = compare_with_housner(free, response, reference)
    np.testing.assert_allclose(table["peak_error"], -0.02, atol=ROUND_OFF)
    np.testing.assert_allclose(table["rest_time_error_s"], 0.25, atol=ROUND_OFF)


def test_what_does_not_exist_is_nan(free):
    reference = swinging(free)
    bare = {name: reference[name] for name in (*LANE_FIELDS, *MODEL_FIELDS)}
    still = bare | {"peak_rotation": np.zeros(9), "rest_time": np.full(9, np.nan)}
    table = compare_with_housner(
        free,
        Response("impulse", bare, np.empty(0)),
        Response("housner", still, np.empty(0)),
    )
    assert table["error_run_ratio"].isna().all()
    assert table["peak_error"].isna().all()
    assert table["rest_time_error_s"].isna().all()


def test_histories_count_until_a_block_lies_flat(free):
    reference = swinging(free)
    flat = np.where(reference.times >= 3.0, 0.5 * np.pi, reference["rotation"][0])
    rotation = reference["rotation"].copy()
    rotation[0] = flat
    outcome = reference["outcome"].copy()
    outcome[0] = Outcome.OVERTURNED
    table = compare_with_housner(
        free, changed(reference, rotation=rotation, outcome=outcome), reference
    )
    assert table["error_run_ratio"][0] == 0.0
    assert (table["outcome"][0], table["reference_outcome"][0]) == ("overturned", "at_rest")


def test_histories_at_other_times_are_refused(free):
    reference = swinging(free)
    late = dataclasses.replace(changed(reference), times=reference.times + 0.001)
    with pytest.raises(ValueError, match="sampled at different times"):
        compare_with_housner(free, late, reference)


def test_a_slide_beyond_the_bound_is_a_reason(free):
    reference = swinging(free)
    slide = comparison.SLIDE_BOUND * free.lanes.width
    sliding = changed(reference, peak_slide=slide)
    assert not any(comparison.where_housner_holds(free, sliding, reference))
    sliding = changed(reference, peak_slide=4.0 * slide)
    why = comparison.where_housner_holds(free, sliding, reference)
    assert why[0] == "slides 2 mm"


def test_a_status_is_a_reason(free):
    reference = swinging(free)
    status = np.full(9, Status.OK)
    status[3] = Status.EVENT_LIMIT
    why = comparison.where_housner_holds(free, changed(reference, status=status), reference)
    assert [bool(text) for text in why] == [lane == 3 for lane in range(9)]
    assert why[3] == "status event_limit"


def test_friction_that_housners_block_lacks_is_a_reason(free):
    """As Housner's own response says: its status decides, the friction it needs is the reason."""
    needed = np.array([0.2, 0.9, 1.3, np.inf, 0.5, 0.5, 0.5, 0.5, 0.5])
    status = np.where(needed > 1.0, Status.OUTSIDE_MODEL, Status.OK)
    fields = {**swinging(free).fields, "friction_needed": needed, "status": status}
    reference = Response("housner", fields, free.times.times)
    impulse = changed(reference, status=np.zeros(9, np.int64))
    for response in (reference, impulse):
        why = comparison.where_housner_holds(free, response, reference)
        assert [lane for lane, text in enumerate(why) if text] == [2, 3]
        assert why[2] == "the block needs more friction than it has: 1.3 for 1"
        assert why[3] == "the base would have to pull the block"
        table = compare_with_housner(free, response, reference)
        np.testing.assert_array_equal(table["holds"], status == Status.OK)
        np.testing.assert_array_equal(table["friction_needed"], needed)


def test_a_prescribed_restitution_is_a_reason_for_other_engines():
    prescribed = expand_lanes(load_case("free-b1-b3", ["contact.angular_restitution=0.8"]))
    housner = swinging(prescribed)
    assert not any(comparison.where_housner_holds(prescribed, housner, housner))
    assert all(comparison.where_housner_holds(prescribed, changed(housner), housner))


def _blocks(lanes):
    return [
        PivotingBlock(
            *(float(a[lane]) for a in (lanes.width, lanes.height, lanes.depth, lanes.density)), None
        )
        for lane in range(lanes.lane_count)
    ]


def test_friction_of_a_velocity_step_follows_from_its_impulses(pulse):
    """The block's rate after the step, by moments of vectors, moves its centre so much."""
    lanes = pulse.lanes
    for lane, block in enumerate(_blocks(lanes)):
        rate = abs(block.rate_step(-1, 0.0, (1.0, 0.0)))
        along = 1.0 - 0.5 * lanes.height[lane] * rate
        across = 0.5 * lanes.width[lane] * rate
        needed = closed_forms.velocity_step_friction(lanes.width[lane], lanes.height[lane])
        assert needed == pytest.approx(along / across, rel=ROUND_OFF)


def test_friction_of_an_impact_follows_from_its_impulses(free):
    lanes = free.lanes
    for lane, block in enumerate(_blocks(lanes)):
        after = block.rate_after_impact(1, -1.0)
        along = 0.5 * lanes.height[lane] * (1.0 - after)
        across = 0.5 * lanes.width[lane] * (1.0 + after)
        needed = rocking.impact_friction(lanes.width[lane], lanes.height[lane])
        assert needed == pytest.approx(along / across, rel=ROUND_OFF)


@pytest.fixture
def answered(monkeypatch):
    """Lets `CaseResponses` answer with given responses, engines not given with that of housner."""

    def answer(**responses: Response) -> None:
        monkeypatch.setattr(
            CaseResponses, "_run", lambda _self, engine: responses.get(engine, responses["housner"])
        )

    return answer


def test_a_housner_check_passes_at_its_limit_and_fails_above(free, answered):
    case = load_case("free-b1-b3")
    reference = swinging(free)
    limit = case.checks[0].limit_5s
    angle = free.lanes.slenderness_angle[5]
    for factor, passes in ((0.99, True), (1.01, False)):
        answered(housner=reference, impulse=bumped(reference, 5, 1.0, factor * limit * angle))
        row = run_checks(case)[0]
        assert row.ok is passes
        assert row.value == pytest.approx(factor * limit, rel=1e-9)
        assert "worst lane: B2 0.99 of slenderness" in row.note


def test_a_housner_check_leaves_out_what_slides_and_says_so(free, answered):
    reference = swinging(free)
    slide = np.zeros(9)
    slide[5] = 0.01
    wrong = changed(bumped(reference, 5, 1.0, 0.2), peak_slide=slide)
    answered(housner=reference, impulse=wrong)
    row = run_checks(load_case("free-b1-b3"))[0]
    assert row.ok
    assert "B2 0.99 of slenderness left out (slides 10 mm)" in row.note


def test_a_housner_check_without_a_lane_left_fails(free, answered):
    reference = swinging(free)
    answered(housner=reference, impulse=changed(reference, peak_slide=np.ones(9)))
    row = run_checks(load_case("free-b1-b3"))[0]
    assert not row.ok
    assert "nothing was checked" in row.note


def test_a_response_that_is_not_finite_fails(free, answered):
    reference = swinging(free)
    answered(housner=reference, impulse=bumped(reference, 0, 1.0, np.nan))
    assert not run_checks(load_case("free-b1-b3"))[0].ok


def test_a_peaks_check_compares_its_own_lanes(pulse, answered):
    case = load_case("single-sine-pulse")
    ratio = np.full(18, np.nan)
    for check in case.checks:
        ratio[pulse.select(check.where)] = check.values
    response = swinging(pulse)
    exact = ratio * pulse.lanes.slenderness_angle
    answered(
        housner=dataclasses.replace(response, fields={**response.fields, "peak_rotation": exact})
    )
    rows = run_checks(case)
    assert len(rows) == len(case.checks)
    assert all(row.ok and row.value <= ROUND_OFF for row in rows)
    exact[7] *= 1.1
    answered(
        housner=dataclasses.replace(response, fields={**response.fields, "peak_rotation": exact})
    )
    rows = run_checks(case)
    assert [row.lanes for row in rows if not row.ok] == ["reading = acceleration"]
    assert "worst lane: acceleration 3.3 Hz 6 mm" in next(row.note for row in rows if not row.ok)


def test_compare_gives_rows_that_json_can_hold(free, answered):
    reference = swinging(free)
    never = changed(reference, rest_time=np.full(9, np.nan))
    answered(housner=reference, impulse=never)
    found = checks.compare(load_case("free-b1-b3"), ["housner", "impulse"])
    assert len(found["rows"]) == 18
    assert found["rows"][9]["engine"] == "impulse"
    assert found["rows"][9]["rest_time_error_s"] is None
    json.dumps(found, allow_nan=False)


def test_compare_refuses_an_unknown_engine():
    with pytest.raises(InputError, match=r"got 'bulllet', allowed: bullet, .* and \d+ more"):
        checks.compare(load_case("free-b1-b3"), ["bulllet"])


def test_every_kind_of_check_has_a_function():
    """Kinds as the case files' own model knows them."""
    from warprock.case.check import CHECKS

    assert set(CHECKS) == set(checks.CHECKS)
