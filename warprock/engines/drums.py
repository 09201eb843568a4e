"""Answers of stacks as those of the columns of an assembly that they are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines.assembly_packs import NOTABLE, falls_by
from warprock.engines.decoding import collapse_loads
from warprock.engines.launching import Found
from warprock.model.drums import drums_of, joints_below
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import FALLEN, JointState

Fields = dict[str, npt.NDArray[Any]]


def end_at_collapse(lanes: Lanes, of_lanes: Fields) -> None:
    """Lets the lanes of columns end where they have collapsed: a drum has sunk by half its width.

    Args:
        lanes: The columns.
        of_lanes: Fields of the kernel's struct of stacks, shape [lane] each, to which it is added.
    """
    own = lanes.assembly
    assert own is not None
    least = np.array([falls_by(kind)[~kind.fixed].min() for kind in own.kinds])
    of_lanes["fall"] = least[own.lane]


def column_fields(
    lanes: Lanes, motions: GroundMotions, found: Found, of_stacks: Mapping[str, npt.NDArray[Any]]
) -> Fields:
    """Fields of columns from those of stacks, histories among them.

    Args:
        lanes: The columns.
        motions: Their ground motions.
        found: What the kernel has left of the stacks.
        of_stacks: Fields of the stacks, the lowest block first.
    """
    own, drums, rows = lanes.assembly, found.drums, found.lanes
    assert own is not None
    assert drums is not None
    fields = dict(of_stacks)
    peak = of_stacks["peak_rotation"]
    top = peak.argmax(axis=1)[:, None]
    for name in ("peak_rotation", "peak_time"):
        fields[name] = np.take_along_axis(of_stacks[name], top, axis=1)
    for name in ("residual_slide", "peak_slide"):
        fields[name] = np.abs(of_stacks[name]).max(axis=1, keepdims=True)
    width = np.stack([kind.joints.lengths[joints_below(kind)] for kind in own.kinds])[own.lane]
    opened = drums["opening"] > NOTABLE * width
    slid = of_stacks["peak_slide"] > NOTABLE * width
    fell = np.isin(of_stacks["outcome"], FALLEN)
    state = np.zeros_like(opened, dtype=np.int64)
    places = np.stack([joints_below(kind) for kind in own.kinds])[own.lane]
    flags = JointState.OPENED * opened + JointState.SLID * slid
    np.put_along_axis(state, places, flags.astype(np.int64), axis=1)
    fields |= {
        "peak_displacement": drums["moved"].max(axis=1),
        "residual_displacement": drums["last"].max(axis=1),
        "peak_opening": drums["opening"].max(axis=1),
        "opened_joints": opened.sum(axis=1),
        "slid_joints": slid.sum(axis=1),
        "collapse_time": np.where(fell, rows["ended"], np.nan),
        "collapse_load": collapse_loads(motions, rows["still"], fell),
        "joint_state": state,
    }
    return fields | _histories(lanes, of_stacks)


def _histories(lanes: Lanes, of_stacks: Mapping[str, npt.NDArray[Any]]) -> Fields:
    """Histories as `assembly` has them: the largest rotation, and the places of all drums."""
    if "rotation" not in of_stacks:
        return {}
    own = lanes.assembly
    assert own is not None
    turn = of_stacks["rotation"]
    fields = {"rotation": np.abs(turn).max(axis=1, keepdims=True)}
    if "x" not in of_stacks:
        return fields
    # From the lowest drum upwards to the order of the blocks that can move.
    order = np.stack([np.argsort(drums_of(kind)) for kind in own.kinds])[own.lane][..., None]
    lowest = [drums_of(kind)[0] for kind in own.kinds]
    middle = np.array([k.centre[b, 0] for k, b in zip(own.kinds, lowest, strict=True)])
    foot = np.array([k.corners[b, :, 1].min() for k, b in zip(own.kinds, lowest, strict=True)])
    places = {
        "x": of_stacks["x"] + middle[own.lane][:, None, None],
        "z": of_stacks["z"] + foot[own.lane][:, None, None],
        "turn": turn,
    }
    return fields | {
        name: np.take_along_axis(values, order, axis=1) for name, values in places.items()
    }
