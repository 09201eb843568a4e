"""A block that rocks and slides, integrated by SciPy: a reference that shares no code with engines.

The block leans to +x or is seen from the other side. With its lower corner at (X, Z) from the
centre of mass, X = b cos(theta) - h sin(theta), Z = -b sin(theta) - h cos(theta), the corner's
velocity u along the base, the base's acceleration a and mass 1:

    f = u' - theta'' Z + theta'^2 X + a,  n = g + theta'' X + theta'^2 Z,  I theta'' = f Z - n X,

and u = 0 where the corner sticks, f = -sign(u) mu n where it slides. Each phase ends at its event:
the corner sticks (u = 0) or slips (|f| = mu n), the block comes down, the base steps its velocity.
A block that comes down is stopped by Coulomb's law at the corner that lands, or at both.
Friction is below 4/3, where a velocity step of the base acts on no corner at the base.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from tests.shared.blocks import Array
from warprock.units import GRAVITY

PIVOT, FLAT, FALLEN = "pivot", "flat", "fallen"
STILL = 1e-5
"""Angular velocity after an impact below which the block lies down [rad/s]."""


@dataclasses.dataclass
class State:
    """Phase of a block: side that it leans to, rotation on it, and its corner's sliding."""

    mode: str = FLAT
    side: float = 1.0
    theta: float = 0.0
    omega: float = 0.0
    u: float = 0.0
    slip: float = 0.0
    slide: float = 0.0


@dataclasses.dataclass(frozen=True)
class Case:
    """Half sizes [m], friction and a base: its acceleration by time and its steps (time, dv)."""

    b: float
    h: float
    mu: float
    acceleration: Callable[[float], float]
    steps: tuple[tuple[float, float], ...]

    @property
    def inertia(self) -> float:
        return (self.b**2 + self.h**2) / 3.0

    def corner(self, theta: float) -> tuple[float, float]:
        s, c = math.sin(theta), math.cos(theta)
        return self.b * c - self.h * s, -self.b * s - self.h * c

    def rates(self, slip: float, theta: float, omega: float, a: float) -> tuple[float, ...]:
        """theta'', u', n and f of a pivoting corner that sticks (slip 0) or slides."""
        x, z = self.corner(theta)
        weight = GRAVITY + omega**2 * z
        if slip == 0.0:
            alpha = (a * z - GRAVITY * x) / (self.inertia + x * x + z * z)
            return alpha, 0.0, weight + alpha * x, a - alpha * z + omega**2 * x
        arm = x + slip * self.mu * z
        alpha = -arm * weight / (self.inertia + x * arm)
        n = weight + alpha * x
        f = -slip * self.mu * n
        return alpha, f - a + alpha * z - omega**2 * x, n, f


def settled(case: Case, s: State, a: float) -> State:
    """The phase that a state begins under an acceleration of the base: it lifts, slips or stays."""
    if s.mode == PIVOT and s.slip == 0.0:
        _al, _du, n, f = case.rates(0.0, s.theta, s.omega, s.side * a)
        slips = abs(f) > case.mu * n
        return dataclasses.replace(s, slip=-math.copysign(1.0, f)) if slips else s
    if s.mode == PIVOT:
        return s
    tips = case.mu > case.b / case.h
    if s.slip == 0.0 and abs(a) > min(case.mu, case.b / case.h) * GRAVITY:
        towards = -math.copysign(1.0, a)
        if not tips:
            return dataclasses.replace(s, slip=towards)
        return settled(case, State(PIVOT, towards, slide=s.slide), a)
    if s.slip != 0.0 and tips:
        return State(PIVOT, s.slip, 0.0, 0.0, abs(s.u), 1.0, s.slide)
    return s


def kicked(s: State, dv: float) -> State:
    """The state after a velocity step of the base: what touches it slides."""
    u = s.u - (dv if s.mode == FLAT else s.side * dv)
    return dataclasses.replace(s, u=u, slip=float(np.sign(u)))


def landed(case: Case, s: State) -> State:
    """The state after the block has come down on its other corner."""
    b, h, mu, w = case.b, case.h, case.mu, 1.0 / case.inertia
    vx, vz, omega = -(s.u + s.omega * h), s.omega * b, -s.omega
    normal, along = vz - omega * b, vx - omega * h
    kn, kt, k = 1.0 + w * b * b, 1.0 + w * h * h, w * b * h
    n = (k * along - kt * normal) / (kn * kt - k * k)
    f = (k * normal - kn * along) / (kn * kt - k * k)
    slip = 0.0
    if abs(f) > mu * n:
        slip = -math.copysign(1.0, f)
        n = -normal / (kn - slip * mu * k)
        f = -slip * mu * n
    vx, vz1, omega1 = vx + f, vz + n, omega + w * (-f * h - n * b)
    if vz1 + b * omega1 < 0.0 or omega1 < STILL:
        # Both corners land: friction takes what it can of the sliding.
        free = -(s.u + s.omega * h)
        u = math.copysign(max(abs(free) - mu * abs(vz), 0.0), free)
        return State(FLAT, u=-s.side * u, slip=-s.side * np.sign(u), slide=s.slide)
    u = vx - omega1 * h if slip != 0.0 else 0.0
    return State(PIVOT, -s.side, 0.0, omega1, u, slip, s.slide)


