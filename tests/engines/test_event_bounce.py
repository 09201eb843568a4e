"""`event` with a restitution: corners that strike the base leave it again."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import at_rest, make_lanes, make_stacks
from tests.shared.held import held_batch
from tests.shared.space_bodies import some_boxes
from tests.shared.spatial_blocks import (
    in_space,
    mirrored,
    sound_run,
    spatial_stack,
    still,
    unmoved,
)
from warprock.engines.base import KernelEngine
from warprock.engines.event import Event
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.release import Release
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.model.scene import scene_kind
from warprock.settings.engines import EventSettings, ImpulseSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

TIMES = SampleTimes(1.5, 0.05, places=True)
NEWTON, POISSON = 0, 1


def rocking(count: int, friction: float, seed: int = 4) -> Lanes:
    """Blocks from twice as high as wide to nearly square, let go from random tilts."""
    draw = np.random.default_rng(seed)
    width, start = draw.uniform(0.2, 0.8, count), draw.uniform(-0.9, 0.9, count)
    return make_lanes(width, 1.0, start, friction)


def run(lanes: Lanes, restitution: float, step: float = 5e-3, law: int = NEWTON) -> Response:
    settings = EventSettings(restitution=restitution, time_step=step, restitution_law=law)
    response = Event(settings).run(lanes, at_rest(lanes.lane_count), TIMES)
    assert np.all(response["status"] == Status.OK)
    return response


@pytest.mark.thorough
@pytest.mark.parametrize(("friction", "law"), [(0.2, NEWTON), (2.0, POISSON)])
def test_second_order_through_bounces_that_follow_ever_faster(friction: float, law: int) -> None:
    """Four times as many steps count one or two bounces more at the end of each series of them."""
    lanes = rocking(64, friction)
    fine = run(lanes, 0.6, 1e-4, law)
    far = [
        np.median(np.abs(run(lanes, 0.6, step, law)["rotation"] - fine["rotation"]).max(axis=1))
        for step in (4e-3, 1e-3)
    ]
    assert far[1] < far[0] / 11.0 < 5e-6
    plastic = run(lanes, 0.0, 1e-4)
    assert np.all(fine["impact_count"] > 2 * plastic["impact_count"])
    # What bounces do is a hundred times as much as the error.
    apart = np.abs(plastic["rotation"] - fine["rotation"]).max(axis=1)
    assert np.median(apart) > 100.0 * far[0]


@pytest.mark.thorough
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_bounces_make_no_energy_and_mirror_images_bounce_alike(friction: float) -> None:
    lanes = rocking(64, friction)
    other = dataclasses.replace(lanes, rotation_start=-lanes.rotation_start)
    for restitution, law in ((0.5, NEWTON), (0.5, POISSON), (1.0, POISSON), (1.0, NEWTON)):
        one, two = run(lanes, restitution, law=law), run(other, restitution, law=law)
        np.testing.assert_array_equal(two["rotation"], -one["rotation"])
        # But for the drift of second order that the ends of steps take back.
        held = lanes.mass * 9.81 * 0.5
        assert np.all(one["energy_lost"] > -1e-5 * held)
    if friction == 0.0:
        # Elastic, and nothing rubs: what is lost are the bounces that are left out, of few lanes.
        lost = one["energy_lost"] / held
        assert np.median(lost) < 1e-12
        assert lost.max() < 1e-3


@pytest.mark.thorough
def test_on_a_wide_block_a_block_bounces_as_on_the_ground() -> None:
    """To the second order of both: stacks and single blocks share no contact solver."""
    lanes = rocking(32, 0.2)
    wide = np.stack([np.full(32, 6.0), lanes.width], axis=1)
    tilt = np.stack([np.zeros(32), lanes.rotation_start], axis=1)
    pairs = make_stacks(wide, [[0.5, 1.0]], rotation=tilt, friction=0.2)
    fine, far = run(lanes, 0.6, 1e-4), []
    for step in (4e-3, 1e-3):
        rotation = run(pairs, 0.6, step)["rotation"]
        assert np.all(rotation[:, 0] == 0.0)
        far.append(np.median(np.abs(rotation[:, 1] - fine["rotation"]).max(axis=1)))
    assert far[1] < far[0] / 11.0 < 5e-6


@pytest.mark.thorough
def test_pairs_bounce_to_second_order_without_energy_and_in_a_mirror() -> None:
    draw, friction = np.random.default_rng(2), 0.2
    width = np.sort(draw.uniform(0.2, 0.8, (64, 2)), axis=1)[:, ::-1]
    height = draw.uniform(0.4, 1.0, (64, 2))
    tilt = draw.uniform(-0.5, 0.5, (64, 2)) * np.arctan2(width, height)
    pairs = make_stacks(width, height, rotation=tilt, friction=friction)
    fine, rough, better = (run(pairs, 0.3, step) for step in (2e-4, 4e-3, 1e-3))
    far = [
        np.median(np.abs(each["rotation"] - fine["rotation"]).max(axis=(1, 2)))
        for each in (rough, better)
    ]
    # Bounces that are left out, and contacts that stop sliding, are few and of second order.
    assert far[1] < far[0] / 7.0 < 5e-6
    plastic = run(pairs, 0.0, 1e-3)
    apart = np.abs(plastic["rotation"] - fine["rotation"]).max(axis=(1, 2))
    assert np.median(apart) > 1000.0 * far[1]
    image = run(dataclasses.replace(pairs, rotation_start=-pairs.rotation_start), 0.3, 4e-3)
    # Round-off, which every impact multiplies.
    np.testing.assert_allclose(image["rotation"], -rough["rotation"], atol=1e-7)
    # But for the drift of second order that the ends of steps take back.
    for found in (rough, run(pairs, 1.0)):
        assert np.all(found["energy_lost"] > -1e-5 * pairs.mass.sum(axis=1) * GRAVITY)


def bricks(
    count: int, friction: float, *, plane: bool = False, sizes: tuple[Any, ...] = (0.1, 0.16, 0.24)
) -> SpatialLanes:
    """Bricks that are thrown with random spins and attitudes, about y alone in a plane.

    Of width, depth and height [m].
    """
    draw = np.random.default_rng(5)
    q, velocity, spin = draw.normal(size=(3, count, 4))
    if plane:
        q[:, [0, 2]], velocity[:, 1], spin[:, [0, 2]] = 0.0, 0.0, 0.0
    q /= np.linalg.norm(q, axis=1)[:, None]
    release = Release(velocity[:, :3], 8.0 * spin[:, :3], q, np.full(count, 0.5))
    width, depth, height = (np.resize(each, count) for each in sizes)
    lanes = in_space(make_lanes(width, height, friction=friction), depth=depth)
    return dataclasses.replace(lanes, release=release)


@pytest.mark.thorough
def test_a_flat_drop_rises_to_e_squared_of_the_height_each_time_and_ends() -> None:
    """The time to its rest is (1 + e) / (1 - e) times that of the fall, less what is left out."""
    lanes, kept = bricks(1, 0.3), 0.6
    flat = Release(*np.zeros((2, 1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]]), np.array([0.62]))
    lanes = dataclasses.replace(lanes, release=flat)
    settings = EventSettings(restitution=kept)
    found = sound_run("event", lanes, still(1), SampleTimes(1.5, 5e-4, places=True), settings)
    z, fall = found["z"][0] - 0.12, np.sqrt(2.0 * 0.5 / GRAVITY)
    tops = z[1:-1][(z[1:-1] > z[:-2]) & (z[1:-1] >= z[2:]) & (z[1:-1] > 1e-4)]
    # A sample misses the top by at most g dt^2 / 8.
    np.testing.assert_allclose(tops, 0.5 * kept ** (2.0 * np.arange(1, len(tops) + 1)), atol=1e-6)
    assert len(tops) >= 8
    # The flights that are left out, each shorter than the one before, the first than a sixteenth of
    # the step.
    left_out = fall * (1.0 + kept) / (1.0 - kept) - found["rest_time"][0]
    assert 0.0 < left_out < 5e-3 / 16.0 / (1.0 - kept)
    assert found["energy_lost"][0] == pytest.approx(lanes.mass[0] * GRAVITY * 0.5, rel=1e-9)


@pytest.mark.thorough
@pytest.mark.parametrize("law", [NEWTON, POISSON])
def test_in_a_plane_blocks_in_space_bounce_as_those_of_the_plane(law: int) -> None:
    """To the second order of both; they share no contact solver."""
    lanes = rocking(64, 0.2)
    fine = run(lanes, 0.6, 1e-4, law)
    far = []
    for step in (4e-3, 1e-3):
        settings = EventSettings(restitution=0.6, time_step=step, restitution_law=law)
        found = sound_run("event", in_space(lanes, depth=0.5), still(64), TIMES, settings)
        # The sweeps of an expansion end at 1e-14 of the velocities; what leaves the plane grows.
        assert found["peak_rotation_across"].max() < (1e-12 if law == NEWTON else 1e-8)
        far.append(np.median(np.abs(found["rotation"] - fine["rotation"]).max(axis=1)))
    assert far[1] < far[0] / 11.0 < 5e-6
    if law == POISSON:
        # The law makes a thousand times as much of a difference.
        apart = np.abs(run(lanes, 0.6, 1e-4)["rotation"] - fine["rotation"]).max(axis=1)
        assert np.median(apart) > 1000.0 * far[1]


@pytest.mark.thorough
@pytest.mark.parametrize("beside", [0.0, 0.02])
def test_boxes_in_space_bounce_on_their_feet_and_overturn_as_boxes_do(beside: float) -> None:
    """With next to no restitution all impacts are plastic: then the body is the box."""
    boxes = some_boxes()
    # Let go beyond its balance the last one falls.
    far = boxes.rotation_start + np.array([0.0, 0.0, 0.0, 0.6])
    off = boxes.centre_offset_x + beside
    boxes = dataclasses.replace(boxes, centre_offset_x=off, rotation_start=far)
    times = SampleTimes(0.6, 0.02, places=True)
    box, body = (
        sound_run("event", boxes, still(4), times, EventSettings(time_step=1e-3, restitution=e))
        for e in (0.0, 1e-9)
    )
    np.testing.assert_array_equal(body["outcome"], box["outcome"])
    assert box["outcome"][3] == Outcome.OVERTURNED
    for name in ("x", "y", "z", "rotation", "rotation_across", "yaw", "slide"):
        # Slides of bodies are of first order in the step, those of boxes of second.
        np.testing.assert_allclose(body[name][:3], box[name][:3], atol=1e-4, err_msg=name)


@pytest.mark.thorough
@pytest.mark.parametrize("friction", [0.0, 0.1, 1.0])
def test_thrown_bricks_make_no_energy(friction: float) -> None:
    lanes, part = bricks(96, friction), {}
    for restitution in (0.5, 1.0):
        for law in (NEWTON, POISSON):
            settings = EventSettings(restitution=restitution, restitution_law=law)
            found = sound_run("event", lanes, still(96), SampleTimes(1.0), settings)
            part[law] = found["energy_lost"] / (lanes.mass * GRAVITY * 0.5)
            # The turn in flight is of second order in the step, 5 ms at some 10 rad/s.
            assert part[law].min() > -3e-3
            assert found["impact_count"].mean() > 2
        if friction == 0.0:
            # Both laws are one where nothing rubs, but for bounces at the bound of those left out.
            assert np.median(np.abs(part[NEWTON] - part[POISSON])) < 1e-12
    if friction == 0.0:
        # Elastic, and nothing rubs.
        assert max(part[NEWTON].max(), part[POISSON].max()) < 3e-3


SHAPES = ([0.1, 0.05, 0.1], [0.1, 0.05, 0.16], [0.1, 0.4, 0.24])
"""Widths, depths and heights of a cube, a rod and a brick [m]."""


def product(a: Array, b: Array) -> Array:
    """Product of quaternions (x, y, z, w), shape [lane, 4]."""
    vector = a[:, 3:] * b[:, :3] + b[:, 3:] * a[:, :3] + np.cross(a[:, :3], b[:, :3])
    scalar = a[:, 3] * b[:, 3] - np.sum(a[:, :3] * b[:, :3], axis=1)
    return np.column_stack([vector, scalar])


@pytest.mark.thorough
@pytest.mark.parametrize("law", [NEWTON, POISSON])
def test_turned_and_mirrored_throws_bounce_alike(law: int) -> None:
    """Cubes, rods and bricks, turned about the vertical by 0.7 rad and mirrored in a plane."""
    lanes, settings = bricks(96, 0.3, sizes=SHAPES), EventSettings(restitution=0.5)
    settings = dataclasses.replace(settings, restitution_law=law)
    thrown, times = lanes.release, SampleTimes(0.5, 0.01, places=True)
    assert thrown is not None
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle), 0.0],
                     [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])  # fmt: skip
    about = np.array([0.0, 0.0, np.sin(0.5 * angle), np.cos(0.5 * angle)])
    turned = dataclasses.replace(
        thrown, velocity=thrown.velocity @ turn.T,
        angular_velocity=thrown.angular_velocity @ turn.T,
        attitude=product(np.tile(about, (96, 1)), thrown.attitude),
    )  # fmt: skip
    flip = np.array([1.0, -1.0, 1.0])
    mirrored = dataclasses.replace(
        thrown, velocity=thrown.velocity * flip, angular_velocity=-thrown.angular_velocity * flip,
        attitude=thrown.attitude * np.array([-1.0, 1.0, -1.0, 1.0]),
    )  # fmt: skip
    places = []
    for release in (thrown, turned, mirrored):
        case = dataclasses.replace(lanes, release=release)
        found = sound_run("event", case, still(96), times, settings)
        places.append(np.stack([found["x"], found["y"], found["z"]], axis=-1))
    assert found["impact_count"].mean() > 2
    # Round-off, which every impact multiplies.
    np.testing.assert_allclose(places[1], places[0] @ turn.T, atol=1e-9)
    np.testing.assert_allclose(places[2], places[0] * flip, atol=1e-9)


@pytest.mark.thorough
@pytest.mark.parametrize("law", [NEWTON, POISSON])
def test_second_order_through_throws_in_a_plane(law: int) -> None:
    """Squares, rods and bricks with a spin about y; impacts are located."""
    lanes, times = bricks(48, 0.3, plane=True, sizes=SHAPES), SampleTimes(0.6, 0.01, places=True)
    fine, *rough = (
        sound_run(
            "event", lanes, still(48), times,
            EventSettings(restitution=0.5, restitution_law=law, time_step=step),
        )
        for step in (2e-4, 4e-3, 1e-3)
    )  # fmt: skip
    # Throws that only fly follow their parabolas to round-off.
    far = [
        np.quantile(np.hypot(each["x"] - fine["x"], each["z"] - fine["z"]).max(axis=1), 0.8)
        for each in rough
    ]
    # A quarter of the step leaves a sixteenth of the error at order 2, a quarter at order 1.
    assert far[1] < far[0] / 8.0 < 1e-7
    assert fine["impact_count"].mean() > 3


@pytest.mark.thorough
def test_event_and_impulse_bounce_alike() -> None:
    """Newton's law in schemes that share no solver; friction is 0.1, as of a die on wood."""
    lanes, times = bricks(96, 0.1, plane=True), SampleTimes(0.5, 0.01, places=True)
    one = sound_run("event", lanes, still(96), times, EventSettings(restitution=0.5))
    two = sound_run("impulse", lanes, still(96), times, ImpulseSettings(restitution=0.5))
    far = np.hypot(one["x"] - two["x"], one["z"] - two["z"])
    # Each impact multiplies what is left of the first order of impulse.
    assert np.median(far[:, -1]) < 2e-3
    assert np.median(far.mean(axis=1)) < 5e-4
    assert one["impact_count"].mean() > 2


