"""What `housner` says of its contact: the friction that a lane needs, and where its model ends.

Held against closed forms, against the SciPy oracle, whose forces come from vectors and Newton's
law, and against `event`, whose block may slide and leave its base.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared import closed_forms
from tests.shared.blocks import Array, make_lanes, sines, velocity_steps
from warprock.case.load import load_case
from warprock.engines.launching import Form
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, HarmonicMotions, StillBase, UprightMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.oracle.block import oracle_response
from warprock.running import engine_choice
from warprock.running.batch import run_batch
from warprock.running.engine_choice import choose_engine, lanes_to_try
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

ROUND_OFF = 1e-12

TURNING = 1e-4
"""Relative error of a largest |force along / upwards| that lies inside a step: a parabola through
the slope of a margin over a step of 0.4 of the fastest rate, squared."""


def random_blocks(seed: int, count: int, control: Control) -> tuple[Lanes, HarmonicMotions]:
    """Blocks of many sizes and frictions that lift before they slide, under two cycles of sine."""
    chance = np.random.default_rng(seed)
    height = 10.0 ** chance.uniform(-0.5, 1.0, count)
    ratio = np.exp(chance.uniform(np.log(0.08), np.log(0.8), count))
    friction = np.maximum(1.0001 * ratio, chance.choice([0.3, 0.6, 1.0, 1.3, 3.0], count))
    frequency = 10.0 ** chance.uniform(-0.5, 1.0, count)
    acceleration = GRAVITY * ratio * 10.0 ** chance.uniform(0.0, 0.8, count)
    start = np.where(chance.random(count) < 0.3, chance.uniform(-0.9, 0.9, count), 0.0)
    rate = 2.0 * np.pi * frequency
    size = acceleration / rate ** {"displacement": 2, "velocity": 1, "acceleration": 0}[control]
    motions = sines(control, size, frequency, 2.0, start=0.1)
    return make_lanes(ratio * height, height, start, friction), motions


def differences(ours: Response, theirs: Response, slenderness: Array) -> Array:
    """Largest |difference of rotations| / slenderness angle, of falls in both up to the angle."""
    fell = (ours["outcome"] == Outcome.OVERTURNED) & (theirs["outcome"] == Outcome.OVERTURNED)
    limit = np.where(fell, slenderness, np.inf)[:, None]
    one, other = (np.clip(each["rotation"], -limit, limit) for each in (ours, theirs))
    return np.asarray(np.abs(one - other).max(axis=1) / slenderness)


@pytest.mark.parametrize(
    "control",
    [
        Control.DISPLACEMENT,
        pytest.param(Control.VELOCITY, marks=pytest.mark.thorough),
        pytest.param(Control.ACCELERATION, marks=pytest.mark.thorough),
    ],
)
def test_friction_needed_is_that_of_the_oracle(control: Control) -> None:
    lanes, motions = random_blocks(2, 16, control)
    times = SampleTimes(1.5, 0.01)
    ours, oracle = (
        run_batch("housner", lanes, motions, times),
        oracle_response(lanes, motions, times),
    )
    assert np.max(differences(ours, oracle, lanes.slenderness_angle)) < 1e-8
    np.testing.assert_array_equal(ours["status"], oracle["status"])
    needed, expected = ours["friction_needed"], oracle["friction_needed"]
    # In a fall it is still growing where the fall is no longer judged, at a time that `housner`
    # knows less well, so that only the status is the same there.
    stands = ours["outcome"] != Outcome.OVERTURNED
    np.testing.assert_array_equal(np.isinf(needed[stands]), np.isinf(expected[stands]))
    finite = stands & np.isfinite(expected)
    np.testing.assert_allclose(needed[finite], expected[finite], rtol=TURNING)
    assert ours.count(Status.OUTSIDE_MODEL) >= 3
    assert np.count_nonzero(finite) >= 4


@pytest.mark.parametrize("control", [Control.DISPLACEMENT, Control.ACCELERATION])
def test_plain_and_packed_kernels_say_the_same(control: Control) -> None:
    lanes, motions = random_blocks(3, 64, control)
    plain, packed = (
        run_batch("housner", lanes, motions, SampleTimes(2.0), form=form)
        for form in (Form.PLAIN, Form.PACKED)
    )
    np.testing.assert_array_equal(plain["status"], packed["status"])
    np.testing.assert_allclose(plain["friction_needed"], packed["friction_needed"], rtol=1e-6)


def test_an_uplift_needs_tan_of_the_slenderness_angle() -> None:
    # Just above its uplift acceleration the block hardly moves: the force is that of uplift.
    ratio = np.array([0.1, 0.3, 0.7])
    lanes = make_lanes(ratio, 1.0, friction=1.0)
    push = 1.000001 * GRAVITY * ratio
    response = run_batch(
        "housner", lanes, sines(Control.ACCELERATION, push, 1.0, 0.5), SampleTimes(1.0)
    )
    np.testing.assert_allclose(response["friction_needed"], ratio, rtol=2e-6)
    assert np.all(response["status"] == Status.OK)
    # Below it the block stays where it is, and its base takes it along.
    rests = sines(Control.ACCELERATION, 0.999 * push, 1.0, 0.5)
    needed = run_batch("housner", lanes, rests, SampleTimes(1.0))["friction_needed"]
    np.testing.assert_allclose(needed, 0.999 * push / GRAVITY, rtol=ROUND_OFF)


@pytest.mark.thorough
@pytest.mark.parametrize("duration", [0.03, 0.2, 1.0])
def test_a_block_at_rest_needs_the_largest_acceleration_over_weight(duration: float) -> None:
    draw = np.random.default_rng(4)
    count = 8
    a, z = draw.uniform(0.1, 1.0, count), draw.uniform(0.5, 6.0, count)
    f, up = draw.uniform(1.0, 4.0, (2, count))
    along = sines(Control.ACCELERATION, a, f, cycles=2.0)
    upwards = sines(Control.ACCELERATION, z, up, cycles=2.0)
    lanes = make_lanes(np.full(count, 2.0), 1.0, friction=9.0)
    time = np.linspace(0.0, duration, 400_001)
    shapes = [
        np.where(time < 2.0 / each[:, None], np.sin(2.0 * np.pi * each[:, None] * time), 0.0)
        for each in (f, up)
    ]
    # Of a crest among 400,000 looks 4e-10 are lost.
    for motions, weight, error in (
        (along, np.full((count, 1), GRAVITY), 1e-9),
        (UprightMotions(along, upwards), GRAVITY + z[:, None] * shapes[1], TURNING),
    ):
        found = run_batch("housner", lanes, motions, SampleTimes(duration))
        assert np.isnan(found["uplift_time"]).all()
        expected = np.max(np.abs(a[:, None] * shapes[0]) / weight, axis=1)
        np.testing.assert_allclose(found["friction_needed"], expected, rtol=error)


def test_a_velocity_step_needs_what_its_impulse_does() -> None:
    needed = closed_forms.velocity_step_friction(0.17, 1.0)
    lanes = make_lanes(np.full(4, 0.17), 1.0, friction=needed * np.array([0.99, 1.01, 9.0, 9.0]))
    # A step throws a block back; one the same way pulls a block that still leans back from it.
    first, second = np.array([0.2, -0.2, 0.1, 0.1]), np.array([0.0, 0.0, 0.1, -0.1])
    motions = velocity_steps(first, second, np.full(4, 0.05))
    response = run_batch("housner", lanes, motions, SampleTimes(0.1))
    np.testing.assert_allclose(response["friction_needed"][:2], needed, rtol=ROUND_OFF)
    # It leans to -x by now: a step to +x pushes that corner on, one to -x takes it away.
    assert response["friction_needed"][2] > needed
    assert np.isinf(response["friction_needed"][3])
    outside = [Status.OUTSIDE_MODEL, Status.OK, Status.OK, Status.OUTSIDE_MODEL]
    assert response["status"].tolist() == outside


def test_an_impact_needs_what_its_impulse_does() -> None:
    # With Housner's restitution less than an uplift does, with a smaller one more.
    ratio, restitution = 0.1, np.array([0.985, 0.9, 0.9])
    impact = rocking.impact_friction(ratio, 1.0, restitution)
    assert impact[1] == pytest.approx(0.1 / 1.9 / ratio, rel=ROUND_OFF)
    friction = np.array([0.2, 1.01, 0.99]) * np.array([1.0, impact[1], impact[2]])
    lanes = make_lanes(np.full(3, ratio), 1.0, 0.5, friction, restitution)
    response = run_batch("housner", lanes, StillBase(3), SampleTimes(2.0))
    np.testing.assert_allclose(response["friction_needed"][1:], impact[1:], rtol=ROUND_OFF)
    assert response["status"].tolist() == [Status.OK, Status.OK, Status.OUTSIDE_MODEL]


def test_the_end_of_a_fall_is_not_judged() -> None:
    # A block that falls from rest on a still base is carried by (m g / 4) (1 - 3 cos(phi))^2: no
    # friction holds it where cos(phi) = 1/3, phi being the angle beyond its balance.
    lanes = make_lanes(np.full(2, 0.2), 1.0, 0.99, friction=np.array([0.5, 5.0]))
    kick = velocity_steps(np.full(2, -0.6), np.zeros(2), np.full(2, 5.0))
    response = run_batch("housner", lanes, kick, SampleTimes(5.0))
    assert np.all(response["outcome"] == Outcome.OVERTURNED)
    # The step itself needs more than 0.5.
    assert response["status"].tolist() == [Status.OUTSIDE_MODEL, Status.OUTSIDE_MODEL]
    push = sines(Control.ACCELERATION, np.full(2, 0.1), 1.0, 0.5)
    lanes = make_lanes(np.full(2, 0.2), 1.0, -0.999, friction=np.array([0.5, 5.0]))
    response = run_batch("housner", lanes, push, SampleTimes(5.0))
    assert np.all(response["outcome"] == Outcome.OVERTURNED)
    assert np.all(response["status"] == Status.OK)
    # Its |force along / upwards| is |sin(phi) (9 cos(phi) - 6)| / (1 - 3 cos(phi))^2: the largest
    # up to the friction angle, or up to 45 degrees.
    for end, needed in zip(np.arctan([0.5, 1.0]), response["friction_needed"], strict=True):
        phi = np.linspace(0.0, end, 1001)
        force = np.abs(np.sin(phi) * (9.0 * np.cos(phi) - 6.0)) / (1.0 - 3.0 * np.cos(phi)) ** 2
        assert needed == pytest.approx(force.max(), rel=0.01)


@pytest.mark.parametrize("control", list(Control))
def test_contact_engines_part_from_housner_where_he_says_so_and_nowhere_else(
    control: Control,
) -> None:
    lanes, motions = random_blocks(1, 96, control)
    times = SampleTimes(2.0, 0.01)
    housner = run_batch("housner", lanes, motions, times)
    event = run_batch("event", lanes, motions, times, settings=EventSettings(time_step=5e-4))
    gap = differences(event, housner, lanes.slenderness_angle)
    # What has come back or has fallen: a run that ends in a fall has no peak.
    ratio = housner["peak_rotation"] / lanes.slenderness_angle
    moved = (ratio > 1e-2) & ((ratio < 1.0) | (housner["outcome"] == Outcome.OVERTURNED))
    inside = moved & (housner["status"] == Status.OK)
    outside = housner["status"] == Status.OUTSIDE_MODEL
    assert min(np.count_nonzero(inside), np.count_nonzero(outside)) >= 4
    # (p dt)^2 = 2e-5 for the smallest block, times the growth of a difference near balance.
    assert np.max(gap[inside]) < 3e-3
    assert np.median(gap[inside]) < 3e-5
    stands = inside & (event["outcome"] != Outcome.OVERTURNED)
    assert np.max(event["peak_slide"][stands] / lanes.width[stands], initial=0.0) < 1e-9
    assert np.median(gap[outside]) > 1e-2


def test_engine_where_none_is_named_follows_the_rule(monkeypatch: pytest.MonkeyPatch) -> None:
    def chosen(case: str, *overrides: str) -> tuple[str, int]:
        choice = choose_engine(load_case(case, overrides))
        return choice.engine, choice.outside

    pulse = "single-sine-pulse"
    # Six lanes start with a velocity step that needs friction 2.19.
    assert chosen(pulse) == ("event", 6)
    assert chosen(pulse, "contact.friction=100") == ("event", 1)
    assert chosen("free-b0") == ("housner", 0)
    # Slides before it rocks: tan(alpha) is 0.2.
    assert chosen("free-b0", "contact.friction=0.1") == ("event", 0)
    # No contact engine can be told how much an impact leaves.
    assert chosen("free-b0", "contact.angular_restitution=0.9") == ("housner", 0)
    assert chosen("stack-sine-pulse") == ("event", 0)
    monkeypatch.setattr(engine_choice, "LANES_JUDGED", 5)
    assert 1 <= chosen(pulse)[1] <= 5


@pytest.mark.parametrize("count", [1, 18, 1000, 1001, 10**6, 77 * 57 * 3])
def test_lanes_judged_are_few_and_meet_every_value_of_an_axis(count: int) -> None:
    lanes = lanes_to_try(count)
    assert min(count, 500) <= len(lanes) <= 1000
    for length in (3, 10, 57, 77, 100):
        if count % length == 0 and length <= len(lanes):
            assert len({lane % length for lane in lanes}) == length
