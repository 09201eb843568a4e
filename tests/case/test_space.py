"""Cases of blocks in space: what asks for space, where blocks start, how their base moves."""

from __future__ import annotations

import pathlib
import tomllib
from typing import Any

import numpy as np
import pytest

from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.case.text import template_text
from warprock.errors import InputError
from warprock.model import pose
from warprock.model.lanes import SpatialLanes
from warprock.model.motion import HarmonicMotions, RecordMotions, SpatialMotions, StillBase
from warprock.model.response import SampleTimes
from warprock.running.batch import run_batch

PLANAR = """
title = "t"
source = "s"
[block]
width = "0.2 m"
height = "1.0 m"
depth = "0.5 m"
density = "2000 kg/m^3"
[contact]
friction = 0.7
[run]
duration = "1 s"
"""

STACK = """
title = "t"
source = "s"
[block.1]
width = "0.4 m"
height = "0.5 m"
depth = "0.6 m"
density = "2000 kg/m^3"
[block.2]
width = "0.3 m"
height = "0.7 m"
depth = "0.5 m"
density = "2000 kg/m^3"
chamfer = "10 mm"
[contact]
friction = 0.7
[run]
duration = "1 s"
"""

PULSE = ('waveform = "sine"', 'control = "displacement"', 'frequency = "5 Hz"', "cycles = 1")


def expanded(text: str, folder: pathlib.Path, *overrides: str) -> LaneSet:
    file = folder / "case.toml"
    file.write_text(text, encoding="utf-8")
    return expand_lanes(load_case(file, overrides))


def in_space(text: str, folder: pathlib.Path, *overrides: str) -> SpatialLanes:
    lanes = expanded(text, folder, *overrides).lanes
    assert isinstance(lanes, SpatialLanes)
    return lanes


def table(name: str, amplitude: str) -> str:
    return "\n".join([f"[{name}]", *PULSE, f'amplitude = "{amplitude}"', ""])


@pytest.mark.parametrize(
    "override",
    [
        'start.yaw="1 deg"',
        'start.rotation_across="1 deg"',
        'start.gap="1 mm"',
        'block.centre_offset_x="1 mm"',
        'block.centre_offset_y="1 mm"',
        'model="spatial"',
    ],
)
def test_an_imperfection_or_a_wish_makes_a_case_spatial(override: str, tmp_path: pathlib.Path):
    assert not expanded(PLANAR, tmp_path).lanes.spatial
    found = expanded(PLANAR, tmp_path, override)
    assert found.lanes.spatial
    assert override.split("=")[0] in found.scene.spatial_because
    assert found.scene.contact_point_count == 4


@pytest.mark.parametrize("direction", ["y", "z"])
def test_a_second_direction_makes_a_case_spatial(direction: str, tmp_path: pathlib.Path):
    text = PLANAR + table("motion", "6 mm") + table(f"motion.{direction}", "1 mm")
    found = expanded(text, tmp_path)
    assert f"motion.{direction}" in found.scene.spatial_because
    motions = found.motions
    assert isinstance(motions, SpatialMotions)
    parts = dict(zip("xyz", motions.components, strict=True))
    assert all(isinstance(part, HarmonicMotions) for part in parts.values())
    w = 2.0 * np.pi * 5.0
    steps = {name: part.velocity_step_start[0] for name, part in parts.items()}
    expected = dict.fromkeys("xyz", 0.0) | {"x": 6e-3 * w, direction: 1e-3 * w}
    assert steps == pytest.approx(expected)
    column = found.inputs[f"amplitude_mm_{direction}"]
    assert column.tolist() == [1.0]
    assert expanded(PLANAR + table("motion", "6 mm"), tmp_path).lanes.spatial is False


def test_without_a_motion_the_base_stands_still_in_space(tmp_path: pathlib.Path):
    motions = expanded(PLANAR, tmp_path, 'start.yaw="1 deg"').motions
    assert isinstance(motions, SpatialMotions)
    assert all(isinstance(part, StillBase) for part in motions.components)


