"""The event engine on stacks: against Housner, the two-block oracle, closed forms and balances."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import (
    at_rest,
    every_height_of_stack,
    free_lanes,
    make_stacks,
    sines,
    velocity_steps,
)
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, StillBase
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.oracle.pair import rock_two_blocks
from warprock.oracle.pair_mechanics import TwoBlocks
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings, ImpulseSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

STEPS = np.array([4e-2, 2e-2, 1e-2, 5e-3])
PAIR = {"width": (0.2, 0.15), "height": (0.6, 0.6), "chamfer": (0.005, 0.005)}
WIDE_TOP = {"width": (0.15, 0.2), "height": (0.5, 0.6), "chamfer": (0.0, 0.0)}


def stacks(
    width: npt.ArrayLike,
    height: npt.ArrayLike,
    *,
    friction: npt.ArrayLike = 10.0,
    chamfer: npt.ArrayLike = 0.0,
    offset: npt.ArrayLike = 0.0,
    start: npt.ArrayLike = 0.0,
    density: npt.ArrayLike = 2000.0,
) -> Lanes:
    """Stacks, shape [lane, block], from values that broadcast against each other."""
    parts = np.broadcast_arrays(
        *(np.atleast_2d(p) for p in (width, height, 0.5, density, friction, chamfer, offset, start))
    )
    count = parts[0].shape[0]
    return Lanes(*(np.array(p, dtype=np.float64) for p in parts), np.ones(count))


def respond(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, step: float = 5e-3
) -> Response:
    """Response of `event` at a time step [s], every lane sound."""
    settings = EventSettings(time_step=step)
    response = run_batch("event", lanes, motions, times, settings=settings)
    assert np.all(response["status"] == Status.OK)
    return response


def orders(found: Array) -> Array:
    """Slope of log(error) over log(step) of every column."""
    return np.asarray(np.polyfit(np.log(STEPS), np.log(found), 1)[0])


@pytest.mark.thorough
def test_stack_of_one_is_the_single_block() -> None:
    single = free_lanes()
    arrays = single.arrays.items()
    columns = {name: each[:, None] for name, each in arrays if name != "angular_restitution"}
    lanes = Lanes(**columns, angular_restitution=single.angular_restitution)
    times = SampleTimes(5.0, 0.01)
    motions = at_rest(9)
    reference = run_batch("housner", single, motions, times)["rotation"]
    alpha = single.slenderness_angle
    found = []
    for step in STEPS:
        response = respond(lanes, motions, times, float(step))
        alone = run_batch(
            "event", single, motions, times, settings=EventSettings(time_step=float(step))
        )
        # The single block's errors are of second order at most: 4e-4 at 1e-2 s.
        gap = np.abs(response["rotation"][:, 0] - alone["rotation"]).max(axis=1) / alpha
        assert np.max(gap) <= 2.0 * 4e-4 * (step / 1e-2) ** 2
        found.append(np.abs(response["rotation"][:, 0] - reference).max(axis=1) / alpha)
    # What resting leaves out is 5e-7.
    assert np.max(found[1]) <= 1e-5
    assert np.max(found[3]) <= 1e-6


def oracle_errors(
    blocks: dict[str, tuple[float, float]],
    motions: GroundMotions,
    times: SampleTimes,
    start: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """Largest |rotation - oracle| / smallest slenderness angle, shape [step]."""
    two = TwoBlocks(depth=(0.5, 0.5), density=(2000.0, 2000.0), **blocks)
    oracle = rock_two_blocks(two, motions.segments(0), times, rotation_start=start)
    assert oracle.odd_choice_count == 0
    assert math.isnan(oracle.pull_time)
    assert len(oracle.impact_times) >= 3
    lanes = stacks(**blocks, start=start)
    found = [respond(lanes, motions, times, float(step))["rotation"][0] for step in STEPS]
    gap = np.abs(np.stack(found) - oracle.rotation).max(axis=(1, 2))
    return np.asarray(gap / lanes.slenderness_angle.min())


@pytest.mark.parametrize(
    ("blocks", "start", "duration"),
    [
        (PAIR, (0.01, 0.01), 0.5),
        (PAIR, (0.03, 0.05), 0.5),
        (PAIR, (0.03, 0.0), 0.23),
        (PAIR, (0.0, 0.03), 0.14),
        (WIDE_TOP, (0.03, -0.02), 0.25),
        # It comes to rest.
        (WIDE_TOP, (0.02, 0.05), 0.5),
    ],
)
def test_released_pairs_follow_the_oracle_at_fifth_order(
    blocks: dict[str, tuple[float, float]], start: tuple[float, float], duration: float
) -> None:
    found = oracle_errors(blocks, at_rest(1), SampleTimes(duration, 0.005), start)
    # A step of the second order would be off by 1e-3 at the second step, and by 1e-5 at the last.
    assert orders(found[:, None])[0] >= 4.0
    assert found[1] <= 1e-5
    assert found[3] <= 1e-9


def test_pairs_under_a_sine_follow_the_oracle_at_fourth_order() -> None:
    # A swing, an impact and every pattern of two blocks; the worst of some inputs, since where the
    # impacts fall in their steps scatters the errors of a single one.
    times = SampleTimes(0.6, 0.005)
    found = [
        oracle_errors(PAIR, sines(Control.ACCELERATION, size, 3.0, 2.0), times)
        for size in (4.5, 5.0, 5.5)
    ]
    # Where a contact opens it is told to a part of the weight: that is of lower order.
    worst = np.max(found, axis=0)
    assert orders(worst[:, None])[0] >= 3.5
    assert worst[1] <= 1e-4
    assert worst[3] <= 1e-7


def test_a_corner_that_is_let_go_slowly_moves_on_the_ground_before_it_sticks() -> None:
    # The velocity step at the end of the sine lets the contacts go, too slowly to count as open.
    lanes = stacks((0.2, 0.15), (0.6, 0.55), friction=1.0, density=2670.0)
    motions, times = sines(Control.DISPLACEMENT, 4e-3, 5.0, 1.0), SampleTimes(0.3, 0.005)
    fine = run_batch("impulse", lanes, motions, times, settings=ImpulseSettings(substeps=999))
    gap = np.abs(respond(lanes, motions, times)["rotation"] - fine["rotation"])
    # First order at 1 / 240,000 s; held to stick at once, the pair would be off by 0.1.
    assert np.max(gap / lanes.slenderness_angle[..., None]) <= 2e-4


def test_a_velocity_step_of_the_base_lifts_a_pair_whose_foot_can_stick() -> None:
    """At a friction of 1.5 "no impulse, all slides" obeys the law of impact, too."""
    pair = make_stacks([0.2, 0.2], [0.6, 0.6], offset=[0.0, 0.01]).take(np.zeros(2, np.intp))
    lanes = dataclasses.replace(pair, friction=np.array([[1.5, 1.5], [10.0, 10.0]]))
    speed = np.full(2, 0.13)
    found = respond(lanes, velocity_steps(speed, 0.0 * speed, 10.0 + speed), SampleTimes(0.1, 0.01))
    rotation = found["rotation"]
    assert np.abs(rotation[1]).max() > 4e-3
    # Nothing slides in either: the same motion, to round-off.
    np.testing.assert_allclose(rotation[0], rotation[1], rtol=0.0, atol=1e-12)


@every_height_of_stack
def test_stack_below_uplift_stays_where_it_is(count: int) -> None:
    # A stack of equal blocks lifts as one at g width / (count height).
    lanes = stacks(np.full((2, count), 0.4), 0.3)
    amplitude = np.array([0.0, 0.99 * GRAVITY * 0.4 / (count * 0.3)])
    motions = sines(Control.ACCELERATION, amplitude, 2.0, 120.0)
    response = respond(lanes, motions, SampleTimes(60.0, 1.0), 1e-2)
    assert np.all(response["rotation"] == 0.0)
    assert np.all(response["peak_slide"] == 0.0)
    assert np.all(response["energy_lost"] == 0.0)
    assert np.all(response["outcome"] == Outcome.AT_REST)


@pytest.mark.thorough
def test_stack_on_a_still_base_stays_in_one_step() -> None:
    still = respond(stacks(np.full((1, 2), 0.4), 0.3), StillBase(1), SampleTimes(60.0))
    for name in ("peak_rotation", "peak_slide", "energy_lost"):
        assert np.all(still[name] == 0.0)
    # On a base that does not move the wait is one step, once a step has shown that nothing moves.
    assert np.all(still["step_count"] <= 3)


def released_energy(lanes: Lanes) -> Array:
    """Potential energy [J] of a released stack above its upright state, shape [lane].

    Blocks of one width that stand on their corners, no offset: what block k turns against the
    one below lifts it and all above by width / 2 of it.
    """
    start, half = lanes.rotation_start, 0.5 * lanes.width
    turn = np.diff(start, axis=1, prepend=0.0)
    side = np.where(turn < 0.0, -1.0, 1.0)
    below = np.concatenate([np.zeros((lanes.lane_count, 1)), start[:, :-1]], axis=1)
    base = np.zeros(lanes.lane_count)
    energy = np.zeros(lanes.lane_count)
    for k in range(lanes.block_count):
        # Up from the middle of the face below to the corner, and from there to the centre.
        corner = base - side[:, k] * half[:, k] * np.sin(below[:, k])
        foot = corner + side[:, k] * half[:, k] * np.sin(start[:, k])
        centre = foot + 0.5 * lanes.height[:, k] * np.cos(start[:, k])
        level = lanes.height[:, :k].sum(axis=1) + 0.5 * lanes.height[:, k]
        energy += lanes.mass[:, k] * GRAVITY * (centre - level)
        base = foot + lanes.height[:, k] * np.cos(start[:, k])
    return energy


@pytest.mark.thorough
@pytest.mark.parametrize("friction", [10.0, 0.4])
def test_energy_lost_is_what_released_stacks_had(friction: float) -> None:
    start = np.array([[0.02, 0.02, 0.02], [0.0, 0.05, 0.05], [0.03, 0.0, 0.02], [0.02, 0.05, 0.01]])
    lanes = stacks(np.full((4, 3), 0.3), 0.4, friction=friction, start=start)
    had = released_energy(lanes)
    for duration in (0.05, 0.2, 0.5):
        lost = respond(lanes, at_rest(4), SampleTimes(duration), 2e-3)["energy_lost"]
        # Never negative but for round-off; never more than there was but for the error of the
        # steps, some (p dt)^2 = 1e-4 of it.
        assert np.all(lost >= -1e-9 * had)
        assert np.all(lost <= had * (1.0 + 1e-3))
    response = respond(lanes, at_rest(4), SampleTimes(20.0), 2e-3)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    np.testing.assert_allclose(response["energy_lost"], had, rtol=1e-3)


def test_the_centre_of_mass_stays_above_a_base_without_friction() -> None:
    # Nothing pushes along the base, so impacts must leave the horizontal momentum at zero: the
    # centre of mass ends above where it began. The places follow from slides, second order.
    start = 0.08
    lanes = stacks(np.full((1, 2), 0.4), 0.5, friction=[[0.0, 10.0]], start=start)
    half, rise = 0.2, 0.5
    began = half - half * math.cos(start) + rise * math.sin(start)
    gaps = []
    for step in (1e-2, 5e-3, 2.5e-3):
        response = respond(lanes, at_rest(1), SampleTimes(20.0, 10.0), step)
        assert np.all(response["rotation"][..., -1] == 0.0)
        first, second = response["residual_slide"][0]
        gaps.append(abs(first + 0.5 * second - began))
    assert gaps[0] <= 1e-2 * began
    assert gaps[2] <= 1e-3 * began


def shaken(count: int) -> tuple[Lanes, GroundMotions]:
    """Stacks that rock, slide and fall: seven lanes of a number of blocks."""
    rng = np.random.default_rng(count)
    lanes = stacks(
        rng.uniform(0.2, 0.4, (7, count)),
        rng.uniform(0.3, 0.6, (7, count)),
        friction=rng.uniform(0.2, 1.0, (7, count)),
        chamfer=0.005,
        offset=rng.uniform(-0.02, 0.02, (7, count)) * (np.arange(count) > 0),
    )
    return lanes, sines(Control.DISPLACEMENT, rng.uniform(0.01, 0.05, 7), 2.5, 4.0)


@pytest.mark.thorough
def test_seven_blocks_settle_at_every_impact() -> None:
    # Friction of 1 jams what slides: sliding that goes on finds no forces (Painleve's paradox).
    lanes = stacks(np.tile(np.linspace(0.4, 0.2, 7), (4, 1)), 0.26, friction=1.0)
    size = GRAVITY * np.array([0.3, 0.35, 0.3, 0.35])
    frequency = np.array([3.3, 3.3, 5.0, 5.0])
    motions = sines(Control.ACCELERATION, size, frequency, 1.0)
    times = SampleTimes(0.7, 5e-3)
    found = [respond(lanes, motions, times, step) for step in (1e-2, 1e-3)]
    assert np.all(found[0]["impact_count"] >= 100)
    assert np.all(found[0]["energy_lost"] > 0.0)
    gap = np.abs(found[0]["rotation"] - found[1]["rotation"]).max(axis=(1, 2))
    # What resting and landings leave out, magnified by some hundred impacts.
    assert np.max(gap / lanes.slenderness_angle.min()) <= 1e-2


def random_scenes(
    blocks: int, count: int, side: float, seed: int = 1
) -> tuple[Lanes, GroundMotions]:
    """Stacks of any shape that rock, slide, fly and fall, or with side -1 their mirror images.

    Every third one starts turned.
    """
    rng = np.random.default_rng(seed)
    shape = (count, blocks)
    width = rng.uniform(0.15, 1.0, shape)
    offset = rng.uniform(-0.1, 0.1, shape) * width * (np.arange(blocks) > 0)
    start = rng.uniform(-0.03, 0.03, shape) * (np.arange(count) % 3 == 0)[:, None]
    lanes = stacks(
        width,
        width * 10.0 ** rng.uniform(-0.3, 0.6, shape),
        friction=rng.uniform(0.2, 1.2, shape),
        offset=side * offset,
        start=side * start,
    )
    size, frequency = rng.uniform(2.0, 9.0, count), rng.uniform(0.5, 3.0, count)
    return lanes, sines(Control.ACCELERATION, side * size, frequency, 4.0)


@pytest.mark.parametrize("count", [2, pytest.param(3, marks=pytest.mark.thorough)])
def test_random_stacks_have_mirrored_answers_in_a_mirror(count: int) -> None:
    times = SampleTimes(6.0, 0.02)
    lanes, _motions = random_scenes(count, 300, 1.0)
    found, image = (
        run_batch("event", *random_scenes(count, 300, side), times) for side in (1.0, -1.0)
    )
    for outcome in Outcome:
        assert np.sum(found["outcome"] == outcome) >= 5
    np.testing.assert_array_equal(image["status"], found["status"])
    np.testing.assert_array_equal(image["outcome"], found["outcome"])
    gap = np.abs(image["rotation"] + found["rotation"]).max(axis=2) / lanes.slenderness_angle
    slip = np.abs(image["residual_slide"] + found["residual_slide"]) / lanes.width
    # Round-off, magnified by up to some hundred impacts.
    assert np.max(gap) <= 1e-3
    assert np.max(slip) <= 1e-3
    assert np.mean(np.maximum(gap, slip) <= 1e-9) >= 0.95


def test_interfaces_slide_by_the_closed_form() -> None:
    # A velocity step v of the base leaves both blocks behind. The upper one is braked by mu2 g; the
    # lower one by the ground, less what the upper one pulls. Squat blocks do not rock.
    speed = np.array([0.5, -0.4, 0.3])
    ground = np.array([0.2, 0.4, 0.3])
    upper = np.array([0.1, 0.2, 0.05])
    lanes = stacks(
        np.tile([4.0, 2.0], (3, 1)),
        [0.2, 0.4],
        friction=np.stack([ground, upper], axis=1),
        density=[1000.0, 3000.0],
    )
    response = respond(
        lanes, velocity_steps(speed, np.zeros(3), np.full(3, 10.0)), SampleTimes(2.0)
    )
    first, second = lanes.mass.T
    lower_brake = GRAVITY * (ground * (first + second) - upper * second) / first
    lower = -np.sign(speed) * speed**2 / (2.0 * lower_brake)
    whole = -np.sign(speed) * speed**2 / (2.0 * upper * GRAVITY)
    # Even decelerations: the steps are exact, and so are the times at which sliding stops.
    np.testing.assert_allclose(response["residual_slide"][:, 0], lower, rtol=1e-9)
    np.testing.assert_allclose(response["residual_slide"][:, 1], whole - lower, rtol=1e-9)
    np.testing.assert_allclose(response["rest_time"], np.abs(speed) / (upper * GRAVITY), rtol=1e-9)
    np.testing.assert_allclose(
        response["energy_lost"], 0.5 * (first + second) * speed**2, rtol=1e-9
    )
    assert np.all(response["peak_rotation"] == 0.0)
    assert np.all(response["outcome"] == Outcome.AT_REST)


def test_upper_blocks_slide_off_or_topple_over_the_edge() -> None:
    # A slab that is thrown off a slab, and a column whose centre stands beyond the edge.
    lanes = stacks(
        [[1.0, 1.0], [1.0, 0.4]],
        [[0.1, 0.01], [0.1, 0.4]],
        friction=[[10.0, 0.01], [10.0, 10.0]],
        density=[[50000.0, 100.0], [50000.0, 100.0]],
        offset=[[0.0, 0.0], [0.0, 0.51]],
    )
    motions = velocity_steps(np.array([9.0, 0.0]), np.zeros(2), np.full(2, 10.0))
    response = respond(lanes, motions, SampleTimes(3.0, 0.01))
    assert response["outcome"].tolist() == [Outcome.SLID_OFF, Outcome.OVERTURNED]
    # Left behind: towards -x, by its way to the edge, to what it moves in 1e-6 of a step.
    np.testing.assert_allclose(response["residual_slide"][0, 1], -1.0, atol=9.0 * 5e-9)
    assert response["rotation"][1, 1, -1] == 0.5 * math.pi
    assert response["rotation"][1, 0, -1] == 0.0


@pytest.mark.parametrize(
    ("chamfer", "offset", "side", "arm"),
    [(0.0, 0.0, 1, 0.4), (0.1, 0.0, 1, 0.3), (0.0, 0.2, 1, 0.4), (0.0, 0.2, -1, 0.3)],
)
def test_uplift_follows_chamfer_and_offset(
    chamfer: float, offset: float, side: int, arm: float
) -> None:
    # The upper block turns about the end of the overlap, `arm` away from its middle, 1 m below its
    # centre: its own face (0.8 m) or the end of the lower one (1 m), beyond which it hangs over.
    lanes = stacks(
        np.tile([1.0, 0.8], (2, 1)),
        [0.2, 2.0],
        chamfer=[0.0, chamfer],
        offset=[0.0, offset],
        density=[20000.0, 1000.0],
    )
    amplitude = side * np.array([0.99, 1.01]) * GRAVITY * arm
    response = respond(lanes, sines(Control.ACCELERATION, amplitude, 0.25, 1.0), SampleTimes(1.2))
    assert math.isnan(response["uplift_time"][0])
    # When the sine passes the threshold, to a thousandth of a step and the curve inside one.
    expected = math.asin(1.0 / 1.01) / (0.5 * math.pi)
    assert response["uplift_time"][1] == pytest.approx(expected, abs=1e-4)
    assert response["peak_rotation"][1, 0] == 0.0


@pytest.mark.thorough
def test_lanes_do_not_depend_on_the_batch_and_a_broken_lane_harms_nobody(unjudged: None) -> None:
    lanes, motions = shaken(6)
    times = SampleTimes(1.0, 0.05)
    together = run_batch("event", lanes, motions, times, workers=1)
    apart = run_batch("event", lanes, motions, times, workers=2, chunk_size=2)
    order = np.arange(7)[::-1]
    turned = run_batch("event", lanes.take(order), motions.take(order), times)
    height = lanes.height.copy()
    height[2, 1] = np.nan
    broken = run_batch("event", dataclasses.replace(lanes, height=height), motions, times)
    sound = np.arange(7) != 2
    for name, values in together.fields.items():
        np.testing.assert_array_equal(apart[name], values)
        np.testing.assert_array_equal(turned[name][order], values)
        np.testing.assert_array_equal(broken[name][sound], values[sound])
    assert broken["status"][2] == Status.NONFINITE


def test_round_off_of_float32_makes_no_steps() -> None:
    lanes = stacks(np.full((8, 2), 0.2), 0.6, friction=0.7)
    size = GRAVITY * np.linspace(0.3, 0.7, 8)
    motions, times = sines(Control.ACCELERATION, size, np.full(8, 4.0), 1.0), SampleTimes(1.0)
    coarse, fine = (
        run_batch("event", lanes, motions, times, precision=each)["step_count"].sum()
        for each in ("float32", "float64")
    )
    # A corner that lies flat but for round-off had four times as many.
    assert coarse <= 1.1 * fine


def test_histories_do_not_change_the_run() -> None:
    lanes, motions = shaken(2)
    with_history = respond(lanes, motions, SampleTimes(1.0, 0.01))
    without = respond(lanes, motions, SampleTimes(1.0))
    for name, values in without.fields.items():
        np.testing.assert_array_equal(with_history[name], values)


def test_a_run_ends_where_a_block_has_slid_off() -> None:
    count = 12
    lanes = stacks([0.6, 0.5], np.full((count, 2), 0.1), friction=np.array([10.0, 0.1]))
    rate = np.linspace(6.0, 12.0, count)
    motions = sines(Control.ACCELERATION, rate, np.full(count, 0.5), 1.0)
    found = run_batch("event", lanes, motions, SampleTimes(2.0))
    assert np.all(found["outcome"] == Outcome.SLID_OFF)
    # At some 2 m/s, to a part of 1e-6 of a step of 5 ms.
    np.testing.assert_allclose(found["peak_slide"][:, 1], 0.5 * (0.6 + 0.5), atol=2e-8)


@pytest.mark.thorough
def test_swings_of_round_off_do_not_strike_for_ever() -> None:
    # The middle block slides a little and stops while the ones beside it chatter.
    draw, count = np.random.default_rng(3), 60
    size = draw.uniform(0.9, 1.1, (3, count, 1))
    lanes = stacks(
        size[0] * [0.4, 0.32, 0.41],
        size[1] * [0.48, 0.4, 1.85],
        density=np.array([1070.0, 2690.0, 1730.0]),
        friction=np.array([0.5, 0.5, 0.6]),
        offset=np.array([0.0, -0.03, 0.016]),
    )
    motions = sines(Control.ACCELERATION, 1.8 * size[2, :, 0], np.full(count, 3.0), 3.0)
    found = run_batch("event", lanes, motions, SampleTimes(3.0))
    assert np.all(found["status"] == Status.OK)
