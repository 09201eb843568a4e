"""Blocks that walls and ties hold, as the kernels `held_run` take them and answer."""

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
    return {
        "blocks": {
            **wall_columns(lanes),
            **load_columns(lanes),
            "half_width": 0.5 * lanes.width,
            "inertia": inertia_of(lanes),
            "mass": lanes.mass,
            "load_height": lanes.height,
        },
        "ties": tie_columns(lanes),
    }


def tie_columns(lanes: Lanes) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Tie` of kernels/contact/ties.py, shape [lane, tie] each."""
    ties = _ties(lanes)
    return {
        "side": ties.side,
        "height": ties.height,
        "stiffness": ties.stiffness,
        "yield_force": np.minimum(ties.yield_force, NEVER),
        "longest": np.minimum(ties.slack + ties.ultimate_elongation, NEVER),
        "free_length": ties.free_length,
        "pushes": ties.pushes.astype(np.int32),
    }


def wall_columns(lanes: Lanes) -> dict[str, Array]:
    """Side of the wall and rebound from it, as both schemes call them, shape [lane] each."""
    hold, nothing = lanes.hold, np.zeros(lanes.lane_count)
    assert hold is not None
    return {
        "wall": nothing if hold.wall is None else hold.wall,
        "rebound": nothing if hold.rebound is None else hold.rebound,
    }


def load_columns(lanes: Lanes) -> dict[str, npt.NDArray[Any]]:
    """What lies on the tops of blocks, as both schemes call it, shape [lane] each."""
    assert lanes.hold is not None
    load = lanes.hold.load or no_load(lanes.lane_count)
    return {
        "load_weight": load.weight,
        "load_thrust": load.thrust,
        "load_place": load.eccentricity,
        "load_stays": load.stays.astype(np.int32),
    }


def free_tie_rate(lanes: Lanes) -> Array:
    """Angular frequency of blocks on their ties alone, free of their base [rad/s], shape [lane].

    At most: every tie as far from the centre of mass as a corner is.
    """
    # Of 1 / m + r^2 / I at r = R, with I = m R^2 / 3.
    return np.asarray(np.sqrt(4.0 * _ties(lanes).stiffness.sum(axis=1) / lanes.mass))


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
