"""`event` with a restitution: corners that strike the base leave it again."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import at_rest, make_lanes
from tests.shared.held import held_batch
from warprock.engines.event import Event
from warprock.model.lanes import Lanes
from warprock.model.response import Response, SampleTimes, Status
from warprock.model.scene import scene_kind
from warprock.settings.engines import EventSettings

TIMES = SampleTimes(1.5, 0.05, places=True)


def rocking(count: int, friction: float, seed: int = 4) -> Lanes:
    """Blocks from twice as high as wide to nearly square, let go from random tilts."""
    draw = np.random.default_rng(seed)
    width, start = draw.uniform(0.2, 0.8, count), draw.uniform(-0.9, 0.9, count)
    return make_lanes(width, 1.0, start, friction)


def run(lanes: Lanes, restitution: float, step: float = 5e-3) -> Response:
    settings = EventSettings(restitution=restitution, time_step=step)
    response = Event(settings).run(lanes, at_rest(lanes.lane_count), TIMES)
    assert np.all(response["status"] == Status.OK)
    return response


@pytest.mark.thorough
@pytest.mark.parametrize("friction", [0.2, 2.0])
def test_second_order_through_bounces_that_follow_ever_faster(friction: float) -> None:
    """Four times as many steps count one or two bounces more at the end of each series of them."""
    lanes = rocking(64, friction)
    fine = run(lanes, 0.6, 1e-4)
    far = [
        np.median(np.abs(run(lanes, 0.6, step)["rotation"] - fine["rotation"]).max(axis=1))
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
    for restitution in (0.5, 1.0):
        one, two = run(lanes, restitution), run(other, restitution)
        np.testing.assert_array_equal(two["rotation"], -one["rotation"])
        # But for the drift of second order that the ends of steps take back.
        held = lanes.mass * 9.81 * 0.5
        assert np.all(one["energy_lost"] > -1e-5 * held)
    if friction == 0.0:
        # Elastic, and nothing rubs: what is lost are the bounces that are left out, of few lanes.
        lost = one["energy_lost"] / held
        assert np.median(lost) < 1e-12
        assert lost.max() < 1e-3


def test_it_refuses_what_does_not_bounce() -> None:
    bouncing, lanes = Event(EventSettings(restitution=0.5)), make_lanes([0.4], [1.0])
    free = scene_kind(lanes, at_rest(1), restitution_given=False)
    assert bouncing.refuses(free) is None
    given = dataclasses.replace(free, restitution_given=True)
    assert "contact.angular_restitution" in str(bouncing.refuses(given))
    held, motions = held_batch(2, 1, wall=True, ties=0)
    walled = scene_kind(held, motions, restitution_given=False)
    assert "[transverse_wall]" in str(bouncing.refuses(walled))
    assert Event().refuses(walled) is None
