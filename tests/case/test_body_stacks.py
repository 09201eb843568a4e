"""Stacks with bodies from a case: what they are, their columns, and what is refused."""

from __future__ import annotations

import pathlib
from collections.abc import Callable

import numpy as np
import pytest

from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import ENGINES, engine_class
from warprock.errors import InputError
from warprock.model.stacking import contact_ends, uplift_ratio
from warprock.running.engine_choice import choose_engine

BOX = """
width = "0.6 m"
height = "0.8 m"
depth = "0.6 m"
density = "2400 kg/m^3"
"""
STATUE = """
mass = "350 kg"
base = [[-0.22, 0.0], [-0.10, 0.0], [0.16, 0.0], [0.24, 0.01]]
centre = [0.02, 0.6]
inertia = "60 kg m^2"
"""
FOOT = """
mass = "120 kg"
base = [["9.75 m", "0.02 m"], [9.8, 0.0], [10.25, 0.0]]
centre = [10.02, 0.2]
inertia = "5 kg m^2"
top = [[10.3, 0.4], [9.7, 0.4]]
"""
REST = """
[contact]
friction = 0.6
[run]
duration = "1 s"
"""


@pytest.fixture
def write(tmp_path: pathlib.Path) -> Callable[..., str]:
    def written(*blocks: str, rest: str = REST) -> str:
        tables = "".join(f"[block.{k}]\n{block}\n" for k, block in enumerate(blocks, 1))
        file = tmp_path / "case.toml"
        file.write_text(f'title = "t"\nsource = "s"\n{tables}{rest}', encoding="utf-8")
        return str(file)

    return written


def test_a_statue_on_a_pedestal(write: Callable[..., str]) -> None:
    lane_set = expand_lanes(load_case(write(BOX, STATUE)))
    lanes = lane_set.lanes
    assert lanes.profiles is not None
    np.testing.assert_allclose(lanes.mass, [[2400.0 * 0.6 * 0.8 * 0.6, 350.0]])
    np.testing.assert_allclose(lanes.profiles.gyration[0, 1], 60.0 / 350.0)
    # The statue stands on the points from -0.24 m to 0.14 m beside its centre of mass; over the
    # last one, which is 0.01 m higher, it falls.
    np.testing.assert_allclose(contact_ends(lanes), [[[-0.3, -0.24]], [[0.3, 0.14]]])
    angles = lanes.profiles.slenderness_angles[0, 1]
    np.testing.assert_allclose(np.tan(angles), [0.24 / 0.6, 0.22 / 0.59])
    np.testing.assert_allclose(uplift_ratio(lanes)[0, 1], 0.14 / 0.6)
    row = lane_set.inputs.iloc[0]
    assert row["mass_2_kg"] == 350.0
    np.testing.assert_allclose(row["slenderness_angle_left_2_rad"], angles[0])
    assert "density_2_kg_m3" not in row
    assert lane_set.scene.bodies


def test_a_box_on_a_foot_stands_on_its_top(write: Callable[..., str]) -> None:
    lanes = expand_lanes(load_case(write(FOOT, BOX))).lanes
    assert lanes.profiles is not None
    # From the centre of mass: the axes of the base lie anywhere.
    np.testing.assert_allclose(lanes.profiles.top[0, 0], [-0.32, 0.28, 0.2])
    np.testing.assert_allclose(lanes.height[0], [0.4, 0.8])
    # Both lift about the end of the foot that is nearer: mass by mass, from its centre.
    masses, ends = lanes.mass[0], np.array([-0.22, 0.23])
    centre = masses @ [0.0, -0.02] / masses.sum()
    high = masses @ [0.2, 0.8] / masses.sum()
    expected = min(centre - ends[0], ends[1] - centre) / high
    np.testing.assert_allclose(uplift_ratio(lanes)[0, 0], expected)


