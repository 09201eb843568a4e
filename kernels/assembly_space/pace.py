"""How the solve of a step of an assembly in space goes from sweep to sweep.

A sweep takes all contacts one after the other (projected Gauss-Seidel). Between sweeps impulses and
velocities go on along their last change (Nesterov 1983, A method of solving a convex programming
problem with convergence rate O(1/k^2), *Soviet Mathematics Doklady* 27): with p what impulses have
changed by from the end of one sweep to the end of the next, and d what the latter changed,

    p = beta p + d,   impulses + beta p,      beta = k / (k + 3)

k sweeps after the last start. It starts again where |d|^2 is `GROWN` times its least in the step
(adaptive restart: O'Donoghue and Candes 2015, *Foundations of Computational Mathematics* 15). |d|^2
grows for a while wherever going on does any good: with 1 in place of 10 a wall of 60 bricks took
1.4 to 3 times as many sweeps. In a lane with friction above `STEEP` it is 1 nevertheless for the
first `LONG` sweeps: there N that overshoots takes (T, S) with it, to another of the answers that an
impact has.

Whether a step is settled is told by p: where impulses go on evenly, d may be a fiftieth of it.

A solve that is not settled after `LATE` sweeps goes on by plain sweeps, for as many, and so on in
turn: where friction is above 1 and blocks wedge one another in, long ways may lead in circles. In a
lane that moves, these take a part of each change of (T, S) where friction is above 1: 1 / 2 after
EASY of them, 1 / 3 after twice as many, and so on (under-relaxation, see assembly/solve.py). What
is left is the whole change in either case.
"""

import warp as wp

GROWN = real(10.0)
"""Growth of |d|^2 over its least from which on impulses start again."""

STANDS, CLOSE = real(10.0), real(0.1)
"""Speed of the fastest corner over the bound of a step below which a lane stands, and its bound
there over that of what moves. Where forces are not unique a step that is not solved lets a stone
slide, and forces follow its slide: at the bound of what moves, loose stones of a portal came
forward by up to 1.4 mm at half the load at which it falls (at 0.3 of it one in ten still did)."""

MOST_KEPT = real(0.98)
"""The largest beta."""

LATE, EASY = 200, real(20.0)
"""Sweeps after which a solve goes on by plain sweeps, and those of them that halve what is taken of
a change of (T, S)."""

LONG, LOOSE, SHARE = 50, real(10.0), real(1.0e-2)
"""Sweeps after which a step of the run may leave so many times its bound, or this share of the
fastest corner's speed. Two in ten come there of a wall that a steady push has near its limit, seven
in ten of bricks under a sine. Where blocks that slide and fall wedge one another in, sweeps go on
in circles, or impulses grow without end; the length of the step is a larger error there: what
touches late by a step has moved by all of it."""

STRICT = 100
"""The same where a friction of the lane is above `STEEP`: what an impact leaves there may turn a
column about its upright, and corners of one edge then land one after the other."""


@wp.struct
class Solve:
    """How far the solve of a lane has come.

    Attributes:
        goes: 1 while it is not settled, else 0.
        steep: See `start_solve`.
        bound: Velocity below which it is settled, a tenth in a lane that stands [m/s].
        sweeps: Sweeps of this step.
        age: Sweeps since impulses started again.
        beta: Part of p by which they go on.
        eased: Part of a change of (T, S) that is taken where friction is above 1.
        worst: Largest change of the velocity of a contact since the last sweep [m/s].
        square: |d|^2 of this sweep [J].
        least: Its least in this step.
        left: `worst` of the last sweep [m/s].
        loose: What may be left after `LONG` sweeps, in a steep lane after `STRICT` [m/s].
    """

    goes: int
    steep: int
    bound: real
    sweeps: int
    age: int
    beta: real
    eased: real
    worst: real
    square: real
    least: real
    left: real
    loose: real


@wp.func
def start_solve(live: int, steep: int, bound: real, speed: real) -> Solve:
    """A solve before its first sweep.

    Args:
        live: 1 in the run, 0 in a solve before it.
        steep: 1 where a friction of the lane is above `STEEP`, else 0.
        bound: Velocity below which it is settled [m/s].
        speed: Largest speed of a corner in the lane [m/s].
    """
    solve = Solve()
    solve.goes = 1
    solve.steep = steep
    solve.eased = real(1.0)
    solve.bound = wp.where(live > 0 and speed < STANDS * bound, CLOSE * bound, bound)
    solve.loose = wp.where(live > 0, larger(LOOSE * solve.bound, SHARE * speed), bound)
    return solve


@wp.func
def decide(most: int, solve: wp.ref[Solve]):
    """Whether a lane sweeps on, and how, after a sweep.

    Args:
        most: Most sweeps of a step.
        solve: Its solve.
    """
    zero = real(0.0)
    steep = solve.steep > 0
    left = wp.where(solve.sweeps < wp.where(steep, STRICT, LONG), solve.bound, solve.loose)
    goes = solve.worst > left and solve.sweeps + 1 < most
    solve.least = wp.where(solve.sweeps == 0, solve.square, smaller(solve.square, solve.least))
    growth = wp.where(steep and solve.sweeps < LONG, real(1.0), GROWN)
    grown = solve.square > growth * solve.least
    solve.age = wp.where(grown or solve.sweeps == 0, 0, solve.age + 1)
    age = real(solve.age)
    kept = smaller(age / (age + real(3.0)), MOST_KEPT)
    turn = solve.sweeps % (2 * LATE) - LATE
    plain = turn >= 0
    solve.eased = EASY / (EASY + real(wp.where(plain and solve.loose > solve.bound, turn, 0)))
    solve.beta = wp.where(goes and not plain, kept, zero)
    solve.goes = wp.where(goes, 1, 0)
    solve.sweeps += 1
    solve.left = solve.worst
    solve.worst = zero
    solve.square = zero