def test_each_direction_holds_its_own_records(tmp_path: pathlib.Path):
    (tmp_path / "a.csv").write_text("# unit: m/s^2\n# interval: 0.01 s\n0\n1\n0\n")
    (tmp_path / "b.csv").write_text("# unit: m/s^2\n# interval: 0.02 s\n0\n3\n5\n0\n")
    text = PLANAR + "\n".join(
        [
            "[motion]\nwaveform = 'record'\nrecord = 'a.csv'",
            "[motion.y]\nwaveform = 'record'\nrecord = 'b.csv'\nscale = 2.0",
        ]
    )
    motions = expanded(text, tmp_path).motions
    assert isinstance(motions, SpatialMotions)
    x, y, z = motions.components
    assert isinstance(x, RecordMotions)
    assert isinstance(y, RecordMotions)
    assert isinstance(z, RecordMotions)
    assert x.pool_acceleration.tolist() == [0.0, 1.0, 0.0]
    assert y.pool_acceleration.tolist() == [0.0, 3.0, 5.0, 0.0]
    # Half way between the samples 3 and 5, twice; half way from 0 to 1; a base that stays.
    assert y.acceleration(np.array([0.03]), 0)[0] == pytest.approx(8.0)
    assert x.acceleration(np.array([0.005]), 0)[0] == pytest.approx(0.5)
    assert z.acceleration(np.array([0.005]), 0)[0] == 0.0


def test_motions_of_two_families_are_refused(tmp_path: pathlib.Path):
    ricker = '[motion.y]\nwaveform="ricker"\ncontrol="velocity"\nfrequency="2 Hz"\n'
    text = PLANAR + table("motion", "6 mm") + ricker + 'amplitude="0.1 m/s"\n'
    with pytest.raises(InputError, match=r"motion\.y\.waveform.*one family"):
        expanded(text, tmp_path)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ('model="flat"', "planar, spatial"),
        ('start.rotation_across="30 deg"', "26.5651 deg"),
        ('block.centre_offset_x="100 mm"', "less than half of the face"),
        ('start.gap="-1 mm"', "at least 0 m"),
        ('start.yaw="200 deg"', "at most 180 deg"),
        ('motion.z.amplitude="1 mm"', "motion.waveform"),
    ],
)
def test_what_cannot_be_is_refused(override: str, words: str, tmp_path: pathlib.Path):
    with pytest.raises(InputError) as caught:
        expanded(PLANAR, tmp_path, override)
    assert words in str(caught.value)


def test_a_planar_model_refuses_what_needs_space(tmp_path: pathlib.Path):
    with pytest.raises(InputError, match=r"model: got 'planar'.*start\.yaw needs it"):
        expanded('model = "planar"' + PLANAR, tmp_path, 'start.yaw="1 deg"')


def test_a_block_stands_on_its_lowest_corner(tmp_path: pathlib.Path):
    starts = ('start.rotation="3 deg"', 'start.rotation_across="-5 deg"', 'start.yaw="20 deg"')
    lanes = in_space(PLANAR, tmp_path, *starts, 'start.gap="7 mm"', 'block.centre_offset_x="4 mm"')
    position, attitude = pose.start_poses(lanes)
    corners = position[:, None] + pose.rotate(attitude[:, None], pose.bottom_corners(lanes))
    lowest = int(np.argmin(corners[0, :, 2]))
    # Towards its own +x and -y it leans: the corner there is the lowest, where it would stand flat.
    yaw = np.deg2rad(20.0)
    expected = (
        0.1 * np.cos(yaw) + 0.25 * np.sin(yaw),
        0.1 * np.sin(yaw) - 0.25 * np.cos(yaw),
        7e-3,
    )
    np.testing.assert_allclose(corners[0, lowest], expected, atol=1e-15)
    axis = pose.rotate(attitude, np.array([[0.0, 0.0, 1.0]]))[0]
    lean = np.deg2rad(np.hypot(3.0, 5.0))
    assert np.arccos(axis[2]) == pytest.approx(lean)
    assert pose.rotations(attitude)[2][0] == pytest.approx(yaw)


