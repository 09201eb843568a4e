"""`housner` with bodies: against boxes, a SciPy integration with events, and closed forms.

The reference knows a body by its support function alone: with H(theta) the height of the centre of
mass of a body that rolls on flat ground, its contact is H' beside it, and

    I theta'' = -g H' - a H - (H + H'') H' theta'^2,  I = k^2 + H^2 + H'^2.
"""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.shared.blocks import Array, at_rest, free_lanes, make_lanes, sines
from tests.shared.planar_bodies import planar_bodies
from warprock.engines.housner import Housner
from warprock.errors import InputError
from warprock.model.bodies import Bodies
from warprock.model.hull import rounded_centres
from warprock.model.lanes import Lanes
from warprock.model.motion import Control
from warprock.model.ratios import peak_ratio, rotation_ratio
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import HousnerSettings
from warprock.units import GRAVITY

STEPPED = np.array([[-0.14, -0.3], [0.1, -0.3], [0.16, -0.285], [0.2, -0.25]])
"""A base that is eccentric and steps up on its right [m]."""

ALWAYS = HousnerSettings(rest_rotation_ratio=0.0)
"""No swing is too small to be followed."""


def lanes_of(body: Bodies, start: float | Array = 0.0, **more: object) -> Lanes:
    """Bodies that never slide, let go from a rotation [rad]."""
    count = len(body.mass)
    lanes = make_lanes(np.full(count, 0.3), 0.6, friction=1e9)
    start = np.broadcast_to(np.asarray(start, float), (count,)).copy()
    return dataclasses.replace(lanes, body=body, rotation_start=start, **more)


def as_bodies(lanes: Lanes) -> Lanes:
    """Boxes as bodies on two points."""
    half, high = 0.5 * lanes.width, 0.5 * lanes.height
    base = np.stack([np.stack([s * half, -high], axis=-1) for s in (-1.0, 1.0)], axis=1)
    count = lanes.lane_count
    body = Bodies(
        mass=lanes.mass,
        gyration=(lanes.width**2 + lanes.height**2) / 12.0,
        points=base,
        count=np.full(count, 2, np.int32),
        corner_radius=np.zeros(count),
        axes=np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)),
    )
    return dataclasses.replace(lanes, body=body)


def run(lanes: Lanes, motions, times: SampleTimes, settings=ALWAYS) -> Response:
    return Housner(settings).run(lanes, motions, times)


def test_a_box_as_a_body_is_the_box() -> None:
    times = SampleTimes(5.0, 0.01)
    shaken = make_lanes(np.full(8, 0.2), np.linspace(0.8, 1.4, 8), friction=3.0)
    pulses = sines(Control.ACCELERATION, np.linspace(2.5, 5.0, 8), 1.5, 2.0)
    for lanes, motions in ((free_lanes(), at_rest(9)), (shaken, pulses)):
        box, body = (run_batch("housner", each, motions, times) for each in
                     (lanes, as_bodies(lanes)))  # fmt: skip
        # A hundred events let round-off grow to this near balance, a million times smaller else.
        np.testing.assert_allclose(body["rotation"], box["rotation"], atol=1e-9)
        for name in ("impact_count", "status", "outcome"):
            np.testing.assert_array_equal(body[name], box[name], err_msg=name)
        for name in ("rest_time", "energy_lost", "friction_needed", "peak_rotation"):
            np.testing.assert_allclose(body[name], box[name], rtol=1e-6, err_msg=name)


