"""`event` of stacks with bodies: boxes, plinths, mirror images, order, energy, random stacks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from tests.shared.blocks import Array, make_stacks, sines
from tests.shared.planar_bodies import STEPPED, body_lanes
from tests.shared.stack_bodies import (
    EIGHT,
    as_bodies,
    mirrored_stacks,
    random_chains,
    random_pairs,
    shaken,
    stack_of_one,
    with_body,
)
from warprock.engines.energy import stack_energy_held
from warprock.engines.event import Event
from warprock.engines.impulse import Impulse
from warprock.engines.launching import Form, Target
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.running.tolerance import run_to_tolerance
from warprock.settings.engines import EventSettings, ImpulseSettings
from warprock.units import GRAVITY

pytestmark = pytest.mark.thorough

Made = Callable[[Array], Lanes]

TIMES = SampleTimes(1.0, 0.01, places=True)
STARTS = np.array([0.08, 0.03, -0.1, -0.15, 0.05, 0.0, 0.0, 0.0])
"""Rotations of bodies on stepped bases [rad]."""
FOOT = ((-0.35, -0.17), (-0.25, -0.2), (0.1, -0.2), (0.2, -0.18), (0.3, -0.12))
"""Corners of a stepped, eccentric foot, from its centre of mass [m]."""


def run(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes = TIMES, step: float = 5e-3
) -> Response:
    response = Event(EventSettings(time_step=step)).run(lanes, motions, times)
    assert np.all(response["status"] == Status.OK)
    return response


def statues(rotation: Array) -> Lanes:
    """Statues on pedestals, of rotations [rad]."""
    lanes = make_stacks([0.8, 0.5], [0.5, 1.0], friction=0.7, rotation=rotation)
    return with_body(lanes, 1)


def cabinets(rotation: Array) -> Lanes:
    """Cabinets on stepped, eccentric feet, of rotations [rad]."""
    lanes = make_stacks(
        [0.7, 0.6], [0.4, 1.2], friction=0.7, rotation=rotation, density=[2400.0, 400.0]
    )
    return with_body(lanes, 0, FOOT, gyration=0.05)


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_boxes_as_bodies_are_the_stack_of_boxes(friction: float) -> None:
    lanes, motions = random_pairs(8, friction), shaken(EIGHT)
    boxes, bodies = run(lanes, motions), run(as_bodies(lanes), motions)
    # A block that falls off another one has left its top where nothing of it is above that.
    stands = boxes["outcome"] <= Outcome.ROCKING
    assert stands.sum() == 7
    # Every field is compared, to round-off.
    assert set(bodies.fields) == set(boxes.fields)
    for name, values in boxes.fields.items():
        np.testing.assert_allclose(bodies[name][stands], values[stands], atol=1e-11, err_msg=name)


def test_a_body_on_a_plinth_that_stands_moves_as_on_the_ground() -> None:
    # The same law of contact in kernels that share no text; the plinth is stout and does not slide.
    single, motions = body_lanes(STEPPED, STARTS, friction=0.3), shaken(EIGHT)
    rotation = np.stack([np.zeros(8), STARTS], axis=1)
    lanes = make_stacks([3.0, 0.6], [0.3, 1.0], friction=[10.0, 0.3], rotation=rotation)
    # The single body is of second order: off by 2e-5 at 2.5e-3 s.
    one, other = (
        run(single, motions, step=2.5e-4),
        run(with_body(lanes, 1), motions, step=2.5e-3),
    )
    assert np.abs(other["rotation"][:, 0]).max() == 0.0
    assert one["impact_count"].max() > 10
    np.testing.assert_array_equal(other["outcome"], one["outcome"])
    # What both leave out where a body comes to rest.
    np.testing.assert_allclose(other["rotation"][:, 1], one["rotation"], atol=1e-6)
    np.testing.assert_allclose(other["slide"][:, 1], one["slide"], atol=1e-6)


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_a_stack_of_one_is_the_single_body(friction: float) -> None:
    lanes, motions = body_lanes(STEPPED, STARTS, friction=friction), shaken(EIGHT)
    one = run(lanes, motions, step=2.5e-4)
    other = run(stack_of_one(lanes), motions, step=2.5e-3)
    np.testing.assert_array_equal(other["outcome"], one["outcome"])
    for name in ("rotation", "slide", "x", "z"):
        np.testing.assert_allclose(other[name][:, 0], one[name], atol=1e-6, err_msg=name)


@pytest.mark.parametrize("block", [0, 1])
def test_a_mirrored_stack_moves_as_in_a_mirror(block: int) -> None:
    lanes, motions = with_body(random_pairs(8, 0.4), block), shaken(EIGHT)
    one, other = run(lanes, motions), run(mirrored_stacks(lanes), motions.scaled(-np.ones(8)))
    assert np.abs(one["rotation"]).max() > 0.1
    for name in ("rotation", "slide", "x"):
        np.testing.assert_allclose(other[name], -one[name], atol=1e-12, err_msg=name)


def test_random_chains_that_start_turned_have_mirrored_answers_in_a_mirror() -> None:
    count = 250
    rng = np.random.default_rng(9)
    lanes = random_chains(2, count, 2)
    motions = sines(
        Control.ACCELERATION, rng.uniform(2.0, 9.0, count), rng.uniform(0.5, 3.0, count), 4.0
    )
    times = SampleTimes(3.0, 0.02)
    one = run_batch("event", lanes, motions, times)
    other = run_batch("event", mirrored_stacks(lanes), motions.scaled(-np.ones(count)), times)
    np.testing.assert_array_equal(other["outcome"], one["outcome"])
    gap = np.abs(other["rotation"] + one["rotation"]).max(axis=2) / lanes.slenderness_angle
    # Round-off, magnified by up to some hundred impacts.
    assert np.max(gap) <= 1e-3
    assert np.mean(gap <= 1e-9) >= 0.9


@pytest.mark.parametrize("amplitude", [0.0, 4.0])
@pytest.mark.parametrize("made", [statues, cabinets])
def test_bodies_that_stick_are_right_at_coarse_steps(made: Made, amplitude: float) -> None:
    rng = np.random.default_rng(3)
    turned = rng.uniform(-0.1, 0.1, (12, 2)) * (0.2, 1.0) * float(amplitude == 0.0)
    lanes, motions = made(turned), shaken(amplitude * rng.uniform(0.7, 1.3, 12))
    exact = run(lanes, motions, step=2e-4)["rotation"]
    found = run(lanes, motions, step=1.6e-2)["rotation"]
    # A step of second order would be off by some 1e-3; resting leaves out 1e-5.
    assert np.median(np.abs(found - exact).max(axis=(1, 2))) <= 2e-5


@pytest.mark.parametrize("made", [statues, cabinets])
def test_energy_never_grows_on_a_base_at_rest(made: Made) -> None:
    rotation = np.array([[0.02, 0.06], [-0.01, -0.09], [0.015, -0.05]])
    lanes = made(rotation)
    profiles = lanes.profiles
    assert profiles is not None
    step = 1e-3
    found = run(lanes, shaken(np.zeros(3)), SampleTimes(1.5, step, places=True), step=step)
    rate = [np.gradient(found[name], step, axis=-1) for name in ("x", "z", "rotation")]
    inertia = np.stack([np.ones_like(profiles.mass)] * 2 + [profiles.gyration])[..., None]
    kinetic = 0.5 * (profiles.mass[..., None] * inertia * np.square(rate)).sum(axis=(0, 2))
    energy = kinetic + (profiles.mass[..., None] * GRAVITY * found["z"]).sum(axis=1)
    # Differences over an impact are no velocities: one sample on either side of it is off.
    highest = np.maximum.accumulate(energy[:, ::-1], axis=1)[:, ::-1]
    grown = np.median(highest[:, 5:] - energy[:, 2:-3], axis=1)
    held = stack_energy_held(lanes)
    assert np.all(grown <= 1e-3 * held)
    assert np.all(found["energy_lost"] >= 0.0)


@pytest.mark.parametrize("made", [statues, cabinets])
def test_a_stack_that_comes_to_rest_has_lost_what_it_held(made: Made) -> None:
    rotation = np.array([[0.02, 0.02], [-0.01, -0.03], [0.01, -0.02]])
    lanes = made(rotation)
    response = run(lanes, shaken(np.zeros(3)), SampleTimes(8.0), step=2e-3)
    np.testing.assert_array_equal(response["outcome"], Outcome.AT_REST)
    # Second order, and what resting leaves out.
    np.testing.assert_allclose(response["energy_lost"], stack_energy_held(lanes), rtol=1e-4)


def test_an_end_of_the_top_below_carries_a_wider_base() -> None:
    # A base of 0.6 m on a top of 0.4 m: it lifts where that ends, and lands on it again.
    lanes = as_bodies(make_stacks(np.full((2, 2), (2.0, 0.6)), [0.4, 1.0]))
    assert lanes.profiles is not None
    lanes.profiles.top[:, 0, :2] = (-0.2, 0.2)
    response = run(lanes, shaken(np.array([0.39, 0.41]) * GRAVITY, 0.5))
    np.testing.assert_array_equal(np.isfinite(response["uplift_time"]), [False, True])
    assert response["peak_penetration"].max() <= 1e-9


def test_random_stacks_end_with_a_status() -> None:
    lanes, motions = random_chains(7, 64, 2), shaken(np.linspace(-8.0, 8.0, 64), 2.0)
    response = Event().run(lanes, motions, SampleTimes(2.0))
    assert np.count_nonzero(response["status"] == Status.OK) >= 63
    assert set(response["status"]) <= {Status.OK, Status.ITERATION_LIMIT}
    assert np.all(np.isfinite(response["peak_rotation"]))
    # Nothing falls through what is below: 1 part in 100,000 of the blocks.
    assert response["peak_penetration"].max() <= 1e-5
    assert len(set(response["outcome"])) == 4


def test_what_random_stacks_lose_is_what_they_have_come_down() -> None:
    lanes = random_chains(5, 48, 2)
    turned = np.random.default_rng(0).uniform(-0.08, 0.08, (48, 2))
    lanes = dataclasses.replace(lanes, rotation_start=turned)
    response = run(lanes, shaken(np.zeros(48)), SampleTimes(4.0, 4.0, places=True))
    assert lanes.profiles is not None
    height = np.diff(response["z"][..., [0, -1]], axis=-1)[..., 0]
    drop = -GRAVITY * (lanes.profiles.mass * height).sum(axis=1)
    rests = response["outcome"] == Outcome.AT_REST
    assert rests.sum() >= 12
    # On whatever edges they rest. Second order, and first where they slide.
    error = np.abs(response["energy_lost"] / drop - 1.0)[rests]
    assert np.median(error) <= 2e-4
    assert error.max() <= 5e-3


def test_many_random_stacks_end_with_a_status() -> None:
    count = 600
    lanes, motions = random_chains(11, count, 2), shaken(np.linspace(-9.0, 9.0, count), 2.0)
    response = Event().run(lanes, motions, SampleTimes(2.0))
    assert set(response["status"]) <= {Status.OK, Status.ITERATION_LIMIT}
    assert np.count_nonzero(response["status"] == Status.OK) >= 0.99 * count
    assert np.quantile(response["peak_penetration"], 0.99) <= 1e-5


def test_a_lane_alone_is_the_lane_in_its_batch() -> None:
    lanes, motions = with_body(random_pairs(8, 0.4), 1), shaken(EIGHT)
    together = run(lanes, motions)
    for lane in (3, 5):
        part = slice(lane, lane + 1)
        alone = run(lanes.take(part), motions.take(part))
        for name, values in alone.fields.items():
            np.testing.assert_array_equal(values[0], together[name][lane], err_msg=name)


@pytest.mark.parametrize("made", [statues, cabinets])
def test_impulse_refined_comes_to_the_same(made: Made) -> None:
    rng = np.random.default_rng(5)
    lanes, motions = made(np.zeros((8, 2))), shaken(rng.uniform(2.5, 4.5, 8))
    exact = run(lanes, motions, step=5e-4)
    plain = Target(form=Form.PLAIN)
    fine = Impulse(ImpulseSettings(substeps=199), target=plain).run(lanes, motions, TIMES)
    gap = np.abs(fine["rotation"] - exact["rotation"]).max(axis=(1, 2))
    # First order at 1 / 48,000 s.
    assert np.median(gap / lanes.slenderness_angle.min(axis=1)) <= 2e-4
    np.testing.assert_array_equal(fine["outcome"], exact["outcome"])


def test_an_estimate_bounds_the_error() -> None:
    lanes, motions = statues(np.zeros((4, 2))), shaken(np.array([3.0, -3.5, 4.0, -4.5]))
    found = run_to_tolerance("event", lanes, motions, TIMES, settings=EventSettings(time_step=4e-2))
    assert np.all(found["status"] == Status.OK)
    exact = run(lanes, motions, step=2e-4)
    error = np.abs(found["rotation"] - exact["rotation"]).max(axis=2)
    assert error.max() > 1e-8
    assert np.all(error <= found["rotation_error"])
