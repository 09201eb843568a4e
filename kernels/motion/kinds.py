"""Motion of the base.

Each kind defines the same functions: `knot_time` and `knot_step` (the time at which the motion
changes its formula, and the velocity step there), `expand` (Taylor coefficients of the acceleration
at a time) and `base_velocity`; all but a record also `velocity_at`, which needs no samples.
`segment` counts the knots passed: 0 before the motion starts. The struct `Motion` holds one lane.
Its fields are the attributes of the class of the same kind in warprock/model/motion.py.

The last arguments of `expand` are the acceleration of a record and its slope at the last knot, see
`ground_at`. `base_velocity` reads the samples of a record itself. The other kinds ignore both.
"""

from typing import Any

import warp as wp

from warprock.kernels.motion.pool import ACCELERATION, AHEAD, PEAK, SLOPE, VELOCITY

TWO_PI = real(6.283185307179586)
OVER_TWO_PI = real(0.5 / 3.141592653589793)
"""Turns per radian, 1 / (2 pi)."""
FLAT = real(44.0)
"""Exponent beyond which a Gaussian is zero to round-off; `decay` takes no more."""

LINEAR = MOTION in ("still", "record")
"""Whether the acceleration is linear between two knots, so that coefficients 2 to 8 are zero."""

if MOTION != "record":

    @wp.func
    def weak_samples_ahead(m: Any, segment: int, strongest: real, bound: real):
        """Whether samples may be passed at once: False without a record; a time without meaning."""
        return False, NEVER

    @wp.func
    def sample_index(m: Any, segment: int) -> int:
        """Place in the pool of the sample that the segment starts at: no record, no sample."""
        return 0


@wp.struct
class Acceleration:
    """Acceleration of the base about a time: ak is its k-th Taylor coefficient [m/s^(2 + k)]."""

    a0: real
    a1: real
    a2: real
    a3: real
    a4: real
    a5: real
    a6: real
    a7: real
    a8: real


@wp.struct
class Ground:
    """The sample of a record at which a segment starts.

    Attributes:
        value: Acceleration at the sample [m/s^2].
        slope: Its slope up to the next sample [m/s^3].
        strongest: Largest |acceleration| of the sample and the AHEAD after it [m/s^2].
    """

    value: real
    slope: real
    strongest: real


if LINEAR:

    @wp.func
    def acceleration_at(a: Acceleration, tau: real) -> real:
        """Acceleration a time tau later, before the next knot [m/s^2]."""
        return fused(tau, a.a1, a.a0)

else:

    @wp.func
    def acceleration_at(a: Acceleration, tau: real) -> real:
        """Acceleration a time tau later, before the next knot [m/s^2]."""
        high = fused(tau, fused(tau, fused(tau, fused(tau, a.a8, a.a7), a.a6), a.a5), a.a4)
        return fused(tau, fused(tau, fused(tau, fused(tau, high, a.a3), a.a2), a.a1), a.a0)


if MOTION == "still":

    @wp.struct
    class Motion:
        """A base that never starts to move."""

        start: real

    @wp.func
    def knot_time(m: Motion, segment: int) -> real:
        """Time of the next knot: never."""
        return NEVER

    @wp.func
    def knot_step(m: Motion, segment: int) -> real:
        """Velocity step at the next knot: none."""
        return real(0.0)

    @wp.func
    def expand(m: Motion, segment: int, time: real, value: real, slope: real) -> Acceleration:
        """Acceleration about a time: zero."""
        return Acceleration()

    @wp.func
    def velocity_at(m: Motion, time: real) -> real:
        """Velocity of the base: zero."""
        return real(0.0)


if MOTION not in ("still", "record"):

    @wp.func
    def lasts(m: Any, segment: int) -> real:
        """One while the motion lasts, else zero."""
        return wp.where(segment == 1, real(1.0), real(0.0))

    @wp.func
    def knot_time(m: Any, segment: int) -> real:
        """Time of the next knot: the start, the stop, never."""
        return wp.where(segment == 0, m.start, wp.where(segment == 1, m.stop, NEVER))

    @wp.func
    def knot_step(m: Any, segment: int) -> real:
        """Velocity step at the next knot."""
        return wp.where(segment == 0, m.velocity_step_start, m.velocity_step_stop)