def reference(
    body: Bodies, push: Callable[[float], float], times: Array, given: float | None
) -> Array:
    """Rotations of the first body at the times, by SciPy: let go from 0.3 rad, it never rests."""
    centres, radius, gyration = body.centres[0], float(body.corner_radius[0]), body.gyration[0]

    def support(turn: float, foot: int) -> tuple[float, float, float]:
        x, z = centres[foot]
        c, s = np.cos(turn), np.sin(turn)
        down, beside = x * s - z * c, x * c + z * s
        return radius + down, beside, -down

    def slope(time: float, state: Array, foot: int) -> list[float]:
        height, first, second = support(state[0], foot)
        inertia = gyration + height**2 + first**2
        turning = (height + second) * first * state[1] ** 2
        return [state[1], (-GRAVITY * first - push(time) * height - turning) / inertia]

    edges = [np.arctan2(*(b - a)[::-1]) for a, b in itertools.pairwise(centres)]
    foot, time, state, found = int(np.sum(np.array(edges) < 0.3)), 0.0, [0.3, 0.0], np.empty(0)
    while time < times[-1]:
        events = []
        for edge, direction in ((foot - 1, -1.0), (foot, 1.0)):
            at = edges[edge] if 0 <= edge < len(edges) else direction * 9.0
            events.append(lambda _t, y, _foot, at=at: y[0] - at)
            events[-1].terminal, events[-1].direction = True, direction
        solved = solve_ivp(
            slope, (time, times[-1]), state, "DOP853", args=(foot,), rtol=1e-12, atol=1e-14,
            events=events, dense_output=True,
        )  # fmt: skip
        inside = times[(times >= time) & (times <= solved.t[-1])]
        found = np.append(found[: np.sum(times < time)], solved.sol(inside)[0])
        time, state = float(solved.t[-1]), list(solved.y[:, -1])
        if solved.status == 1:
            right = len(solved.t_events[1]) > 0
            edge = foot if right else foot - 1
            foot = edge + right
            state[0] = edges[edge]
            height, before, _ = support(state[0], edge + (not right))
            behind = support(state[0], foot)[1]
            kept = (gyration + height**2 + before * behind) / (gyration + height**2 + behind**2)
            state[1] *= given if given is not None and edge == 0 else kept
    return found


@pytest.mark.parametrize("radius", [0.0, 0.02])
@pytest.mark.parametrize("given", [None, 0.9])
def test_a_stepped_base_follows_the_reference(radius: float, given: float | None) -> None:
    body = planar_bodies(mass=300.0, inertia=12.0, points=STEPPED, corner_radius=radius)
    lanes = lanes_of(body, start=0.3)
    if given is not None:
        lanes = dataclasses.replace(
            lanes, restitution_given=True, angular_restitution=np.array([given])
        )
    times = SampleTimes(1.6, 0.01)
    found = run(lanes, sines(Control.ACCELERATION, np.array([6.0]), 2.5, 20.0), times)

    def push(time: float) -> float:
        return 6.0 * float(np.sin(5.0 * np.pi * time))

    right = reference(body, push, times.times, given)
    # It starts beyond both steps of its base, and swings to either side.
    assert found["impact_count"][0] >= 4
    assert found["rotation"].min() < -0.1
    np.testing.assert_allclose(found["rotation"][0], right, atol=1e-9)


def test_sides_of_an_eccentric_base_have_their_own_closed_forms() -> None:
    # Let go from either side, it comes down on the other with its own part of the velocity.
    base = np.array([[-0.1, -0.29], [0.3, -0.29]])
    body = planar_bodies(mass=[354.0, 354.0], inertia=18.0, points=base)
    np.testing.assert_allclose(body.slenderness_angles[0], np.arctan([0.1 / 0.29, 0.3 / 0.29]))
    np.testing.assert_allclose(body.uplift_ratios[0], [0.1 / 0.29, 0.3 / 0.29])
    k2 = 18.0 / 354.0
    kept = [(k2 - 0.03 + 0.29**2) / (k2 + 0.29**2 + far**2) for far in (0.1, 0.3)]
    np.testing.assert_allclose(body.angular_restitutions[0], kept)
    start = np.array([-0.2, 0.05])
    lanes = lanes_of(body, start=start)
    times = SampleTimes(2.0, 1e-3)
    found = run(lanes, at_rest(2), times)
    far = np.hypot([0.1, 0.3], 0.29)
    angle = np.arctan([0.1 / 0.29, 0.3 / 0.29])
    for lane, (side, other) in enumerate(((0, 1), (1, 0))):
        # Energy of the fall, the part kept, and how far that lifts the body on its other side.
        fallen = (
            GRAVITY * far[side] * (np.cos(angle[side] - abs(start[lane])) - np.cos(angle[side]))
        )
        rate2 = 2.0 * fallen / (k2 + far[side] ** 2) * kept[other] ** 2
        lifted = 0.5 * rate2 * (k2 + far[other] ** 2) / (GRAVITY * far[other])
        swing = angle[other] - np.arccos(np.cos(angle[other]) + lifted)
        sign = -np.sign(start[lane])
        # Sampled every ms, a swing of half a second is seen to within (1 ms)^2 of its top.
        assert (sign * found["rotation"][lane]).max() == pytest.approx(swing, rel=1e-4)