def dropped_pairs(count: int) -> SpatialLanes:
    """Pairs in space, turned against one another; the upper block starts on a corner in the air."""
    draw, upper = np.random.default_rng(3), np.array([0.0, 1.0])
    one = spatial_stack([0.5, 0.4], [0.3, 0.3])
    parts = {name: np.repeat(each, count, axis=0) for name, each in one.arrays.items()}
    parts["friction"] = 10.0 ** draw.uniform(-1.0, 0.0, (count, 2))
    parts["yaw_start"] = draw.uniform(-0.5, 0.5, (count, 2))
    parts["offset"] = draw.uniform(-0.03, 0.03, (count, 2))
    parts["rotation_start"] = upper * draw.uniform(-0.1, 0.1, (count, 1))
    parts["rotation_across_start"] = upper * draw.uniform(-0.1, 0.1, (count, 1))
    parts["gap_start"] = upper * draw.uniform(0.0, 0.02, (count, 1))
    return SpatialLanes(**parts)


def drop(lanes: SpatialLanes, restitution: float, times: SampleTimes) -> Response:
    settings = EventSettings(restitution=restitution)
    return sound_run("event", lanes, unmoved(lanes.lane_count), times, settings)


@pytest.mark.thorough
def test_pairs_in_space_bounce_as_those_of_the_plane() -> None:
    """By the equations of space, towards those of the plane; they share no contact solver."""
    draw, count, kept = np.random.default_rng(2), 16, 0.3
    width = np.sort(draw.uniform(0.2, 0.8, (count, 2)), axis=1)[:, ::-1]
    height = draw.uniform(0.4, 1.0, (count, 2))
    tilt = draw.uniform(-0.5, 0.5, (count, 2)) * np.arctan2(width, height) * [0.0, 1.0]
    pairs = make_stacks(width, height, rotation=tilt, friction=0.6)
    times, base = SampleTimes(1.0, 0.02), unmoved(count)
    settings = EventSettings(restitution=kept, time_step=2e-4)
    fine = Event(settings).run(pairs, at_rest(count), times)
    far = []
    for step in (4e-3, 1e-3):
        event = Event(dataclasses.replace(settings, time_step=step))
        found = KernelEngine.run(event, in_space(pairs, depth=0.5), base, times)
        assert np.all(found["status"] == Status.OK)
        far.append(np.quantile(np.abs(found["rotation"] - fine["rotation"]).max(axis=(1, 2)), 0.25))
    # Of second order, but where an edge lets go of an end: of first.
    assert far[1] < far[0] / 4.0 < 5e-6
    plastic = Event(EventSettings()).run(pairs, at_rest(count), times)
    apart = np.abs(plastic["rotation"] - fine["rotation"]).max(axis=(1, 2))
    assert np.median(apart) > 1000.0 * far[1]


