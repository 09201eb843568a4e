"""Cylinders: the box that stands for them, and what is said of the difference."""

from __future__ import annotations

import re

import numpy as np
import pytest

from warprock.case.block import ROUND_DEPTH
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.case.round_base import round_base_note
from warprock.errors import InputError

DIAMETER, HEIGHT = 0.6, 1.1


def moments(depth_at: np.ndarray, x: np.ndarray) -> tuple[float, float, float]:
    """Mass and inertia about the rim, over the density, and height of the mass: by quadrature."""
    z = (np.arange(2000) + 0.5) * HEIGHT / 2000
    slices = depth_at * (x[1] - x[0]) * HEIGHT
    mass = float(slices.sum())
    inertia = float((slices * x**2).sum() + mass * np.mean(z**2))
    return mass, inertia, float(np.mean(z))


def test_the_box_keeps_the_mass_and_its_inertia_is_off_as_said():
    x = (np.arange(200_000) + 0.5) * DIAMETER / 200_000
    chord = 2.0 * np.sqrt((DIAMETER / 2) ** 2 - (x - DIAMETER / 2) ** 2)
    cylinder, box = moments(chord, x), moments(np.full_like(x, ROUND_DEPTH * DIAMETER), x)
    assert box[0] == pytest.approx(cylinder[0], rel=1e-6)
    sine = DIAMETER**2 / (DIAMETER**2 + HEIGHT**2)
    assert box[1] / cylinder[1] == pytest.approx(1.0 / (1.0 - sine / 16.0), rel=1e-6)
    lane_set = expand_lanes(
        load_case("single-sine-pulse", [f"block.diameter={DIAMETER} m", f"block.height={HEIGHT} m"])
    )
    said = re.search(r"rim is (\S+) % larger", round_base_note(lane_set.inputs))
    assert said is not None
    assert float(said[1]) == pytest.approx(100.0 * (box[1] / cylinder[1] - 1.0), rel=0.05)
    kept = [1.0 - m * DIAMETER**2 / (2.0 * inertia) for m, inertia, _ in (cylinder, box)]
    said = re.search(r"keeps (\S+) more", round_base_note(lane_set.inputs))
    assert said is not None
    assert float(said[1]) == pytest.approx(kept[1] - kept[0], rel=0.05)


def test_a_diameter_stands_for_width_and_depth():
    inputs = expand_lanes(load_case("free-b0", ["block.diameter=1 m, 0.5 m"])).inputs
    assert set(inputs["diameter_m"]) == {0.5, 1.0}
    np.testing.assert_array_equal(inputs["width_m"], inputs["diameter_m"])
    np.testing.assert_allclose(inputs["depth_m"], np.pi / 4.0 * inputs["diameter_m"], rtol=1e-15)
    drums = expand_lanes(load_case("stack-sine-pulse", ["block.2.diameter=0.16 m"])).inputs
    assert drums["depth_2_m"][0] == pytest.approx(np.pi / 4.0 * 0.16)
    assert drums["diameter_2_m"][0] == 0.16
    assert round_base_note(expand_lanes(load_case("free-b0")).inputs) == ""


@pytest.mark.parametrize(
    ("name", "overrides", "words"),
    [
        (
            "space-free",
            ["block.diameter=1 m"],
            "block.diameter: got a round base, must be left",
        ),
        ("free-b0", ["block.diameter=1 m", "block.width=1 m"], "block.depth: got nothing, must be"),
        ("rocking-spectrum", ["block.diameter=1 m"], "must not be given beside block.width"),
    ],
)
def test_what_a_cylinder_cannot_be_is_refused(name: str, overrides: list[str], words: str):
    with pytest.raises(InputError, match=re.escape(words)):
        expand_lanes(load_case(name, overrides))