if MOTION in ("harmonic", "modulated"):

    @wp.func
    def wave(w: real, a0: real, a1: real) -> Acceleration:
        """A harmonic acceleration, a'' = -w^2 a, from its first two Taylor coefficients."""
        # The reciprocals come first: the compiler folds two constants into one.
        q = -w * w
        a2 = a0 * (q * OVER_2)
        a3 = a1 * (q * (OVER_2 * OVER_3))
        a4 = a2 * (q * (OVER_3 * OVER_4))
        a5 = a3 * (q * (OVER_4 * OVER_5))
        a6 = a4 * (q * (OVER_5 * OVER_6))
        a7 = a5 * (q * (OVER_6 * OVER_7))
        a8 = a6 * (q * (OVER_7 * OVER_8))
        return Acceleration(a0, a1, a2, a3, a4, a5, a6, a7, a8)


if MOTION == "harmonic":

    @wp.struct
    class Motion:
        """A sine or cosine; see `HarmonicMotions`."""

        start: real
        stop: real
        velocity_step_start: real
        velocity_step_stop: real
        velocity_final: real
        frequency: real
        acceleration_amplitude: real
        phase: real
        velocity_offset: real

    @wp.func
    def expand(m: Motion, segment: int, time: real, value: real, slope: real) -> Acceleration:
        """Acceleration about a time."""
        w = TWO_PI * m.frequency
        s, c = cycle(fused(m.frequency, time - m.start, m.phase * OVER_TWO_PI))
        amplitude = m.acceleration_amplitude * lasts(m, segment)
        return wave(w, amplitude * s, amplitude * w * c)

    @wp.func
    def velocity_at(m: Motion, time: real) -> real:
        """Velocity of the base just after a time, with all velocity steps up to then."""
        w = TWO_PI * m.frequency
        _s, c = cycle(fused(m.frequency, time - m.start, m.phase * OVER_TWO_PI))
        moving = fused_less(m.acceleration_amplitude / w, c, m.velocity_offset)
        after = wp.where(time < m.stop, moving, m.velocity_final)
        return wp.where(time < m.start, real(0.0), after)


if MOTION == "ricker":

    @wp.struct
    class Motion:
        """A Ricker pulse; see `RickerMotions`."""

        start: real
        stop: real
        velocity_step_start: real
        velocity_step_stop: real
        velocity_final: real
        rate: real
        c0: real
        c1: real
        c2: real
        c3: real

    @wp.func
    def expand(m: Motion, segment: int, time: real, value: real, slope: real) -> Acceleration:
        """Acceleration about a time: P(x) exp(-x^2), P of degree 4."""
        r = m.rate
        x = r * (time - real(0.5) * (m.start + m.stop))
        # The Gaussian: E' = -2 x E.
        e0 = decay(smaller(x * x, FLAT)) * lasts(m, segment)
        e1 = real(-2.0) * x * e0
        e2 = -fused(x, e1, e0)
        e3 = real(-2.0) * OVER_3 * fused(x, e2, e1)
        e4 = real(-2.0) * OVER_4 * fused(x, e3, e2)
        e5 = real(-2.0) * OVER_5 * fused(x, e4, e3)
        e6 = real(-2.0) * OVER_6 * fused(x, e5, e4)
        e7 = real(-2.0) * OVER_7 * fused(x, e6, e5)
        e8 = real(-2.0) * OVER_8 * fused(x, e7, e6)
        # P = velocity' - 2 x velocity, shifted to x.
        k0 = m.c1
        k1 = real(2.0) * (m.c2 - m.c0)
        k2 = real(3.0) * m.c3 - real(2.0) * m.c1
        k3 = real(-2.0) * m.c2
        k4 = real(-2.0) * m.c3
        p0 = fused(x, fused(x, fused(x, fused(x, k4, k3), k2), k1), k0)
        p1 = fused(x, fused(x, real(4.0) * k4, real(3.0) * k3), real(2.0) * k2)
        p1 = fused(x, p1, k1)
        p2 = fused(x, fused(x, real(6.0) * k4, real(3.0) * k3), k2)
        p3 = fused(x, real(4.0) * k4, k3)
        p4 = k4
        r2 = r * r
        r3 = r2 * r
        r4 = r2 * r2
        a0 = r * p0 * e0
        a1 = r2 * fused(p0, e1, p1 * e0)
        a2 = r3 * fused(p0, e2, fused(p1, e1, p2 * e0))
        a3 = r4 * fused(p0, e3, fused(p1, e2, fused(p2, e1, p3 * e0)))
        a4 = r4 * r * fused(p0, e4, fused(p1, e3, fused(p2, e2, fused(p3, e1, p4 * e0))))
        a5 = r4 * r2 * fused(p0, e5, fused(p1, e4, fused(p2, e3, fused(p3, e2, p4 * e1))))
        a6 = r4 * r3 * fused(p0, e6, fused(p1, e5, fused(p2, e4, fused(p3, e3, p4 * e2))))
        a7 = r4 * r4 * fused(p0, e7, fused(p1, e6, fused(p2, e5, fused(p3, e4, p4 * e3))))
        a8 = r4 * r4 * r * fused(p0, e8, fused(p1, e7, fused(p2, e6, fused(p3, e5, p4 * e4))))
        return Acceleration(a0, a1, a2, a3, a4, a5, a6, a7, a8)

    @wp.func
    def velocity_at(m: Motion, time: real) -> real:
        """Velocity of the base just after a time."""
        x = m.rate * (time - real(0.5) * (m.start + m.stop))
        swing = fused(x, fused(x, fused(x, m.c3, m.c2), m.c1), m.c0)
        moving = swing * decay(smaller(x * x, FLAT))
        after = wp.where(time < m.stop, moving, m.velocity_final)
        return wp.where(time < m.start, real(0.0), after)