@pytest.mark.thorough
def test_a_block_that_drops_flat_on_another_rises_to_e_squared_of_the_height_each_time() -> None:
    """Its yaw leaves the pair no plane of symmetry; the lower block stays."""
    kept = 0.6
    lanes = spatial_stack([0.6, 0.3], [0.4, 0.3], gap_start=[[0.0, 0.5]], yaw_start=[[0.0, 0.3]])
    found = drop(lanes, kept, SampleTimes(1.5, 5e-4, places=True))
    assert np.abs(found["z"][0, 0] - 0.2).max() < 1e-14
    z = found["z"][0, 1] - 0.55
    tops = z[1:-1][(z[1:-1] > z[:-2]) & (z[1:-1] >= z[2:]) & (z[1:-1] > 1e-4)]
    # A sample misses the top by at most g dt^2 / 8.
    np.testing.assert_allclose(tops, 0.5 * kept ** (2.0 * np.arange(1, len(tops) + 1)), atol=1e-6)
    assert len(tops) >= 8
    assert found["energy_lost"][0] == pytest.approx(lanes.mass[0, 1] * GRAVITY * 0.5, rel=1e-6)


@pytest.mark.thorough
def test_dropped_pairs_in_space_make_no_energy_and_keep_their_momentum() -> None:
    """On ground without friction the centre of mass of a pair has no way to leave its vertical."""
    lanes = dropped_pairs(24)
    lanes = dataclasses.replace(lanes, friction=lanes.friction * [0.0, 1.0])
    share = (lanes.mass / lanes.mass.sum(axis=1)[:, None])[..., None]
    held = lanes.mass.sum(axis=1) * GRAVITY * 0.3
    for kept in (0.5, 1.0):
        before = np.zeros(24)
        for until in (0.05, 0.1, 0.2, 0.4):
            found = drop(lanes, kept, SampleTimes(until, 0.05, places=True))
            # But for the turn in flight, which is of second order in the step.
            assert np.all(found["energy_lost"] > before - 1e-6 * held)
            before = found["energy_lost"]
        assert found["impact_count"].mean() > 50.0
        for way in ("x", "y"):
            centre = np.sum(share * found[way], axis=1)
            assert np.abs(centre - centre[:, :1]).max() < 1e-14
            assert np.abs(found[way] - found[way][..., :1]).max() > 1e-3


