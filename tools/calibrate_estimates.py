"""Holds the error estimates of lanes against the truth, and writes the factors that they need.

    python tools/calibrate_estimates.py -o cases/estimate/calibration.csv

Three sets of lanes are drawn from a seed: blocks let go, pulses (sines and cosines of one to three
cycles under displacement, velocity and acceleration control), and the six shipped records. Their
friction is .3 to 1.3, so that many slide. Every engine with an order in the step runs them at its
default settings with `run_to_tolerance` at the default tolerance. The truth is `event` at steps of
2e-5 s, but for `dem`, which answers its own springs, itself at 1/32 of its step. A lane is left out
where that still differs from its run at a longer step (1e-4 s, 1/16) by more than 1e-3 of the
slenderness angle, for its true answer is not known; where its block falls; and where its status is
not `ok`.

An estimate is a factor times what two runs tell, and a floor. The floor is set: `FLOORS` says why.
The factor is the least of `LADDER` with which, of the lanes of the first seed, `AIM` have an error
within their estimate, in every set that shares the factor (free lanes and pulses do). A factor
changes what is run again, so lanes of the second seed then run with the factors found: their
coverage is what the table says. It takes some five minutes on two cores.
"""

from __future__ import annotations

import argparse
import dataclasses
import datetime
import pathlib
from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt
import pandas as pd
from calibration_lanes import Problem, free, pulses, records

from warprock.engines import ENGINES, engine_class
from warprock.engines.workload import FINEST_STEPS
from warprock.model.response import Outcome, Response, Status
from warprock.running import calibration, options
from warprock.running.batch import run_batch
from warprock.running.calibration import PLAIN, QUANTITIES, Factor
from warprock.running.companions import halve_step
from warprock.running.devices import start_warp
from warprock.running.tolerance import run_to_tolerance
from warprock.settings.engines import SETTINGS, EventSettings

Array = npt.NDArray[np.float64]

Key = tuple[str, str, str]

SEEDS = (20, 21)
"""Of the lanes that factors are fitted to, and of those that they are held against."""

TRUE_STEP, CHECKED_STEP = 2e-5, 1e-4
TRUE_HALVINGS, CHECKED_HALVINGS = 5, 4
"""Steps of `event` [s], and halvings of that of `dem`: of the truth, and to see if it is known."""

KNOWN = 1e-3
"""Difference of the two, over the slenderness angle, above which the truth is not known."""

ROUND_OFF = 1e-7
"""Error over the slenderness angle, or over the width, that counts as none: round-off and the rest
rules' leavings."""

AIM = {"free": 0.97, "pulses": 0.97, "records": 0.98}
"""Share of lanes that a factor has to cover, so that others are covered at 95 %: the more where few
are judged."""

LADDER = (1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)

ROTATION_FLOOR = 5e-4
"""Of first-order engines under records: swings shorter than a few steps, of a block that barely
lifts, are missed by all runs alike. So they are in `dem`, whose springs give way as far."""

SLIDE_FLOOR = 5e-3
"""Of `event`: a slip that ends within the step, as after a velocity step of the base, is walked in
one go whatever the step is, and errs by a few parts in a thousand."""

DEM_LANES = 100
"""Lanes of a set that `dem` runs. Under records it has none whose true answer is known."""


def largest_difference(one: Response, other: Response) -> Array:
    """Largest |difference of the rotations| over the run [rad], shape [lane]."""
    return np.asarray(np.abs(one["rotation"] - other["rotation"]).max(axis=-1))


def stands(response: Response) -> npt.NDArray[np.bool_]:
    """Lanes whose block has not fallen."""
    return np.asarray(~np.isin(response["outcome"], (Outcome.OVERTURNED, Outcome.SLID_OFF)))


