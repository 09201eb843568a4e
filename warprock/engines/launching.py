"""What the host side of every engine shares: filling lanes into Warp arrays and launching.

Both forms of a kernel take the same arrays. `packed` runs packs of `LANE_WIDTH` lanes on the
CPU, `plain` one lane a thread on any device.
"""

from __future__ import annotations

import dataclasses
import enum
from collections.abc import Mapping
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.kernels.instance import LANE_WIDTH, REALS
from warprock.model.lanes import Lanes
from warprock.model.motion import (
    GroundMotions,
)
from warprock.model.response import (
    INTEGER_FIELDS,
    LANE_FIELDS,
    MODEL_FIELDS,
    SPATIAL_FIELDS,
    USABLE,
    Response,
    SampleTimes,
    Status,
)

NEVER = 1.0e30
"""A time that has not come, in the kernels."""


STEPS_SPARE = 50
"""Steps of `event` allowed for every step that a run without events would take; an impact takes
some four, so this is far above any motion and ends only a lane that makes no headway."""


class Form(enum.StrEnum):
    """Form of the kernel."""

    PACKED = "packed"
    PLAIN = "plain"


@dataclasses.dataclass(frozen=True)
class Target:
    """Where and how a kernel runs.

    Attributes:
        precision: "float64" or "float32".
        device: Name of a Warp device, such as "cpu" or "cuda:0".
        form: Form of the kernel; packed needs the CPU.
    """

    precision: str = "float64"
    device: str = "cpu"
    form: Form | None = None

    def __post_init__(self) -> None:
        if self.precision not in REALS:
            raise ValueError(
                f"precision: got {self.precision!r}, must be one of {', '.join(REALS)}"
            )
        if self.form is not None:
            # Its value as a string would do in a comparison and not in the next.
            object.__setattr__(self, "form", Form(self.form))
        if self.form is Form.PACKED and not self.on_cpu:
            raise ValueError(f"device: got {self.device!r}, the packed form needs the CPU")

    @property
    def on_cpu(self) -> bool:
        """Whether the device is the CPU."""
        return self.device.startswith("cpu")

    @property
    def kernel_form(self) -> Form:
        """The form asked for, else the fast one for the device."""
        return self.form or (Form.PACKED if self.on_cpu else Form.PLAIN)


@dataclasses.dataclass(frozen=True)
class Kernel:
    """The kernel that an engine runs a scene with.

    Attributes:
        file: Stem of its file in the folder of kernels.
        form: Whether a thread runs a pack of lanes or one lane.
    """

    file: str
    form: Form

    @property
    def packed(self) -> bool:
        """Whether a thread runs a pack of lanes side by side."""
        return self.form is Form.PACKED


