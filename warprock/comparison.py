"""An engine's response held against Housner's, lane by lane, and where Housner holds at all.

Housner's block (Housner 1963) is planar, does not slide and loses energy in impacts alone. Where
an engine's block slides, or is asked for more friction than it has, a difference from Housner is
no error of the engine; such a lane is compared all the same, with the reason beside it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.expansion import LaneSet
from warprock.lanes import Lanes
from warprock.motion import (
    GroundMotions,
    HarmonicMotions,
    ModulatedMotions,
    RecordMotions,
    RickerMotions,
)
from warprock.response import Outcome, Response, Status

Array = npt.NDArray[np.float64]

SLIDE_BOUND = 1e-3
"""Largest slide / width at which a lane still counts as one that does not slide."""
EARLY_TIME = 5.0
"""Time [s] that the early error covers: the stretch that the paper's figures enlarge."""
RESTITUTION_BOUND = 1e-9
"""Difference from Housner's angular restitution above which a case prescribes its own."""
SMALL_ROTATION_RATIO = 1e-9
"""Peak rotation / slenderness angle below which a relative peak error has no meaning."""


def friction_for_uplift(lanes: Lanes) -> Array:
    """Friction below which a block slides before it rocks, shape [lane]: b/h."""
    return lanes.width / lanes.height


def friction_for_impact(lanes: Lanes) -> Array:
    """Friction that a Housner impact needs, shape [lane].

    The block comes in at w about the old corner and leaves at e w about the new one, e its
    angular restitution: the base gives its centre the impulses m h w (1 - e) along and
    m b w (1 + e) across. With e = 1 - 1.5 sin(a)^2 their ratio is
    3 sin(a) cos(a) / (4 - 3 sin(a)^2), a the slenderness angle.
    """
    sine = np.sin(lanes.slenderness_angle)
    cosine = np.cos(lanes.slenderness_angle)
    return np.asarray(3.0 * sine * cosine / (4.0 - 3.0 * sine**2))


def friction_for_velocity_step(lanes: Lanes) -> Array:
    """Friction that a velocity step v of the base needs at a resting block, shape [lane].

    Without slip the block turns about a corner at w = 3 h v / (4 R^2) (half sizes b, h). Its
    centre then moves at h w against the base and b w upwards, so the base gives it the impulses
    m (v - h w) along and m b w across; their ratio is (4 b^2 + h^2) / (3 b h).
    """
    return np.asarray((4.0 * lanes.width**2 + lanes.height**2) / (3.0 * lanes.width * lanes.height))


def velocity_step_at_start(motions: GroundMotions) -> Array:
    """Velocity step of every lane's base at the start of its motion [m/s], shape [lane]."""
    if isinstance(motions, (HarmonicMotions, RickerMotions, ModulatedMotions)):
        return np.asarray(motions.velocity_step_start)
    if isinstance(motions, RecordMotions):
        return np.asarray(motions.scale * motions.velocity_step_start)
    return np.zeros(motions.lane_count)


def where_housner_holds(lane_set: LaneSet, response: Response) -> list[str]:
    """Why Housner does not hold, one text a lane; an empty text where it does."""
    lanes = lane_set.lanes
    friction = lanes.friction
    uplift, impact = friction_for_uplift(lanes), friction_for_impact(lanes)
    at_step = friction_for_velocity_step(lanes)
    stepped = velocity_step_at_start(lane_set.motions) != 0.0
    closed_form = 1.0 - 1.5 * np.sin(lanes.slenderness_angle) ** 2
    prescribed = np.abs(lanes.angular_restitution - closed_form) > RESTITUTION_BOUND
    slide = response["peak_slide"]
    reasons: list[str] = []
    for lane in range(lanes.lane_count):
        why: list[str] = []
        status = Status(int(response["status"][lane]))
        if status is not Status.OK:
            why.append(f"status {status.name.lower()}")
        if friction[lane] < uplift[lane]:
            why.append(
                f"uplift needs friction {uplift[lane]:.2f}, it has {friction[lane]:.2f}: "
                "it slides before it rocks"
            )
        elif stepped[lane] and friction[lane] < at_step[lane]:
            why.append(
                f"the velocity step at the start needs friction {at_step[lane]:.2f}, it has "
                f"{friction[lane]:.2f}"
            )
        if friction[lane] < impact[lane]:
            why.append(f"an impact needs friction {impact[lane]:.2f}, it has {friction[lane]:.2f}")
        if slide[lane] > SLIDE_BOUND * lanes.width[lane]:
            why.append(f"slides {1e3 * slide[lane]:.2g} mm")
        if prescribed[lane] and response.engine != "housner":
            why.append("the case prescribes an angular restitution of its own")
        reasons.append("; ".join(why))
    return reasons


