"""Where a base is, and how fast, at any time: what a shake table follows.

Engines of ours follow the acceleration of a base and the steps of its velocity; programs of others
move a table through places, and pictures show where the base is. Displacements are integrals, in
closed form where one is written here: they are zero until the motion starts, and after its end the
base keeps its velocity. A velocity at a knot is that after it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from warprock.model.loads import LoadMotions
from warprock.model.motion import (
    GroundMotions,
    HarmonicMotions,
    ModulatedMotions,
    PlanarMotions,
    RecordMotions,
    RickerMotions,
    StillBase,
)
from warprock.model.pulse import PulseMotions

Array = npt.NDArray[np.float64]
Path = Callable[[Array], tuple[Array, Array]]
"""Times [s] -> displacements [m] and velocities [m/s] of one direction, shape [time]."""


@dataclasses.dataclass(frozen=True)
class BasePath:
    """The motion of one lane's base.

    Attributes:
        paths: Paths along x, y and z; None along a direction in which the base does not move.
    """

    paths: tuple[Path | None, Path | None, Path | None]

    def displacement(self, times: Array) -> Array:
        """Displacements since the start [m], shape [time, 3]."""
        return self._part(times, 0)

    def velocity(self, times: Array) -> Array:
        """Velocities [m/s], shape [time, 3]; at a velocity step that after it."""
        return self._part(times, 1)

    def _part(self, times: Array, part: int) -> Array:
        still = np.zeros_like(times)
        return np.stack([p(times)[part] if p else still for p in self.paths], axis=-1)


def base_path(motions: GroundMotions, lane: int) -> BasePath | None:
    """The motion of one lane's base; None if it stands still.

    Of a load it is that of the level base which acts on blocks alike.
    """
    parts = zip(motions.axes, motions.components, strict=True)
    paths = {axis: _path(part, lane) for axis, part in parts}
    x, y, z = (paths.get(axis) for axis in "xyz")
    return BasePath((x, y, z)) if x or y or z else None


def base_places(motions: GroundMotions, lane: int, times: Array) -> Array:
    """Displacements of one lane's base since the start [m], shape [time, 3]; of a load none."""
    loaded = any(isinstance(part, LoadMotions) for part in motions.components)
    path = None if loaded else base_path(motions, lane)
    return path.displacement(times) if path else np.zeros((len(times), 3))


def _path(motions: PlanarMotions, lane: int) -> Path | None:
    if isinstance(motions, StillBase):
        return None
    if isinstance(motions, RecordMotions):
        return _record_path(motions, lane)
    if isinstance(motions, HarmonicMotions):
        inside = _harmonic_path(motions, lane)
    elif isinstance(motions, ModulatedMotions):
        inside = _modulated_path(motions, lane)
    elif isinstance(motions, RickerMotions):
        inside = _ricker_path(motions, lane)
    else:
        assert isinstance(motions, PulseMotions)
        inside = integrated_path(motions, lane)
    start, stop = float(motions.start[lane]), float(motions.stop[lane])
    final = float(motions.velocity_final[lane])

    def path(times: Array) -> tuple[Array, Array]:
        place, velocity = inside(np.clip(times, start, stop))
        after = times >= stop
        place = place + np.where(after, final * (times - stop), 0.0)
        velocity = np.where(after, final, np.where(times < start, 0.0, velocity))
        return place, velocity

    return path


def _harmonic_path(motions: HarmonicMotions, lane: int) -> Path:
    """Path between the start and the stop: twice the integral of a sin(w tau + phase)."""
    start, w = float(motions.start[lane]), 2.0 * math.pi * float(motions.frequency[lane])
    amplitude, phase = float(motions.acceleration_amplitude[lane]), float(motions.phase[lane])
    offset = float(motions.velocity_offset[lane])

    def path(times: Array) -> tuple[Array, Array]:
        tau = times - start
        angle = w * tau + phase
        place = offset * tau - amplitude / w**2 * (np.sin(angle) - math.sin(phase))
        return place, offset - amplitude / w * np.cos(angle)

    return path


