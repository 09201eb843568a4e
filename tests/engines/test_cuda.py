"""Kernels on a GPU: that they can be built for one, without one, and what they answer on one."""

from __future__ import annotations

import dataclasses
import pathlib

import numpy as np
import pytest

from tests.shared.device_scenes import Run, compiled, measured, runs
from warprock.engines.launching import Form
from warprock.model.motion import MotionKind
from warprock.model.response import INTEGER_FIELDS, SampleTimes
from warprock.run.batch import run_batch
from warprock.run.devices import device_names

ORDINARY = ("event: block, record", "impulse: block, record", "dem: block, record")
"""Kernels that the ordinary run builds; `thorough` has all of them on a record, whose kernels are
the longest, and `python -m tests.shared.device_scenes` every other motion."""

COPIES = 50
"""Times that a GPU runs the same four lanes: warps whose lanes do unlike things."""

TIMES = SampleTimes(1.0, 0.1, places=True)

ON_RECORD = [
    pytest.param(run, id=run.name, marks=() if run.name in ORDINARY else pytest.mark.thorough)
    for run in runs((MotionKind.RECORD,))
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


@dataclasses.dataclass(frozen=True)
class Bounds:
    """How far a lane on a GPU may lie from the same lane on the CPU.

    Attributes:
        share: Of real numbers, as a part of them, or of 1 [rad, m, s, J] where they are small.
        counts: Of impacts and steps.
    """

    share: float
    counts: int


ROUND_OFF = Bounds(1e-6, 0)
"""Sines, roots and fused products round otherwise there; impacts magnify that."""
CHATTER = Bounds(1e-4, 6)
"""Where round-off decides whether a corner that hardly leaves what it stands on lands once more,
and so in which step the next thing happens."""

CHATTERS = {"impulse": "in space", "event": "in space", "xpbd": ""}
"""Engines, and in which scenes, whose corners part and land within round-off."""


def bounds_of(run: Run) -> Bounds:
    return CHATTER if CHATTERS.get(run.engine, "nowhere") in run.scene else ROUND_OFF


@pytest.mark.thorough
@pytest.mark.skipif("cuda:0" not in device_names(), reason="no CUDA device")
@pytest.mark.parametrize(
    "run",
    [
        pytest.param(run, id=run.name)
        for run in runs((MotionKind.STILL, MotionKind.HARMONIC, MotionKind.RECORD))
    ],
)
def test_lanes_are_those_of_the_cpu(run: Run):
    lanes, motions = run.batch()
    if run.kind is MotionKind.STILL:
        lanes = dataclasses.replace(lanes, rotation_start=lanes.rotation_start + 0.03)
    many, bounds = np.arange(COPIES * lanes.lane_count) % lanes.lane_count, bounds_of(run)
    copies = lanes.take(many), motions.take(many)
    here = run_batch(run.engine, lanes, motions, TIMES, settings=run.settings, form=Form.PLAIN)
    there = run_batch(run.engine, *copies, TIMES, settings=run.settings, device="cuda:0")
    assert set(here.fields) == set(there.fields)
    for name in here.fields:
        found = there[name]
        np.testing.assert_array_equal(found, found[many], err_msg=f"{name}: copies of a lane")
        found = found[: lanes.lane_count]
        if name in ("impact_count", "step_count"):
            assert np.max(np.abs(found - here[name])) <= bounds.counts, name
        elif name in INTEGER_FIELDS:
            np.testing.assert_array_equal(found, here[name], err_msg=name)
        else:
            np.testing.assert_allclose(found, here[name], bounds.share, bounds.share, err_msg=name)


@pytest.mark.thorough
@pytest.mark.skipif("cuda:0" not in device_names(), reason="no CUDA device")
def test_a_batch_does_not_depend_on_its_chunks_there():
    lanes, motions = Run("event", "block", MotionKind.HARMONIC).batch()
    many = np.arange(5000) % lanes.lane_count
    batch = lanes.take(many), motions.take(many)
    whole = run_batch("event", *batch, TIMES, device="cuda:0")
    parts = run_batch("event", *batch, TIMES, device="cuda:0", chunk_size=300, workers=6)
    for name in whole.fields:
        np.testing.assert_array_equal(parts[name], whole[name], err_msg=name)
