"""Random scenes and their mirror images: blocks and pairs that wait for their base, or turned."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import make_lanes, make_stacks, sines
from tests.shared.vertical_motion import sampled
from warprock.engines import engine_class
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, HarmonicMotions, UprightMotions
from warprock.model.response import Response, SampleTimes
from warprock.running.batch import run_batch

COUNT = 96
TIMES = SampleTimes(1.2, 0.02)
ROUND_OFF = {"direct": 1e-6}
"""Largest difference of a rotation from its mirror image [rad]. What is not here has the same bits.

The exact solution of contacts is one, but its round-off is not mirrored where a scene is its own
mirror image; impacts magnify it."""


def random_scenes(stacked: bool) -> Lanes:
    """Blocks, or pairs, of which a half stands flat and in the middle: their own mirror images."""
    draw = np.random.default_rng(27)
    shape = (COUNT, 2) if stacked else (COUNT,)
    width, height = draw.uniform(0.15, 0.5, shape), draw.uniform(0.4, 1.0, shape)
    turned = (draw.random(COUNT) < 0.5).reshape((COUNT,) + (1,) * stacked)
    # No less than what Housner's blocks need so as not to slide.
    friction = np.maximum(draw.uniform(0.3, 1.2, shape), 1.1 * width / height)
    if not stacked:
        ratio = turned * draw.uniform(-0.9, 0.9, shape)
        return make_lanes(width, height, ratio, friction=friction)
    return make_stacks(
        width,
        height,
        density=draw.uniform(800.0, 2500.0, shape),
        friction=friction,
        offset=turned * np.stack([np.zeros(COUNT), draw.uniform(-0.05, 0.05, COUNT)], axis=1),
        rotation=turned * draw.uniform(-0.05, 0.05, shape) * draw.integers(0, 2, (COUNT, 1)),
    )


def mirrored(lanes: Lanes) -> Lanes:
    return dataclasses.replace(lanes, rotation_start=-lanes.rotation_start, offset=-lanes.offset)


def late_sines() -> HarmonicMotions:
    """Sines before which the base stands still for a while."""
    draw = np.random.default_rng(28)
    size = draw.uniform(0.5, 7.0, COUNT) * draw.choice([-1.0, 1.0], COUNT)
    frequency = draw.uniform(0.7, 4.0, COUNT)
    return sines(Control.ACCELERATION, size, frequency, cycles=1.5, start=0.153)


def assert_mirrored(engine: str, there: Response, back: Response) -> None:
    np.testing.assert_allclose(
        back["rotation"], -there["rotation"], rtol=0.0, atol=ROUND_OFF.get(engine, 0.0)
    )


@pytest.mark.parametrize(
    ("engine", "stacked"),
    [
        ("housner", False),
        ("impulse", False),
        ("impulse", True),
        ("direct", False),
        pytest.param("direct", True, marks=pytest.mark.thorough),
        ("xpbd", False),
        pytest.param("xpbd", True, marks=pytest.mark.thorough),
        ("dem", False),
        ("dem", True),
        ("two-block", True),
    ],
)
def test_random_scenes_have_mirrored_answers(engine: str, stacked: bool) -> None:
    lanes, motions = random_scenes(stacked), late_sines()
    there = run_batch(engine, lanes, motions, TIMES)
    back = run_batch(engine, mirrored(lanes), motions.scaled(-np.ones(COUNT)), TIMES)
    assert np.mean(there["peak_rotation"].reshape(COUNT, -1).max(axis=1) > 1e-2) > 0.5
    assert_mirrored(engine, there, back)


@pytest.mark.thorough
@pytest.mark.parametrize("stacked", [False, True])
def test_what_is_its_own_mirror_image_neither_turns_nor_slides(stacked: bool) -> None:
    # Tossed and landed again by its base, which moves upwards alone. Ten sweeps in one order would
    # turn it at every landing.
    lanes = random_scenes(stacked)
    time = 0.01 * np.arange(101)
    draw = np.random.default_rng(29)
    size, frequency = draw.uniform(5.0, 20.0, (2, COUNT, 1)) * np.array([[[1.0]], [[0.3]]])
    upwards = sampled(size * np.sin(2.0 * np.pi * frequency * time), 0.01)
    motions = UprightMotions(sampled(np.zeros((COUNT, 101)), 0.01), upwards)
    run = engine_class("impulse")().run
    there, back = (run(each, motions, TIMES) for each in (lanes, mirrored(lanes)))
    assert_mirrored("impulse", there, back)
    odd = np.stack([lanes.rotation_start, lanes.offset]).reshape(2, COUNT, -1)
    even = ~odd.any(axis=(0, 2))
    assert even.sum() > 0.3 * COUNT
    assert np.all(there["peak_rotation"][even] == 0.0)
    assert np.all(there["residual_slide"][even] == 0.0)
    assert np.mean(there["impact_count"][even] > 0) > 0.3
