"""Cases whose base moves upwards, too: in the plane where they ask for it, else in space."""

from __future__ import annotations

import dataclasses
import pathlib

import numpy as np
import pytest

from tests.shared.case_texts import FREE
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.engines import ENGINES, engine_class
from warprock.errors import InputError
from warprock.model.motion import RecordMotions, SpatialMotions, UprightMotions

RISING = """
[motion]
waveform = "record"
record = "ridgecrest-2019-ccc-090"
[motion.z]
waveform = "record"
record = "ridgecrest-2019-ccc-360"
scale = 0.5
"""


PROFILE = """
title = "t"
source = "s"
[block]
mass = "100 kg"
base = [[-0.1, 0], [0.3, 0], [0.4, 0.02]]
centre = [0.1, 0.5]
inertia = ["12 kg m^2"]
[contact]
friction = 0.7
[run]
duration = "5 s"
"""


def expanded(text: str, folder: pathlib.Path, *overrides: str) -> LaneSet:
    file = folder / "case.toml"
    file.write_text(text, encoding="utf-8")
    return expand_lanes(load_case(str(file), overrides))


def test_a_box_stays_in_the_plane_where_the_case_asks_for_it(tmp_path: pathlib.Path) -> None:
    asked = expanded(FREE + RISING, tmp_path, 'model="planar"')
    left = expanded(FREE + RISING, tmp_path)
    assert isinstance(asked.motions, UprightMotions)
    assert isinstance(left.motions, SpatialMotions)
    assert asked.scene.vertical
    assert not asked.scene.spatial
    assert left.scene.spatial_because == (
        'moves its base upwards without model = "planar" (motion.z)'
    )
    assert isinstance(asked.motions.z, RecordMotions)
    np.testing.assert_array_equal(asked.motions.z.scale, [0.5])
    row = asked.inputs.iloc[0]
    assert (row["record"], row["record_z"]) == (
        "ridgecrest-2019-ccc-090",
        "ridgecrest-2019-ccc-360",
    )
    assert row["peak_acceleration_m_s2_z"] < row["peak_acceleration_m_s2"]


def test_engines_without_it_say_so_in_a_line(tmp_path: pathlib.Path) -> None:
    scene = expanded(FREE + RISING, tmp_path, 'model="planar"').scene
    follow = {name for name in ENGINES if engine_class(name).supports(scene) is None}
    assert follow == {"housner", "event", "impulse", "dem"}
    for name in ENGINES:
        declined = engine_class(name).supports(scene) or ""
        assert "\n" not in declined
        assert name in follow or "motion.z" in declined
    for bodies in (False, True):
        stack = dataclasses.replace(scene, stacked=True, block_count=2, bodies=bodies)
        follow = {name for name in ENGINES if engine_class(name).supports(stack) is None}
        assert follow == {"event", "impulse", "dem"}


def test_a_motion_across_still_asks_for_space(tmp_path: pathlib.Path) -> None:
    across = RISING + '[motion.y]\nwaveform = "record"\nrecord = "ridgecrest-2019-ccc-360"\n'
    with pytest.raises(InputError, match=r"motion\.y needs it"):
        expanded(FREE + across, tmp_path, 'model="planar"')


def test_a_profile_knows_no_other_space_than_its_plane(tmp_path: pathlib.Path) -> None:
    found = expanded(PROFILE + RISING, tmp_path)
    assert isinstance(found.motions, UprightMotions)
    assert not found.scene.spatial
