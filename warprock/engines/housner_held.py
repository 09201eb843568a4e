"""Blocks that walls and ties hold, as kernels/housner/held_run.py takes them and answers."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines.decoding import time_or_nan
from warprock.engines.launching import NEVER
from warprock.model import rocking
from warprock.model.hold import Ties, TopLoad
from warprock.model.lanes import Lanes

Array = npt.NDArray[np.float64]


def no_ties(lane_count: int) -> Ties:
    """The ties of blocks that have none."""
    nothing = np.empty((lane_count, 0))
    return Ties(
        side=nothing,
        height=nothing,
        stiffness=nothing,
        slack=nothing,
        prestress=nothing,
        yield_force=nothing,
        ultimate_elongation=nothing,
        pushes=nothing.astype(np.bool_),
    )


def no_load(lane_count: int) -> TopLoad:
    """The load of blocks that have none."""
    nothing = np.zeros(lane_count)
    return TopLoad(nothing, nothing, nothing, nothing.astype(np.bool_))


def inertia_of(lanes: Lanes) -> Array:
    """Moments of inertia of boxes about a corner of their base [kg m^2], shape [lane].

    Of a frame twice its kinetic energy over the square of its angular velocity.
    """
    radius = rocking.half_diagonal(lanes.width, lanes.height)
    inertia = np.asarray(4.0 / 3.0 * lanes.mass * radius**2)
    if lanes.hold is not None and lanes.hold.frame is not None:
        return np.asarray(inertia * lanes.hold.frame.inertia_factor)
    return inertia


def tie_rate(lanes: Lanes) -> Array:
    """Angular frequency of the blocks on their ties alone [rad/s], shape [lane]."""
    ties = _ties(lanes)
    squares = ties.stiffness * (ties.height**2 + lanes.width[:, None] ** 2)
    return np.asarray(np.sqrt(squares.sum(axis=1) / inertia_of(lanes)))


def held_inputs(lanes: Lanes) -> dict[str, dict[str, npt.NDArray[Any]]]:
    """What the kernel takes besides what it takes of free-standing blocks.

    Returns:
        Fields of the struct of each argument: of `blocks`, shape [lane]; of `ties`, [lane, tie].
    """
    hold, ties = lanes.hold, _ties(lanes)
    assert hold is not None
    nothing = np.zeros(lanes.lane_count)
    load = hold.load or no_load(lanes.lane_count)
    return {
        "blocks": {
            "wall": nothing if hold.wall is None else hold.wall,
            "rebound": nothing if hold.rebound is None else hold.rebound,
            "half_width": 0.5 * lanes.width,
            "inertia": inertia_of(lanes),
            "mass": lanes.mass,
            "load_weight": load.weight,
            "load_thrust": load.thrust,
            "load_place": load.eccentricity,
            "load_height": lanes.height,
            "load_stays": load.stays.astype(np.int32),
        },
        "ties": {
            "side": ties.side,
            "height": ties.height,
            "stiffness": ties.stiffness,
            "yield_force": np.minimum(ties.yield_force, NEVER),
            "longest": np.minimum(ties.slack + ties.ultimate_elongation, NEVER),
            "free_length": ties.free_length,
            "pushes": ties.pushes.astype(np.int32),
        },
    }


def _ties(lanes: Lanes) -> Ties:
    assert lanes.hold is not None
    return lanes.hold.ties or no_ties(lanes.lane_count)


def held_fields(lanes: Lanes, rows: npt.NDArray[Any]) -> dict[str, npt.NDArray[Any]]:
    """Fields of a response that lanes with ties have, from rows of its `Result`, shape [lane]."""
    if _ties(lanes).count == 0:
        return {}
    return {
        "peak_tie_force": rows["force"],
        "peak_tie_elongation": rows["stretch"],
        "broken_ties": rows["broken"],
        "tie_break_time": time_or_nan(rows["break_time"]),
        "tie_energy_lost": rows["tie_loss"],
    }
