"""Stacks in case files: what is read, what is refused, what the lanes of a stack are."""

import json

import numpy as np
import pytest

from tests.shared.commands import succeed
from warprock.case.input_columns import input_meaning
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.model.motion import StillBase
from warprock.model.response import SampleTimes
from warprock.model.stacking import contact_ends, uplift_ratio
from warprock.oracle.pair import rock_two_blocks
from warprock.oracle.pair_mechanics import TwoBlocks
from warprock.running.batch import run_batch
from warprock.running.case_run import run_case
from warprock.units import GRAVITY
from warprock.verification.checks import compare

STACK = """
title = "t"
source = "s"
[block.1]
width = "0.4 m"
height = "0.6 m"
depth = "20 cm"
density = "2000 kg/m^3"
[block.2]
width = "0.2 m"
height = "0.5 m"
depth = "30 cm"
density = "1000 kg/m^3"
chamfer = "5 mm"
friction = 0.3
[contact]
friction = "45 deg"
[motion]
waveform = "sine"
control = "acceleration"
frequency = "4 Hz"
amplitude = "2 m/s^2"
cycles = 1
[run]
duration = "5 s"
"""


def test_a_stack_becomes_lanes_with_a_block_axis(write):
    sweep = '[[sweep]]\nblock.2.height = ["0.5 m", "0.6 m"]\n"block.1.offset" = ["0 m", "0 m"]\n'
    lane_set = expand_lanes(load_case(write(STACK + sweep)))
    lanes = lane_set.lanes
    assert lanes.stacked
    assert (lanes.lane_count, lanes.block_count) == (2, 2)
    assert lanes.height.tolist() == [[0.6, 0.5], [0.6, 0.6]]
    assert np.allclose(lanes.friction, [[1.0, 0.3]] * 2, rtol=1e-15)
    assert np.allclose(lanes.face_width, [[0.4, 0.19]] * 2, rtol=1e-15)
    assert np.allclose(lanes.mass[0], [96.0, 30.0], rtol=1e-15)
    scene = lane_set.scene
    assert (scene.stacked, scene.block_count, scene.contact_point_count) == (True, 2, 4)
    assert scene.centred
    assert lane_set.inputs["height_2_m"].tolist() == [0.5, 0.6]
    assert lane_set.inputs["chamfer_2_mm"].tolist() == [5.0, 5.0]
    assert input_meaning("chamfer_2_mm") == ("mm", "Width cut off each edge, block 2")


def test_a_stack_of_one_is_a_stack(write):
    text = STACK[: STACK.index("[block.2]")] + STACK[STACK.index("[contact]") :]
    lanes = expand_lanes(load_case(write(text))).lanes
    assert lanes.stacked
    assert lanes.width.shape == (1, 1)


def test_an_override_reaches_a_block(write):
    case = load_case(write(STACK), ["block.2.height=0.7 m", "contact.friction=0.5"])
    lanes = expand_lanes(case).lanes
    assert lanes.height.tolist() == [[0.6, 0.7]]
    assert lanes.friction.tolist() == [[0.5, 0.3]]


def test_some_lanes_are_those_of_all_lanes(write):
    grid = '[[sweep]]\nblock.2.chamfer = { from = "1 mm", to = "9 mm", count = 5 }\n'
    case = load_case(write(STACK + grid))
    whole, part = expand_lanes(case).lanes, expand_lanes(case, range(2, 4)).lanes
    for name, each in whole.arrays.items():
        assert np.array_equal(each[2:4], getattr(part, name))


BAD = [
    ('chamfer = "5 mm"', 'chamfer = "5"', "block.2.chamfer", "5"),
    ('chamfer = "5 mm"', 'chamfer = "-1 mm"', "block.2.chamfer", "at least 0 m"),
    ('chamfer = "5 mm"', 'chamfor = "5 mm"', "block.2.chamfor", "chamfer"),
    ("friction = 0.3", "friction = -0.3", "block.2.friction", "at least 0"),
    ("[block.2]", "[block.3]", "block.3", "must have block.2 below it"),
    ('width = "0.2 m"\n', "", "block.2.width", "must be the full width"),
    ("[contact]", '[start]\nrotation = "1 deg"\n[contact]', "start.rotation", "for a stack"),
    (
        '"45 deg"',
        '"45 deg"\nangular_restitution = 0.9',
        "contact.angular_restitution",
        "for a stack",
    ),
]


@pytest.mark.parametrize(("old", "new", "key", "said"), BAD)
def test_bad_stacks_are_refused_by_name(write, old, new, key, said):
    file = write(STACK.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_case(file)
    message = str(caught.value)
    assert caught.value.key == key, message
    assert said in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("override", "key", "said"),
    [
        ("block.2.chamfer=0.1 m", "block.2.chamfer", "so that a face is left"),
        ("block.2.offset=0.31 m", "block.2.offset", "on the face of the block below"),
        ("block.1.offset=1 mm", "block.1.offset", "must be 0"),
    ],
)
def test_blocks_that_cannot_stand_are_refused(write, override, key, said):
    case = load_case(write(STACK), [override])
    with pytest.raises(InputError) as caught:
        expand_lanes(case)
    assert (caught.value.source, caught.value.key) == ("-s", key)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("block.7.height=1 m", "-s: block.7: got a block of that number, must have block.3 below"),
        ("block.3.height=1 m", "-s: block.3.density: got nothing, must be the density"),
    ],
)
def test_a_block_that_an_override_alone_begins_is_named_by_it(write, override, said):
    with pytest.raises(InputError, match=said):
        load_case(write(STACK), [override])


