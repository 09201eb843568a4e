"""Motions of floors against closed forms, and against an integration of the oscillator."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.shared.blocks import sines
from warprock.model.floor import SAMPLES, Floors, floor_motions
from warprock.model.motion import Control
from warprock.recordings import Record, record_motions

DURATION = np.full(1, 12.0)


def floors(frequency: float, damping: float, height_factor: float = 1.0) -> Floors:
    """One floor."""
    return Floors(*(np.array([each]) for each in (frequency, damping, height_factor)))


@pytest.mark.parametrize("height_factor", [1.0, 1.4])
def test_a_floor_on_a_sine_is_known_at_its_samples(height_factor):
    a, f, f0, z = 2.0, 1.7, 2.5, 0.05
    ground = sines(Control.ACCELERATION, np.array([a]), np.array([f]), cycles=100.0)
    found, ways = floor_motions(ground, floors(f0, z, height_factor), DURATION)
    t = found.interval[0] * np.arange(int(found.count[0]) - 1)
    # q'' + 2 z w q' + w^2 q = -a sin(W t) from rest: forced part, and what makes q = q' = 0 at 0.
    w, big = 2.0 * np.pi * f0, 2.0 * np.pi * f
    size = -a / ((w * w - big * big) + 2j * z * w * big)
    pole = complex(-z * w, w * np.sqrt(1.0 - z * z))
    q0, v0 = -size.imag, -(1j * big * size).imag
    c1 = q0 - 1j * (v0 + z * w * q0) / pole.imag
    forced, free = size * np.exp(1j * big * t), c1 * np.exp(pole * t)
    bend = (-(big**2) * forced).imag + (pole * pole * free).real
    expected = a * np.sin(big * t) + height_factor * bend
    # Where the height factor is not 1, the ground is read 1e-9 of an interval after a sample.
    np.testing.assert_allclose(found.pool_acceleration[:-1], expected, atol=1e-8)
    assert found.interval[0] <= 1.0 / (f0 * SAMPLES)
    # At its samples, the last of which starts no piece and is none of t.
    way = height_factor * np.abs(forced.imag + free.real).max()
    np.testing.assert_allclose(ways, way, rtol=1e-10)


def test_a_floor_on_a_record_is_known_at_its_samples():
    rng = np.random.default_rng(3)
    record = Record(
        name="noise",
        interval=0.05,
        samples=rng.normal(0.0, 1.0, 60),
        quantity=Control.ACCELERATION,
        source="made here",
        licence="none",
        sha256="",
        file="made here",
    )
    ground = record_motions([record], index=np.zeros(1, int), scale=np.ones(1), start=np.zeros(1))
    f0, z = 3.0, 0.2
    found, _ = floor_motions(ground, floors(f0, z), np.full(1, 2.9))
    w, at = 2.0 * np.pi * f0, np.linspace(0.0, 2.9, 30)
    state, expected = np.zeros(2), []
    for begin, end in itertools.pairwise(at):
        # From sample to sample the ground is linear.
        for low in np.arange(begin, end - 1e-9, 0.05):
            solved = solve_ivp(
                lambda t, y: (
                    y[1],
                    -float(ground.acceleration(np.array([t]), 0)[0])
                    - 2 * z * w * y[1]
                    - w * w * y[0],
                ),
                (low, low + 0.05 * (1.0 - 1e-12)),
                state,
                rtol=1e-11,
                atol=1e-13,
            )
            state = solved.y[:, -1]
        expected.append(-2.0 * z * w * state[1] - w * w * state[0])
    step = round(0.1 / float(found.interval[0]))
    np.testing.assert_allclose(found.pool_acceleration[step:-1:step][:28], expected[:28], atol=1e-7)


def test_a_velocity_step_of_the_ground_sets_a_floor_free():
    ground = sines(Control.VELOCITY, np.array([0.0]), np.array([1.0]), cycles=1.0)
    ground = dataclasses.replace(ground, velocity_step_start=np.array([0.3]))
    found, ways = floor_motions(ground, floors(2.0, 0.0), DURATION)
    w = 4.0 * np.pi
    t = found.interval[0] * np.arange(int(found.count[0]) - 1)
    # q' = -0.3 at the start, so that the floor swings with 0.3 w sin(w t), and has no step.
    np.testing.assert_allclose(found.pool_acceleration[:-1], 0.3 * w * np.sin(w * t), atol=1e-9)
    assert found.velocity_step_start[0] == 0.0
    # A crest lies between two samples, 100 a period.
    np.testing.assert_allclose(ways, 0.3 / w, rtol=5e-4)


def test_a_stiff_floor_is_the_ground():
    ground = sines(Control.ACCELERATION, np.array([2.0]), np.array([1.0]), cycles=3.0)
    found, _ = floor_motions(ground, floors(400.0, 0.5), np.full(1, 2.0))
    t = np.linspace(0.1, 1.9, 37)
    # The forced part is left: it is beyond the ground by W^2 / w^2 = 6e-6, its lag is of order 3.
    np.testing.assert_allclose(found.acceleration(t, 0), ground.acceleration(t, 0), atol=2e-4)