if MOTION == "modulated":

    @wp.struct
    class Motion:
        """A pulse of three harmonics; see `ModulatedMotions`."""

        start: real
        stop: real
        velocity_step_start: real
        velocity_step_stop: real
        velocity_final: real
        frequency: real
        modulation: real
        phase: real
        swing_1: real
        swing_2: real
        swing_3: real
        velocity_offset: real

    @wp.func
    def expand_swing(m: Motion, part: real, swing: real, time: real) -> Acceleration:
        """Acceleration of one harmonic about a time."""
        f = m.frequency * part
        w = TWO_PI * f
        s, c = cycle(fused(f, time - real(0.5) * (m.start + m.stop), m.phase * OVER_TWO_PI))
        return wave(w, -swing * w * s, swing * (-w * w) * c)

    @wp.func
    def add(a: Acceleration, b: Acceleration, c: Acceleration) -> Acceleration:
        """The sum of three accelerations."""
        return Acceleration(
            a.a0 + b.a0 + c.a0,
            a.a1 + b.a1 + c.a1,
            a.a2 + b.a2 + c.a2,
            a.a3 + b.a3 + c.a3,
            a.a4 + b.a4 + c.a4,
            a.a5 + b.a5 + c.a5,
            a.a6 + b.a6 + c.a6,
            a.a7 + b.a7 + c.a7,
            a.a8 + b.a8 + c.a8,
        )

    @wp.func
    def expand(m: Motion, segment: int, time: real, value: real, slope: real) -> Acceleration:
        """Acceleration about a time: the sum of three harmonics."""
        i = lasts(m, segment)
        one = real(1.0)
        first = expand_swing(m, one, i * m.swing_1, time)
        second = expand_swing(m, one + m.modulation, i * m.swing_2, time)
        third = expand_swing(m, one - m.modulation, i * m.swing_3, time)
        return add(first, second, third)

    @wp.func
    def swing_velocity(m: Motion, part: real, swing: real, time: real) -> real:
        """Velocity of one harmonic."""
        since = time - real(0.5) * (m.start + m.stop)
        _s, c = cycle(fused(m.frequency * part, since, m.phase * OVER_TWO_PI))
        return swing * c

    @wp.func
    def velocity_at(m: Motion, time: real) -> real:
        """Velocity of the base just after a time."""
        one = real(1.0)
        moving = m.velocity_offset + swing_velocity(m, one, m.swing_1, time)
        moving = moving + swing_velocity(m, one + m.modulation, m.swing_2, time)
        moving = moving + swing_velocity(m, one - m.modulation, m.swing_3, time)
        after = wp.where(time < m.stop, moving, m.velocity_final)
        return wp.where(time < m.start, real(0.0), after)


