"""Sideways loads as bases that accelerate."""

import numpy as np
import pytest

from warprock.model.base_path import base_path, base_places
from warprock.model.loads import push_motions


def test_a_push_rises_evenly_and_stays_and_so_does_its_base():
    load, rise, start = np.array([2.0, -3.0]), np.array([2.0, 0.7]), np.array([1.0, 0.0])
    motions = push_motions(load, rise, start, np.full(2, 6.0))
    times = np.array([0.5, 1.35, 2.5, 5.9])
    for lane in range(2):
        part = np.clip((times - start[lane]) / rise[lane], 0.0, 1.0)
        assert motions.acceleration(times, lane) == pytest.approx(-load[lane] * part)
        assert not base_places(motions, lane, times).any()
    assert motions.end.tolist() == [6.0, 6.0]


def test_programs_of_others_have_the_base_that_loads_blocks_alike():
    """2 m/s^2 after 1 s: a way of 1/3 m and 1 m/s as it has risen, then t + t^2."""
    motions = push_motions(*(np.array([value]) for value in (-2.0, 1.0, 0.0, 4.0)))
    path = base_path(motions, 0)
    assert path is not None
    wanted = 1.0 / 3.0 + 2.0 + 4.0
    assert path.displacement(np.array([1.0, 3.0]))[:, 0] == pytest.approx([1.0 / 3.0, wanted])
    assert path.velocity(np.array([3.0]))[:, 0] == pytest.approx([5.0])
