"""`event` with blocks that walls, ties and loads hold, and that may slide."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import at_rest, make_lanes, sines, velocity_steps
from tests.shared.held import held_batch, mirrored, one_tie
from tests.shared.marks import first
from warprock.engines import engine_class
from warprock.engines import event as event_engine
from warprock.model import rocking
from warprock.model.hold import Frame, Hold, TopLoad
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import USABLE, Outcome, Response, SampleTimes, Status
from warprock.model.scene import scene_kind
from warprock.oracle.sliding_swings import slide
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

AGREEMENT = 1e-8
"""What is left between two exact solutions, in slenderness angles: steps of 1e-12 that grow where a
block comes close to its balance; of 1,800 lanes 2e-10 at most."""

KINDS = [
    (True, 0, False, 1),
    (False, 1, False, 3),
    (False, 3, False, 2),
    (True, 2, False, 5),
    (False, 0, True, 7),
    (True, 1, True, 4),
]
"""With a wall or not, ties, with a load or not, and a seed, as of `housner`."""

every_kind = pytest.mark.parametrize(("wall", "ties", "load", "seed"), KINDS)

FINE = EventSettings(rest_rotation_ratio=1e-9)
"""The rest rule of `housner`."""


def run(lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
    """Lanes of which none may fail."""
    found = run_batch("event", lanes, motions, times, settings=FINE, workers=1)
    np.testing.assert_array_equal(found["status"], Status.OK)
    return found


def loaded(lanes: Lanes, thrust: npt.ArrayLike, weight: npt.ArrayLike = 0.0) -> TopLoad:
    """Loads in the middle of the tops of blocks."""
    count = lanes.lane_count
    parts = [
        np.broadcast_to(np.asarray(each, dtype=np.float64), count) for each in (weight, thrust)
    ]
    return TopLoad(parts[0], np.zeros(count), parts[1], np.zeros(count, dtype=np.bool_))


def assert_follows_housner(count: int, seed: int, *, wall: bool, ties: int, load: bool) -> None:
    """Random lanes that do not slide beside `housner`, up to where they fall."""
    lanes, motions = held_batch(count, seed, wall=wall, ties=ties, load=load)
    lanes = dataclasses.replace(lanes, friction=np.full(count, 50.0))
    times = SampleTimes(4.0, 0.02)
    event = run_batch("event", lanes, motions, times, settings=FINE, workers=1)
    found = run_batch("housner", lanes, motions, times, workers=1)
    # Beyond its balance a block falls; there its corner may slide or be pulled off its base.
    angle = lanes.slenderness_angle[:, None]
    falls = np.maximum.accumulate(np.abs(found["rotation"]) > angle, axis=1)
    inside = found["status"] == Status.OK
    off = np.where(falls, 0.0, np.abs(event["rotation"] - found["rotation"]) / angle)
    assert off[inside].max() < AGREEMENT
    np.testing.assert_array_equal(event["outcome"][inside], found["outcome"][inside])
    stands = inside & ~falls.any(axis=1)
    assert stands.sum() > count // 4
    for name in ("impact_count", *(("broken_ties",) if ties else ())):
        np.testing.assert_array_equal(event[name][stands], found[name][stands], err_msg=name)
    names = ["peak_rotation", "energy_lost", "uplift_time", "rest_time"]
    if ties:
        names += ["peak_tie_force", "peak_tie_elongation", "tie_break_time", "tie_energy_lost"]
    for name in names:
        np.testing.assert_allclose(
            event[name][stands], found[name][stands], rtol=AGREEMENT, atol=1e-8, err_msg=name
        )
    assert event["peak_slide"][stands].max() < 1e-12


@pytest.mark.thorough
@every_kind
def test_without_sliding_it_is_housner(wall, ties, load, seed):
    assert_follows_housner(30, seed, wall=wall, ties=ties, load=load)


@pytest.mark.thorough
@every_kind
def test_many_lanes_without_sliding_are_housner(wall, ties, load, seed):
    assert_follows_housner(300, seed, wall=wall, ties=ties, load=load)


BEYOND = 1e-6
"""What is left between `event` and the oracle of sliding, in slenderness angles: what the oracle
takes for touching, 1e-9 m, grows in a cascade of impacts between base and wall. In 143 of 144 lanes
it is below 1e-8."""


def assert_follows_oracle(part: float, seed: int, *, wall: bool, ties: int, load: bool) -> None:
    """A part of 24 random lanes with little friction beside SciPy, those that slide most."""
    lanes, motions = held_batch(24, seed, wall=wall, ties=ties, load=load)
    friction = np.random.default_rng(seed + 100).uniform(0.05, 0.8, 24)
    lanes = dataclasses.replace(lanes, friction=friction)
    times = SampleTimes(2.0, 0.02, places=True)
    event = run(lanes, motions, times)
    falls = event["outcome"] == Outcome.OVERTURNED
    chosen = np.argsort(np.where(falls, 0.0, -event["peak_slide"]))[: round(24 * part)]
    assert event["peak_slide"][chosen[0]] > 1e-3
    for lane in chosen.tolist():
        found = slide(lanes, motions, lane, times)
        assert found.status == Status.OK
        angle = lanes.slenderness_angle[lane]
        np.testing.assert_allclose(
            event["rotation"][lane], found.rotation, rtol=0.0, atol=BEYOND * angle, err_msg=lane
        )
        np.testing.assert_allclose(event["x"][lane], found.x, rtol=0.0, atol=BEYOND, err_msg=lane)
        # Where impacts on base and wall follow one another ever faster, the last ones are too weak
        # for one and not for the other.
        if not wall:
            assert event["impact_count"][lane] == len(found.impacts)
        names = {
            "energy_lost": found.energy_lost,
            "residual_slide": found.slide,
            "uplift_time": found.uplift_time,
            "rest_time": found.rest_time,
        }
        if ties:
            names |= {
                "tie_energy_lost": found.tie_energy_lost,
                "broken_ties": sum(tie.broken < np.inf for tie in found.ties),
            }
        for name, value in names.items():
            if name == "residual_slide" and event["outcome"][lane] == Outcome.OVERTURNED:
                continue
            np.testing.assert_allclose(
                event[name][lane], value, rtol=1e-5, atol=1e-6, err_msg=f"{lane} {name}"
            )


@pytest.mark.parametrize(("wall", "ties", "load", "seed"), first(1, [KINDS[1], KINDS[5]]))
def test_with_sliding_it_follows_the_oracle(wall, ties, load, seed):
    assert_follows_oracle(1.0 / 24.0, seed, wall=wall, ties=ties, load=load)


@pytest.mark.thorough
@every_kind
def test_many_sliding_lanes_follow_the_oracle(wall, ties, load, seed):
    # All 24 of each kind were held against it once.
    assert_follows_oracle(0.2, seed, wall=wall, ties=ties, load=load)


def test_without_anything_that_holds_it_is_the_free_block():
    lanes, motions = held_batch(20, 1, wall=False, ties=0)
    friction = np.random.default_rng(3).uniform(0.1, 0.9, 20)
    lanes = dataclasses.replace(lanes, hold=None, friction=friction)
    times = SampleTimes(3.0, 0.02, places=True)
    held = run(dataclasses.replace(lanes, hold=Hold(load=loaded(lanes, 0.0))), motions, times)
    gaps = []
    for step in (1e-3, 5e-4):
        settings = dataclasses.replace(FINE, time_step=step)
        free = run_batch("event", lanes, motions, times, settings=settings)
        np.testing.assert_array_equal(held["outcome"], free["outcome"])
        gaps.append(np.abs(held["slide"] - free["slide"]).max())
    # The free block is of second order in its step where it slides.
    assert gaps[1] < 1e-5
    assert gaps[0] / gaps[1] > 2.5


def test_a_block_on_a_spring_slides_as_a_coulomb_oscillator():
    # Low and wide, so that it does not tip; a spring at half of its height, both ways.
    friction, speed = np.array([0.05, 0.1, 0.2]), 0.8
    lanes = make_lanes(np.full(3, 2.0), 0.5, 0.0, friction)
    stiffness = 4e4
    tie = one_tie(lanes, side=1.0, height=0.25, stiffness=stiffness, pushes=True)
    lanes = dataclasses.replace(lanes, hold=Hold(ties=tie))
    # The base jumps to -x and goes on evenly: the block goes to +x.
    motions = velocity_steps(np.full(3, -speed), np.zeros(3), np.full(3, 50.0))
    found = run(lanes, motions, SampleTimes(10.0))
    rate = np.sqrt(stiffness / lanes.mass)
    lag = friction * GRAVITY / rate**2
    # Half swings about -lag and lag in turn: each ends 2 lag nearer, the last within lag.
    first = np.sqrt(lag**2 + (speed / rate) ** 2) - lag
    halves = np.ceil((first - lag) / (2.0 * lag)).astype(int)
    rests = first - 2.0 * lag * halves
    begin = np.arctan2(speed / rate, lag) / rate
    np.testing.assert_allclose(found["peak_slide"], first, rtol=1e-12)
    np.testing.assert_allclose(found["residual_slide"], (-1.0) ** halves * rests, atol=1e-12)
    np.testing.assert_allclose(found["rest_time"], begin + halves * np.pi / rate, rtol=1e-12)
    held = 0.5 * lanes.mass * speed**2 - 0.5 * stiffness * rests**2
    np.testing.assert_allclose(found["energy_lost"], held, rtol=1e-12)
    np.testing.assert_allclose(found["peak_tie_force"], stiffness * first, rtol=1e-12)


def test_a_thrust_below_friction_moves_nothing_and_one_above_it_does():
    friction, weight = 0.3, 2e3
    lanes = make_lanes(np.full(4, 2.0), 0.5, 0.0, friction)
    holds = friction * (lanes.mass * GRAVITY + weight)
    thrust = holds * np.array([0.999, 1.001, -0.999, -1.4])
    lanes = dataclasses.replace(lanes, hold=Hold(load=loaded(lanes, thrust, weight)))
    found = run(lanes, at_rest(4), SampleTimes(1.0))
    over = np.sign(thrust) * np.maximum(np.abs(thrust) - holds, 0.0)
    np.testing.assert_allclose(found["residual_slide"], 0.5 * over / lanes.mass, atol=1e-12)
    np.testing.assert_array_equal(found["outcome"] == Outcome.AT_REST, [True, False, True, False])
    # Friction takes what it moves through.
    lost = holds * np.abs(found["residual_slide"])
    np.testing.assert_allclose(found["energy_lost"], lost, rtol=1e-12)


def test_a_thrust_tips_a_block_or_slides_it_off_as_statics_say():
    friction = np.array([0.5, 0.5, 0.1, 0.1])
    lanes = make_lanes(np.full(4, 0.6), 3.0, 0.0, friction)
    tips, slides = 0.1 * lanes.mass * GRAVITY, friction * lanes.mass * GRAVITY
    # About the corner: T h = W b; the thrust acts at the top.
    least = np.minimum(tips, slides)
    thrust = least * np.array([0.999, 1.001, 0.999, 1.001])
    lanes = dataclasses.replace(lanes, hold=Hold(load=loaded(lanes, thrust)))
    found = run(lanes, at_rest(4), SampleTimes(0.5))
    np.testing.assert_array_equal(np.isfinite(found["uplift_time"]), [False, True, False, True])


def test_a_block_thrust_to_its_wall_bounces_as_a_ball_on_a_slope():
    friction, thrust, speed = 0.2, 4e3, 0.5
    rebound = np.array([0.0, 0.3, 0.7])
    lanes = make_lanes(np.full(3, 2.0), 0.5, 0.0, friction)
    hold = Hold(-np.ones(3), rebound, load=loaded(lanes, -thrust))
    lanes = dataclasses.replace(lanes, hold=hold)
    motions = velocity_steps(np.full(3, -speed), np.zeros(3), np.full(3, 50.0))
    found = run(lanes, motions, SampleTimes(6.0))
    out = thrust / lanes.mass + friction * GRAVITY
    back = thrust / lanes.mass - friction * GRAVITY
    # It goes out against thrust and friction, and comes back against friction.
    kept = np.sqrt(back / out)
    flight = speed / out + speed * kept / back
    np.testing.assert_allclose(found["peak_slide"], 0.5 * speed**2 / out, rtol=1e-12)
    # A geometric series of bounces. The rest rule leaves out those of 1e-9 of the size, which take
    # 3e-5 of the time, and counts them as if the block came back as it goes out.
    np.testing.assert_allclose(found["rest_time"], flight / (1.0 - rebound * kept), rtol=1e-4)
    np.testing.assert_allclose(found["energy_lost"], 0.5 * lanes.mass * speed**2, rtol=1e-9)
    np.testing.assert_array_equal(found["residual_slide"], 0.0)
    np.testing.assert_array_equal(found["impact_count"][:1], 1)


def stored(lanes: Lanes, found: Response, at: int) -> npt.NDArray[np.float64]:
    """Energy of blocks that stand still at a sample [J]: of weight, springs, thrusts."""
    hold = lanes.hold
    assert hold is not None
    theta, x = found["rotation"][:, at], found["x"][:, at]
    held = rocking.energy(lanes.width, lanes.height, 0.5, 2000.0, theta, 0.0)
    for tie in range(0 if hold.ties is None else hold.ties.count):
        ties = hold.ties
        assert ties is not None
        above = ties.height[:, tie] - 0.5 * lanes.height
        across = 0.5 * ties.side[:, tie] * lanes.width
        moved = x + across * (np.cos(theta) - 1.0) + above * np.sin(theta)
        force = -ties.side[:, tie] * moved - ties.free_length[:, tie]
        force = np.where(ties.pushes[:, tie], force, np.maximum(force, 0.0))
        held += 0.5 * ties.stiffness[:, tie] * force**2
    if hold.load is not None:
        load = hold.load
        top = x + load.eccentricity * np.cos(theta) + 0.5 * lanes.height * np.sin(theta)
        held -= load.thrust * top
    return np.asarray(held)


@pytest.mark.parametrize(("wall", "ties"), [(False, 2), (True, 0), (True, 2)])
def test_what_rests_has_lost_what_it_held(wall, ties):
    count = 40
    lanes, _motions = held_batch(count, 8, wall=wall, ties=ties)
    rng = np.random.default_rng(9)
    lanes = dataclasses.replace(
        lanes,
        friction=rng.uniform(0.03, 0.5, count),
        rotation_start=np.copysign(0.5 * lanes.slenderness_angle, -1.0 + 0.0 * lanes.friction),
    )
    hold = lanes.hold
    assert hold is not None
    if wall:
        assert hold.wall is not None
        lanes = dataclasses.replace(lanes, rotation_start=-hold.wall * np.abs(lanes.rotation_start))
    if ties:
        assert hold.ties is not None
        # Elastic ones, of which the energy is known from where the block is.
        forever = np.full_like(hold.ties.yield_force, np.inf)
        elastic = dataclasses.replace(
            hold.ties, yield_force=forever, ultimate_elongation=forever.copy()
        )
        lanes = dataclasses.replace(lanes, hold=dataclasses.replace(hold, ties=elastic))
    found = run(lanes, at_rest(count), SampleTimes(12.0, 0.5, places=True))
    rests = found["outcome"] == Outcome.AT_REST
    assert rests.sum() > count // 3
    assert (found["peak_slide"][rests] > 1e-3).sum() > 5
    spent = stored(lanes, found, 0) - stored(lanes, found, -1)
    scale = stored(lanes, found, 0)[rests].max()
    # Round-off of some hundred steps, and what the rest rule leaves out.
    np.testing.assert_allclose(
        found["energy_lost"][rests], spent[rests], rtol=1e-8, atol=1e-10 * scale
    )


@every_kind
def test_a_mirrored_lane_has_mirrored_bits(wall, ties, load, seed):
    lanes, motions = held_batch(40, seed, wall=wall, ties=ties, load=load)
    friction = np.random.default_rng(seed).uniform(0.05, 0.8, 40)
    lanes = dataclasses.replace(lanes, friction=friction)
    times = SampleTimes(4.0, 0.05, places=True)
    there = run(lanes, motions, times)
    back = run(*mirrored(lanes, motions), times)
    for name in ("rotation", "x"):
        np.testing.assert_array_equal(there[name], -back[name], err_msg=name)
    for name in ("z", "energy_lost", "impact_count", "step_count", "rest_time"):
        np.testing.assert_array_equal(there[name], back[name], err_msg=name)


def test_a_lane_does_not_depend_on_its_neighbours_or_on_histories():
    lanes, motions = held_batch(24, 5, wall=True, ties=2)
    friction = np.random.default_rng(1).uniform(0.05, 0.8, 24)
    lanes = dataclasses.replace(lanes, friction=friction)
    whole = run(lanes, motions, SampleTimes(3.0, 0.03, places=True))
    plain = run(lanes, motions, SampleTimes(3.0))
    few = np.array([3, 11, 20])
    # One of which the numbers overflow, beside them.
    bad = lanes.take(np.array([0, 3, 11, 20]))
    assert bad.hold is not None
    pushed = loaded(bad, np.array([1e300, 0.0, 0.0, 0.0]))
    bad = dataclasses.replace(bad, hold=dataclasses.replace(bad.hold, load=pushed))
    beside = motions.take(np.array([0, 3, 11, 20]))
    found = run_batch("event", bad, beside, SampleTimes(3.0, 0.03), settings=FINE)
    assert found["status"][0] not in USABLE
    for name in plain.fields:
        np.testing.assert_array_equal(plain[name], whole[name], err_msg=name)
        np.testing.assert_array_equal(plain[name][few], found[name][1:], err_msg=name)
    np.testing.assert_array_equal(whole["rotation"][few], found["rotation"][1:])


@pytest.mark.thorough
def test_float32_is_the_same_motion():
    lanes, motions = held_batch(60, 5, wall=True, ties=2)
    friction = np.random.default_rng(2).uniform(0.05, 0.8, 60)
    lanes = dataclasses.replace(lanes, friction=friction)
    times = SampleTimes(3.0, 0.02)
    fine = run(lanes, motions, times)
    coarse = run_batch("event", lanes, motions, times, precision="float32", workers=1)
    np.testing.assert_array_equal(coarse["status"], Status.OK)
    np.testing.assert_array_equal(coarse["outcome"], fine["outcome"])
    # Some hundred roundings of 6e-8, larger where a block comes close to its balance.
    gaps = np.abs(coarse["rotation"] - fine["rotation"]).max(axis=1) / lanes.slenderness_angle
    assert np.median(gaps) < 1e-5
    assert gaps.max() < 1e-2


EVENTS = {
    "slack": {"stiffness": 6e4, "slack": 0.02},
    "yield and unload": {"stiffness": 6e4, "yield_force": 1200.0},
    "yield both ways": {"stiffness": 6e4, "yield_force": 900.0, "pushes": True},
    "break": {"stiffness": 6e4, "ultimate_elongation": 0.03},
}


@pytest.mark.parametrize("kind", EVENTS)
@pytest.mark.parametrize("friction", [0.15, 1.2])
def test_it_converges_through_the_events_of_a_tie(kind, friction, monkeypatch):
    assert_converges(
        monkeypatch, friction, lambda lanes: Hold(ties=one_tie(lanes, side=-1.0, **EVENTS[kind]))
    )


@pytest.mark.parametrize("rebound", [0.0, 0.5])
@pytest.mark.parametrize("friction", [0.15, 1.2])
def test_it_converges_through_impacts_on_a_wall(rebound, friction, monkeypatch):
    assert_converges(monkeypatch, friction, lambda _lanes: Hold(-np.ones(1), np.array([rebound])))


def assert_converges(monkeypatch, friction, hold_of):
    """The order in the step, at steps that are much longer than the engine takes by itself."""
    lanes = make_lanes(0.6, 4.8, 0.0, friction)
    lanes = dataclasses.replace(lanes, hold=hold_of(lanes))
    motions = sines(Control.ACCELERATION, -3.0, 1.0, cycles=1.5)
    times = SampleTimes(2.0, 0.05)

    def rotation(phase: float) -> npt.NDArray[np.float64]:
        for name in ("HELD_STEP", "MOTION_STEP", "PHASE_STEP"):
            monkeypatch.setattr(event_engine, name, phase)
        found = run_batch("event", lanes, motions, times, settings=EventSettings(time_step=0.1))
        assert found["status"][0] == Status.OK
        return found["rotation"][0]

    best = rotation(0.1)
    phases = np.array([1.6, 1.2, 0.8, 0.6, 0.4])
    gaps = [np.abs(rotation(phase) - best).max() for phase in phases]
    # Series of degree 10; 6.8 to 11.5 were measured, for events lie anywhere in the steps.
    assert np.polyfit(np.log(phases), np.log(gaps), 1)[0] > 5.5
    # The step that the engine takes by itself at most.
    assert gaps[-1] < 1e-10


def test_it_declines_what_its_contact_law_does_not_know():
    lanes = make_lanes(np.full(2, 1.0), 6.0)
    engine = engine_class("event")
    frame = dataclasses.replace(lanes, hold=Hold(frame=Frame(np.full(2, 4.0), np.ones(2))))
    declined = engine.supports(scene_kind(frame, at_rest(2), restitution_given=False))
    assert declined is not None
    assert "(frame); housner runs it" in declined
    walled = dataclasses.replace(lanes, hold=Hold(np.ones(2), np.zeros(2)))
    assert engine.supports(scene_kind(walled, at_rest(2), restitution_given=False)) is None
    declined = engine.supports(scene_kind(walled, at_rest(2), restitution_given=True))
    assert declined is not None
    assert "contact.angular_restitution" in declined
