"""Sampled records as motions of the base."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import ClassVar, Self

import numpy as np
import numpy.typing as npt

from warprock.model.lane_motion import (
    Array,
    LaneMotions,
    Lanes,
    Mask,
    MotionKind,
    Segment,
    no_acceleration,
)


@dataclasses.dataclass(frozen=True)
class RecordMotions(LaneMotions):
    """Sampled records, each lane following one of them, scaled.

    The samples of all records lie behind one another in a pool. Between two samples the
    acceleration is linear: acceleration[i] + slope[i] (t - t_i). The last sample of a record
    is an empty segment (zero acceleration and slope) that carries the final velocity.

    Attributes:
        start: Time at which the record starts [s], shape [lane].
        scale: Factor on the motion, shape [lane].
        offset: First sample of the lane's record in the pool, shape [lane].
        count: Samples of the lane's record, shape [lane].
        interval: Time between samples of the lane's record [s], shape [lane].
        velocity_step_start: Velocity step at the first sample [m/s], unscaled, shape [lane].
        velocity_step_stop: Velocity step at the last sample [m/s], unscaled, shape [lane].
        pool_acceleration: [m/s^2], shape [pool].
        pool_slope: [m/s^3], shape [pool].
        pool_velocity: Base velocity just after each sample [m/s], shape [pool].
    """

    start: Array
    scale: Array
    offset: npt.NDArray[np.int32]
    count: npt.NDArray[np.int32]
    interval: Array
    velocity_step_start: Array
    velocity_step_stop: Array
    pool_acceleration: Array
    pool_slope: Array
    pool_velocity: Array
    kind: ClassVar[MotionKind] = MotionKind.RECORD

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return len(self.start)

    @property
    def velocity_steps(self) -> tuple[Array, Array]:
        """Steps of the base velocity at the first and at the last sample [m/s]."""
        return self.scale * self.velocity_step_start, self.scale * self.velocity_step_stop

    @property
    def moves(self) -> Mask:
        """Whether the base moves at all."""
        return np.asarray(self.scale != 0.0)

    @property
    def end(self) -> Array:
        """Time from which on the base keeps its velocity [s]: its last sample."""
        last = self.start + (self.count - 1) * self.interval
        return np.where(self.moves, last, 0.0)

    @property
    def fastest_rate(self) -> float:
        """Rate at which the acceleration changes [rad/s]: it is linear between two samples."""
        return 0.0

    @property
    def shortest_period(self) -> Array:
        """Period of the fastest part of the waveform [s]: there is none."""
        return np.full(self.lane_count, np.inf)

    @property
    def knot_count(self) -> npt.NDArray[np.int32]:
        """Samples of the lane's record."""
        return self.count

    @property
    def knot_interval(self) -> Array:
        """Time between samples of the lane's record [s]."""
        return self.interval

    @property
    def pool(self) -> Array:
        """Samples of all records, shape [3, sample]: acceleration, slope, velocity."""
        return np.stack([self.pool_acceleration, self.pool_slope, self.pool_velocity])

    def take(self, lanes: Lanes) -> Self:
        """The motions of some lanes; the pool is shared."""
        names = [f.name for f in dataclasses.fields(self) if not f.name.startswith("pool_")]
        return dataclasses.replace(self, **{name: getattr(self, name)[lanes] for name in names})

    def compact(self) -> Self:
        """The same motions with a pool of the samples that they use, where that is half as large.

        A chunk of lanes follows few of the records of a large case, and its pool is copied.
        """
        offsets, of_lane = np.unique(self.offset, return_inverse=True)
        counts = np.zeros_like(offsets)
        np.maximum.at(counts, of_lane, self.count)
        if 2 * counts.sum() > len(self.pool_velocity):
            return self
        used = np.concatenate(
            [np.arange(at, at + n) for at, n in zip(offsets, counts, strict=True)]
        )
        ends = np.cumsum(counts)
        return dataclasses.replace(
            self,
            offset=(ends - counts)[of_lane].astype(np.int32),
            pool_acceleration=self.pool_acceleration[used],
            pool_slope=self.pool_slope[used],
            pool_velocity=self.pool_velocity[used],
        )

    @property
    def record_count(self) -> int:
        """Number of records that the lanes follow."""
        return len(np.unique(self.offset))

    def first_above(self, bound: Array) -> Array:
        """Time of the first sample of at least an acceleration [s], shape [lane].

        Args:
            bound: The acceleration [m/s^2], shape [lane].

        Returns:
            Infinite where there is none.
        """
        found = np.full(self.lane_count, np.inf)
        with np.errstate(divide="ignore"):
            asked = bound / np.abs(self.scale)
        by_record = np.argsort(self.offset, kind="stable")
        cuts = np.flatnonzero(np.diff(self.offset[by_record])) + 1
        for lanes in np.split(by_record, cuts):
            first, count = self.offset[lanes[0]], int(self.count[lanes].max())
            strongest = np.maximum.accumulate(np.abs(self.pool_acceleration[first : first + count]))
            index = np.searchsorted(strongest, asked[lanes])
            times = self.start[lanes] + index * self.interval[lanes]
            found[lanes] = np.where(index < self.count[lanes], times, np.inf)
        return found

    def scaled(self, factors: Array) -> Self:
        """The motions times a factor."""
        return dataclasses.replace(self, scale=self.scale * factors)

    def _index(self, times: Array, lane: int) -> npt.NDArray[np.intp]:
        position = (np.asarray(times) - self.start[lane]) / self.interval[lane]
        return np.asarray(np.clip(np.floor(position), 0, self.count[lane] - 1), dtype=np.intp)

    def acceleration(self, times: Array, lane: int) -> Array:
        """Acceleration of one lane's base [m/s^2] at times [s], without the velocity steps."""
        index = self._index(times, lane)
        tau = np.asarray(times) - self.start[lane] - index * self.interval[lane]
        at = self.offset[lane] + index
        value = self.pool_acceleration[at] + self.pool_slope[at] * tau
        return np.where(times < self.start[lane], 0.0, self.scale[lane] * value)

    def segments(self, lane: int) -> list[Segment]:
        """The motion of one lane, sample by sample."""
        offset, count = int(self.offset[lane]), int(self.count[lane])
        start, interval, scale = (float(a[lane]) for a in (self.start, self.interval, self.scale))
        parts = [] if start <= 0.0 else [Segment(0.0, start, 0.0, no_acceleration)]
        for index in range(count):
            begin = start + index * interval
            end = start + (index + 1) * interval if index < count - 1 else np.inf
            value = scale * float(self.pool_acceleration[offset + index])
            slope = scale * float(self.pool_slope[offset + index])
            step = 0.0
            if index == 0:
                step = scale * float(self.velocity_step_start[lane])
            elif index == count - 1:
                step = scale * float(self.velocity_step_stop[lane])

            def linear(
                time: float, begin: float = begin, value: float = value, slope: float = slope
            ) -> float:
                return value + slope * (time - begin)

            parts.append(Segment(begin, end, step, linear))
        return parts

    def _records(self) -> Iterator[tuple[npt.NDArray[np.intp], Array, Array]]:
        """The lanes of each record; accelerations at both ends of its segments, unscaled."""
        keys = np.stack([self.offset, self.count])
        records, of_lane = np.unique(keys, axis=1, return_inverse=True)
        for number, (offset, count) in enumerate(records.T):
            lanes = np.flatnonzero(of_lane.reshape(-1) == number)
            begin = self.pool_acceleration[offset : offset + count]
            slope = self.pool_slope[offset : offset + count]
            yield lanes, begin, begin + slope * self.interval[lanes[0]]

    def velocity_variation(self, duration: float) -> Array:
        """Upper bound of the total variation of the base velocity until a time [m/s], [lane]."""
        moved = np.zeros(self.lane_count)
        for lanes, begin, end in self._records():
            interval = self.interval[lanes]
            sizes = np.concatenate([[0.0], np.cumsum(0.5 * (np.abs(begin) + np.abs(end)))])
            passed = np.ceil((duration - self.start[lanes]) / interval)
            moved[lanes] = interval * sizes[np.clip(passed, 0, len(begin)).astype(int)]
        steps = np.abs(self.velocity_step_start) + np.abs(self.velocity_step_stop)
        return np.asarray(np.abs(self.scale) * (moved + steps))

    def acceleration_bound(self) -> Array:
        """The largest |acceleration| of the base [m/s^2], shape [lane]."""
        largest = np.zeros(self.lane_count)
        for lanes, begin, end in self._records():
            largest[lanes] = np.maximum(np.abs(begin), np.abs(end)).max()
        return np.asarray(largest * np.abs(self.scale))

    def later_acceleration(self, duration: Array | float) -> Array:
        """The largest |acceleration| of the base after a time [m/s^2], shape [lane].

        Infinite where a velocity step is left.
        """
        passed = np.floor((duration - self.start) / self.interval).astype(np.intp)
        first = self.offset + np.clip(passed, 0, self.count - 1)
        stop = (self.offset + self.count).astype(np.int64)
        _, spans, span = np.unique(
            first * (len(self.pool_acceleration) + 1) + stop, return_index=True, return_inverse=True
        )
        largest = np.array(
            [np.abs(self.pool_acceleration[first[at] : stop[at]]).max() for at in spans]
        )
        left = np.abs(self.scale) * largest[span]
        steps = (self.velocity_step_stop != 0.0) | (
            (self.velocity_step_start != 0.0) & (self.start > duration)
        )
        return np.where(self.end > duration, np.where(steps, np.inf, left), 0.0)
