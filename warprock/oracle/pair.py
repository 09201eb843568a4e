"""The independent reference for two stacked rigid blocks: DOP853, event by event.

The mechanics are those of `warprock.oracle.pair_mechanics`, which holds no closed formula
of the model; the integrator and the root finder are SciPy's.

- Integration: `scipy.integrate.DOP853`, restarted at every knot of the motion and at every event.
- Impact: a gap that closes is bracketed on a step's dense output, also one that closes and opens
  again inside a step; the step is repeated from its start to the root and the root corrected by
  Newton's method. The pattern after it is the admissible one (`after_impulse`).
- Smooth transition: a closed contact opens when the resultant of its reaction leaves its width
  (`after_force`). Looked at `LOOKS` times in a step, of at most `longest_step`, so that a violation
  that comes and goes within `longest_step / LOOKS` may go unseen. The root is overstepped by
  `SHORTEST_STEP`, so that the violation is clear.
- Velocity step of the base: an impulse at its knot. Contacts that are open keep their pivots.
- Peaks are turning points and impacts, never samples.
- Rest rule, for each contact: after an impact or a velocity step it closes, with the projection
  that closing asks for, if it would stay closed under the accelerations of that moment and the
  swing that it is about to make, were the accelerations to stay, remained below
  `REST_ROTATION_RATIO` of the block's slenderness angle. The infinitely many impacts left out are
  neither counted nor given their time, some 1e-4 s for blocks of a metre.
- A block has overturned once |rotation| = pi/2; the run ends there and its rotations stay.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.model.motion import Segment
from warprock.model.response import SampleTimes, Status
from warprock.oracle.pair_mechanics import REST, Pair, StackMechanics, TwoBlocks
from warprock.oracle.pair_swings import StackOutcome, StackRun

Array = npt.NDArray[np.float64]

RELATIVE_TOLERANCE = 1e-11
"""Relative tolerance of DOP853."""
LONGEST_STEP = 0.01
"""Longest step between looks at the contacts [s]."""


@dataclasses.dataclass(frozen=True)
class TwoBlockResponse:
    """The oracle's answer for one stack; index 0 is the lower block.

    Attributes:
        rotation: Rotations [rad], positive towards +x, shape [block, sample].
        times: Sample times [s], shape [sample].
        peak_rotation: Largest |rotation| [rad], shape [block].
        peak_time: Their times [s], shape [block].
        pattern_times: Times from which the patterns hold [s], shape [change].
        patterns: Patterns (ground, interface), shape [change, 2].
        impact_times: Times of the impacts [s], shape [impact].
        rest_time: Time from which both blocks stay at rest [s]; NaN if they do not.
        outcome: Where the blocks are at the end.
        status: Whether the numbers may be used.
        energy_lost: Energy lost in impacts [J], seen from the base.
        odd_choice_count: Impacts, velocity steps and transitions that did not have exactly one
            admissible outcome.
        pull_time: First time at which a contact would have to pull [s], so that in truth a block
            would leave its pivot; NaN if never. Looked at where steps and events end.
        evaluation_count: Evaluations of the equations of motion.
    """

    rotation: Array
    times: Array
    peak_rotation: Array
    peak_time: Array
    pattern_times: Array
    patterns: npt.NDArray[np.int64]
    impact_times: Array
    rest_time: float
    outcome: StackOutcome
    status: Status
    energy_lost: float
    odd_choice_count: int
    pull_time: float
    evaluation_count: int


def rock_two_blocks(
    blocks: TwoBlocks,
    segments: Sequence[Segment],
    times: SampleTimes,
    *,
    rotation_start: Pair = (0.0, 0.0),
    rtol: float = RELATIVE_TOLERANCE,
    longest_step: float = LONGEST_STEP,
) -> TwoBlockResponse:
    """Runs one stack.

    Args:
        blocks: The blocks, lower first.
        segments: Motion of the base, as `GroundMotions.segments` gives it.
        times: Duration and sampling.
        rotation_start: Rotations from which the blocks are released at rest [rad].
        rtol: Relative tolerance of the integrator.
        longest_step: Longest step [s].
    """
    run = StackRun(StackMechanics(blocks), times, rtol, longest_step)
    run.start(rotation_start)
    for segment in segments:
        if segment.start < times.duration and run.outcome is None:
            run.follow(segment)
    return _answer(run)


def _answer(run: StackRun) -> TwoBlockResponse:
    """What the finished run came to."""
    resting = run.pattern == REST
    standing = StackOutcome.AT_REST if resting else StackOutcome.ROCKING
    return TwoBlockResponse(
        rotation=run.rotation,
        times=run.times,
        peak_rotation=run.peak,
        peak_time=run.peak_time,
        pattern_times=np.array(run.pattern_times),
        patterns=np.array(run.patterns, dtype=np.int64),
        impact_times=np.array(run.impacts),
        rest_time=run.pattern_times[-1] if resting else math.nan,
        outcome=standing if run.outcome is None else run.outcome,
        status=run.status,
        energy_lost=run.energy_lost,
        odd_choice_count=run.odd_choices,
        pull_time=run.pull_time,
        evaluation_count=run.evaluations,
    )
