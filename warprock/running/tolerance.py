"""Runs every lane until its rotations are within a tolerance, or says that they are not.

This file has the only estimate of a lane's error by runs at other steps. Every lane runs at the
asked step, and a companion at twice the step shows the error. Let the error be A h^p, of order p in
the step h. Then halving h divides it by r = 2^p, and the error of the finer of two runs is their
difference over r - 1 (Richardson 1911). A lane whose estimate misses the tolerance runs again at
half of the step. Only those lanes do, at most `HALVINGS` times, and the numbers of a lane are those
of its finest run. If doubling the setting changes no step, because something else limits it, the
lane starts with half of the step instead.

Each pair of neighbouring runs gives A; the estimate takes the root of the mean of the squares. A
pair whose difference exceeds `CHAOTIC_ABOVE` does not count, except for the last one. Three runs
also give r, the ratio of their two differences; it lies between 2, of a first order, and 2^p.
Errors of the first order scatter: an impact is late by any part of a step, and two runs may agree
by chance. So if p is 1, lanes also run at four times the step, which costs less than the repeated
runs that it avoids; m pairs give the error better than one, by the root of m. Then the factors and
floors of `warprock.running.calibration` are applied.

A lane whose estimate is large is either chaotic or its step is too long. One more companion tells
which, at twice the step and under a motion that is larger by `PERTURBATION`: a lane that magnifies
this difference `CHAOTIC_GAIN` times is chaotic, and no finer step is tried. Where errors are of the
first order, ten times that, for an impact may come a step later.

Under a record lanes are costly and many are chaotic. A lane then ends early if its error, at the
present rate of convergence (at first, that of the order), would miss the tolerance at the finest
step, too; and if its `BUDGET` is spent. Under any other motion a lane ends early if the differences
of its runs are large and do not decrease. Of a stack in space they are large already if an error
that shrank by the whole order from now on would miss the tolerance at the finest step. (Stacks in
the plane may find another branch and converge on it by a high order.) Further runs would cost much
and help little.

A lane that missed the tolerance is one of two kinds. If its runs converge, about as the order says,
it keeps its status; its estimate says how large its error may be, and a smaller step will do. If
they do not converge, it stands in one run and falls in another, or it magnifies small differences
(`Status.SENSITIVE`). Then its estimate is the difference of its runs, not the size of its error; an
ensemble gives a distribution. If a lane fell in every run, only the time of the fall is in doubt.

Under a record the companions of a lane end soon after it rests for good, if its engine keeps a
block at rest exactly: nothing after that depends on the step. A companion that does not rest there
runs on.

The estimate cannot see errors that all runs share: what the model leaves out, wrong inputs, or an
event that all of them miss, such as an uplift shorter than the finest step of an engine that
detects uplifts at the ends of its steps.

L. F. Richardson (1911), The approximate arithmetical solution by finite differences of physical
problems involving differential equations, *Philosophical Transactions of the Royal Society A* 210,
307-357.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines import engine_class
from warprock.engines.workload import FINEST_STEPS
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import (
    ESTIMATE_FIELDS,
    HISTORIES,
    SOUND,
    USABLE,
    Outcome,
    Response,
    SampleTimes,
    Status,
    join_responses,
    take_lanes,
)
from warprock.running.batch import run_batch
from warprock.running.calibration import PLAIN, estimate_factors
from warprock.running.companions import (
    PERTURBATION,
    Companions,
    as_columns,
    companion_settings,
    cut_records,
    find_branched_lanes,
    find_fallen,
    find_parted_lanes,
    gap,
    halve_step,
    largest,
    many_pieces,
    peak_gap,
    peaks_apart,
    record_alone,
    sample_times,
    slide_gap,
    uplift_error,
    uplift_gap,
    usable,
)
from warprock.running.options import DEFAULT_OPTIONS, RunOptions
from warprock.running.waiting import Forecast

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.intp]

HALVINGS = 3
"""How often the step is halved, at most: to an eighth."""

BUDGET = 3.55
"""Largest number of steps of all runs of a lane under a record, over that of its first run. The
numbers are predicted, so the limit is approximate. It allows half of the step for a lane that rocks
from end to end (1 + 1/2 + 2), and more for one that rests early. Seven blocks under six records at
ten scales took up to 2.99 in the mean."""

SLOWEST = 2.0
"""Least r of an estimate, that of a first order; a smaller ratio is chance."""

FASTEST = 2.0**5
"""Largest r of an estimate: stacks that stick are of fifth order."""

SMALL = 0.02
"""Peak / slenderness angle below which two runs show an error of the first order: such a swing is
a few steps long. Of bodies under pulses, against Housner's equation, 10 of 1,128 with larger swings
erred by more than 1.5 times what the order says, and 14 of 38 with smaller ones."""

SCATTERED = 2
"""How often the step of companions is doubled if errors are of the first order. Under a record a
third companion costs too much."""

SENSITIVE_ABOVE = 0.03
"""Estimate / slenderness angle above which a lane whose runs do not converge is sensitive."""

SLACK = 0.5
"""Difference between the order of the engine and the observed one up to which a large error counts
as a coarse step, not as chaos."""

CHAOTIC_ABOVE = 0.3
"""Estimate / slenderness angle above which every lane is sensitive: an error as large as the motion
does not propagate in proportion, and its runs agree only by chance."""

CHAOTIC_GAIN = 1e7
"""Difference of the rotations over the slenderness angle that a small difference of the motion
grows to, over that difference, from which on a lane is chaotic. Of 256 stacks of two blocks in the
plane under 10 s of sine 236 had that gain: 15 of these met a tolerance of 0.01 at an eighth of the
step, as is possible by chance, and 18 of the 20 others."""

CHAOTIC_GAIN_FIRST = 1e8
"""The same where errors are of the first order. Of 421 lanes in doubt, of blocks, pairs and columns
in `impulse`, `xpbd`, `direct`, `dem` and `assembly`, 37 had a gain above 3e7, and none of these met
a tolerance of 0.01 at an eighth of the step; of 12 with 1e7 to 3e7 two did, and 46 of 93 with 1e6
to 1e7."""

ESTIMATED = 1.75, 2.0
"""Steps of a run with its coarser companions over those of the run alone, at least. Where errors
are of the first order, two run at twice and four times the step; else two at twice the step."""

SAMPLE_INTERVAL = 4e-2
"""Largest time between the samples that are compared [s]. Shorter ones cost as much as the run. Of
159 lanes under records, 50 ms (with the difference of the peaks) take less than 4 % from the
largest difference in three of four, and less than 15 % in nine of ten."""

CHUNK_VALUES = 4_000_000
"""Number of values in the histories of one run that are held at a time."""

PARTS = 32
"""Parts of a run: the record of a companion ends with one of them, so that lanes share records."""

MARGIN = 1.0 / 64.0
"""How long a record goes on after its lane came to rest, as a part of the run."""


def run_to_tolerance(
    engine: str,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    options: RunOptions = DEFAULT_OPTIONS,
    *,
    settings: Any = None,
    halvings: int = HALVINGS,
) -> Response:
    """Runs all lanes of a batch with one engine, at finer steps where a lane needs them.

    Args:
        engine: Name in `ENGINES`; one whose error has no order in the step runs once.
        lanes: The lanes.
        motions: Their ground motions.
        times: Duration and sampling; estimates do not depend on the sampling.
        options: How they are run, with a tolerance.
        settings: Settings of the engine, with the coarsest step; its defaults where None.
        halvings: How often the step is halved, at most; 1 or more, for a lane without a coarser
            companion has no estimate before.

    Returns:
        The numbers of every lane's finest run, with `ESTIMATE_FIELDS`: the estimated errors, NaN
        where the lane itself has no number, infinite where a companion had none; `time_step`, the
        setting that the numbers are from [s]; and the steps that this took. The step count of a
        lane that was run again may end soon after it came to rest. A lane that was OK may be
        `Status.SENSITIVE`; the `rotation_error` of the others says whether they met the tolerance.

    Raises:
        ValueError: No lanes, no halvings, or a tolerance that is not above zero.
        KeyError: Unknown engine.
    """
    tolerance = options.tolerance
    if tolerance is None or not tolerance > 0.0:
        raise ValueError(f"tolerance: got {tolerance}, must be > 0")
    if halvings < 1:
        raise ValueError(f"halvings: got {halvings}, must be 1 or more")
    built = engine_class(engine)
    settings = settings or built.settings_type()
    asked = Companions(engine, lanes, motions, times, settings, options.without_progress())
    if built.order is None or lanes.lane_count == 0:
        return dataclasses.replace(asked, options=options).run()
    compared = sample_times(float(times.times[-1]), SAMPLE_INTERVAL)
    case = dataclasses.replace(asked, times=compared)
    forecast = Forecast(
        lanes.lane_count, ESTIMATED[built.order > 1], ", and more for lanes that miss the tolerance"
    )
    refine = functools.partial(_refine, tolerance=tolerance, most=halvings, forecast=forecast)
    found = case.in_chunks(refine, CHUNK_VALUES, options.progress)
    return found if times.interval is None else _with_histories(asked, found)


def run_at_step(
    engine: str,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    options: RunOptions,
    *,
    step: float,
    settings: Any,
) -> Response:
    """Runs lanes once, at the step that `run_to_tolerance` ended with for the same settings.

    Args:
        engine: Name in `ENGINES`, of an engine with an order in the step.
        lanes: The lanes.
        motions: Their ground motions.
        times: Duration and sampling.
        options: How they are run.
        step: Their `time_step` [s].
        settings: Settings of the engine, with the coarsest step.
    """
    finer = companion_settings(settings, round(math.log2(settings.time_step / step)), lanes)
    return run_batch(
        engine,
        lanes,
        motions,
        times,
        settings=finer,
        most_steps=FINEST_STEPS,
        **options.of_batch,
    )


def _with_histories(case: Companions, found: Response) -> Response:
    """The response of the same lanes at the same steps, with histories."""
    halvings = np.rint(np.log2(case.settings.time_step / found["time_step"])).astype(np.intp)
    history = case.run_halved(halvings)
    added = {name: found[name] for name in ("status", *ESTIMATE_FIELDS)}
    return dataclasses.replace(history, fields={**history.fields, **added})


def _refine(case: Companions, tolerance: float, most: int, forecast: Forecast) -> Response:
    """Runs a chunk of lanes, without histories, halving their steps at most `most` times."""
    asked = dataclasses.replace(case, options=case.options.watched_by(forecast)).run()
    known = _Known(case, asked, tolerance)
    ends = np.full(case.lanes.lane_count, np.inf)
    if case.rest_is_known:
        ends = _ends(asked, case.times.duration)
        known.hold(np.flatnonzero(ends == 0.0))
    work = np.minimum(known.lasted, ends)
    lanes = np.flatnonzero(known.going & case.coarser)
    if len(lanes) > 0:
        part = case.take(lanes)
        doubled = [
            _run_until_rest(
                part, np.full(len(lanes), -count), ends[lanes], work[lanes], known, lanes
            )
            for count in range(known.doublings, 0, -1)
        ]
        for coarser, coarse in itertools.pairwise(doubled):
            known.compare(lanes, coarser, coarse)
        known.weigh(lanes, doubled[-1], take_lanes(asked, lanes), most)
        doubtful = np.flatnonzero(known.in_doubt(lanes))
        if len(doubtful) > 0 and case.options.precision == "float64":
            some = lanes[doubtful]
            moved = _run_until_rest(
                part.take(doubtful).perturbed(),
                np.full(len(some), -1),
                ends[some],
                work[some],
                known,
                some,
            )
            known.end_chaotic(some, take_lanes(doubled[-1], doubtful), moved)
    before, before_lanes = asked, np.arange(len(ends))
    for power in range(1, most + 1):
        lanes = np.flatnonzero(known.going & known.affordable(2.0**power * work))
        if len(lanes) == 0:
            break
        part = case.take(lanes)
        halvings = part.halvings(power)
        after = _run_until_rest(part, halvings, ends[lanes], work[lanes], known, lanes)
        before = take_lanes(before, np.searchsorted(before_lanes, lanes))
        known.adopt(lanes, after, halvings)
        known.weigh(lanes, before, after, most - power)
        before, before_lanes = after, lanes
    return known.response()


def _ends(asked: Response, duration: float) -> Array:
    """Finds when the records of companions end [s]; 0 of lanes that never moved.

    A lane that does not rest at the end may take any time.
    """
    rest = asked["rest_time"]
    ends = np.ceil((rest / duration + MARGIN) * PARTS) / PARTS * duration
    rests = (asked["outcome"] == Outcome.AT_REST) & (ends < duration)
    return np.where(rests, np.where(rest == 0.0, 0.0, ends), np.inf)


def _run_until_rest(
    case: Companions, halvings: Numbers, ends: Array, work: Array, known: _Known, lanes: Numbers
) -> Response:
    """Runs companions under cut-off records, and longer ones where a lane did not rest by then."""
    short, half = np.isfinite(ends), len(ends) // 2
    if half and np.any(short) and many_pieces(case.motions, ends):
        parts = [
            _run_until_rest(case.take(p), halvings[p], ends[p], work[p], known, lanes[p])
            for p in (slice(None, half), slice(half, None))
        ]
        return join_responses(parts)
    cut = case
    if np.any(short):
        cut = dataclasses.replace(case, motions=cut_records(case.motions, ends))
    found = cut.run_halved(halvings, work)
    known.count_steps(lanes, found)
    rests = (found["outcome"] == Outcome.AT_REST) & (found["rest_time"] <= ends)
    awake = np.flatnonzero(short & ~rests)
    if len(awake) == 0:
        return found
    later = 2.0 * ends[awake]
    later = np.where(later < case.times.duration, later, np.inf)
    part = case.take(awake)
    longer = _run_until_rest(part, halvings[awake], later, work[awake], known, lanes[awake])
    return _replace_lanes(found, awake, longer)


def _replace_lanes(response: Response, lanes: Numbers, others: Response) -> Response:
    """Replaces some lanes of a response by those of another."""
    fields = {name: values.copy() for name, values in response.fields.items()}
    for name, values in fields.items():
        values[lanes] = others[name]
    return dataclasses.replace(response, fields=fields)


class _Known:
    """The lanes of a chunk so far: the numbers of their finest runs, and their estimated errors."""

    def __init__(self, case: Companions, asked: Response, tolerance: float) -> None:
        """Starts with the run at the step asked for."""
        self.case, self.tolerance, self.order = case, tolerance, case.order
        self.engine = asked.engine
        records = record_alone(case.motions)
        self.records = records
        self.budget = np.full(len(asked["status"]), BUDGET if records else np.inf)
        self.scatters = self.order == 1 or records
        self.doublings = SCATTERED if self.order == 1 and not records else 1
        self.factors = estimate_factors(case.engine, case.scene, records=records)
        self.lasted = np.where(find_fallen(asked), largest(asked["peak_time"]), case.times.duration)
        self.fields = {n: v.copy() for n, v in asked.fields.items() if n not in HISTORIES}
        self.alpha = case.lanes.slenderness_angle
        self.floor = case.rest_floor
        self.going = usable(asked)
        self.met = np.zeros_like(self.going)
        self.not_converging = np.zeros_like(self.going)
        self.falls = find_fallen(asked)
        self.halvings, self.halved, self.pairs = np.zeros((3, len(self.going)), dtype=np.intp)
        self.first_steps = self.fields["step_count"].copy()
        self.total_steps = self.first_steps.copy()
        self.apart = np.full(len(self.going), np.nan)
        self.first_apart = np.zeros(len(self.going))
        self.before = np.full(len(self.going), np.nan)
        self.squares, self.errors = (
            {name: np.zeros_like(self.alpha) for name in ("rotation", "peak", "slide")}
            for _ in range(2)
        )
        self.uplift = np.zeros(len(self.going))

    def hold(self, lanes: Numbers) -> None:
        """Takes lanes out whose numbers do not depend on the step."""
        self.met[lanes], self.going[lanes] = True, False

    def count_steps(self, lanes: Numbers, run: Response) -> None:
        """Adds the steps of a run of some lanes."""
        self.total_steps[lanes] += run["step_count"]

    def affordable(self, work: Array) -> Mask:
        """Lanes that may run again within their budget of steps, shape [lane].

        Args:
            work: Simulated time x step refinement of the next run [s].
        """
        spent = self.total_steps / np.maximum(self.first_steps, 1)
        return np.asarray(spent + work / self.lasted <= self.budget)

    def adopt(self, lanes: Numbers, run: Response, halvings: Numbers) -> None:
        """Takes the numbers of a finer run of some lanes, where it has any."""
        sound = usable(run)
        for name, values in self.fields.items():
            values[lanes[sound]] = run[name][sound]
        self.halvings[lanes[sound]] = halvings[sound]

    def compare(self, lanes: Numbers, before: Response, after: Response) -> None:
        """Adds two runs to what is known of the errors of the finer one.

        Args:
            lanes: Numbers of the lanes.
            before: Their coarser run.
            after: Their finer run.
        """
        angle, full = self.alpha[lanes], 2.0**self.order
        gaps = np.maximum(gap(before, after, angle), peaks_apart(before, after))
        apart = largest(gaps / angle)
        # An error as large as the motion does not shrink in proportion.
        likely = np.isfinite(self.apart[lanes]) & (self.apart[lanes] <= CHAOTIC_ABOVE)
        self.halved[lanes] = np.where(likely, self.halved[lanes] + 1, 0)
        self.first_apart[lanes] = np.where(likely, self.first_apart[lanes], apart)
        kept = likely & self.scatters
        self.pairs[lanes] = np.where(kept, self.pairs[lanes] + 1, 1)
        self.before[lanes], self.apart[lanes] = self.apart[lanes], apart
        found = {
            "rotation": gaps,
            "peak": peak_gap(before, after),
            "slide": slide_gap(before, after),
        }
        columns = as_columns(kept, angle)
        for name, each in found.items():
            squares = self.squares[name]
            squares[lanes] = each**2 + np.where(columns, squares[lanes], 0.0) / full**2

    def weigh(self, lanes: Numbers, before: Response, after: Response, left: int) -> None:
        """Estimates the errors of the finer of two runs, and decides which lanes run again.

        Args:
            lanes: Numbers of the lanes.
            before: Their coarser run.
            after: Their finer run.
            left: Halvings that may follow.
        """
        self.compare(lanes, before, after)
        angle, full = self.alpha[lanes], 2.0**self.order
        apart, pairs = self.apart[lanes], self.pairs[lanes]
        with np.errstate(divide="ignore", invalid="ignore"):
            shrunk = self.before[lanes] / apart
            overall = self.first_apart[lanes] / apart
        refined = np.isfinite(shrunk)
        small = largest(np.abs(after["peak_rotation"]) / angle) < SMALL
        # Of two runs; a stack has swings of all sizes.
        unknown = np.where(small | self.case.piled, SLOWEST, full)
        # What is seen beyond an order above the first counts half.
        most = FASTEST if self.order > 1 else full
        seen = np.minimum(shrunk, np.sqrt(np.minimum(shrunk, most) * full))
        rate = np.where(refined, np.maximum(seen, SLOWEST), unknown)
        means = pairs if self.order == 1 else np.sqrt(pairs)
        share = 1.0 / as_columns((rate - 1.0) * means, angle)
        for name, squares in self.squares.items():
            factor = getattr(self.factors, name)
            size = np.abs(after["peak_slide"]) if name == "slide" else angle
            floor = factor.floor * size + (0.0 if name == "slide" else self.floor[lanes])
            self.errors[name][lanes] = factor.factor * share * np.sqrt(squares[lanes]) + floor
        self.uplift[lanes] = uplift_gap(before, after)
        ratio = largest(self.errors["rotation"][lanes] / angle)
        likely = largest(share * np.sqrt(self.squares["rotation"][lanes]) / angle)
        differ = find_parted_lanes(before, after)
        branched = self.case.piled & find_branched_lanes(self.before[lanes], apart, self.tolerance)
        met = ~differ & ~branched & (ratio <= self.tolerance)
        # At best the error goes on to shrink as it did, at least as of a first order.
        hope = np.where(refined, np.maximum(rate, 2.0), full)
        best = apart / (full - 1.0) / hope**left
        wild = ~(ratio <= CHAOTIC_ABOVE)
        if self.case.piled and self.case.lanes.spatial:
            # Nor if its error were to shrink by the whole order from now on.
            wild |= apart / (full - 1.0) / full**left > self.tolerance
        wild &= refined & (shrunk < 2.0)
        hopeless = usable(before) & (best > self.tolerance if self.records else wild)
        halved = self.halved[lanes]
        steady = (halved > 0) & (overall >= 2.0 ** ((self.order - SLACK) * halved))
        doubtful = (ratio > SENSITIVE_ABOVE) & ~steady
        self.met[lanes] = met
        self.falls[lanes] &= find_fallen(before) & find_fallen(after)
        self.going[lanes] = usable(after) & ~met & ~hopeless
        self.not_converging[lanes] = differ | branched | doubtful | ~(likely <= CHAOTIC_ABOVE)

    def in_doubt(self, lanes: Numbers) -> Mask:
        """Of some lanes those that go on with an estimate as large as that of a chaotic one."""
        ratio = largest(self.errors["rotation"][lanes] / self.alpha[lanes])
        return self.going[lanes] & ~(ratio <= SENSITIVE_ABOVE)

    def end_chaotic(self, lanes: Numbers, before: Response, moved: Response) -> None:
        """Ends lanes that are chaotic.

        Args:
            lanes: Numbers of the lanes.
            before: A run of theirs.
            moved: The same run under a motion that differs by `PERTURBATION`.
        """
        gaps = np.maximum(gap(before, moved, self.alpha[lanes]), peaks_apart(before, moved))
        # With errors of the first order an impact of the moved run may be a whole step later.
        most = (CHAOTIC_GAIN if self.order > 1 else CHAOTIC_GAIN_FIRST) * PERTURBATION
        parted = find_fallen(before) != find_fallen(moved)
        far = largest(gaps / self.alpha[lanes]) > most
        chaotic = usable(before) & usable(moved) & (parted | far)
        self.falls[lanes] &= ~chaotic | find_fallen(moved)
        self.not_converging[lanes] |= chaotic
        self.going[lanes] &= ~chaotic
        # The steps of this run are no part of what halving the step may take.
        self.budget[lanes] += moved["step_count"] / np.maximum(self.first_steps[lanes], 1)

    def response(self) -> Response:
        """The finest numbers, with the estimates."""
        fields = dict(self.fields)
        answered = np.isin(fields["status"], USABLE)
        sensitive = self.not_converging & ~self.met & np.isin(fields["status"], SOUND)
        fields["status"] = np.where(sensitive, int(Status.SENSITIVE), fields["status"])
        columns = as_columns(answered, self.alpha)
        # A lane that fell in every run is in doubt of the time of its fall alone.
        sensitive = as_columns(sensitive & ~self.falls, self.alpha)
        error = np.maximum(self.errors["rotation"], self.floor)
        peak_error = np.minimum(np.maximum(self.errors["peak"], self.floor), error)
        fields["peak_rotation_error"] = np.where(
            columns, np.where(sensitive, error, peak_error), np.nan
        )
        fields["rotation_error"] = np.where(columns, error, np.nan)
        fields["peak_slide_error"] = np.where(columns, self.errors["slide"], np.nan)
        counts = np.unique(self.halvings)
        steps = {k: halve_step(self.case.settings, int(k)).time_step for k in counts}
        fields["time_step"] = np.array([steps[k] for k in self.halvings])
        finest = Response(engine=self.engine, fields=fields, times=np.empty(0))
        # Of the first order, for two runs leave the order open.
        fields["uplift_time_error"] = uplift_error(
            finest, PLAIN * self.uplift, self.case.uplift_floor(fields["time_step"])
        )
        fields["first_step_count"] = self.first_steps
        fields["total_step_count"] = self.total_steps
        return Response(engine=self.engine, fields=fields, times=np.empty(0))
