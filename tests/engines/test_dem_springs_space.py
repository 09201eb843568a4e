"""Springs of `dem` in space: modes, stable steps, what they carry and where they are."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest

from tests.shared.blocks import Array, make_lanes, make_stacks, velocity_steps
from tests.shared.spatial_blocks import in_space, sound_run, unmoved
from warprock.engines.dem_springs_space import SpatialSprings, spatial_frequencies
from warprock.model.lanes import Lanes
from warprock.model.motion import SpatialMotions
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

run = functools.partial(sound_run, "dem")


def closed_form_frequencies(lanes: Lanes, settings: DemSettings) -> Array:
    """Six frequencies of a single block on its springs [rad/s], rising."""
    w, h, d, m = (float(v[0]) for v in (lanes.width, lanes.height, lanes.depth, lanes.mass))
    kn, ks = settings.normal_stiffness * w * d, settings.shear_stiffness * w * d
    # Mean of the squared distance from the middle: the trapezoidal rule over n points.
    mean = [
        size**2 / 4.0 * (1.0 / 3.0 + 2.0 / 3.0 / (n - 1) ** 2)
        for size, n in ((w, settings.subcontacts), (d, settings.subcontacts_across))
    ]
    found = [kn / m, ks * sum(mean) / (m * (w**2 + d**2) / 12.0)]
    for size, part in ((w, mean[0]), (d, mean[1])):
        inertia = m * (size**2 + h**2) / 12.0
        rock = (kn * part + ks * h**2 / 4.0) / inertia
        half = 0.5 * (ks / m + rock)
        root = np.sqrt(half**2 - ks * kn * part / (m * inertia))
        found += [half - root, half + root]
    return np.sqrt(np.sort(found))


@pytest.mark.thorough
def test_six_small_motions_have_the_frequencies_of_the_closed_forms() -> None:
    settings = DemSettings(
        subcontacts_across=4, shear_stiffness=4e8, stiffness_damping=0.0,
        tensile_strength=1e12, cohesion=1e12, step_safety=0.05,
    )  # fmt: skip
    lanes = in_space(make_lanes(0.5, 0.6), depth=0.4)
    expected = closed_form_frequencies(lanes, settings)
    np.testing.assert_allclose(spatial_frequencies(lanes, settings)[0], expected, rtol=1e-8)
    # The kernel's block, bonded to its base, rings after a velocity step of all directions; its
    # centre is a little beside the middle, which lets it twist.
    lanes = dataclasses.replace(lanes, centre_offset_x=np.array([1e-3]))
    step = velocity_steps(np.array([1e-3]), np.zeros(1), np.full(1, 10.0))
    times = SampleTimes(1.0, 2e-4)
    response = run(lanes, SpatialMotions(step, step, step), times, settings)
    frequency = 2.0 * np.pi * np.fft.rfftfreq(len(response.times), 2e-4)
    resolution = frequency[1]
    modes = spatial_frequencies(lanes, settings)[0]
    for name in ("rotation", "rotation_across", "yaw"):
        signal = response[name][0] - response[name][0].mean()
        peak = frequency[np.argmax(np.abs(np.fft.rfft(signal * np.hanning(len(signal)))))]
        assert np.min(np.abs(modes - peak)) <= resolution
    assert np.ptp(response["yaw"][0]) > 0.0


@pytest.mark.parametrize("ratio", [0.0, 0.3])
def test_steps_are_stable_up_to_the_limit_and_not_beyond(ratio: float) -> None:
    lanes = in_space(make_lanes(1.0, 0.6), rotation_start=1e-6, rotation_across_start=1e-6)
    base = DemSettings(tensile_strength=1e12, cohesion=1e12, time_step=0.1)
    stiffest = spatial_frequencies(lanes, base)[0, -1]
    damped = dataclasses.replace(base, stiffness_damping=2.0 * ratio / stiffest)
    for safety, stable in ((0.99, True), (1.02, False)):
        settings = dataclasses.replace(damped, step_safety=safety)
        response = run_batch("dem", lanes, unmoved(1), SampleTimes(1.0), settings=settings)
        assert (response["status"][0] == Status.OK) == stable


def test_block_at_rest_sinks_by_its_weight_over_the_springs() -> None:
    lanes = in_space(
        make_lanes(np.full(3, 0.5), 1.0), depth=[0.3, 0.5, 0.5], yaw_start=[0.0, 0.3, 0.0],
        centre_offset_x=[0.0, 0.0, 0.05], centre_offset_y=[0.0, 0.0, -0.03],
    )  # fmt: skip
    response = run(lanes, unmoved(3), SampleTimes(2.0, 0.1))
    area = lanes.width * lanes.depth
    sunk = lanes.mass * GRAVITY / (DemSettings().normal_stiffness * area)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    # The third leans on its springs, whose second moment is 3/8 A b^2.
    deepest = sunk * np.array([1.0, 1.0, 1.0 + 0.25 * (0.05 + 0.03) / (0.375 * 0.25**2)])
    np.testing.assert_allclose(response["peak_penetration"], deepest, rtol=1e-3)
    assert np.all(np.abs(np.diff(response["rotation"], axis=1)) <= 1e-9)
    assert np.all(response["peak_slide"] <= 1e-9)


def test_points_stand_for_the_whole_face_and_none_beyond_an_edge() -> None:
    lanes = in_space(
        make_stacks(np.array([[0.4, 0.5], [0.4, 0.4], [0.4, 0.3]]), 0.6),
        offset=[[0.0, 0.1], [0.0, 0.0], [0.0, 0.0]],
        depth=[[0.3, 0.4], [0.4, 0.4], [0.4, 0.3]],
        yaw_start=[[0.0, 0.0], [0.2, 0.3], [0.0, 0.5]],
    )  # fmt: skip
    springs = SpatialSprings.of(lanes, DemSettings(subcontacts_across=3))
    place = springs.place[:, 1]
    # Shared from 0.1 - 0.25 to 0.2 along, over the lower depth across.
    np.testing.assert_allclose(springs.area[0].sum(axis=1), [0.4 * 0.3, 0.35 * 0.3])
    np.testing.assert_allclose(place[0, :, 0].min(), -0.25)
    np.testing.assert_allclose(place[0, :, 0].max(), 0.1)
    c, s = np.cos(0.1), np.sin(0.1)
    seen = np.stack(
        [c * place[1, :, 0] - s * place[1, :, 1], s * place[1, :, 0] + c * place[1, :, 1]]
    )
    assert np.all(np.abs(seen) <= 0.2 + 1e-12)
    np.testing.assert_allclose(springs.area[2].sum(axis=1), [0.16, 0.09])


@pytest.mark.thorough
def test_stack_of_six_stands_for_a_minute() -> None:
    settings = DemSettings(
        normal_stiffness=1e8, shear_stiffness=1e8, subcontacts=2, subcontacts_across=2,
        stiffness_damping=2e-3, step_safety=0.5,
    )  # fmt: skip
    lanes = in_space(
        make_stacks(np.full((1, 6), 0.4), 0.6), depth=0.4,
        yaw_start=[0.0, 0.1, -0.1, 0.2, 0.0, 0.3],
        offset_across=[0.0, 0.02, -0.02, 0.01, 0.0, 0.02],
        offset=[0.0, 0.01, 0.0, 0.0, -0.02, 0.01],
        centre_offset_x=[0.0, 0.0, 0.01, 0.0, 0.0, 0.0],
    )  # fmt: skip
    response = run(lanes, unmoved(1), SampleTimes(60.0, 1.0), settings)
    assert response["outcome"][0] == Outcome.AT_REST
    for name in ("rotation", "rotation_across", "yaw"):
        moved = np.abs(response[name] - response[name][..., :1]).max()
        # It starts in equilibrium to the square of how far it leans on its springs, 1e-3 rad.
        assert moved <= 1e-5
    assert np.all(response["peak_slide"] <= 1e-5)