def padded_count(lane_count: int) -> int:
    """Lanes rounded up to whole packs."""
    width = int(LANE_WIDTH)
    return -(-lane_count // width) * width


def padded(values: npt.NDArray[Any], count: int) -> npt.NDArray[Any]:
    """Values of lanes, the last one repeated up to a count of lanes."""
    return np.concatenate([values, np.repeat(values[-1:], count - len(values))])


def struct_rows(struct: Any, columns: dict[str, npt.NDArray[Any]], count: int) -> npt.NDArray[Any]:
    """Rows of a Warp struct from its fields by name, padded to a count of lanes."""
    rows = np.zeros(count, dtype=struct.numpy_dtype())
    for name in rows.dtype.names or ():
        rows[name] = padded(np.asarray(columns[name]), count)
    return rows


def motion_columns(struct: Any, motions: GroundMotions) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Motion`: the attributes of the same name."""
    names = np.dtype(struct.numpy_dtype()).names or ()
    return {name: getattr(motions, name) for name in names}


def step_limit(
    motions: GroundMotions, times: SampleTimes, longest_step: npt.NDArray[np.float64]
) -> npt.NDArray[np.int64]:
    """Steps after which a lane of `event` counts as stalled, shape [lane]."""
    steps = times.duration / longest_step + motions.knot_count
    return np.where(np.isfinite(steps), STEPS_SPARE * (steps + 100.0), 0.0).astype(np.int64)


def launch(
    module: ModuleType,
    kernel: Kernel,
    target: Target,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    blocks: dict[str, npt.NDArray[Any]],
    *settings: Any,
) -> tuple[npt.NDArray[Any], npt.NDArray[np.float64] | None]:
    """Runs a kernel of a launch module over a batch of lanes.

    Args:
        module: Instance of a `*_launch` kernel file.
        kernel: Which of its kernels runs.
        target: Where it runs.
        lanes: The lanes.
        motions: Their ground motions.
        times: Duration and sampling.
        blocks: Fields of the struct `Block`, shape [lane] each.
        settings: What the kernel takes besides, after the sample times.

    Returns:
        The rows of `Result`, shape [lane], and the rotations [rad], shape [lane, sample], if
        asked for.
    """
    real = REALS[target.precision]
    packs = kernel.packed
    count = padded_count(lanes.lane_count) if packs else lanes.lane_count
    samples = times.times
    with wp.ScopedDevice(target.device):
        results = wp.empty(count, dtype=module.Result)
        shape = (len(samples), count) if times.interval is not None else (0, 0)
        rotations = wp.full(shape, value=np.inf, dtype=real)
        pool = wp.array(motions.components[0].pool, dtype=real)
        block_rows = struct_rows(module.Block, blocks, count)
        motion_rows = struct_rows(module.Motion, motion_columns(module.Motion, motions), count)
        wp.launch(
            getattr(module, kernel.form),
            dim=count // LANE_WIDTH if packs else count,
            inputs=[
                wp.array(block_rows, dtype=module.Block),
                wp.array(motion_rows, dtype=module.Motion),
                pool,
                wp.array(padded(lanes.rotation_start, count), dtype=real),
                wp.array(samples, dtype=real),
                *settings,
                results,
                rotations,
            ],
        )
        rows = results.numpy()[: lanes.lane_count]
        if times.interval is None:
            return rows, None
        return rows, rotations.numpy()[:, : lanes.lane_count].T.astype(np.float64)


def time_or_nan(times: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Times as float64, NaN where they have not come."""
    values = np.asarray(times, dtype=np.float64)
    return np.where(values >= NEVER, np.nan, values)


FINITE_FIELDS = (
    "peak_rotation",
    "residual_slide",
    "peak_slide",
    "peak_penetration",
    "energy_lost",
)
"""Numbers that no lane may lack, besides its rotations."""


def respond(
    engine: str,
    columns: dict[str, npt.NDArray[Any]],
    rotations: npt.NDArray[np.float64] | None,
    times: SampleTimes,
    others: Mapping[str, npt.NDArray[np.float64]] | None = None,
) -> Response:
    """A response from its lane fields; every one must be there, others that an engine has may be.

    `others` are their histories besides the rotations, by field.
    A lane of which a number is not finite gets the status NONFINITE if its status would let that
    pass, on any base. Rotations end at a right angle, as peaks do.
    """
    fields: dict[str, npt.NDArray[Any]] = {
        name: np.asarray(columns[name], np.int64 if name in INTEGER_FIELDS else np.float64)
        for name in (*LANE_FIELDS, *(n for n in (*SPATIAL_FIELDS, *MODEL_FIELDS) if n in columns))
    }
    status = fields["status"]
    numbers = [fields[name] for name in FINITE_FIELDS]
    numbers += [] if rotations is None else [rotations]
    # A sum is finite only if all of its parts are.
    total = sum(each.reshape(len(status), -1).sum(axis=1) for each in numbers)
    broken = ~np.isfinite(total) & np.isin(status, USABLE)
    fields["status"] = np.where(broken, np.int64(Status.NONFINITE), status)
    if rotations is None:
        return Response(engine=engine, fields=fields, times=np.empty(0))
    turned = np.clip(rotations, -0.5 * np.pi, 0.5 * np.pi)
    fields = {**fields, "rotation": turned, **(others or {})}
    return Response(engine=engine, fields=fields, times=times.times)