if MOTION == "record":

    @wp.struct
    class Motion:
        """A sampled record; see `RecordMotions`."""

        start: real
        scale: real
        offset: int
        count: int
        interval: real
        velocity_step_start: real
        velocity_step_stop: real

    @wp.func
    def knot_time(m: Motion, segment: int) -> real:
        """Time of the next sample; never after the last one."""
        return wp.where(segment < m.count, fused(real(segment), m.interval, m.start), NEVER)

    @wp.func
    def knot_step(m: Motion, segment: int) -> real:
        """Velocity step at the next sample; only the first and the last have one."""
        last = wp.where(segment == m.count - 1, m.velocity_step_stop, real(0.0))
        return m.scale * wp.where(segment == 0, m.velocity_step_start, last)

    @wp.func
    def between_samples(m: Motion, segment: int) -> bool:
        """Whether the segment lies between two samples and ends without a velocity step."""
        # Read before the `and`, which would branch around the read and prevent vector code.
        last = m.count - 1
        return segment > 0 and segment < last

    @wp.func
    def weak_samples_ahead(m: Motion, segment: int, strongest: real, bound: real):
        """Whether the next AHEAD samples are all weaker than a bound, and the time of the last.

        `strongest` is the largest |acceleration| of them, which the record holds at this sample.
        """
        last = segment + AHEAD - 1
        # Read before an `and`, as in `between_samples`.
        weak = size(m.scale) * strongest < bound
        far = knot_time(m, last)
        return between_samples(m, last) and segment > 0 and weak, far

    @wp.func
    def sample_index(m: Motion, segment: int) -> int:
        """Place in the pool of the sample that the segment starts at."""
        return m.offset + wp.where(segment > 0, segment - 1, 0)

    @wp.func
    def expand(m: Motion, segment: int, time: real, value: real, slope: real) -> Acceleration:
        """Acceleration about a time: linear between two samples."""
        zero = real(0.0)
        moving = wp.where(segment > 0, m.scale, zero)
        tau = time - fused(real(segment - 1), m.interval, m.start)
        a0 = moving * fused(slope, tau, value)
        return Acceleration(a0, moving * slope, zero, zero, zero, zero, zero, zero, zero)

    @wp.func
    def sample_segment(m: Motion, time: real) -> int:
        """Segment that a time lies in."""
        position = wp.floor((time - m.start) / m.interval)
        last = wp.where(position < real(m.count - 1), position, real(m.count - 1))
        return int(wp.where(last < real(0.0), real(-1.0), last)) + 1

    @wp.func
    def base_velocity(m: Motion, time: real, pool: wp.array2d(dtype=real)) -> real:
        """Velocity of the base just after a time: the integral from the last sample."""
        segment = sample_segment(m, time)
        place = sample_index(m, segment)
        tau = time - fused(real(segment - 1), m.interval, m.start)
        tau = wp.where(tau < m.interval, tau, m.interval)
        gain = fused(HALF * pool[SLOPE, place], tau, pool[ACCELERATION, place])
        moving = m.scale * fused(tau, gain, pool[VELOCITY, place])
        return wp.where(time < m.start, real(0.0), moving)

else:

    @wp.func
    def base_velocity(m: Motion, time: real, pool: wp.array2d(dtype=real)) -> real:
        """Velocity of the base just after a time."""
        return velocity_at(m, time)


@wp.func
def ground_at(m: Motion, segment: int, pool: wp.array2d(dtype=real)) -> Ground:
    """The sample of a record at which a segment starts; of other motions the pool has zeros."""
    place = sample_index(m, segment)
    return Ground(pool[ACCELERATION, place], pool[SLOPE, place], pool[PEAK, place])
