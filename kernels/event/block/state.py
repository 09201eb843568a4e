"""State of a lane with one block in the plane, results of a step, and the observed response."""

import warp as wp

from warprock.kernels.lane.modes import FLAT, OVERTURNED, STALLED


@wp.struct
class State:
    """State of one lane, relative to its base.

    Attributes:
        theta: Clockwise rotation [rad].
        slide: Slide of the lower corner along the base [m].
        gap: Gap of the lower corner above it [m].
        vx, vz: Velocity of the centre of mass [m/s].
        omega: Angular velocity [rad/s].
        slip: Direction in which the corner slides, -1 or 1, or 0 where it sticks.
        mode: FLYING, PIVOTING, FLAT, or why the lane has ended.
        time: [s].
        segment: Knots of the motion passed.
        base: Velocity of the base [m/s].
        cap: Longest step allowed next time [s].
    """

    theta: real
    slide: real
    gap: real
    vx: real
    vz: real
    omega: real
    slip: real
    mode: int
    time: real
    segment: int
    base: real
    cap: real


@wp.struct
class Span:
    """A trial step, and the motion of the base in it.

    Attributes:
        d: Length [s].
        time: Its end [s].
        passed: Whether the end is a knot of the motion.
        a0, a1: Acceleration of the base at the start and at the end [m/s^2].
        dv: Change of its velocity between [m/s].
        kick: Step of its velocity at the end [m/s].
    """

    d: real
    time: real
    passed: bool
    a0: real
    a1: real
    dv: real
    kick: real


@wp.struct
class End:
    """A block at the end of a step, before an impact there.

    Attributes:
        theta, gap, vx, vz, omega, mode, slip: As of `State`.
        glide: Distance of the lower corner along the base in the step [m].
        lost: Energy lost to friction in the step per unit mass [J/kg].
        deep: Penetration before the block is put back on the base [m].
    """

    theta: real
    glide: real
    gap: real
    vx: real
    vz: real
    omega: real
    mode: int
    slip: real
    lost: real
    deep: real


@wp.struct
class Event:
    """Events inside a step or at its end.

    Attributes:
        missed: Whether an event lies inside the step.
        cut: Length of the step that ends at that event [s].
        falls: Whether the block falls on its other corner.
        lands: Whether its lower corner lands.
    """

    missed: bool
    cut: real
    falls: bool
    lands: bool


@wp.struct
class Shown:
    """What a step adds to the response.

    Attributes:
        taken: Whether the step was taken.
        hit: Whether it ended at an impact.
        apex: Turning point of theta, or of |theta|, inside the step [rad]; zero if there is none.
        apex_time: Time of that [s].
        lost: Energy lost per unit mass [J/kg].
        tail: Time of the impacts that the rest rule omits [s].
        deep: Penetration at the end before the block is put back on the base [m].
    """

    taken: bool
    hit: bool
    apex: real
    apex_time: real
    lost: real
    tail: real
    deep: real


@wp.struct
class Seen:
    """Observed response of a lane up to its time.

    Attributes:
        peak, peak_time: Largest |theta| [rad] and its time [s].
        peak_slide: Largest |slide| [m].
        uplift_time: Time at which the block first left its flat state [s], or NEVER.
        rest_time: Time at which it last came to rest [s]; NEVER while it moves.
        loss: Energy lost per unit mass [J/kg].
        deepest: Deepest penetration [m].
        impacts, steps: Their numbers.
    """

    peak: real
    peak_time: real
    peak_slide: real
    uplift_time: real
    rest_time: real
    loss: real
    deepest: real
    impacts: int
    steps: int


@wp.func
def start_seen(theta: real, flat: bool) -> Seen:
    """Observed response of a lane at its start, from its rotation [rad]; `flat` if at rest."""
    zero = real(0.0)
    lifted, rests = wp.where(flat, NEVER, zero), wp.where(flat, zero, NEVER)
    return Seen(size(theta), zero, zero, lifted, rests, zero, zero, 0, 0)


@wp.func
def is_at_rest(s: State) -> bool:
    """Whether a block lies on its base and does not slide."""
    lies, sticks = s.mode == FLAT, s.slip == real(0.0)
    return lies and sticks


@wp.func
def observe_peaks(n: State, apex: real, apex_time: real, seen: wp.ref[Seen]):
    """Updates the peaks with the end of a step and with a turning point |theta| inside it."""
    highest = larger(size(n.theta), apex)
    higher = highest > seen.peak
    seen.peak_time = wp.where(higher, wp.where(apex >= highest, apex_time, n.time), seen.peak_time)
    seen.peak = larger(highest, seen.peak)
    seen.peak_slide = larger(size(n.slide), seen.peak_slide)


@wp.func
def observe(
    going: bool, step_limit: int, still: bool, s: State, n: State, shown: Shown,
    seen: wp.ref[Seen],
) -> int:  # fmt: skip
    """Updates the response of a lane with a step from s to n; the mode of n.

    Args:
        going: Whether the lane took part in the step.
        step_limit: Largest number of steps, trials included.
        still: Whether the block has not moved in the step. A velocity step of the base then lifts
            it at the end; otherwise an acceleration has lifted it at the start.
        s, n: State before and after the step.
        shown: What the step adds to the response.
        seen: Observed response of the lane.
    """
    observe_peaks(n, size(shown.apex), shown.apex_time, seen)
    lay, goes, first = s.mode == FLAT, n.mode < FLAT, seen.uplift_time >= NEVER
    lifts = lay and goes and first
    lifted = wp.where(still, n.time, s.time)
    seen.uplift_time = wp.where(lifts, lifted, seen.uplift_time)
    rested = wp.where(is_at_rest(s), seen.rest_time, n.time + shown.tail)
    seen.rest_time = wp.where(is_at_rest(n), rested, NEVER)
    seen.loss = seen.loss + shown.lost
    seen.deepest = larger(shown.deep, seen.deepest)
    seen.impacts = seen.impacts + wp.where(shown.hit, 1, 0)
    seen.steps = seen.steps + wp.where(going, 1, 0)
    spent, runs = seen.steps >= step_limit, n.mode < OVERTURNED
    return wp.where(going and spent and runs, STALLED, n.mode)
