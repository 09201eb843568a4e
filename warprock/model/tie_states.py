"""What the ties of a block do over time, from where the block is."""

from __future__ import annotations

import enum

import numpy as np
import numpy.typing as npt

from warprock.model.hold import Ties

Array = npt.NDArray[np.float64]
Codes = npt.NDArray[np.int8]

TAKEN_UP = 1e-6
"""Part of its height below which the slack of a tie counts as taken up."""


class TieState(enum.IntEnum):
    """What a tie does."""

    SLACK = 0
    TAUT = 1
    YIELDING = 2
    BROKEN = 3


def tie_elongations(ties: Ties, width: float, height: float, pose: Array) -> Array:
    """Elongations of the ties of one lane from the state at rest [m], shape [tie, sample].

    Args:
        ties: Ties of this one lane, shape [1, tie].
        width: Of its block [m].
        height: Of its block [m].
        pose: Place of the middle of the block along x and z beside its base [m], and its rotation
            towards +x [rad], shape [3, sample].
    """
    x, _, rotation = pose
    across = 0.5 * width * ties.side[0][:, None]
    above = ties.height[0][:, None] - 0.5 * height
    moved = x + across * (np.cos(rotation) - 1.0) + above * np.sin(rotation)
    return np.asarray(-ties.side[0][:, None] * moved)


def tie_states(ties: Ties, elongation: Array, times: Array, first_break: float) -> Codes:
    """What the ties of one lane do at every sample, shape [tie, sample].

    A tie is elastic and perfectly plastic; one that gives tension alone is slack below the
    elongation at which it has no force, which grows by what it yields.

    Args:
        ties: Ties of this one lane, shape [1, tie].
        elongation: From the state at rest [m], shape [tie, sample].
        times: Of the samples [s].
        first_break: When the first of them broke [s], NaN if none did: a break between samples is
            one of the tie that came nearest to its ultimate elongation.
    """
    longest = ties.slack[0] + ties.ultimate_elongation[0]
    broken = np.maximum.accumulate(elongation, axis=1) >= longest[:, None]
    if not np.isnan(first_break):
        nearest = int(np.argmax(elongation.max(axis=1) / longest))
        broken[nearest] |= times >= first_break
    states = np.full(elongation.shape, TieState.TAUT, np.int8)
    for tie, stretches in enumerate(elongation):
        reach = ties.yield_force[0, tie] / ties.stiffness[0, tie]
        free, pushes = ties.free_length[0, tie], bool(ties.pushes[0, tie])
        near = TAKEN_UP * ties.height[0, tie]
        for sample, stretch in enumerate(stretches):
            if stretch > free + reach:
                free, states[tie, sample] = stretch - reach, TieState.YIELDING
            elif pushes and stretch < free - reach:
                free, states[tie, sample] = stretch + reach, TieState.YIELDING
            elif not pushes and stretch < free - near:
                states[tie, sample] = TieState.SLACK
    states[broken] = TieState.BROKEN
    return states