@dataclasses.dataclass(frozen=True)
class Truth:
    """What lanes truly do, and whether that is known, shape [lane]."""

    problem: Problem
    response: Response
    known: npt.NDArray[np.bool_]
    decided: npt.NDArray[np.bool_]

    @classmethod
    def of(cls, engine: str, problem: Problem) -> Truth:
        """The truth that an engine is held against."""
        if engine == "dem":
            problem = problem.first(DEM_LANES)
            default = SETTINGS["dem"]()
            fine = [halve_step(default, count) for count in (TRUE_HALVINGS, CHECKED_HALVINGS)]
        else:
            engine = "event"
            fine = [EventSettings(time_step=step) for step in (TRUE_STEP, CHECKED_STEP)]
        lanes, motions, times = problem.lanes, problem.motions, problem.times
        truth, checked = (
            run_batch(engine, lanes, motions, times, settings=settings, most_steps=FINEST_STEPS)
            for settings in fine
        )
        near = largest_difference(truth, checked) <= KNOWN * lanes.slenderness_angle
        known = near & stands(truth) & (truth["status"] == Status.OK)
        return cls(problem, truth, known, stands(truth) == stands(checked))


@dataclasses.dataclass(frozen=True)
class Judged:
    """Lanes with an estimate beside their true errors."""

    truth: Truth
    response: Response

    @property
    def ok(self) -> npt.NDArray[np.bool_]:
        """Lanes that are judged."""
        return self.truth.known & stands(self.response) & (self.response["status"] == Status.OK)

    def size(self, quantity: str) -> Array:
        """What an error is small beside."""
        lanes = self.truth.problem.lanes
        return lanes.width if quantity == "peak_slide_error" else lanes.slenderness_angle

    def error(self, quantity: str) -> Array:
        """True errors; zero where they are round-off."""
        if quantity == "rotation_error":
            found = largest_difference(self.response, self.truth.response)
        else:
            name = quantity.removesuffix("_error")
            found = np.abs(self.response[name] - self.truth.response[name])
        return np.where(found <= ROUND_OFF * self.size(quantity), 0.0, found)

    def covered(self, quantity: str, used: Factor, tried: Factor) -> float:
        """Share of the lanes whose error lies within the estimate.

        Args:
            quantity: Name of the estimate.
            used: What the estimate was made with.
            tried: What it is to be made with.
        """
        estimate = self.response[quantity]
        if tried != used:
            sliding = quantity == "peak_slide_error"
            base = self.response["peak_slide"] if sliding else self.size(quantity)
            bare = np.maximum(estimate - used.floor * base, 0.0) / used.factor
            estimate = tried.factor * bare + tried.floor * base
        return float(np.mean((self.error(quantity) <= estimate)[self.ok]))


SETS: Mapping[str, Callable[[np.random.Generator], Problem]] = {
    "free": free,
    "pulses": pulses,
    "records": records,
}


def with_order(name: str) -> list[str]:
    """The engines that are judged on a set."""
    found = [engine for engine in ENGINES if engine_class(engine).order is not None]
    return [engine for engine in found if (name, engine) != ("records", "dem")]


def truths(seed: int) -> dict[tuple[str, str], Truth]:
    """(Set, engine) -> what its lanes truly do."""
    found = {}
    for index, (name, make) in enumerate(SETS.items()):
        problem = make(np.random.default_rng([seed, index]))
        one = Truth.of("event", problem)
        for engine in with_order(name):
            found[name, engine] = Truth.of(engine, problem) if engine == "dem" else one
        print(f"seed {seed}, {name}: {len(one.known)} lanes, the truth of {one.known.sum()} known")
    return found


def judge(
    known: Mapping[tuple[str, str], Truth], table: dict[Key, Factor]
) -> dict[tuple[str, str], Judged]:
    """(Set, engine) -> lanes with the estimates that the factors of a table give."""
    calibration.shipped_factors = lambda: table  # type: ignore[assignment]
    found = {}
    for (name, engine), truth in known.items():
        problem = truth.problem
        response = run_to_tolerance(engine, problem.lanes, problem.motions, problem.times)
        found[name, engine] = Judged(truth, response)
    return found


def floor(name: str, engine: str, quantity: str) -> float:
    """The floor of an estimate."""
    if quantity == "peak_slide_error":
        return SLIDE_FLOOR if engine == "event" else 0.0
    return ROTATION_FLOOR if name == "records" and engine != "event" else 0.0