def test_a_rocker_keeps_its_energy_and_the_rate_of_small_swings() -> None:
    # Arcs that nearly share a centre, 0.1 m above the centre of mass.
    flat, radius, high = 1e-7, 0.4, 0.3
    base = np.array([[-flat - radius, -high], [flat + radius, -high]])
    body = planar_bodies(mass=[100.0], inertia=8.0, points=base, corner_radius=radius)
    amplitude = 0.02
    found = run(lanes_of(body, start=amplitude), at_rest(1), SampleTimes(20.0, 2e-3))
    turned = found["rotation"][0]
    crossings = np.flatnonzero(np.diff(np.sign(turned)))
    part = turned[crossings] / (turned[crossings] - turned[crossings + 1])
    times = 2e-3 * (crossings + part)
    period = 2.0 * np.mean(np.diff(times))
    inertia = 8.0 / 100.0 + high**2
    rate = np.sqrt(GRAVITY * (radius - high) / inertia)
    # Of second order in the amplitude: the mass moves up and down by 0.1 m x amplitude^2.
    assert period == pytest.approx(2.0 * np.pi / rate, rel=amplitude**2)
    # Every crossing of the flat, 2e-7 m wide, takes (flat / inertia) of the velocity.
    assert np.abs(turned[-2000:]).max() == pytest.approx(amplitude, rel=1e-4)


def test_rounding_the_corners_lowers_the_angle_of_balance() -> None:
    sharp, round_ = (
        planar_bodies(mass=300.0, inertia=12.0, points=STEPPED[:2], corner_radius=r)
        for r in (0.0, 0.02)
    )
    np.testing.assert_allclose(
        round_.slenderness_angles[0], np.arctan([0.12 / 0.28, 0.08 / 0.28]), rtol=1e-12
    )
    assert np.all(round_.slenderness_angles < sharp.slenderness_angles)
    # It stands on what is flat between the arcs.
    np.testing.assert_allclose(round_.uplift_ratios[0], [0.4, 0.08 / 0.3], rtol=1e-12)
    near = round_.slenderness_angles[0, 1] * np.array([0.999, 1.001])
    both = round_.take(np.zeros(2, np.intp))
    found = run(lanes_of(both, start=near), at_rest(2), SampleTimes(8.0, None))
    assert found["outcome"].tolist() == [Outcome.AT_REST, Outcome.OVERTURNED]


def test_a_body_rolls_over_to_another_face_and_rests_there() -> None:
    # A hexagon that starts beyond its balance lies down on its next side and stays.
    turn = np.deg2rad(np.arange(6) * 60.0 - 120.0)
    hexagon = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    body = planar_bodies(mass=100.0, inertia=40.0, points=hexagon)
    lanes = lanes_of(body, start=np.deg2rad(31.0))
    found = run_batch("housner", lanes, at_rest(1), SampleTimes(30.0, 0.05))
    assert found["rotation"][0, -1] == pytest.approx(np.deg2rad(60.0), abs=1e-12)
    assert found["outcome"][0] == Outcome.AT_REST
    # All that it held, and the height that it fell, went into impacts.
    start_height, side = np.cos(np.deg2rad(1.0)), np.cos(np.deg2rad(30.0))
    lost = 100.0 * GRAVITY * (start_height - side)
    assert found["energy_lost"][0] == pytest.approx(lost, rel=1e-4)


def test_a_middle_point_changes_nothing_and_a_wide_body_stays_on_both_ends() -> None:
    base = np.array([[-0.2, -0.1], [0.0, -0.1], [0.2, -0.1]])
    bodies = [
        planar_bodies(mass=10.0, inertia=0.05, points=points) for points in (base, base[[0, 2]])
    ]
    found = [
        run_batch("housner", lanes_of(body, start=0.3), at_rest(1), SampleTimes(2.0, 0.01))
        for body in bodies
    ]
    np.testing.assert_array_equal(found[0]["rotation"], found[1]["rotation"])
    # k^2 + x_o x_n + H^2 is below zero: the body keeps no rotation.
    assert bodies[0].angular_restitutions.max() < 0.0
    assert found[0]["impact_count"][0] == 1
    assert found[0]["rotation"][0, -1] == 0.0


def test_uplift_to_each_side_at_its_own_acceleration() -> None:
    body = planar_bodies(mass=[300.0] * 4, inertia=12.0, points=STEPPED)
    left, right = body.uplift_ratios[0] * GRAVITY
    # The base pushes to +x to lift it over its -x end.
    sizes = np.array([0.999 * left, 1.001 * left, -0.999 * right, -1.001 * right])
    half = sines(Control.ACCELERATION, sizes, 1.0, 0.5)
    found = run_batch("housner", lanes_of(body), half, SampleTimes(3.0, 0.01))
    assert np.isnan(found["uplift_time"]).tolist() == [True, False, True, False]
    assert found["rotation"][1].min() < 0.0
    assert found["rotation"][3].max() > 0.0
    assert np.all(found["status"] == Status.OK)


