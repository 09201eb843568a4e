"""Kernels on a GPU: that they can be built for one, without one, and what they answer on one."""

from __future__ import annotations

import dataclasses
import functools
import pathlib

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.device_scenes import Run, compiled, measured, runs
from warprock.engines.launching import Form
from warprock.model.lanes import Lanes
from warprock.model.motion import MotionKind
from warprock.model.response import Response, SampleTimes
from warprock.run.batch import run_batch
from warprock.run.devices import device_names

ORDINARY = ("impulse: block, record", "dem: block, record")
THOROUGH = ("event: stack, record", "event: block in space, record")
"""Kernels that the ordinary run builds, and long ones that `thorough` builds. All that there are on
a record, which take five minutes, are marked `gpu`; `python -m tests.shared.device_scenes` has
every other motion, too."""

COPIES = 50
"""Times that a GPU runs the same four lanes: warps whose lanes do unlike things."""

TIMES = SampleTimes(1.0, 0.1, places=True)


def mark_of(name: str) -> pytest.MarkDecorator | tuple[()]:
    if name in ORDINARY:
        return ()
    return pytest.mark.thorough if name in THOROUGH else pytest.mark.gpu


ON_RECORD = [
    pytest.param(run, id=run.name, marks=mark_of(run.name)) for run in runs((MotionKind.RECORD,))
]


@pytest.mark.parametrize("run", ON_RECORD)
def test_kernels_can_be_built_for_a_gpu(run: Run, tmp_path: pathlib.Path):
    code = compiled(run.module(), tmp_path).read_text(encoding="ascii")
    assert ".visible .entry run_lanes" in code
    assert ".target sm_80" in code


def test_what_a_kernel_takes_is_read_from_its_machine_code():
    _took, found = measured(Run("event", "block", MotionKind.RECORD).module())
    # A lane of a single block lives in registers: none of it in the device's memory.
    assert 32 < found.registers <= 255
    assert found.local_memory == 0


ROUND_OFF = 1e-7
"""Sines, roots and fused products round otherwise on a GPU; as a part of a number, or of 1 [rad,
m, s, J] where it is small."""
MAGNIFIED = 5.0
"""Times the spread that round-off makes on the CPU: the GPU draws once from much the same."""


def numbers(response: Response, name: str) -> npt.NDArray[np.float64]:
    """A field, with -1 for times that never came."""
    return np.nan_to_num(response[name].astype(np.float64), nan=-1.0)


def nudged(lanes: Lanes, many: npt.NDArray[np.intp]) -> Lanes:
    """Copies of lanes whose widths differ by some units in the last place."""
    found = lanes.take(many)
    units = np.random.default_rng(0).integers(-8, 9, size=found.width.shape)
    return dataclasses.replace(found, width=found.width * (1.0 + np.spacing(1.0) * units))


@pytest.mark.gpu
@pytest.mark.skipif("cuda:0" not in device_names(), reason="no CUDA device")
@pytest.mark.parametrize(
    "run",
    [
        pytest.param(run, id=run.name)
        for run in runs((MotionKind.STILL, MotionKind.HARMONIC, MotionKind.RECORD))
    ],
)
def test_lanes_are_those_of_the_cpu_within_round_off(run: Run):
    """As far as impacts magnify it, which lanes on the CPU tell whose widths it moves."""
    lanes, motions = run.batch()
    if run.kind is MotionKind.STILL:
        lanes = dataclasses.replace(lanes, rotation_start=lanes.rotation_start + 0.03)
    count = lanes.lane_count
    many = np.arange(COPIES * count) % count
    moved = motions.take(many)
    answer = functools.partial(run_batch, run.engine, times=TIMES, settings=run.settings)
    here = answer(lanes=lanes, motions=motions, form=Form.PLAIN)
    beside = answer(lanes=nudged(lanes, many), motions=moved, form=Form.PLAIN)
    there = answer(lanes=lanes.take(many), motions=moved, device="cuda:0")
    assert set(here.fields) == set(there.fields)
    for name in here.fields:
        own, found = numbers(here, name), numbers(there, name)
        np.testing.assert_array_equal(found, found[many], err_msg=f"{name}: copies of a lane")
        spread = np.abs(numbers(beside, name) - own[many]).max(axis=0, initial=0.0)
        bound = MAGNIFIED * spread + ROUND_OFF * np.maximum(np.abs(own), 1.0)
        assert np.all(np.abs(found[:count] - own) <= bound), name


@pytest.mark.gpu
@pytest.mark.skipif("cuda:0" not in device_names(), reason="no CUDA device")
def test_a_batch_does_not_depend_on_its_chunks_there():
    lanes, motions = Run("event", "block", MotionKind.HARMONIC).batch()
    many = np.arange(5000) % lanes.lane_count
    batch = lanes.take(many), motions.take(many)
    whole = run_batch("event", *batch, TIMES, device="cuda:0")
    parts = run_batch("event", *batch, TIMES, device="cuda:0", chunk_size=300, workers=6)
    for name in whole.fields:
        np.testing.assert_array_equal(parts[name], whole[name], err_msg=name)