def _history_errors(response: Response, reference: Response, scale: Array) -> tuple[Array, Array]:
    """Largest |rotation difference| / scale up to `EARLY_TIME` and over the run, shape [lane].

    A lane is compared until either block lies flat: what a history holds afterwards is a
    convention, not a motion.
    """
    times = response.times
    if len(times) != len(reference.times) or not np.allclose(times, reference.times):
        raise ValueError(
            f"histories: {response.engine} and {reference.engine} are sampled at different times"
        )
    ours, theirs = response["rotation"], reference["rotation"]
    fallen = np.maximum(np.abs(ours), np.abs(theirs)) >= 0.5 * np.pi - 1e-6
    standing = np.cumsum(fallen, axis=1) == 0
    difference = np.where(standing, np.abs(ours - theirs), 0.0) / scale[:, None]
    early = times <= EARLY_TIME + 1e-9
    return np.asarray(difference[:, early].max(axis=1)), np.asarray(difference.max(axis=1))


def compare_with_housner(
    lane_set: LaneSet, response: Response, reference_response: Response
) -> pd.DataFrame:
    """One row a lane: the engine's errors against Housner, and where Housner does not hold.

    Args:
        lane_set: The lanes that both responses answer.
        response: Response of the engine under test, with or without histories.
        reference_response: Housner's response (`housner` or the oracle) of the same lanes.

    Returns:
        The lanes' inputs, then `engine`, `holds`, `why`, `outcome`, `reference_outcome`,
        `peak_rotation_ratio`, `reference_peak_rotation_ratio`, `error_5s_ratio` and
        `error_run_ratio` (max |rotation difference| / slenderness angle over the first 5 s and
        over the run; NaN without histories), `peak_error` (relative; NaN where the reference
        does not rock), `peak_slide_mm` and `rest_time_error_s` (engine's minus Housner's; NaN
        where either never rests).
    """
    slenderness = lane_set.lanes.slenderness_angle
    reasons = where_housner_holds(lane_set, response)
    lane_count = len(reasons)
    early = run = np.full(lane_count, np.nan)
    if "rotation" in response.fields and "rotation" in reference_response.fields:
        early, run = _history_errors(response, reference_response, slenderness)
    peak = response["peak_rotation"] / slenderness
    reference_peak = reference_response["peak_rotation"] / slenderness
    rocks = reference_peak > SMALL_ROTATION_RATIO
    peak_error = np.full(lane_count, np.nan)
    peak_error[rocks] = peak[rocks] / reference_peak[rocks] - 1.0
    table = lane_set.inputs.reset_index(drop=True).copy()
    return table.assign(
        engine=response.engine,
        holds=[not why for why in reasons],
        why=reasons,
        outcome=[Outcome(int(code)).name.lower() for code in response["outcome"]],
        reference_outcome=[
            Outcome(int(code)).name.lower() for code in reference_response["outcome"]
        ],
        peak_rotation_ratio=peak,
        reference_peak_rotation_ratio=reference_peak,
        error_5s_ratio=early,
        error_run_ratio=run,
        peak_error=peak_error,
        peak_slide_mm=1e3 * response["peak_slide"],
        rest_time_error_s=response["rest_time"] - reference_response["rest_time"],
    )