@pytest.mark.thorough
def test_turned_and_mirrored_pairs_in_space_bounce_alike() -> None:
    """Turned about the vertical by 0.7 rad; each impact multiplies round-off."""
    lanes, cos, sin = dropped_pairs(24), np.cos(0.7), np.sin(0.7)
    turned = dataclasses.replace(
        lanes, yaw_start=lanes.yaw_start + 0.7,
        offset=cos * lanes.offset - sin * lanes.offset_across,
        offset_across=sin * lanes.offset + cos * lanes.offset_across,
    )  # fmt: skip
    cases = (lanes, turned, mirrored(lanes, x=True, y=False))
    one, two, image = (drop(case, 0.7, SampleTimes(0.1, 0.01, places=True)) for case in cases)
    assert one["impact_count"].mean() > 10.0
    off = [two["x"] - (cos * one["x"] - sin * one["y"]), image["x"] + one["x"]]
    for each in off:
        assert np.median(np.abs(each).max(axis=(1, 2))) < 1e-12
        assert np.abs(each).max() < 1e-4


@pytest.mark.thorough
def test_dropped_pairs_in_space_come_to_rest() -> None:
    """Their bounces, ever smaller, end; what they held is what they lose in whatever bounces."""
    lanes = dropped_pairs(12)
    bounced, plastic = (drop(lanes, kept, SampleTimes(1.5)) for kept in (0.5, 0.0))
    assert np.all(np.isfinite(bounced["rest_time"]))
    assert np.all(bounced["impact_count"] > plastic["impact_count"])
    held = plastic["energy_lost"]
    np.testing.assert_allclose(bounced["energy_lost"], held, atol=1e-4 * held.max())


def test_it_refuses_what_does_not_bounce() -> None:
    bouncing, lanes = Event(EventSettings(restitution=0.5)), make_lanes([0.4], [1.0])
    free = scene_kind(lanes, at_rest(1), restitution_given=False)
    assert bouncing.refuses(free) is None
    given = dataclasses.replace(free, restitution_given=True)
    assert "contact.angular_restitution" in str(bouncing.refuses(given))
    by_poisson = Event(EventSettings(restitution=0.5, restitution_law=POISSON))
    assert by_poisson.refuses(free) is None
    stack = dataclasses.replace(free, stacked=True)
    in_a_plane = dataclasses.replace(stack, spatial_because="yaw", coplanar=1.0)
    for pile in (stack, dataclasses.replace(stack, spatial_because="yaw"), in_a_plane):
        assert bouncing.refuses(pile) is None
        assert bouncing.kernel_of(pile).bounces
        assert "restitution_law = 1 is for single" in str(by_poisson.refuses(pile))
    held, motions = held_batch(2, 1, wall=True, ties=0)
    walled = scene_kind(held, motions, restitution_given=False)
    assert "[transverse_wall]" in str(bouncing.refuses(walled))
    assert Event().refuses(walled) is None
