"""Runs of the same lanes at other steps, and the differences of two such runs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines import engine_class
from warprock.engines.base import AbstractEngine
from warprock.engines.launching import Target
from warprock.engines.workload import FINEST_STEPS, MOST_STEPS
from warprock.model.lanes import Lanes
from warprock.model.motion import ComposedMotions, GroundMotions, RecordMotions, UprightMotions
from warprock.model.response import (
    FALLEN,
    USABLE,
    Response,
    SampleTimes,
    join_responses,
    take_lanes,
)
from warprock.running.batch import run_batch
from warprock.running.calibration import BLOCK, BODY, STACK
from warprock.running.options import Progress, RunOptions

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.intp]


STACK_REST = 3.0
"""Least motion that an omitted swing causes in the other blocks of a stack, over that swing."""

PIECES_KEPT = 2**24
"""Largest number of samples of shortened records in memory at a time, 400 MB; lanes that need more
run in parts."""

STACK_RESTS = 1e-2
"""Swing at which blocks of a stack in the plane rest, over that at twice the step. The two are far
enough apart for the order of impacts to differ where it depends on which blocks rest."""

LATE = 3.0
"""Number of steps by which two runs may both be late with an uplift, for an engine that detects
uplifts at the ends of its steps. For 60 random pulses no lane of `impulse`, `direct` and `xpbd`
then erred by more than its estimate; with 2 one in twelve did."""

BRANCHES = 64.0
"""Ratio of two differences above which two nearly simultaneous impacts have changed their order.
Convergence cannot explain it: the ratio is twice that of the fifth order, of sticking stacks."""

PERTURBATION = 1e-9
"""Relative change of the motions and of the start that shows how a lane magnifies small
differences: round-off moves a lane less, and nobody knows a motion so well."""

REST_RATIO_LEAST = 1e-9
REST_RATIO_MOST = 1e-2
"""Bounds of the setting `rest_rotation_ratio`."""


def sample_times(duration: float, interval: float) -> SampleTimes:
    """Makes sample times for comparing runs; the last one is exactly the end of the run.

    Samples are a power of two in number, so that the last one is the duration to the last bit.

    Args:
        duration: Length of the run [s].
        interval: Time between samples, at most [s].
    """
    power = max(0, math.ceil(math.log2(duration / interval)))
    return SampleTimes(duration, duration / 2.0**power)


def record_alone(motions: GroundMotions) -> bool:
    """Whether nothing but records moves the base."""
    return all(isinstance(part, RecordMotions) for part in motions.components)


def cut_records(motions: GroundMotions, ends: Array) -> GroundMotions:
    """Cuts records short: they stop moving the base at their first sample at or after a time.

    Args:
        motions: Motions of records alone.
        ends: The times [s], shape [lane]; infinite for all of a record.
    """
    if isinstance(motions, ComposedMotions):
        return motions.with_parts(lambda part: _cut_record(part, ends))
    return _cut_record(motions, ends)


def many_pieces(motions: GroundMotions, ends: Array) -> bool:
    """Whether the pools of `cut_records` would be too large to be held at once."""
    samples = sum(int(_pieces(part, ends)[0][:, 1].sum()) for part in motions.components)
    return samples > PIECES_KEPT


def _pieces(motions: Any, ends: Array) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.intp]]:
    """The pieces of records that remain: offset, samples left and all samples of each.

    Returns:
        Shape [piece, 3], and the piece of every lane, shape [lane].
    """
    assert isinstance(motions, RecordMotions)
    with np.errstate(invalid="ignore"):
        samples = np.ceil((ends - motions.start) / motions.interval) + 1.0
    count = np.clip(samples, 1, motions.count).astype(np.int32)
    pieces, piece = np.unique(
        np.stack([motions.offset, count, motions.count], axis=1), axis=0, return_inverse=True
    )
    return pieces, piece.reshape(-1)


def _cut_record(motions: Any, ends: Array) -> RecordMotions:
    """The records of one direction, each cut off, with a pool of the pieces that are left."""
    pieces, piece = _pieces(motions, ends)
    count = pieces[piece, 1]
    places = [np.arange(offset, offset + kept) for offset, kept, _ in pieces]
    where = np.concatenate(places)
    last = np.cumsum(pieces[:, 1]) - 1
    # The last sample of a record is an empty segment.
    pool = {n: getattr(motions, f"pool_{n}")[where] for n in ("acceleration", "slope", "velocity")}
    pool["acceleration"][last], pool["slope"][last] = 0.0, 0.0
    found: RecordMotions = dataclasses.replace(
        motions,
        offset=(last - pieces[:, 1] + 1).astype(np.int32)[piece],
        count=count,
        velocity_step_stop=np.where(count < motions.count, 0.0, motions.velocity_step_stop),
        **{f"pool_{name}": values for name, values in pool.items()},
    )
    return found


@dataclasses.dataclass(frozen=True)
class Companions:
    """Lanes and everything that they run with, except the time step.

    Attributes:
        engine: Name in `ENGINES`, of an engine with an order in the step.
        lanes: The lanes.
        motions: Their ground motions.
        times: Duration and sampling.
        settings: Settings of the engine, with the step asked for.
        options: How they are run.
        most_steps: Steps that a lane may need, at most.
    """

    engine: str
    lanes: Lanes
    motions: GroundMotions
    times: SampleTimes
    settings: Any
    options: RunOptions
    most_steps: float = MOST_STEPS

    @property
    def order(self) -> int:
        """Order of the engine."""
        order = engine_class(self.engine).order
        assert order is not None
        return order

    @property
    def piled(self) -> bool:
        """Whether the engine runs the lanes as stacks: columns of an assembly, too."""
        of_assembly = self.lanes.assembly is not None and engine_class(self.engine).drums
        return self.lanes.stacked or of_assembly

    @property
    def scene(self) -> str:
        """The kind of scene, by which the factors of the error estimates are chosen."""
        if self.piled:
            return STACK
        upright = isinstance(self.motions, UprightMotions)
        own = self.lanes.spatial or self.lanes.on_points or self.lanes.restitution_given or upright
        # What bounces runs as a body.
        bounces = getattr(self.settings, "restitution", 0.0) > 0.0
        return BODY if own or bounces else BLOCK

    @property
    def rest_is_known(self) -> bool:
        """Whether a lane that rests for good does so at every step.

        That holds if a resting block does not move at all and steps end at the knots between which
        the acceleration of the base is linear: the next uplift then depends only on the base.
        """
        return engine_class(self.engine).rests_exactly and record_alone(self.motions)

    @property
    def rest_floor(self) -> Array:
        """Least estimate [rad]: the swings that the rest rule leaves out at every step.

        That is the swing below which a block rests. In a stack it moves the other blocks, too.
        """
        swing = getattr(self.settings, "rest_rotation_ratio", 0.0) * self.lanes.slenderness_angle
        return np.asarray(swing * (STACK_REST if self.piled else 1.0))

    def uplift_floor(self, steps: Array | float) -> Array:
        """Error of an uplift time that is the same at every step setting [s], shape [lane].

        It is zero if the engine locates uplifts inside its steps.
        """
        if engine_class(self.engine).rests_exactly:
            return np.zeros(self.lanes.lane_count)
        return np.asarray(LATE * np.minimum(steps, self._longest_step(self.settings)))

    def take(self, lanes: slice | Numbers) -> Companions:
        """Takes some of the lanes."""
        return dataclasses.replace(
            self, lanes=self.lanes.take(lanes), motions=self.motions.take(lanes)
        )

    def perturbed(self) -> Companions:
        """Companions whose motions and starts, yaws apart, are larger by `PERTURBATION`."""
        larger = 1.0 + PERTURBATION
        starts = ("rotation_start", "rotation_across_start", "gap_start")
        arrays = self.lanes.arrays
        moved: dict[str, Any] = {n: arrays[n] * larger for n in starts if n in arrays}
        if self.lanes.release is not None:
            moved["release"] = self.lanes.release.scaled(larger)
        lanes = dataclasses.replace(self.lanes, **moved)
        factors = np.full(self.lanes.lane_count, larger)
        return dataclasses.replace(self, lanes=lanes, motions=self.motions.scaled(factors))

    def run(self) -> Response:
        """Runs the lanes at the step of the settings."""
        return run_batch(
            self.engine,
            self.lanes,
            self.motions,
            self.times,
            settings=self.settings,
            most_steps=self.most_steps,
            **self.options.of_batch,
        )

    def in_chunks(
        self,
        answer: Callable[[Companions], Response],
        values: int,
        progress: Progress | None,
    ) -> Response:
        """Works chunk by chunk, and joins the responses.

        Args:
            answer: The work.
            values: Values in the histories of one run that are held at a time.
            progress: Called with the number of lanes finished so far.
        """
        count = self.lanes.lane_count
        size = max(1, values // (len(self.times.times) * self.lanes.block_count))
        parts = []
        for low in range(0, count, size):
            high = min(low + size, count)
            parts.append(answer(self.take(slice(low, high))))
            if progress is not None:
                progress(high)
        return join_responses(parts)

    @property
    def coarser(self) -> Mask:
        """Lanes whose steps are twice as long with twice the setting, shape [lane]."""
        twice = self._longest_step(halve_step(self.settings, -1))
        with np.errstate(invalid="ignore"):
            return np.asarray(twice > 1.99 * self._longest_step(self.settings))

    def _longest_step(self, settings: Any) -> Array:
        return self._built(settings).longest_step(self.lanes, self.motions)

    def _built(self, settings: Any) -> AbstractEngine:
        target = Target(self.options.precision, self.options.device)
        return engine_class(self.engine)(settings, target)

    def halvings(self, power: int) -> Numbers:
        """How often to halve the setting for steps at most 2^-power of those taken, shape [lane].

        If the frequency of the block or the knots of a record limit the step of a lane, the setting
        must be halved more than `power` times before the runs differ.
        """
        # Round-off apart; a lane whose sizes are not finite takes part as it is.
        asked = self._built(self.settings).step_of_settings(self.lanes, self.motions)
        cuts = np.ceil(np.log2(asked / self._longest_step(self.settings)) - 1e-9)
        return power + np.where(np.isfinite(cuts), cuts, 0.0).astype(np.intp)

    def run_halved(self, halvings: Numbers, work: Array | None = None) -> Response:
        """Runs the lanes at halved steps.

        Args:
            halvings: How often, shape [lane]; below zero doublings.
            work: Predicted cost of every lane, in any unit, shape [lane]. Lanes of a pack wait for
                one another, so lanes of about the same cost run side by side.
        """
        found, places = [], []
        for count in np.unique(halvings):
            lanes = np.flatnonzero(halvings == count)
            if work is not None:
                lanes = lanes[np.argsort(work[lanes], kind="stable")]
            finer = dataclasses.replace(
                self.take(lanes),
                settings=companion_settings(self.settings, int(count), self.lanes),
                most_steps=FINEST_STEPS,
            )
            found.append(finer.run())
            places.append(lanes)
        return take_lanes(join_responses(found), np.argsort(np.concatenate(places)))


def companion_settings(settings: Any, count: int, lanes: Lanes) -> Any:
    """Settings with the step halved `count` times (doubled if negative), and a matching rest rule.

    At a halved step blocks rest at smaller swings, in proportion to the square of the step. If all
    runs omitted the same last swing, none would show its effect on a later shock: one of 76 lanes
    under 40 s of a record differs from Housner's equation for that reason.

    Blocks of a stack rest at swings smaller by `STACK_RESTS`, and at twice the step at larger ones.
    Whether a small swing has ended decides which ends take part in an impact elsewhere, and which
    of two nearly simultaneous impacts is the first. Runs that differ only in the step would all
    take the same branch there; runs with different rest rules do not.
    """
    found = halve_step(settings, count)
    if count == 0 or not hasattr(found, "rest_rotation_ratio"):
        return found
    # Of assemblies only columns, which run as stacks, have a rest rule.
    stack = (lanes.stacked or lanes.assembly is not None) and not lanes.spatial
    part = STACK_RESTS**count if stack else 0.25 ** max(count, 0)
    ratio = min(max(part * found.rest_rotation_ratio, REST_RATIO_LEAST), REST_RATIO_MOST)
    return dataclasses.replace(found, rest_rotation_ratio=ratio)


def halve_step(settings: Any, count: int) -> Any:
    """Halves the time step of settings `count` times; doubles it where the count is below zero."""
    if count < 0:
        return settings.with_step_scaled(2.0**-count)
    for _ in range(count):
        settings = settings.halved()
    return settings


def find_fallen(response: Response) -> Mask:
    """Lanes that overturned or slid off, shape [lane]."""
    return np.asarray(np.isin(response["outcome"], FALLEN))


def usable(response: Response) -> Mask:
    """Lanes that the engine has an answer for, shape [lane]."""
    return np.asarray(np.isin(response["status"], USABLE))


def find_parted_lanes(one: Response, other: Response) -> Mask:
    """Lanes that stand in one run and fall in the other, or that have no answer in one of them."""
    return np.asarray((find_fallen(one) != find_fallen(other)) | ~usable(one) | ~usable(other))


def gap(one: Response, other: Response, alpha: Array) -> Array:
    """Largest |rotation difference| of two runs [rad]; infinite where one failed.

    If the blocks fall in both runs, only rotations up to the slenderness angle count: the time of
    the fall matters, not its end.
    """
    both = as_columns(find_fallen(one) & find_fallen(other), alpha)
    bound = np.where(both, alpha, np.inf)[..., None]
    ours, theirs = (np.clip(each["rotation"], -bound, bound) for each in (one, other))
    return _where_run(np.abs(ours - theirs).max(axis=-1), one, other)


def peak_gap(one: Response, other: Response) -> Array:
    """|Difference of the peak rotations| of two runs [rad]; infinite where one failed."""
    return _where_run(np.abs(one["peak_rotation"] - other["peak_rotation"]), one, other)


def peaks_apart(one: Response, other: Response) -> Array:
    """Differences of the peaks of two runs [rad], which may lie between two samples."""
    gaps = peak_gap(one, other)
    # If the blocks fall in both runs, the histories show when.
    return np.where(as_columns(find_fallen(one) & find_fallen(other), gaps), 0.0, gaps)


def find_branched_lanes(before: Array, after: Array, tolerance: float) -> Mask:
    """Stacks whose first two runs took different branches and the next two the same, shape [lane].

    That does not prove that the true motion takes this branch: a further run has to confirm it.

    Args:
        before: Difference of two runs / slenderness angle, NaN where it is not known.
        after: Difference of the finer of these and a still finer run / slenderness angle.
        tolerance: Difference that matters.
    """
    return np.asarray((before > tolerance) & (before > BRANCHES * after) & np.isfinite(before))


def slide_gap(one: Response, other: Response) -> Array:
    """Largest |difference| of the slides of two runs [m], that of the peaks or that at the end."""
    gaps = [np.abs(one[name] - other[name]) for name in ("peak_slide", "residual_slide")]
    return _where_run(np.maximum(*gaps), one, other)


def uplift_gap(one: Response, other: Response) -> Array:
    """|Difference of the uplift times| of two runs [s], shape [lane].

    Zero if neither lifts; infinite if only one does, or one failed.
    """
    ours, theirs = one["uplift_time"], other["uplift_time"]
    lifts, lifted = np.isfinite(ours), np.isfinite(theirs)
    apart = np.abs(np.where(lifts, ours, 0.0) - np.where(lifted, theirs, 0.0))
    return _where_run(np.where(lifts == lifted, apart, np.inf), one, other)


def uplift_error(response: Response, apart: Array, floor: Array) -> Array:
    """Estimated error of the uplift time [s], NaN of lanes that lift in no run, shape [lane].

    Args:
        response: The run whose uplift times count.
        apart: Error by the differences from other runs [s].
        floor: Error that all runs share [s].
    """
    never = np.isnan(response["uplift_time"]) & np.isfinite(apart)
    return np.where(usable(response) & ~never, apart + floor, np.nan)


def _where_run(values: Array, one: Response, other: Response) -> Array:
    return np.where(as_columns(usable(one) & usable(other), values), values, np.inf)


def largest(values: Array) -> Array:
    """Largest value of a lane's blocks, shape [lane]."""
    return np.asarray(values.reshape(len(values), -1).max(axis=1))


def as_columns(lanes: npt.NDArray[Any], like: Array) -> npt.NDArray[Any]:
    """Values of lanes in a shape that broadcasts with values of their blocks."""
    return lanes.reshape(-1, *[1] * (like.ndim - 1))
