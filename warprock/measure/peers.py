"""Programs of others and plain loops beside ours: the same blocks, the same errors, one run.

A program or loop is there where its package is installed. MuJoCo and Bullet run one scene after the
other, as they have no batches on a CPU: one block of many costs there what a block alone does, and
more cores would share the time, not the CPU time. So does SciPy. Several settings of each
are tried with ever finer steps for as long as a budget of CPU time lasts; where it is short, those
go on that were best so far. What a program takes to build its scene, and a compiler to compile, is
not counted.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines import engine_class
from warprock.engines.launching import Form
from warprock.measure import bench, price
from warprock.measure.price import Trial
from warprock.model.lanes import Lanes
from warprock.model.motion import StillBase
from warprock.programs.loops import PlainLoop, numba_loop, scipy_loop
from warprock.programs.table import run_program
from warprock.settings.programs import BulletSettings, MujocoSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

PEERS = ("mujoco", "bullet")
"""Programs that are run, the fast ones: their names, and those of their extras."""

RATES = tuple(200.0 * 2**k for k in range(10))
"""Steps a second that they are tried with, from coarse to fine."""

KNOBS: dict[str, tuple[Any, ...]] = {
    "mujoco": (
        MujocoSettings(),
        *(MujocoSettings(damping_ratio=ratio) for ratio in (1.0, 4.0, 8.0)),
        *(MujocoSettings(contact_time=count) for count in (3.0, 4.0)),
        *(MujocoSettings(impedance=share) for share in (0.999, 0.99)),
        MujocoSettings(impedance=0.99, damping_ratio=4.0),
    ),
    "bullet": (
        BulletSettings(),
        BulletSettings(iterations=10),
        *(BulletSettings(breaking_threshold=gap) for gap in (1e-5, 1e-3)),
    ),
}
"""What else they are tried with, at each rate."""

BUDGET = 15.0
"""CPU time that a program may take, over the time of a measurement."""

LOOP_METHODS = ("RK45", "DOP853", "LSODA")
LOOP_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
"""What SciPy's loop is tried with."""

LOOP_STEPS = (0.4, 0.3, 0.2, 0.15, 0.1, 0.07, 0.05, 0.03, 0.02)
LOOP_LANES = 4096
"""Steps of Numba's loop [s], and blocks in a call of it."""

IN_SPACE = "impulse"
"""Engine whose steps in space are counted beside theirs."""


def compare(engines: Sequence[str], seconds: float) -> dict[str, Any]:
    """Tries our engines, and everything else that is installed.

    Args:
        engines: Names of ours.
        seconds: Time of a measurement of ours, about [s]; a program may take `BUDGET` times it.

    Returns:
        rows (`price.price_rows`), space (`space_row`), missing (one sentence for each that is not
        installed), tried (settings tried by name), took_s (wall time of all of it).
    """
    begin = time.perf_counter()
    trials = [trial for engine in engines for trial in price.own_trials(engine, seconds)]
    more: dict[str, Callable[[], list[Trial]]] = {
        **{name: functools.partial(peer_trials, name, BUDGET * seconds) for name in PEERS},
        "scipy loop": functools.partial(scipy_trials, seconds),
        "numba loop": functools.partial(numba_trials, seconds),
    }
    absent, tried = [], {}
    peers: list[Trial] = []
    for name, run in more.items():
        try:
            found = run()
        except ImportError as error:
            absent.append(str(error))
            continue
        tried[name] = len(found)
        peers += found
    rows = price.price_rows([*trials, *peers])
    space = space_row([trial for trial in peers if trial.name in PEERS], seconds)
    took = time.perf_counter() - begin
    return {"rows": rows, "space": space, "missing": absent, "tried": tried, "took_s": took}


def peer_trials(name: str, budget: float) -> list[Trial]:
    """Runs a program at ever finer steps.

    Each rate may take what leaves time for one setting at all finer ones, or, of a budget too small
    for that, its share. The settings of the least errors so far come first; those that would not
    fit are left out.

    Args:
        name: Name in `PEERS`.
        budget: CPU time of its steps [s].

    Raises:
        ImportError: It is not installed; one line that names the extra.
    """
    lanes = price.b0_lanes(price.STARTS)
    simulated = len(price.STARTS) * price.TIMES.duration
    trials: list[Trial] = []
    score = dict.fromkeys(range(len(KNOBS[name])), 0.0)
    spent, per_step = 0.0, 0.0
    for place, rate in enumerate(RATES):
        due = simulated * rate * per_step
        finer = simulated * sum(RATES[place + 1 :]) * per_step
        allowed = max(budget - finer, budget * (place + 1) / len(RATES))
        for number, knob in enumerate(sorted(score, key=lambda knob: score[knob])):
            if spent + due > (allowed if number else budget):
                break
            settings = dataclasses.replace(KNOBS[name][knob], steps_per_second=rate)
            answer = run_program(name, lanes, StillBase(len(price.STARTS)), price.TIMES, settings)
            errors = price.start_errors(answer.response["rotation"])
            error = float(np.median(errors))
            # The errors are below 1: one that was left out stays behind those that went on.
            score[knob] += math.log(error)
            trials.append(
                Trial(
                    name,
                    _text(settings),
                    error,
                    float(errors.max()),
                    answer.cost,
                    answer.cost,
                    answer.steps_per_s,
                )
            )
            spent += answer.cpu_s
            per_step = answer.cost / answer.steps_per_s
    return trials