def test_a_statue_from_a_scan_is_seen_along_the_motion(write: Callable[..., str]) -> None:
    statue = """
mass = "350 kg"
base = [[-0.2, -0.1, 0.0], [0.3, -0.1, 0.0], [0.3, 0.15, 0.0], [-0.2, 0.15, 0.0]]
centre = [0.0, 0.0, 0.6]
inertia = [50.0, 60.0, 10.0, 0.0, 0.0, 0.0]
"""
    rest = (
        REST
        + """
[motion]
waveform = "sine"
control = "acceleration"
frequency = "1 Hz"
amplitude = "0.1 g"
cycles = 1
[[sweep]]
"motion.direction" = ["0 deg", "90 deg"]
"""
    )
    file = pathlib.Path(write(BOX, statue, rest=rest))
    with pytest.raises(InputError, match=r'block.2.base: .* without model = "planar"'):
        expand_lanes(load_case(str(file)))
    file.write_text('model = "planar"\n' + file.read_text())
    lane_set = expand_lanes(load_case(str(file)))
    profiles = lane_set.lanes.profiles
    assert profiles is not None
    np.testing.assert_allclose(profiles.base_ends[:, 1], [[-0.2, 0.3], [-0.1, 0.15]], atol=1e-12)
    np.testing.assert_allclose(profiles.gyration[:, 1] * 350.0, [60.0, 50.0])
    assert "direction_deg" in lane_set.inputs


def test_event_runs_them_where_no_engine_is_named(write: Callable[..., str]) -> None:
    assert choose_engine(load_case(write(BOX, STATUE))).engine == "event"


def test_engines_that_stack_boxes_alone_say_so(write: Callable[..., str]) -> None:
    scene = expand_lanes(load_case(write(BOX, STATUE))).scene
    declined = {name: engine_class(name).supports(scene) for name in ENGINES}
    assert declined["impulse"] is None
    assert all(
        "body" in why for name, why in declined.items() if why is not None and name != "housner"
    )
    assert all(engine_class(name).stacked_bodies == (why is None) for name, why in declined.items())


@pytest.mark.parametrize(
    ("blocks", "rest", "said"),
    [
        ((STATUE, BOX), "", "block.1.top: got nothing, must be given"),
        ((BOX, STATUE + 'width = "1 m"\n'), "", "block.2.width: .* must not be given beside"),
        ((FOOT + 'height = "1 m"\n', BOX), "", "block.1.height: .* must not be given beside top"),
        ((FOOT.replace("0.4]]", "0.5]]"), BOX), "", "block.1.top: .* the same z"),
        ((FOOT.replace("0.4]", "0.01]"), BOX), "", "block.1.top: .* above all points of the base"),
        ((FOOT.replace("0.4]]", "0.4], [0, 0]]"), BOX), "", "block.1.top: .* list of 2 points"),
        ((BOX, STATUE.replace("-0.22,", "-0.22, 0.0,")), "", r"base\[1\]: .* 3 coordinates"),
        ((BOX, STATUE + 'chamfer = "1 mm"\n'), "", "block.2.chamfer: .* must not be given beside"),
        ((BOX, STATUE + 'offset = "0.6 m"\n'), "", "block.2.offset: .* on the face of the block"),
        ((BOX, STATUE + 'corner_radius = "1 mm"\n'), "", "corner_radius: .* unknown key"),
        ((BOX + 'yaw = "5 deg"\n', STATUE), "", "block.2.base: .* in a stack in space"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_in_one_line(
    write: Callable[..., str], blocks: tuple[str, ...], rest: str, said: str
) -> None:
    with pytest.raises(InputError, match=said):
        expand_lanes(load_case(write(*blocks, rest=REST + rest)))


def test_a_body_is_swept_as_any_block(write: Callable[..., str]) -> None:
    rest = REST + '[[sweep]]\n"block.2.mass" = ["300 kg", "400 kg"]\n'
    lane_set = expand_lanes(load_case(write(BOX, STATUE + "base_scale = 0.9\n", rest=rest)))
    lanes = lane_set.lanes
    np.testing.assert_allclose(lanes.mass[:, 1], [300.0, 400.0])
    np.testing.assert_allclose(uplift_ratio(lanes)[:, 1], 0.9 * 0.14 / 0.6)
    assert {"mass_2_kg", "base_scale_2"} <= set(lane_set.inputs)