def test_peaks_are_measured_by_the_side_that_they_are_on() -> None:
    body = planar_bodies(mass=300.0, inertia=12.0, points=STEPPED)
    left, right = body.slenderness_angles[0]
    lanes = lanes_of(body, start=0.9 * right)
    found = run(lanes, at_rest(1), SampleTimes(3.0, 1e-3))
    turned = found["rotation"][0]
    assert found["peak_rotation_right"][0] == found["peak_rotation"][0] == 0.9 * right
    # Seen at the ends of steps, of which one lies at each turning point.
    assert found["peak_rotation_left"][0] == pytest.approx(-turned.min(), rel=1e-5)
    assert peak_ratio(found, lanes)[0] == pytest.approx(max(0.9, -turned.min() / left), rel=1e-5)
    ratio = rotation_ratio(found["rotation"], lanes)[0]
    np.testing.assert_array_equal(ratio, turned / np.where(turned < 0.0, left, right))


def test_random_bodies_lose_what_they_held_above_the_edge_they_rest_on() -> None:
    rng = np.random.default_rng(15)
    bodies, starts = [], []
    while len(bodies) < 96:
        x, z = np.sort(rng.uniform(-0.3, 0.3, 7)), rng.uniform(0.0, 0.06, 7)
        z[2:5] = 0.0
        points = np.stack([x, z - rng.uniform(0.2, 0.5)], axis=-1)
        radius = rng.choice([0.0, 0.004])
        body = planar_bodies(
            mass=100.0, inertia=rng.uniform(1.0, 8.0), points=points, corner_radius=radius
        )
        centres = rounded_centres(body.points, body.corner_radius)[0]
        if body.base_ends[0, 0] < -0.01 < 0.01 < body.base_ends[0, 1] and np.all(
            np.diff(centres[:, 0]) > 0.0
        ):
            side = rng.integers(2)
            bodies.append(body)
            starts.append(
                (-1.0, 1.0)[side] * rng.uniform(0.2, 1.3) * body.slenderness_angles[0, side]
            )
    most = max(body.most_points for body in bodies)
    together = Bodies(
        **{
            field.name: np.concatenate(
                [
                    np.pad(part, ((0, 0), (0, most - part.shape[1]), (0, 0)), mode="edge")
                    if part.ndim == 3
                    else part
                    for part in (getattr(body, field.name) for body in bodies)
                ]
            )
            for field in dataclasses.fields(Bodies)
        }
    )
    lanes = lanes_of(together, start=np.array(starts))
    found = run_batch("housner", lanes, at_rest(96), SampleTimes(20.0, 0.5))
    assert np.all(found["status"] == Status.OK)
    rests = found["outcome"] == Outcome.AT_REST
    assert rests.sum() > 50
    assert (found["outcome"] == Outcome.OVERTURNED).sum() > 10
    ends = found["rotation"][:, -1]
    # Some come to rest on another edge than that of their base.
    assert np.sum(rests & (np.abs(ends) > 0.01)) >= 3
    heights = together.roll_centres(np.stack([lanes.rotation_start, ends], axis=1))[1]
    held = 100.0 * GRAVITY * (heights[:, 0] - heights[:, 1])
    np.testing.assert_allclose(found["energy_lost"][rests], held[rests], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("field", "values", "said"),
    [
        ("mass", np.array([300.0, 0.0]), "lanes.body.mass: got 0.0, must be more than 0 (lane 1)"),
        ("mass", np.array([300.0]), "lanes.body.mass: got [1]"),
        ("points", np.tile(np.add(STEPPED, (0.2, 0.0)), (2, 1, 1)), "above the area between"),
        ("gyration", np.full((2, 3), 0.04), "lanes.body.gyration: got [2, 3]"),
    ],
)
def test_bodies_that_cannot_be_run_get_one_line(field: str, values: Array, said: str) -> None:
    body = planar_bodies(mass=[300.0] * 2, inertia=12.0, points=STEPPED)
    wrong = dataclasses.replace(lanes_of(body), body=dataclasses.replace(body, **{field: values}))
    with pytest.raises(InputError, match=re.escape(said)):
        run_batch("housner", wrong, at_rest(2), SampleTimes(1.0))
