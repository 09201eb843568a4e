"""Sweeps of a case file: what is refused, what their keys mean, and how lanes are numbered."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.shared.case_texts import FREE, PULSE, refusal
from warprock.case.axes import lane_indices
from warprock.case.load import load_case

BAD_SWEEPS = [
    ("sweep = 3", "sweep", "must be [[sweep]] tables"),
    ("[[sweep]]", "sweep[0]", "must list at least one key"),
    ("[[sweep]]\nblock.height = []", "sweep[0].block.height", "at least one value"),
    ('[[sweep]]\nblock.height = "1 m"', "sweep[0].block.height", "must be a list or a grid"),
    ("[[sweep]]\nblock.height = [1.0]", "sweep[0].block.height[0]", "a length with a unit"),
    (
        '[[sweep]]\nblock.height = ["1 m", "-1 m"]',
        "sweep[0].block.height[1]",
        "got '-1 m', must be at least 1 mm and at most 1 km: the full height",
    ),
    ('[[sweep]]\nblock.hight = ["1 m"]', "sweep[0].block.hight", "did you mean block.height?"),
    ('[[sweep]]\nrun.sample_interval = ["1 s"]', "sweep[0].run.sample_interval", "must not be"),
    ('[[sweep]]\nlabel.Name = ["a"]', "sweep[0].label.Name", "lower case letters"),
    ("[[sweep]]\nlabel.name = [1]", "sweep[0].label.name[0]", "must be text that names lanes"),
    (
        '[[sweep]]\nblock.height = ["1 m", "2 m"]\nblock.width = ["1 m"]',
        "sweep[0].block.width",
        "got 1 value, must be as many as block.height beside it, 2",
    ),
    (
        '[[sweep]]\nblock.height = ["1 m"]\n[[sweep]]\nblock.height = ["1 m"]',
        "sweep[1].block.height",
        "must be in one axis only; sweep[0] has it too",
    ),
    (
        '[[sweep]]\nblock.height = { from = "1 m", to = "2 m", count = 0 }',
        "sweep[0].block.height.count",
        "got 0, must be a whole number from 1",
    ),
    (
        '[[sweep]]\nblock.height = { from = "1 m", to = "2 m" }',
        "sweep[0].block.height.count",
        "got nothing",
    ),
    (
        '[[sweep]]\nblock.height = { from = "1 m", to = 2, count = 3 }',
        "sweep[0].block.height.to",
        "got 2, must be a length with a unit",
    ),
    (
        '[[sweep]]\nblock.height = { from = "1 m", to = "2 m", count = 3, spacing = "cubic" }',
        "sweep[0].block.height.spacing",
        "must be linear or log",
    ),
    (
        '[[sweep]]\nblock.height = { form = "1 m", to = "2 m", count = 3 }',
        "sweep[0].block.height.form",
        "did you mean from?",
    ),
    (
        '[[sweep]]\ncontact.friction = { from = 0, to = 1, count = 3, spacing = "log" }',
        "sweep[0].contact.friction.from",
        "must be > 0, as to, for spacing log",
    ),
]


@pytest.mark.parametrize(("lines", "key", "words"), BAD_SWEEPS)
def test_bad_sweeps_are_named(lines, key, words, write):
    text = f"{lines}\n{FREE}" if lines.startswith("sweep") else f"{FREE}{lines}\n"
    file = write(text)
    error = refusal(file)
    assert str(error).startswith(f"{file}: {key}: got ")
    assert words in str(error)


def test_amplitudes_of_one_axis_are_of_one_kind(write):
    file = write(PULSE + '[[sweep]]\nmotion.amplitude = ["8 mm", "0.3 g"]\n')
    assert "amplitude[1]: got '0.3 g', must be of the kind of the first" in str(refusal(file))
    grid = 'motion.amplitude = { from = "8 mm", to = "0.3 g", count = 2 }'
    file = write(f"{PULSE}[[sweep]]\n{grid}\n")
    assert "motion.amplitude.to: got '0.3 g', must be of the kind of from" in str(refusal(file))


def test_a_swept_key_need_not_be_given_elsewhere(write):
    text = PULSE.replace('frequency = "3 Hz"', "")
    case = load_case(write(text + '[[sweep]]\nmotion.frequency = ["2 Hz", "4 Hz"]\n'))
    assert case.lane_count == 2


def test_quoted_and_plain_dotted_sweep_keys_are_the_same(write):
    plain = load_case(write(PULSE + '[[sweep]]\nmotion.frequency = ["2 Hz"]\n'))
    quoted = load_case(write(PULSE + '[[sweep]]\n"motion.frequency" = ["2 Hz"]\n'))
    assert plain.axes[0].columns.keys() == quoted.axes[0].columns.keys() == {"motion.frequency"}


SHAPES = st.lists(st.integers(1, 5), max_size=4).map(tuple)


@pytest.mark.thorough
@given(shape=SHAPES)
def test_lane_numbers_are_digits_in_mixed_radix(shape):
    total = math.prod(shape)
    digits = lane_indices(shape, range(total))
    assert [len(d) for d in digits] == [total] * len(shape)
    # Oracle: nested loops, the first axis outermost.
    looped = list(itertools.product(*map(range, shape)))
    assert list(zip(*digits, strict=True)) == (looped if shape else [])


@given(shape=SHAPES, cut=st.data())
def test_a_range_of_lanes_is_a_slice_of_all(shape, cut):
    total = math.prod(shape)
    start = cut.draw(st.integers(0, total))
    stop = cut.draw(st.integers(start, total))
    whole, part = lane_indices(shape, range(total)), lane_indices(shape, range(start, stop))
    for found, all_of_them in zip(part, whole, strict=True):
        np.testing.assert_array_equal(found, all_of_them[start:stop])


@pytest.mark.parametrize("lanes", [range(-1, 3), range(5, 7), range(10, 12)])
def test_a_lane_outside_the_grid_is_refused(lanes):
    with pytest.raises(ValueError, match="must lie in 0 to 5"):
        lane_indices((2, 3), lanes)