def follow(
    case: Case, s: State, start: float, stop: float, at: Array
) -> tuple[State, float, Array]:
    """One phase: the state at its end, the time there and the rotations at the times `at`."""
    side = 1.0 if s.mode == FLAT else s.side

    def rhs(t: float, y: Array) -> list[float]:
        a = side * case.acceleration(t)
        if s.mode == FLAT:
            return [0.0, 0.0, -s.slip * case.mu * GRAVITY - a if s.slip else 0.0, y[2]]
        alpha, du, _n, _f = case.rates(s.slip, y[0], y[1], a)
        return [y[1], alpha, du, y[2]]

    def down(t: float, y: Array) -> float:
        return float(y[0]) if s.mode == PIVOT else 1.0

    def stops(t: float, y: Array) -> float:
        return float(s.slip * y[2]) if s.slip else 1.0

    def lets_go(t: float, y: Array) -> float:
        a = side * case.acceleration(t)
        if s.slip:
            return 1.0
        if s.mode == FLAT:
            return min(case.mu, case.b / case.h) * GRAVITY - abs(a)
        _al, _du, n, f = case.rates(0.0, y[0], y[1], a)
        return case.mu * n - abs(f)

    def over(t: float, y: Array) -> float:
        return float(y[0]) - 0.5 * math.pi

    events = [down, stops, lets_go, over]
    for event in events[:3]:
        event.direction = -1.0  # type: ignore[attr-defined]
    for event in events:
        event.terminal = True  # type: ignore[attr-defined]
    begin = [s.theta, s.omega, s.u, 0.0]
    found = solve_ivp(
        rhs, (start, stop), begin, method="DOP853", rtol=1e-10, atol=1e-13, events=events,
        dense_output=True, max_step=5e-3,
    )  # fmt: skip
    t = float(found.t[-1])
    y = found.y[:, -1]
    inside = at[(at >= start) & (at < t)]
    rotations = side * found.sol(inside)[0] if len(inside) else np.zeros(0)
    end = dataclasses.replace(
        s, theta=float(y[0]), omega=float(y[1]), u=float(y[2]), slide=s.slide + side * float(y[3])
    )
    if len(found.t_events[3]):
        end = dataclasses.replace(end, mode=FALLEN)
    elif len(found.t_events[0]):
        end = landed(case, end)
    elif len(found.t_events[1]):
        end = dataclasses.replace(end, u=0.0, slip=0.0)
    elif len(found.t_events[2]):
        # A hair beyond its bound, for the force to tell what gives way.
        end = settled(case, end, (1.0 + 1e-9) * case.acceleration(t))
        if s.mode == PIVOT and end.slip == 0.0:
            _al, _du, _n, f = case.rates(0.0, end.theta, end.omega, side * case.acceleration(t))
            end = dataclasses.replace(end, slip=-math.copysign(1.0, f))
    return end, t, np.asarray(rotations)


def between_knots(case: Case, begin: float, end: float) -> Case:
    """The case with the acceleration of the base on one side of its knots, where it jumps."""
    hair = 1e-12

    def acceleration(t: float) -> float:
        return case.acceleration(min(max(t, begin + hair), end - hair))

    return dataclasses.replace(case, acceleration=acceleration)


def motion(case: Case, at: Array) -> tuple[Array, float]:
    """Rotations at rising times [rad] of a block that lies flat at 0, and its largest slide [m].

    After the block has fallen its rotation stays where it was then.
    """
    state, time, peak, phases = State(), 0.0, 0.0, 0
    rotations: list[float] = []
    knots = [*case.steps, (float(at[-1]) + 1e-9, 0.0)]
    for until, dv in knots:
        part_of = between_knots(case, time, until)
        while time < until and state.mode != FALLEN:
            state = settled(part_of, state, part_of.acceleration(time))
            state, time, part = follow(part_of, state, time, until, at)
            rotations.extend(part)
            peak = max(peak, abs(state.slide))
            phases += 1
            assert phases < 1000, "the block makes no headway"
        if state.mode != FALLEN and dv != 0.0:
            state = kicked(state, dv)
    rotations.extend([state.side * state.theta] * (len(at) - len(rotations)))
    return np.array(rotations), peak
