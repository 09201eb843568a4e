"""How far a lane's rotations may be off for its time step, from companion runs at finer steps.

Every lane runs a second time at half of its step. With an error of order p in the step the true
rotation lies the difference of the two runs times 2^p / (2^p - 1) away (Richardson 1911), so the
largest such difference over the run, times a factor of safety, is the lane's `rotation_error`; the
difference of the two peaks gives its `peak_rotation_error`. A lane whose estimate is not negligible
runs a third time, at a quarter of the step. Where the runs then approach one another as the order
says, the step was coarse and the estimate holds, be it large. Where they do not, the lane magnifies
small differences (chaos, a block that barely lifts or barely falls, impacts that come or stay
away): its distance from the third run counts too, and where that matters the lane becomes
`Status.SENSITIVE`: its estimate says how far the runs lie apart, not how far the truth may be.

A block beyond its slenderness angle that falls in all runs is compared up to that angle: the time
of the fall is estimated, not the end of it. No estimate is below the swing that the rest rule of
an engine leaves out.

`warprock.running.tolerance`, which refines lanes, estimates otherwise: from a run at twice the
step, with factors fitted to lanes whose true answer is known. That costs half a run instead of two
or more, and its estimate is two to five times as large. `run --accuracy` judges a choice of
settings at one step, on few lanes, with the estimate of this module; with the other it would pass
fewer settings.

The estimate cannot see what the runs have in common: what the model leaves out, wrong inputs, or an
event that all of them miss, such as a base acceleration that would lift a block for less than the
finest step.

L. F. Richardson (1911), The approximate arithmetical solution by finite differences of physical
problems involving differential equations, *Philosophical Transactions of the Royal Society A* 210,
307-357.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines import engine_class
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import (
    ERROR_FIELDS,
    HISTORIES,
    SOUND,
    Response,
    SampleTimes,
    Status,
    take_lanes,
)
from warprock.running.companions import (
    Companions,
    as_columns,
    gap,
    largest,
    parted,
    peak_gap,
    sample_times,
    slide_gap,
    usable,
)
from warprock.running.options import DEFAULT_OPTIONS, RunOptions

Array = npt.NDArray[np.float64]

SAFETY = 1.5
"""Factor on the extrapolated difference. With it, of some 700 lanes that stand (free rocking,
pulses and bursts of sines, against Housner's solution) at most one in a hundred errs by more than
its estimate, for each of six settings; with 1 one in seven does, for most errors lie within a few
parts in a hundred of the difference, and 2 gains nothing."""

REFINED_ABOVE = 1e-3
"""Estimate / slenderness angle above which a lane runs a third time."""

SENSITIVE_ABOVE = 0.03
"""Estimate / slenderness angle above which a lane whose runs do not converge is sensitive."""

CHAOTIC_ABOVE = 0.3
"""Estimate / slenderness angle above which every lane is: an error as large as the motion does not
propagate in proportion, and its runs approach one another by chance."""

SAMPLE_INTERVAL = 5e-3
"""Time between the samples that are compared [s], at most: in nineteen lanes of twenty half of it
adds less than 3 % to the largest difference, and twice of it takes less than 13 % away."""

CHUNK_VALUES = 4_000_000
"""Values in the histories of one run that are held at a time."""


def run_with_estimate(
    engine: str,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    options: RunOptions = DEFAULT_OPTIONS,
    *,
    settings: Any = None,
) -> Response:
    """Runs all lanes of a batch with one engine, and estimates the errors of their rotations.

    Args:
        engine: Name in `ENGINES`; of one whose error has no order in the step, no estimate.
        lanes: The lanes.
        motions: Their ground motions.
        times: Duration and sampling; an estimate does not depend on the sampling.
        options: How they are run; a tolerance plays no part.
        settings: Settings of the engine; its defaults where None.

    Returns:
        The response that `run_batch` gives, with `rotation_error`, `peak_rotation_error` [rad] and
        `peak_slide_error` [m], shape [lane], or [lane, block] of stacks: infinite where a companion
        run failed, NaN where the lane itself did. A lane that was OK may be `Status.SENSITIVE`.

    Raises:
        ValueError: No lanes.
        KeyError: Unknown engine.
    """
    built = engine_class(engine)
    settings = settings or built.settings_type()
    asked = Companions(engine, lanes, motions, times, settings, options.without_progress())
    if built.order is None or lanes.lane_count == 0:
        return dataclasses.replace(asked, options=options).run()
    case = dataclasses.replace(asked, times=sample_times(float(times.times[-1]), SAMPLE_INTERVAL))
    found = case.in_chunks(_estimated, CHUNK_VALUES, options.progress)
    if times.interval is None:
        return found
    history = asked.run()
    added = {name: found[name] for name in ("status", *ERROR_FIELDS)}
    return dataclasses.replace(history, fields={**history.fields, **added})


def _estimated(case: Companions) -> Response:
    """The response of a chunk of lanes without histories, with the estimates."""
    order = case.order
    first, second = case.run(), case.run_halved(case.halvings(1))
    alpha = case.lanes.slenderness_angle
    near = 2.0**order / (2.0**order - 1.0)
    far = 4.0**order / (4.0**order - 1.0)
    apart = gap(first, second, alpha)
    error = near * apart
    peak_error = near * peak_gap(first, second)
    slide_error = near * slide_gap(first, second)
    sensitive = parted(first, second)
    slow = np.zeros_like(sensitive)
    chosen = np.flatnonzero(largest(error / alpha) > REFINED_ABOVE)
    chosen = chosen[np.isfinite(largest(error))[chosen]]
    if len(chosen) > 0:
        part = case.take(chosen)
        third = part.run_halved(part.halvings(2))
        one, two, angle = take_lanes(first, chosen), take_lanes(second, chosen), alpha[chosen]
        error[chosen] = np.maximum(error[chosen], far * gap(one, third, angle))
        peak_error[chosen] = np.maximum(peak_error[chosen], far * peak_gap(one, third))
        slide_error[chosen] = np.maximum(slide_error[chosen], far * slide_gap(one, third))
        sensitive[chosen] |= parted(one, third)
        shrunk = largest(gap(two, third, angle) / angle) / largest(apart[chosen] / angle)
        # Half as fast as the order says is slow; a failed companion shrinks to infinity.
        slow[chosen] = shrunk > 2.0 ** (1 - order)
    ratio = largest(error / alpha)
    sensitive |= (slow & (ratio > SENSITIVE_ABOVE)) | (ratio > CHAOTIC_ABOVE)
    answered = usable(first)
    sensitive &= np.isin(first["status"], SOUND)
    floor = case.rest_floor
    columns = as_columns(answered, error)
    error = np.where(columns, SAFETY * error + floor, np.nan)
    # Two peaks may lie close to one another by chance.
    peak_error = np.where(
        as_columns(sensitive, error), error, np.where(columns, SAFETY * peak_error + floor, np.nan)
    )
    fields = {name: first[name] for name in first.fields if name not in HISTORIES}
    fields["status"] = np.where(sensitive, int(Status.SENSITIVE), first["status"])
    fields["peak_rotation_error"], fields["rotation_error"] = peak_error, error
    fields["peak_slide_error"] = np.where(columns, SAFETY * slide_error, np.nan)
    return Response(engine=first.engine, fields=fields, times=np.empty(0))
