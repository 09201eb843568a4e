"""Kernels on a GPU: that they can be built for one, without one, and what they answer on one."""

from __future__ import annotations

import contextlib
import dataclasses
import pathlib
import re
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import pytest
import warp as wp

from tests.shared.device_scenes import Run, compiled, measured, runs
from warprock.engines.launching import Form
from warprock.kernels.launch.instance import BYTES
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, MotionKind
from warprock.model.response import Response, SampleTimes, take_lanes
from warprock.running.batch import run_batch
from warprock.running.devices import device_names

THOROUGH = [
    ("impulse: block, record", "float64"),
    ("dem: block, record", "float32"),
    ("impulse: block in space, record", "float32"),
]
"""Kernels and precisions that `thorough` builds. All that there are on a record are marked `gpu`;
`python -m tests.shared.device_scenes` builds those of every other motion, too."""

IN_A_POWER = {"two-block": {"rcp.approx.ftz"}}
"""What else the code of an engine has that takes a power: `two-block`, for its step."""

COPIES = 50
"""Times that a GPU runs the same four lanes: warps whose lanes do unlike things."""

TIMES = SampleTimes(1.0, 0.1, places=True)


def mark_of(name: str, precision: str) -> pytest.MarkDecorator:
    return pytest.mark.thorough if (name, precision) in THOROUGH else pytest.mark.gpu


ON_RECORD = [
    pytest.param(run, precision, id=f"{run.name}-{precision}", marks=mark_of(run.name, precision))
    for run in runs((MotionKind.RECORD,))
    for precision in BYTES
]


@pytest.mark.parametrize(("run", "precision"), ON_RECORD)
def test_kernels_can_be_built_for_a_gpu(run: Run, precision: str, tmp_path: pathlib.Path):
    code = compiled(run.module(precision=precision), tmp_path).read_text(encoding="ascii")
    assert ".visible .entry run_lanes" in code
    assert ".target sm_80" in code
    # Every operation rounds to nearest, in the one way that IEEE 754 states: `mul.rn` is never
    # fused, as `mul` may be. None is in the other precision.
    names = "add|sub|mul|fma|mad|div|rcp|sqrt|rsqrt|ex2|lg2|sin|cos"
    arithmetic = re.findall(rf"\b((?:{names})\S*)\.f(32|64)\b", code)
    assert {f"float{bits}" for _operation, bits in arithmetic} == {precision}
    operations = {operation for operation, _bits in arithmetic}
    assert {"add.rn", "mul.rn", "fma.rn"} <= operations
    assert {each for each in operations if ".rn" not in each} == IN_A_POWER.get(run.engine, set())


@pytest.mark.thorough
def test_what_a_kernel_takes_is_read_from_its_machine_code():
    _took, found = measured(Run("event", "block", MotionKind.RECORD).module())
    # A lane of a single block lives in registers: none of it in the device's memory.
    assert 32 < found.registers <= 255
    assert found.local_memory == 0


ROUND_OFF = 1e-7
"""As a part of a number, or of 1 [rad, m, s, J] where it is small. By what the tests here show of
kernels nothing rounds otherwise on a GPU; no card was at hand since they are built so."""
MAGNIFIED = 5.0
"""Times the spread that round-off makes on the CPU: the GPU draws once from much the same."""


NUDGED = ("width", "height", "friction")
"""Arrays of lanes that `nudged` moves, besides starts, points of bodies, and the base."""

REBUILT = (
    "event: block, harmonic",
    "housner: block, harmonic",
    "dem: block, harmonic",
    "impulse: block, harmonic",
    "event: stack, harmonic",
    "event: block in space, harmonic",
)
"""Batches whose kernels `thorough` builds twice; the mark `gpu` does so for all."""


def rebuilt_in(run: Run) -> pytest.MarkDecorator:
    return pytest.mark.thorough if run.name in REBUILT else pytest.mark.gpu


DIFFERENT_KINDS = (MotionKind.STILL, MotionKind.HARMONIC, MotionKind.RECORD)
"""Kinds of motion with kernels of their own; the other analytic ones differ in `series` alone."""

NO_TIME = {"peak_time": "peak_rotation"}
"""Times that tell nothing where what they belong to is round-off."""

ON_ALL = [pytest.param(run, id=run.name) for run in runs(DIFFERENT_KINDS)]


def numbers(response: Response, name: str) -> npt.NDArray[np.float64]:
    """A field, with -1 for times that never came."""
    found = np.nan_to_num(response[name].astype(np.float64), nan=-1.0)
    if name in NO_TIME:
        found[response[NO_TIME[name]] < ROUND_OFF] = 0.0
    return found