def test_too_many_blocks_are_refused(write):
    block = STACK[STACK.index("[block.2]") : STACK.index("[contact]")]
    more = "".join(block.replace("block.2", f"block.{number}") for number in range(3, 22))
    with pytest.raises(InputError, match="at most 20 blocks"):
        load_case(write(STACK + more))


def test_a_stack_that_is_too_high_for_an_engine_names_those_that_run_it(write):
    block = STACK[STACK.index("[block.2]") : STACK.index("[contact]")]
    more = "".join(block.replace("block.2", f"block.{number}") for number in range(3, 8))
    case = load_case(write(STACK + more))
    with pytest.raises(InputError, match=r"up to 6 blocks in the plane.* one of 7.*event runs up"):
        run_case(case, "impulse")
    lanes = expand_lanes(case).lanes
    with pytest.raises(InputError, match="at most 6 blocks a lane in dem"):
        run_batch("dem", lanes, StillBase(lanes.lane_count), SampleTimes(0.1))


PEAKS = (
    '[[check]]\nkind = "peaks"\nengine = "event"\nvalues = [0.1]\ntolerance = 1\nbecause = "b"\n'
)


def test_a_check_of_a_stack_names_its_block(write):
    assert load_case(write(STACK + PEAKS + "block = 2\n")).checks[0].block == 2
    for block, said in (("", "got nothing"), ("block = 3\n", "a block from 1 to 2")):
        with pytest.raises(InputError, match=said):
            load_case(write(STACK + PEAKS + block))
    housner = '[[check]]\nkind = "housner"\nengine = "event"\nlimit_5s = 1\nbecause = "b"\n'
    with pytest.raises(InputError, match="must not be on a stack"):
        load_case(write(STACK + housner))


def test_uplift_follows_from_statics(write):
    """Moments by hand: weights 96 g and 30 g, centres 0.3 m and 0.85 m above the base."""
    lanes = expand_lanes(load_case(write(STACK))).lanes
    whole = 0.2 * 126.0 / (96.0 * 0.3 + 30.0 * 0.85)
    top = 0.095 / 0.25
    assert np.allclose(uplift_ratio(lanes), [[whole, top]], rtol=1e-14)
    table = expand_lanes(load_case(write(STACK))).inputs
    smallest = min(whole, top)
    assert table["uplift_ratio"].item() == pytest.approx(smallest, rel=1e-14)
    expected = 2.0 / (GRAVITY * smallest)
    assert table["normalised_acceleration"].item() == pytest.approx(expected, rel=1e-12)


def test_an_offset_moves_the_centre_of_mass_and_the_contact(write):
    """The upper block 0.15 m aside overhangs by 0.045 m: its face ends at the lower's edge."""
    lanes = expand_lanes(load_case(write(STACK), ["block.2.offset=0.15 m"])).lanes
    low, high = contact_ends(lanes)
    assert low[0].tolist() == pytest.approx([-0.2, -0.095], rel=1e-14)
    assert high[0].tolist() == pytest.approx([0.2, 0.05], rel=1e-14)
    aside = 30.0 * 0.15 / 126.0
    height = (96.0 * 0.3 + 30.0 * 0.85) / 126.0
    expected = [[(0.2 - aside) / height, 0.05 / 0.25]]
    assert np.allclose(uplift_ratio(lanes), expected, rtol=1e-14)


def test_the_oracle_answers_for_a_stack(write):
    """As `rock_two_blocks` does for one lane; -e oracle of `compare` runs it."""
    case = load_case(write(STACK), ["run.duration=1 s", "run.sample_interval=0.1 s"])
    lane_set = expand_lanes(case)
    blocks = TwoBlocks(
        width=(0.4, 0.2), height=(0.6, 0.5), depth=(0.2, 0.3), density=(2e3, 1e3), chamfer=(0, 5e-3)
    )
    alone = rock_two_blocks(blocks, lane_set.motions.segments(0), lane_set.times)
    rows = compare(case, ["oracle"])["rows"]
    slenderness = lane_set.lanes.slenderness_angle[0]
    for row, peak, angle in zip(rows, alone.peak_rotation, slenderness, strict=True):
        assert row["peak_rotation_ratio"] == peak / angle
        assert row["difference_run_ratio"] == 0.0
    three = STACK[STACK.index("[block.2]") : STACK.index("[contact]")].replace("block.2", "block.3")
    with pytest.raises(InputError, match="has two blocks, the case has 3"):
        compare(load_case(write(STACK + three)), ["oracle"])


def test_a_stack_runs_without_naming_an_engine(write):
    file = write(STACK + PEAKS.replace("values = [0.1]", "values = [0.1]\nblock = 1"))
    done = succeed("run", file, "--no-estimate", "--json")
    found = json.loads(done.stdout)
    assert found["engine"]["name"] == "event"
    assert {"peak_rotation_1_rad", "peak_rotation_2_rad", "peak_rotation_ratio_2"} <= set(
        found["rows"][0]
    )
