"""The independent reference: one rocking block integrated by SciPy's DOP853, event by event.

It shares no formula with the kernels or with `warprock.model.rocking`: the mechanics come from
vectors (`warprock.oracle.block_mechanics`), the integrator and the root finder from SciPy.

Physics (Housner 1963): the block never slides and never bounces; it pivots on a base corner
until the free corner meets the base, an impact without restitution normal to the base.

- Integration: `scipy.integrate.DOP853` (order 8, the stepper inside `solve_ivp`), restarted at
  every knot of the motion and at every event. Records are restarted at every sample, so that each
  interval between samples is as a rule one step over a smooth right-hand side.
- Impact, turning point and overturning are bracketed on a step's dense output; the step is then
  repeated from its start to the root and the root corrected by Newton's method. So an event's
  state has the accuracy of the integrator, not of the interpolation.
- Peaks are turning points, never samples.
- Rest rule: after an impact the block rests if the base acceleration would lift neither corner
  and the next swing, were the acceleration to stay, remained below `REST_ROTATION_RATIO` (in
  `swings`) of the slenderness angle on either side. The infinitely many impacts left out take a
  geometric series of times, which the rest time includes. The block lifts again at the root of
  the overturning moment, or at a velocity step whose swing counts by the same rule.
- A velocity step of the base is an impulse at its knot; the corner in contact is kept.
- A base that moves upwards, too, adds its acceleration to gravity, and its velocity steps to the
  impulses; one that falls faster than the block would have to pull it (infinite friction needed).
- Overturning is |rotation| = pi/2; the rotation stays there.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes
from warprock.model.motion import (
    GroundMotions,
    SpatialMotions,
    UprightMotions,
)
from warprock.model.response import (
    FIELDS,
    INTEGER_FIELDS,
    LANE_FIELDS,
    MODEL_FIELDS,
    TIE_FIELDS,
    Outcome,
    Response,
    SampleTimes,
    Status,
)
from warprock.oracle.bed import BedRun
from warprock.oracle.block_base import base_segments
from warprock.oracle.block_mechanics import PivotingBlock
from warprock.oracle.block_swings import BlockRun
from warprock.oracle.frame import RockingFrame
from warprock.oracle.held_swings import HeldRun
from warprock.oracle.strip import StripRun, StripWall
from warprock.processes import worker_processes

Array = npt.NDArray[np.float64]

RELATIVE_TOLERANCE = 1e-12
"""Relative tolerance of DOP853; SciPy raises anything below 100 x round-off = 2.2e-14."""
FRICTION_SLACK = 1e-6
"""Part by which friction may fall short before a block counts as one that slides: what the refined
looks at the contact force may miss."""
SCANS_PER_PERIOD = 64
"""Looks at the overturning moment in a period of the motion while the block rests."""


@dataclasses.dataclass(frozen=True)
class OracleResponse:
    """The oracle's answer for one lane.

    Attributes:
        rotation: Rotation [rad] at `times`, shape [sample].
        times: Sample times [s], shape [sample].
        peak_rotation: Largest |rotation| [rad].
        peak_time: Its time [s].
        impact_times: Times of the impacts [s], shape [impact].
        uplift_time: Time at which the block first leaves its flat state [s]; NaN if never, and
            the start of the run for a block that is released from a rotation.
        rest_time: Time from which the block stays at rest [s]; NaN if it does not.
        outcome: Where the block is at the end.
        status: Whether the numbers may be used.
        energy_lost: Energy lost in impacts and to ties [J].
        evaluation_count: Evaluations of the equation of motion.
        friction_needed: Largest |along| / upwards of the contact force and of the impulses at
            impacts and velocity steps; infinite where the base would have to pull.
        peak_tie_force: Largest force of a tie [N].
        peak_tie_elongation: Largest elongation of a tie [m].
        broken_ties: Ties that broke.
        tie_break_time: When the first of them did [s]; NaN if none.
        tie_energy_lost: Energy that ties took by yielding and breaking [J].
    """

    rotation: Array
    times: Array
    peak_rotation: float
    peak_time: float
    impact_times: Array
    uplift_time: float
    rest_time: float
    outcome: Outcome
    status: Status
    energy_lost: float
    evaluation_count: int
    friction_needed: float
    peak_tie_force: float = 0.0
    peak_tie_elongation: float = 0.0
    broken_ties: int = 0
    tie_break_time: float = math.nan
    tie_energy_lost: float = 0.0


def _answer(run: BlockRun | HeldRun | BedRun, friction: float) -> OracleResponse:
    """What a finished run came to, of a block with a friction."""
    status = run.status
    if status is Status.OK and run.friction_needed > (1.0 + FRICTION_SLACK) * friction:
        status = Status.OUTSIDE_MODEL
    standing = Outcome.AT_REST if run.flat else Outcome.ROCKING
    return OracleResponse(
        rotation=run.rotation,
        times=run.times,
        peak_rotation=run.peak,
        peak_time=run.peak_time,
        impact_times=np.array(run.impacts),
        uplift_time=run.uplift_time,
        rest_time=run.rest_time,
        outcome=Outcome.OVERTURNED if run.overturned else standing,
        status=status,
        energy_lost=run.energy_lost,
        evaluation_count=run.evaluations,
        friction_needed=run.friction_needed,
        **_of_ties(run),
    )


def _of_ties(run: BlockRun | HeldRun | BedRun) -> dict[str, Any]:
    """What became of the ties of a lane."""
    if not isinstance(run, HeldRun):
        return {}
    broken = [tie.broken for tie in run.ties if tie.broken < math.inf]
    return {
        "peak_tie_force": run.peak_tie_force,
        "peak_tie_elongation": run.peak_tie_elongation,
        "broken_ties": len(broken),
        "tie_break_time": min(broken, default=math.nan),
        "tie_energy_lost": run.tie_energy_lost,
    }


def _block(lanes: Lanes, lane: int) -> PivotingBlock:
    """The block of a lane; its angular restitution counts only if it is not the rigid one."""
    width, height = float(lanes.width[lane]), float(lanes.height[lane])
    depth, density = float(lanes.depth[lane]), float(lanes.density[lane])
    given = float(lanes.angular_restitution[lane])
    frame = None if lanes.hold is None else lanes.hold.frame
    if frame is not None:
        return RockingFrame(
            (width, height, depth),
            density,
            given if lanes.restitution_given else None,
            columns=int(frame.columns[lane]),
            mass_ratio=float(frame.mass_ratio[lane]),
        )
    strip = None if lanes.hold is None else lanes.hold.strip
    if strip is not None:
        given_restitution = given if lanes.restitution_given else None
        return StripWall((width, height, depth), density, given_restitution, strip, lane)
    rigid = PivotingBlock(width, height, depth, density, None)
    if abs(rigid.rate_after_impact(1, -1.0) - given) <= 1e-12:
        return rigid
    return PivotingBlock(width, height, depth, density, given)


def rock(
    lanes: Lanes,
    motions: GroundMotions,
    lane: int,
    times: SampleTimes,
    *,
    rtol: float = RELATIVE_TOLERANCE,
) -> OracleResponse:
    """Runs one lane.

    Args:
        lanes: Blocks and starts, shape [lane].
        motions: Ground motions of the same lanes.
        lane: Index of the lane.
        times: Duration and sampling.
        rtol: Relative tolerance of the integrator.
    """
    assert not isinstance(motions, SpatialMotions)
    parts = (motions.x, motions.z) if isinstance(motions, UprightMotions) else (motions,)
    friction = float(lanes.friction[lane])
    run: BlockRun | HeldRun | BedRun
    block = _block(lanes, lane)
    bed = None if lanes.hold is None else lanes.hold.bed
    if bed is not None:
        sizes = (float(lanes.width[lane]), float(lanes.height[lane]), float(lanes.depth[lane]))
        ground = (float(bed.stiffness[lane]), float(bed.damping[lane]))
        run = BedRun(sizes, float(lanes.density[lane]), ground, times, rtol, friction)
    elif isinstance(block, StripWall):
        run = StripRun(block, times, rtol, friction)
    elif lanes.hold is None or lanes.hold.frame is not None:
        run = BlockRun(block, times, rtol, friction)
    else:
        run = HeldRun(block, lanes.hold, lane, times, rtol, friction)
    run.start(float(lanes.rotation_start[lane]))
    # A resting block is looked at so often; in a segment of a record its ends are enough.
    scan = min(float(part.shortest_period[lane]) for part in parts) / SCANS_PER_PERIOD
    for segment in base_segments(motions, lane):
        if segment.start < times.duration and not run.overturned:
            run.follow(segment, scan)
    run.finish()
    return _answer(run, friction)


def _rock_all(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, rtol: float
) -> list[OracleResponse]:
    return [rock(lanes, motions, lane, times, rtol=rtol) for lane in range(lanes.lane_count)]


def oracle_response(
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    workers: int = 1,
    *,
    rtol: float = RELATIVE_TOLERANCE,
) -> Response:
    """Runs every lane, over worker processes if asked for.

    Args:
        lanes: Blocks and starts, shape [lane].
        motions: Ground motions of the same lanes.
        times: Duration and sampling.
        workers: Worker processes; 1 stays in this one.
        rtol: Relative tolerance of the integrator.

    Returns:
        Every lane field; `step_count` counts evaluations of the equation of motion, slides and
        penetrations are zero by the model.
    """
    if workers <= 1 or lanes.lane_count <= 1:
        answers = _rock_all(lanes, motions, times, rtol)
    else:
        size = max(1, lanes.lane_count // (4 * workers))
        parts = [slice(at, at + size) for at in range(0, lanes.lane_count, size)]
        with worker_processes(workers, "spawn") as pool:
            tasks = [
                pool.submit(_rock_all, lanes.take(part), motions.take(part), times, rtol)
                for part in parts
            ]
            answers = [answer for task in tasks for answer in task.result()]
    rows = {
        "impact_count": [len(a.impact_times) for a in answers],
        "step_count": [a.evaluation_count for a in answers],
        "residual_slide": [0.0] * len(answers),
        "peak_slide": [0.0] * len(answers),
        "peak_penetration": [0.0] * len(answers),
    }
    fields: dict[str, npt.NDArray[np.generic]] = {}
    tied = lanes.hold is not None and lanes.hold.ties is not None
    judged = lanes.hold is None or lanes.hold.frame is None
    besides = (*(MODEL_FIELDS if judged else ()), *(TIE_FIELDS if tied else ()))
    for name in (*LANE_FIELDS, *besides):
        values = rows[name] if name in rows else [getattr(a, name) for a in answers]
        fields[name] = np.array(values, np.int64 if name in INTEGER_FIELDS else np.float64)
    if times.interval is None:
        return Response("oracle", fields, np.empty(0))
    fields[FIELDS["rotation"].name] = np.array([a.rotation for a in answers])
    return Response("oracle", fields, times.times)