def _text(settings: MujocoSettings | BulletSettings) -> str:
    """Settings in words: the rate, and what differs from the defaults."""
    default = type(settings)()
    words = [f"{settings.steps_per_second:g} steps/s"]
    for field in dataclasses.fields(settings):
        value = getattr(settings, field.name)
        if field.name != "steps_per_second" and value != getattr(default, field.name):
            words.append(f"{field.name} {value:g}")
    return ", ".join(words)


def _block() -> tuple[float, float, float]:
    """Slenderness angle [rad], squared frequency [1/s^2] and angular restitution of block B0."""
    lanes: Lanes = price.b0_lanes(price.STARTS[:1])
    radius = 0.5 * math.hypot(price.B0_WIDTH, price.B0_HEIGHT)
    square = 3.0 * GRAVITY / (4.0 * radius)
    return float(lanes.slenderness_angle[0]), square, float(lanes.angular_restitution[0])


def scipy_trials(seconds: float) -> list[Trial]:
    """The loop over `solve_ivp`, for as long as the budget lasts."""
    block, begin = _block(), time.process_time()
    trials: list[Trial] = []
    ends = np.array([0.0, price.TIMES.duration])
    for tolerance in LOOP_TOLERANCES:
        for method in LOOP_METHODS:
            if trials and time.process_time() - begin > seconds:
                return trials

            def rotations(times: Array, method: str = method, rtol: float = tolerance) -> Array:
                starts = block[0] * price.STARTS
                return np.array([scipy_loop(s, *block, method, rtol, times) for s in starts])

            errors = price.start_errors(rotations(price.TIMES.times))
            before = time.process_time()
            rotations(ends)
            cost = time.process_time() - before
            cost /= len(price.STARTS) * price.TIMES.duration
            text = f"{method}, tolerance {tolerance:g}"
            most = float(errors.max())
            trials.append(Trial("scipy loop", text, float(np.median(errors)), most, cost, cost))
    return trials


def numba_trials(seconds: float) -> list[Trial]:
    """The loop of Runge-Kutta steps, compiled by Numba; a call runs one block, or many.

    Raises:
        ImportError: Numba is not installed; one line that says how to install it.
    """
    loop = numba_loop()
    alone = 1 + int(100 * min(seconds, 1.0))
    return [_loop_trial(loop, step, LOOP_LANES, alone) for step in LOOP_STEPS]


def _loop_trial(loop: PlainLoop, step: float, lanes: int, calls: int) -> Trial:
    """One time step of the loop: its errors, and its costs by one call of many and many of one."""
    block = _block()
    seen = np.empty((len(price.STARTS), len(price.TIMES.times)))
    loop(block[0] * price.STARTS, *block, step, float(price.TIMES.interval or 0.0), seen)
    errors = price.start_errors(seen)
    starts = block[0] * np.linspace(price.STARTS[0], price.STARTS[-1], lanes)

    def cost(count: int, calls: int) -> float:
        picked = starts[lanes // 2 :][:1] if count == 1 else starts
        ends = np.empty((count, 2))
        begin = time.process_time()
        for _ in range(calls):
            loop(picked, *block, step, price.TIMES.duration, ends)
        return (time.process_time() - begin) / (count * calls * price.TIMES.duration)

    many = min(cost(lanes, 1) for _ in range(price.REPEATS))
    single = min(cost(1, calls) for _ in range(price.REPEATS))
    text, most = f"steps of {step:g} s", float(errors.max())
    return Trial("numba loop", text, float(np.median(errors)), most, many, single, 1.0 / step)


def space_row(trials: Sequence[Trial], seconds: float) -> dict[str, Any]:
    """Steps that a block in space takes in a CPU second, with ours and with each program.

    Args:
        trials: Of the programs.
        seconds: Time of the measurement of ours, about [s].
    """
    cost = bench.measure(IN_SPACE, seconds, form=Form.PACKED, spatial=True).cpu_s_per_simulated_s
    time_step: float = engine_class(IN_SPACE)().settings.time_step
    row: dict[str, Any] = {
        "engine": f"{IN_SPACE} in space",
        "block_steps_per_cpu_s": 1.0 / (cost * time_step),
    }
    for peer in dict.fromkeys(trial.name for trial in trials):
        best = max((t.steps_per_s or 0.0) / t.cost for t in trials if t.name == peer)
        row |= {peer: best, f"ratio to {peer}": row["block_steps_per_cpu_s"] / best}
    return row