def test_a_lean_in_the_plane_is_the_rotation_of_the_plane(tmp_path: pathlib.Path):
    lanes = in_space(PLANAR, tmp_path, 'model="spatial"', 'start.rotation="-4 deg"')
    rotation, across, yaw = pose.rotations(pose.start_poses(lanes)[1])
    assert rotation[0] == pytest.approx(np.deg2rad(-4.0))
    assert (across[0], yaw[0]) == (0.0, 0.0)


def test_blocks_of_a_stack_start_flat_on_one_another(tmp_path: pathlib.Path):
    overrides = ('block.2.yaw="90 deg"', 'block.2.offset="20 mm"', 'block.2.offset_across="-30 mm"')
    lanes = in_space(STACK, tmp_path, *overrides, 'block.2.centre_offset_x="5 mm"')
    position, attitude = pose.start_poses(lanes)
    # The middle of the upper box is 20 mm to +x and 30 mm to -y; turned by 90 degrees its own +x
    # is +y.
    np.testing.assert_allclose(position[0], [(0.0, 0.0, 0.25), (0.02, -0.025, 0.85)], atol=1e-15)
    corners = position[0, 1] + pose.rotate(attitude[0, 1, None], pose.bottom_corners(lanes)[0, 1])
    np.testing.assert_allclose(corners[:, 2], 0.5)
    assert np.ptp(corners[:, 0]) == pytest.approx(0.48)
    assert np.ptp(corners[:, 1]) == pytest.approx(0.28)


def test_blocks_of_a_stack_that_lean_alike_start_as_one(tmp_path: pathlib.Path):
    overrides = ('block.2.offset="20 mm"', 'block.2.offset_across="-30 mm"')
    leaning = tuple(f'block.{number}.rotation="5 deg"' for number in (1, 2))
    flat = in_space(STACK, tmp_path, *overrides)
    lanes = in_space(STACK, tmp_path, *overrides, *leaning)
    there, here = (pose.start_poses(each)[0][0] for each in (flat, lanes))
    # About the edge at +x of the lower block, 0.2 m from its middle.
    edge, (s, c) = np.array([0.2, 0.0, 0.0]), (np.sin(np.deg2rad(5.0)), np.cos(np.deg2rad(5.0)))
    turned = edge + (there - edge) @ np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    np.testing.assert_allclose(here, turned, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ('block.1.offset_across="1 mm"', "must be 0"),
        ('block.2.offset_across="0.55 m"', "on the face of the block below"),
    ],
)
def test_a_stack_that_cannot_stand_is_refused(override: str, words: str, tmp_path: pathlib.Path):
    with pytest.raises(InputError) as caught:
        expanded('model = "spatial"' + STACK, tmp_path, override)
    assert words in str(caught.value)


def test_the_template_is_a_case_in_space(tmp_path: pathlib.Path):
    text = template_text("spatial")
    raw: dict[str, Any] = tomllib.loads(text)
    assert "y" in raw["motion"]
    assert expanded(text, tmp_path).lanes.spatial


def test_a_sweep_may_follow_a_second_direction(tmp_path: pathlib.Path):
    text = PLANAR + table("motion", "6 mm") + table("motion.y", "1 mm")
    text += '[[sweep]]\nmotion.y.amplitude = ["1 mm", "2 mm"]\nstart.yaw = ["0 deg", "1 deg"]\n'
    found = expanded(text, tmp_path)
    assert found.inputs["amplitude_mm_y"].tolist() == [1.0, 2.0]
    assert found.inputs["yaw_start_rad"].tolist() == pytest.approx([0.0, np.deg2rad(1.0)])