def plain_table() -> dict[Key, Factor]:
    """Factors to begin with."""
    return {
        (name, engine, quantity): Factor(PLAIN, floor(name, engine, quantity))
        for name in SETS
        for engine in with_order(name)
        for quantity in QUANTITIES
    }


def fitted(found: Mapping[tuple[str, str], Judged], table: dict[Key, Factor]) -> dict[Key, Factor]:
    """The table with the least factors that cover what they have to."""
    new = {}
    for name, engine, quantity in table:
        alike = ["records"] if name == "records" else ["free", "pulses"]
        for factor in LADDER:
            tried = Factor(factor, table[name, engine, quantity].floor)
            shares = [
                found[other, engine].covered(quantity, table[other, engine, quantity], tried)
                for other in alike
            ]
            if min(shares) >= AIM[name]:
                break
        new[name, engine, quantity] = tried
    return new


def as_rows(found: Mapping[tuple[str, str], Judged], table: Mapping[Key, Factor]) -> pd.DataFrame:
    """Factors with the coverage that they gave."""
    rows = []
    for (name, engine, quantity), used in table.items():
        judged = found[name, engine]
        response, truth = judged.response, judged.truth
        erring = judged.ok & (judged.error(quantity) > 0.0)
        excess = pd.Series(response[quantity][erring] / judged.error(quantity)[erring])
        alpha = truth.problem.lanes.slenderness_angle
        met = judged.ok & (response["rotation_error"] <= options.TOLERANCE * alpha)
        off = judged.error("rotation_error") > options.TOLERANCE * alpha
        wrong = truth.decided & (stands(response) != stands(truth.response))
        steps = float(response["total_step_count"].sum() / response["first_step_count"].sum())
        rows.append(
            {
                "set": name,
                "engine": engine,
                "quantity": quantity,
                "factor": used.factor,
                "floor": used.floor,
                "lanes": int(judged.ok.sum()),
                "covered": judged.covered(quantity, used, used),
                "excess": excess.median(),
                "met": int(met.sum()),
                "met_but_off": int((met & off).sum()),
                "wrong_outcome": int((wrong & (response["status"] == Status.OK)).sum()),
                "steps": steps,
            }
        )
    return pd.DataFrame(rows)


COLUMNS = {
    "set": "lanes that it was held against; factors of free lanes and pulses are the same",
    "engine": "engine, default settings",
    "quantity": "estimate",
    "factor": "on the extrapolated difference of two runs",
    "floor": "added, over the slenderness angle, or over the peak slide for slides",
    "lanes": "lanes judged: status ok, standing, with a known true answer",
    "covered": "share of them whose true error lies within the estimate",
    "excess": "median of estimate / true error",
    "met": "of them, lanes whose rotation estimate met the default tolerance",
    "met_but_off": "of those, lanes whose true error did not",
    "wrong_outcome": "lanes ok that stand and truly fall, or the other way round",
    "steps": "steps of all runs over those of the first one, the whole set",
}


def write(path: pathlib.Path, table: pd.DataFrame) -> None:
    """Writes the table as it is shipped."""
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    head = [
        f"Factors of the error estimates: tools/calibrate_estimates.py -o {path}, {today}.",
        f"Fitted to lanes of seed {SEEDS[0]}; what is said of coverage is of lanes of {SEEDS[1]}.",
        *(f"{name}: {text}" for name, text in COLUMNS.items()),
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = table.to_csv(index=False, float_format="%.4g")
    path.write_text("".join(f"# {line}\n" for line in head) + rows, encoding="utf-8")


def main() -> None:
    """Fits, verifies, prints the tables, and writes the last one where it is asked to."""
    ask = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    ask.add_argument("-o", dest="path", type=pathlib.Path)
    asked = ask.parse_args()
    start_warp()
    known = truths(SEEDS[0])
    table = plain_table()
    found = judge(known, table)
    print(as_rows(found, table).to_string(index=False, float_format="{:.3g}".format), flush=True)
    table = fitted(found, table)
    rows = as_rows(judge(truths(SEEDS[1]), table), table)
    print(rows.to_string(index=False, float_format="{:.3g}".format))
    if asked.path is not None:
        write(asked.path, rows)


if __name__ == "__main__":
    main()
