"""Bodies in case files: what is read, what is refused, and the lanes that they make."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

from warprock.case.lanes import expand_lanes
from warprock.case.load import build_case, load_case
from warprock.case.text import parse_case
from warprock.engines import ENGINES, engine_class
from warprock.errors import InputError
from warprock.model.motion import SpatialMotions
from warprock.units import GRAVITY

HEAD = """
title = "t"
source = "s"
[contact]
friction = 2.0
[run]
duration = "2 s"
"""

PROFILE = (
    HEAD
    + """
[block]
mass = "354 kg"
base = [["-10 cm", "0 m"], [0.3, 0], [0.1, 0.02]]
centre = ["0 m", "0.29 m"]
inertia = "18 kg m^2"
"""
)

SOLID = (
    HEAD
    + """
[block]
mass = "354 kg"
base = [[-0.3, -0.2, 0], [0.4, -0.2, 0], [0, 0.3, 0], [0.5, 0.4, 0.05]]
centre = [0, 0, 0.5]
inertia = [18, 15, 12, 0.5, 0.2, -0.1]
"""
)

SHAKEN = """
[motion]
waveform = "sine"
control = "acceleration"
frequency = "2 Hz"
amplitude = "0.4 g"
cycles = 1
direction = "30 deg"
"""

ACROSS = """
[motion.y]
waveform = "sine"
control = "acceleration"
frequency = "2 Hz"
amplitude = "0.4 g"
cycles = 1
"""


def test_a_profile_is_seen_from_its_centre_of_mass(write):
    lane_set = expand_lanes(load_case(write(PROFILE)))
    body = lane_set.lanes.body
    assert body is not None
    # The point that lies inside the hull cannot touch flat ground.
    np.testing.assert_allclose(body.points, [[[-0.1, -0.29], [0.3, -0.29]]])
    assert body.count.tolist() == [2]
    assert body.mass.tolist() == lane_set.lanes.mass.tolist() == [354.0]
    np.testing.assert_allclose(body.gyration, 18.0 / 354.0)
    shown = lane_set.inputs.iloc[0]
    assert shown["mass_kg"] == 354.0
    assert shown["slenderness_angle_rad"] == shown["slenderness_angle_left_rad"]
    assert shown["slenderness_angle_left_rad"] == pytest.approx(np.arctan(0.1 / 0.29))
    assert shown["slenderness_angle_right_rad"] == pytest.approx(np.arctan(0.3 / 0.29))
    assert shown["half_diagonal_m"] == pytest.approx(np.hypot(0.1, 0.29))
    assert shown["width_m"] == pytest.approx(0.4)
    assert shown["height_m"] == pytest.approx(0.58)
    assert "base_scale" not in shown


def test_a_case_with_a_body_is_written_and_read_again(write):
    case = load_case(write(SOLID))
    again = build_case("again", "again", None, parse_case(case.to_toml(), "again"))
    there, here = (expand_lanes(each).lanes.body for each in (again, case))
    np.testing.assert_array_equal(there.points, here.points)


def test_a_direction_turns_the_plane_of_rocking(write):
    case = load_case(write(SOLID + SHAKEN), ["model=planar", "motion.direction=0 deg, 90 deg"])
    lane_set = expand_lanes(case)
    assert not lane_set.scene.spatial
    body = lane_set.lanes.body
    np.testing.assert_allclose(body.base_ends, [[-0.3, 0.4], [-0.2, 0.3]], atol=1e-12)
    # Rocking along x turns the body about y, rocking along y about x.
    np.testing.assert_allclose(body.gyration, np.array([15.0, 18.0]) / 354.0)
    assert lane_set.inputs["direction_deg"].tolist() == [0.0, 90.0]
    np.testing.assert_allclose(
        lane_set.inputs["normalised_acceleration"], [0.4 / 0.6, 0.4 / 0.4], rtol=1e-12
    )


def test_in_space_a_direction_splits_the_motion(write):
    lane_set = expand_lanes(load_case(write(SOLID + SHAKEN)))
    assert lane_set.scene.spatial
    motions = lane_set.motions
    assert isinstance(motions, SpatialMotions)
    times = np.array([0.1])
    x, y, z = (part.acceleration(times, 0)[0] for part in motions.components)
    assert y / x == pytest.approx(np.tan(np.deg2rad(30.0)))
    assert np.hypot(x, y) == pytest.approx(0.4 * GRAVITY * np.sin(0.4 * np.pi))
    assert z == 0.0
    # The base is left where the line of shaking crosses its nearer side.
    ends = lane_set.lanes.body.reach(np.deg2rad([30.0]))[0]
    ratio = 0.4 / (np.abs(ends).min() / 0.5)
    assert lane_set.inputs["normalised_acceleration"][0] == pytest.approx(ratio, rel=1e-12)


def test_a_box_is_shaken_in_a_direction_in_space_alone(write):
    box = 'width = "0.5 m"\nheight = "1 m"\ndepth = "0.4 m"\ndensity = "2000 kg/m^3"\n'
    lane_set = expand_lanes(load_case(write(HEAD + "[block]\n" + box + SHAKEN)))
    assert lane_set.scene.spatial
    assert lane_set.inputs["direction_deg"].tolist() == [30.0]
    # Over the edge that the line meets first, half of 0.4 m across at 30 degrees to it.
    reach = min(0.25 / np.cos(np.pi / 6.0), 0.2 / np.sin(np.pi / 6.0))
    assert lane_set.inputs["normalised_acceleration"][0] == pytest.approx(0.4 / (reach / 0.5))


def test_start_ratios_are_of_the_side_that_a_body_leans_to(write):
    lanes = expand_lanes(load_case(write(PROFILE), ["start.rotation_ratio=-0.5, 0.5"])).lanes
    np.testing.assert_allclose(lanes.rotation_start, 0.5 * np.arctan([-0.1 / 0.29, 0.3 / 0.29]))


def test_an_ensemble_spreads_the_scale_of_the_base(write):
    spread = '[ensemble]\nmembers = 4\nspread.block.base_scale = "2 %"\n'
    text = PROFILE.replace("[block]", "[block]\nbase_scale = 1.0") + spread
    lane_set = expand_lanes(load_case(write(text)))
    scale = lane_set.inputs["base_scale"].to_numpy()
    assert len(set(scale)) == 4
    np.testing.assert_allclose(lane_set.lanes.body.points[:, 0, 0], -0.1 * scale)


def test_engines_say_why_they_decline_bodies(write):
    scenes = [expand_lanes(load_case(write(text))).scene for text in (PROFILE, SOLID)]
    rounded = expand_lanes(load_case(write(PROFILE), ["block.corner_radius=5 mm"])).scene
    for name in ENGINES:
        engine = engine_class(name)
        for scene in scenes:
            said = engine.supports(scene)
            if not engine.bodies[scene.spatial]:
                assert said is not None, name
        if engine.bodies[0] and not engine.rounded:
            assert "block.corner_radius" in str(engine.supports(rounded))
    assert "block.base" in str(engine_class("direct").supports(scenes[0]))
    assert "block.base" in str(engine_class("xpbd").supports(scenes[0]))
    assert engine_class("housner").supports(rounded) is None


def refusal(file: pathlib.Path, *overrides: str) -> InputError:
    """The error, of one line, with which a case or its lanes are refused."""
    with pytest.raises(InputError) as caught:
        expand_lanes(load_case(file, overrides))
    assert "\n" not in str(caught.value)
    return caught.value


BAD = [
    ('mass = "354 kg"', "", "block.mass", "kg, t"),
    ("[0.3, 0]", "[0.3]", "block.base[1]", "[x, z]"),
    ("[0.3, 0]", "[0.3, 0, 1]", "block.base[1]", "2 coordinates"),
    ("[0.3, 0]", '[0.3, "1 s"]', "block.base[1]", "a length with a unit"),
    ('[["-10 cm", "0 m"], [0.3, 0], [0.1, 0.02]]', "[[0, 0]]", "block.base", "2 to 64"),
    ('["0 m", "0.29 m"]', "[0, 0, 0.29]", "block.centre", "2 coordinates"),
    ('["0 m", "0.29 m"]', "[0, -0.1]", "block.centre", "above the lowest"),
    ('["0 m", "0.29 m"]', "[0.31, 0.29]", "block.centre", "lowest contact points"),
    ('"18 kg m^2"', '"18 kg"', "block.inertia", "kg m^2"),
    ('"18 kg m^2"', '"-1 kg m^2"', "block.inertia", "more than 0"),
    ('"18 kg m^2"', "[1, 2, 3, 0, 0, 0]", "block.inertia", "in the plane"),
    ("[block]", '[block]\nwidth = "1 m"', "block.width", "a body is no box"),
    ("[block]", '[block]\ncorner_radius = "0.2 m"', "block.corner_radius", "must leave an edge"),
    ("[block]", "model = 1\n[block]", "run.model", "unknown key"),
]


@pytest.mark.parametrize(("old", "new", "key", "said"), BAD)
def test_what_no_body_is_gets_one_line(write, old: str, new: str, key: str, said: str):
    assert old in PROFILE
    error = refusal(write(PROFILE.replace(old, new)))
    assert error.key == key
    assert said in str(error)


@pytest.mark.parametrize(
    ("text", "override", "key", "said"),
    [
        (PROFILE, "model=spatial", "block.base", "[x, y, z]"),
        (PROFILE + SHAKEN, "run.duration=1 s", "motion.direction", "a plane itself"),
        (SOLID, "block.inertia=[1, 1, 5, 0, 0, 0]", "block.inertia", "above the sum"),
        (SOLID, "block.corner_radius=5 mm", "block.corner_radius", "in space"),
        (SOLID, "start.rotation_across=60 deg", "start.rotation_across", "slenderness angle"),
        (PROFILE, "start.rotation=-20 deg", "start.rotation", "of that side"),
        (SOLID + SHAKEN + ACROSS, "run.duration=1 s", "motion.direction", "beside motion.y"),
    ],
)
def test_what_does_not_fit_together_gets_one_line(write, text, override, key, said):
    error = refusal(write(text), override)
    assert error.key == key
    assert said in str(error)