def _modulated_path(motions: ModulatedMotions, lane: int) -> Path:
    """Path between the start and the stop: the integral of three cosines."""
    start, stop = float(motions.start[lane]), float(motions.stop[lane])
    f, m = float(motions.frequency[lane]), float(motions.modulation[lane])
    phase, offset = float(motions.phase[lane]), float(motions.velocity_offset[lane])
    swings = [float(s[lane]) for s in (motions.swing_1, motions.swing_2, motions.swing_3)]
    waves = [
        (swing, 2.0 * math.pi * f * part)
        for swing, part in zip(swings, (1.0, 1.0 + m, 1.0 - m), strict=True)
    ]

    def integral(tau: Array) -> Array:
        parts = [swing / w * np.sin(w * tau + phase) for swing, w in waves]
        return np.asarray(offset * tau + sum(parts))

    def path(times: Array) -> tuple[Array, Array]:
        tau = times - 0.5 * (start + stop)
        parts = [swing * np.cos(w * tau + phase) for swing, w in waves]
        place = integral(tau) - integral(np.asarray(0.5 * (start - stop)))
        return place, np.asarray(offset + sum(parts))

    return path


def _ricker_path(motions: RickerMotions, lane: int) -> Path:
    """Path between the start and the stop: the integral of a cubic times exp(-x^2).

    The integrals of exp(-x^2), x exp(-x^2), x^2 exp(-x^2) and x^3 exp(-x^2) are E, -e/2,
    (E - x e)/2 and -(1 + x^2) e/2, where e = exp(-x^2) and E = sqrt(pi)/2 erf(x).
    """
    start, stop, rate = (float(part[lane]) for part in (motions.start, motions.stop, motions.rate))
    c0, c1, c2, c3 = (float(c[lane]) for c in (motions.c0, motions.c1, motions.c2, motions.c3))

    def integral(x: Array) -> Array:
        e, area = np.exp(-x * x), 0.5 * math.sqrt(math.pi) * np.vectorize(math.erf)(x)
        parts = c0 * area - 0.5 * c1 * e + 0.5 * c2 * (area - x * e) - 0.5 * c3 * (1.0 + x * x) * e
        return np.asarray(parts / rate)

    def path(times: Array) -> tuple[Array, Array]:
        x = rate * (times - 0.5 * (start + stop))
        first = np.asarray(-0.5 * rate * (stop - start))
        velocity = (c0 + x * (c1 + x * (c2 + x * c3))) * np.exp(-x * x)
        return integral(x) - integral(first), velocity

    return path


NODES = 4001
"""Times at which the acceleration of a waveform without a closed form is integrated: of ten cycles
400 a cycle, whose displacement then errs by less than 1e-9 of its size (Simpson's rule)."""


def integrated_path(motions: PulseMotions, lane: int) -> Path:
    """Path between the start and the stop: the acceleration, integrated twice by Simpson's rule."""
    from scipy.integrate import cumulative_simpson
    from scipy.interpolate import CubicHermiteSpline

    times = np.linspace(float(motions.start[lane]), float(motions.stop[lane]), NODES)
    pull = motions.acceleration_inside(times, lane)
    begun = float(motions.velocity_step_start[lane])
    speeds = begun + cumulative_simpson(pull, x=times, initial=0.0)
    places = cumulative_simpson(speeds, x=times, initial=0.0)
    place = CubicHermiteSpline(times, places, speeds)
    velocity = CubicHermiteSpline(times, speeds, pull)
    return lambda at: (np.asarray(place(at)), np.asarray(velocity(at)))


def _record_path(motions: RecordMotions, lane: int) -> Path:
    """Path of a record: a cubic between its samples, from the velocities just after them."""
    start, scale, interval = (
        float(part[lane]) for part in (motions.start, motions.scale, motions.interval)
    )
    count = int(motions.count[lane])
    pool = slice(int(motions.offset[lane]), int(motions.offset[lane]) + count)
    acceleration, slope = motions.pool_acceleration[pool], motions.pool_slope[pool]
    speed = motions.pool_velocity[pool]

    def within(index: npt.NDArray[np.intp], tau: Array) -> tuple[Array, Array]:
        a, s = acceleration[index], slope[index]
        moved = tau * (speed[index] + tau * (a / 2.0 + tau * s / 6.0))
        return moved, speed[index] + tau * (a + tau * s / 2.0)

    moved = within(np.arange(count - 1), np.full(count - 1, interval))[0]
    places = np.concatenate([[0.0], np.cumsum(moved)])

    def path(times: Array) -> tuple[Array, Array]:
        position = (times - start) / interval
        index = np.asarray(np.clip(np.floor(position), 0, count - 1), dtype=np.intp)
        tau = np.maximum(times - start - index * interval, 0.0)
        moved, velocity = within(index, tau)
        before = times < start
        place = np.where(before, 0.0, places[index] + moved)
        return scale * place, np.where(before, 0.0, scale * velocity)

    return path