ECCENTRIC = ("block.centre_offset_x='30 mm'", "block.centre_offset_y='-40 mm'")


def test_the_slenderness_of_an_eccentric_block_is_that_of_its_weaker_side(tmp_path: pathlib.Path):
    found = expanded(PLANAR, tmp_path, *ECCENTRIC, "start.rotation_ratio=0.5")
    # Half sizes 0.1, 0.25 and 0.5 m; the centre of mass is 30 and 40 mm off the middle.
    along, across = np.arctan(0.07 / 0.5), np.arctan(0.21 / 0.5)
    row = found.inputs.iloc[0]
    assert row["slenderness_angle_rad"] == pytest.approx(along, rel=1e-15)
    assert row["slenderness_angle_across_rad"] == pytest.approx(across, rel=1e-15)
    np.testing.assert_allclose(found.lanes.slenderness_angle, along, rtol=1e-15)
    np.testing.assert_allclose(found.lanes.rotation_start, 0.5 * along, rtol=1e-15)
    assert row["rotation_ratio_start"] == pytest.approx(0.5, rel=1e-15)
    stack = expanded(STACK, tmp_path, "block.2.centre_offset_x='-20 mm'").inputs.iloc[0]
    assert stack["slenderness_angle_1_rad"] == pytest.approx(np.arctan(0.4 / 0.5), rel=1e-15)
    assert stack["slenderness_angle_2_rad"] == pytest.approx(np.arctan(0.12 / 0.35), rel=1e-15)


def test_a_start_beyond_the_edge_that_it_leans_over_is_refused(tmp_path: pathlib.Path):
    # 7.97 deg to the side of the centre of mass, 14.57 deg to the other.
    for rotation in ("8.1 deg", "-14.7 deg"):
        with pytest.raises(InputError, match=r"start\.rotation: .* slenderness angle"):
            in_space(PLANAR, tmp_path, ECCENTRIC[0], f"start.rotation='{rotation}'")
    for rotation in ("7.8 deg", "-14.4 deg"):
        in_space(PLANAR, tmp_path, ECCENTRIC[0], f"start.rotation='{rotation}'")


def test_normalised_accelerations_are_those_at_which_eccentric_blocks_lift(tmp_path: pathlib.Path):
    rng = np.random.default_rng(3)
    offsets = rng.uniform(-0.06, 0.06, (2, 16))
    yaw = rng.uniform(0.0, 0.5 * np.pi, 16) * (np.arange(16) % 3 > 0)
    lists = {
        "block.centre_offset_x": [f"{v} m" for v in offsets[0]],
        "block.centre_offset_y": [f"{v} m" for v in offsets[1]],
        "start.yaw": [f"{v} rad" for v in yaw],
    }
    sweep = "\n[[sweep]]\n" + "".join(f"{key} = {values}\n" for key, values in lists.items())
    pulse = (PULSE[0], 'control = "acceleration"', *PULSE[2:])
    for direction in ("x", "y"):
        moves = ("0.1 g", "0 g") if direction == "x" else ("0 g", "0.1 g")
        motion = "".join(
            "\n".join((f"\n[{table}]", *pulse, f'amplitude = "{size}"', ""))
            for table, size in zip(("motion", "motion.y"), moves, strict=True)
        )
        found = expanded(PLANAR.replace("0.7", "3.0") + motion + sweep, tmp_path)
        column = "normalised_acceleration" + ("_y" if direction == "y" else "")
        unit = 1.0 / found.inputs[column].to_numpy()
        for part, lifts in ((0.99, False), (1.01, True)):
            motions = found.motions.scaled(part * unit)
            response = run_batch("event", found.lanes, motions, SampleTimes(0.15))
            np.testing.assert_array_equal(np.isfinite(response["uplift_time"]), lifts)