def started(run: Run) -> tuple[Lanes, GroundMotions]:
    """The batch of a run, with starts that move on a still base."""
    lanes, motions = run.batch()
    if run.kind is MotionKind.STILL:
        lanes = dataclasses.replace(lanes, rotation_start=lanes.rotation_start + 0.03)
    return lanes, motions


def nudged(lanes: Lanes, motions: GroundMotions) -> tuple[Lanes, GroundMotions]:
    """Lanes and motions whose numbers differ by some units in the last place.

    Widths alone would not do: a body has none, and a height or a start is what other ties hang on.
    """
    random = np.random.default_rng(0)

    def moved(values: npt.NDArray[np.float64], axes: int = 4) -> npt.NDArray[np.float64]:
        """Values times factors near 1 that differ along so many of the first axes."""
        size = (*values.shape[:axes], *(1 for _axis in values.shape[axes:]))
        return values * (1.0 + np.spacing(1.0) * random.integers(-8, 9, size=size))

    # Blocks of a stack that start as one do so still, and what is level on a body with a flat face
    # for another stays so.
    found = dataclasses.replace(
        lanes, **{name: moved(getattr(lanes, name)) for name in NUDGED},
        rotation_start=moved(lanes.rotation_start, axes=1),
    )  # fmt: skip
    if lanes.body is not None:
        body = dataclasses.replace(lanes.body, points=moved(lanes.body.points))
        found = dataclasses.replace(found, body=body)
    if lanes.profiles is not None:
        profiles = dataclasses.replace(lanes.profiles, points=moved(lanes.profiles.points, axes=2))
        found = dataclasses.replace(found, profiles=profiles)
    return found, motions.scaled(moved(np.ones(lanes.lane_count)))


def answer(run: Run, lanes: Lanes, motions: GroundMotions, device: str = "cpu") -> Response:
    """What lanes of a run answer, in the plain form."""
    return run_batch(
        run.engine, lanes, motions, TIMES, settings=run.settings, device=device, form=Form.PLAIN
    )


def assert_like(here: Response, there: Response, beside: Response) -> None:
    """Within round-off, as far as impacts magnify it.

    Args:
        here: Lanes on the CPU.
        there: The same where numbers are rounded otherwise.
        beside: Copies of `here` on the CPU, nudged.
    """
    assert set(here.fields) == set(there.fields)
    for name in here.fields:
        own, found, moved = numbers(here, name), numbers(there, name), numbers(beside, name)
        spread = np.abs(moved - own[np.arange(len(moved)) % len(own)]).max(axis=0, initial=0.0)
        bound = MAGNIFIED * spread + ROUND_OFF * np.maximum(np.abs(own), 1.0)
        assert np.all(np.abs(found - own) <= bound), name


@contextlib.contextmanager
def built_otherwise(module: str) -> Iterator[None]:
    """Lets the kernel of a module be built for a while as for a processor of another make.

    It has no vectors but SSE2, no instruction that fuses, and the compiler hardly moves anything.
    """
    options = {
        "cpu_compiler_flags": "-ffp-contract=off", "max_unroll": 0, "optimization_level": 1,
    }  # fmt: skip
    before = {key: wp.get_module_options(module)[key] for key in options}
    wp.set_module_options(options, module=module)
    try:
        yield
    finally:
        wp.set_module_options(before, module=module)


@pytest.mark.parametrize(
    "run",
    [pytest.param(run, id=run.name, marks=rebuilt_in(run)) for run in runs(DIFFERENT_KINDS)],
)
def test_lanes_have_the_same_bits_however_a_kernel_is_built(run: Run):
    """What of another machine this one can show, a GPU's included: the order of operations."""
    lanes, motions = started(run)
    here = answer(run, lanes, motions)
    with built_otherwise(run.module()):
        there = answer(run, lanes, motions)
    for name in here.fields:
        np.testing.assert_array_equal(there[name], here[name], err_msg=name)


@pytest.mark.gpu
@pytest.mark.skipif("cuda:0" not in device_names(), reason="no CUDA device")
@pytest.mark.parametrize("run", ON_ALL)
def test_lanes_are_those_of_the_cpu_within_round_off(run: Run):
    """As far as impacts magnify it, which lanes on the CPU tell whose numbers it moves."""
    lanes, motions = started(run)
    count = lanes.lane_count
    many = np.arange(COPIES * count) % count
    copies = lanes.take(many), motions.take(many)
    there = answer(run, *copies, device="cuda:0")
    for name in there.fields:
        found = numbers(there, name)
        np.testing.assert_array_equal(found, found[many], err_msg=f"{name}: copies of a lane")
    here, beside = answer(run, lanes, motions), answer(run, *nudged(*copies))
    assert_like(here, take_lanes(there, np.arange(count)), beside)


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
