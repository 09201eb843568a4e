"""What the ties of a block do over time, from where the block is."""

from __future__ import annotations

import dataclasses
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


@dataclasses.dataclass(frozen=True)
class TieHistory:
    """What the ties of one lane do over time.

    Attributes:
        states: What they do at every sample, shape [tie, sample].
        force: Tension [N], shape [tie, sample].
        free: Elongation at which each has no force after the last sample [m], shape [tie].
    """

    states: Codes
    force: Array
    free: Array

    def worn(self, ties: Ties) -> Ties | None:
        """The ties as the run leaves them; None where all broke.

        Args:
            ties: Ties of this one lane as it began, shape [1, tie].
        """
        whole = np.flatnonzero(self.states[:, -1] != TieState.BROKEN)
        if not len(whole):
            return None
        kept = {each.name: getattr(ties, each.name)[:, whole] for each in dataclasses.fields(ties)}
        free, longest = self.free[None, whole], kept["slack"] + kept["ultimate_elongation"]
        slack = np.maximum(free, 0.0)
        kept |= {"slack": slack, "ultimate_elongation": longest - slack}
        return Ties(**kept | {"prestress": kept["stiffness"] * np.maximum(-free, 0.0)})


def tie_history(ties: Ties, elongation: Array, times: Array, first_break: float) -> TieHistory:
    """What the ties of one lane do at every sample.

    A tie is elastic and perfectly plastic; one that gives tension alone is slack below the
    elongation at which it has no force, which grows by what it yields. What it yields between
    samples is not seen.

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
    free_at = np.empty(elongation.shape)
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
            free_at[tie, sample] = free
    states[broken] = TieState.BROKEN
    force = ties.stiffness[0][:, None] * (elongation - free_at)
    force = np.where(ties.pushes[0][:, None], force, np.maximum(force, 0.0))
    return TieHistory(states, np.where(broken, 0.0, force), free_at[:, -1])
