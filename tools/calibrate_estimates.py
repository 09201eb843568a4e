"""Holds the error estimates of lanes against the truth, and writes the factors that they need.

    python tools/calibrate_estimates.py -o cases/estimate/calibration.csv

Lanes are drawn from a seed (`tools/calibration_lanes.py`): blocks, the same blocks as bodies on
contact points, and stacks of two and of three; let go, under pulses (sines and cosines of one to
three cycles under displacement, velocity and acceleration control), and under the six shipped
records. Their friction is .3 to 1.3, so that many slide. Every engine with an order in the step
runs them at its default settings with `run_to_tolerance` at the default tolerance. The truth of
blocks and bodies is `event` on blocks at steps of 2e-5 s, of stacks at 4e-4 s with a rest rule a
thousand times finer; of `dem`, which answers its own springs, itself at 1/32 of its step, on
blocks alone. A lane is left out where that still differs from its run at a longer step by more
than 1e-3 of the slenderness angle, for its true answer is not known; where its block falls; and
where its status is not `ok`.

An estimate is a factor times what the runs tell, and a floor. The floor is set: `FLOORS` says why.
The factor is the least of `LADDER` with which, of the lanes of the first seed, `AIM` have an error
within their estimate, in every set that shares the factor (free lanes and pulses do). Two runs and
more have factors of their own. A factor changes what is run again, so it is fitted twice, and lanes
of the second seed then run with the factors found: their coverage is what the table says.
"""

from __future__ import annotations

import argparse
import dataclasses
import datetime
import math
import pathlib
import time
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import pandas as pd
from calibration_lanes import SETS, Problem, as_bodies, problems

from warprock.engines import ENGINES, engine_class
from warprock.engines.workload import FINEST_STEPS
from warprock.model.response import FALLEN, Response, Status, take_lanes
from warprock.running import calibration, options
from warprock.running.batch import run_batch
from warprock.running.calibration import BLOCK, BODY, PLAIN, QUANTITIES, STACK, Factor, Key
from warprock.running.companions import Companions, halve_step, largest
from warprock.running.devices import start_warp
from warprock.running.options import DEFAULT_OPTIONS
from warprock.running.tolerance import run_to_tolerance
from warprock.settings.engines import SETTINGS, EventSettings

Array = npt.NDArray[np.float64]

Place = tuple[str, str, str]
"""Scene, set of lanes, engine."""

SEEDS = (20, 22)
"""Of the lanes that factors are fitted to, and of those that they are held against."""

FITS = 3
"""How often factors are fitted: with other factors other lanes are run again."""

TRUE_STEP, CHECKED_STEP = 2e-5, 1e-4
STACK_TRUE_STEP, STACK_CHECKED_STEP, STACK_REST_RATIO = 4e-4, 6e-4, 1e-9
TRUE_HALVINGS, CHECKED_HALVINGS = 5, 4
"""Steps of `event` [s], of stacks with a rest rule, and halvings of that of `dem`: of the truth,
and to see if it is known."""

KNOWN = 1e-3
"""Difference of the two, over the slenderness angle, above which the truth is not known."""

ROUND_OFF = 1e-7
"""Error over the slenderness angle, or over the width, that counts as none: round-off and the rest
rules' leavings."""

SEEN = 1e-5
"""Error over the slenderness angle above which the excess of an estimate is judged: smaller ones
lie below its floor."""

AIM = {1: 0.97, 2: 0.96}
"""Share of errors that a factor has to cover, so that those of other lanes are covered at 95 %, by
the order of the engine."""

OTHER_AIM = {"peak_rotation_error": 0.97, "peak_slide_error": 0.98}
"""The same of peaks and slides: no lane runs again for these, so that a larger factor is free."""

STACKS = 1.0
"""Factor of stacks in `event` but under records. Larger ones make lanes run again whose
finer runs miss the same events: 1.75 covers 3 blocks of 100 more, at 1.06 times the steps."""

DEM_AIM = 1.0
"""The same of `dem`, of which a few dozen lanes can be judged: one of them is 2 %. Its peaks, that
are fewer still, have the factor of its rotations at least."""

SEEN_AIM = 0.93
"""The same of the errors above `SEEN` alone."""

SAFETY = 1.56
"""Least factor: with it blocks let go, whose errors shrink a little more slowly than the order
says, have estimates of 1.4 times their errors."""

LADDER = tuple(SAFETY * 1.1**power for power in range(21))
"""Factors to try."""

FEW = 10
"""Errors above `SEEN` from which on they are judged by themselves."""

ROTATION_FLOOR = 5e-4
"""Of first-order engines under records: swings shorter than a few steps, of a block that barely
lifts, are missed by all runs alike. So they are in `dem`, whose springs give way as far."""

STACK_FLOOR = 4e-5
"""Of stacks in `event`: a small swing that begins and ends within the step is missed by runs at
longer steps, too, and so are the impacts whose order hangs on it."""

SLIDE_FLOOR = 5e-3
"""Of `event` and `dem`: a slip that ends within the step, as after a velocity step of the base, is
walked in one go whatever the step is, and errs by a few parts in a thousand."""

DEM_LANES = 100
"""Lanes of a set that `dem` runs. Under records it has none whose true answer is known."""

STACK_ENGINES = ("event", "impulse")
"""Engines whose stacks are judged; those of the others have the factors of their blocks."""

SLOW_STACKS = 40
"""Stacks of a set and height that `impulse` runs, which cost a hundred times as much as those of
`event`. Under records they have the factors of blocks."""

BODY_ENGINES = ("event",)
"""Engines whose bodies have factors of their own: a box as a body is another order to `event`, and
the same lane to the others."""


def largest_difference(one: Response, other: Response) -> Array:
    """Largest |difference of the rotations| over the run [rad], shape [lane] or [lane, block]."""
    return np.asarray(np.abs(one["rotation"] - other["rotation"]).max(axis=-1))


def stands(response: Response) -> npt.NDArray[np.bool_]:
    """Lanes whose block has not fallen."""
    return np.asarray(~np.isin(response["outcome"], FALLEN))


@dataclasses.dataclass(frozen=True)
class Truth:
    """What lanes truly do, and whether that is known, shape [lane]."""

    problem: Problem
    response: Response
    known: npt.NDArray[np.bool_]
    decided: npt.NDArray[np.bool_]

    def first(self, count: int) -> Truth:
        """That of the first lanes."""
        some = np.arange(min(count, len(self.known)))
        return Truth(
            self.problem.first(count),
            take_lanes(self.response, some),
            self.known[some],
            self.decided[some],
        )

    @classmethod
    def of(cls, engine: str, problem: Problem) -> Truth:
        """The truth that an engine is held against."""
        if engine == "dem":
            problem = problem.first(DEM_LANES)
            default = SETTINGS["dem"]()
            fine = [halve_step(default, count) for count in (TRUE_HALVINGS, CHECKED_HALVINGS)]
        elif problem.lanes.stacked:
            engine = "event"
            fine = [
                EventSettings(time_step=step, rest_rotation_ratio=STACK_REST_RATIO)
                for step in (STACK_TRUE_STEP, STACK_CHECKED_STEP)
            ]
        else:
            engine = "event"
            fine = [EventSettings(time_step=step) for step in (TRUE_STEP, CHECKED_STEP)]
        lanes, motions, times = problem.lanes, problem.motions, problem.times
        truth, checked = (
            run_batch(engine, lanes, motions, times, settings=settings, most_steps=FINEST_STEPS)
            for settings in fine
        )
        apart = largest(largest_difference(truth, checked) / lanes.slenderness_angle)
        known = (apart <= KNOWN) & stands(truth) & (truth["status"] == Status.OK)
        return cls(problem, truth, known, stands(truth) == stands(checked))


def judge_lanes(engine: str, problem: Problem, truth: Truth) -> pd.DataFrame:
    """Runs lanes with estimates, and sets these beside the true errors, a row a block."""
    lanes, motions, times = problem.lanes, problem.motions, problem.times
    started = time.process_time()
    found = run_to_tolerance(engine, lanes, motions, times)
    spent = time.process_time() - started
    right, alpha = truth.response, lanes.slenderness_angle
    case = Companions(engine, lanes, motions, times, SETTINGS[engine](), DEFAULT_OPTIONS)
    usable = found["status"] == Status.OK
    met = largest(found["rotation_error"] / alpha) <= options.TOLERANCE
    wrong = truth.decided & (stands(found) != stands(right)) & usable
    of_lanes = {
        "judged": truth.known & stands(found) & usable,
        "ok": usable,
        "met": met,
        "wrong": wrong,
        "first_steps": found["first_step_count"],
        "all_steps": found["total_step_count"],
    }
    shape = alpha.reshape(lanes.lane_count, -1).shape
    table = {n: np.repeat(v, shape[1]) for n, v in of_lanes.items()}
    table["lane"] = np.repeat(np.arange(shape[0]), shape[1])
    for quantity in QUANTITIES:
        name = quantity.removesuffix("_error")
        slide = quantity == "peak_slide_error"
        error = np.abs(found[name] - right[name]) if name != "rotation" else None
        off = largest_difference(found, right) if error is None else error
        size = lanes.width if slide else alpha
        table[f"true {quantity}"] = np.where(off <= ROUND_OFF * size, 0.0, off).reshape(-1)
        table[quantity] = found[quantity].reshape(-1)
        table[f"size {quantity}"] = (np.abs(found["peak_slide"]) if slide else size).reshape(-1)
    table["angle"] = alpha.reshape(-1)
    table["floor"] = case.rest_floor.reshape(-1)
    rows = pd.DataFrame(table)
    rows.attrs["cpu"] = spent
    return rows


def estimate_with(rows: pd.DataFrame, quantity: str, used: Factor, tried: Factor) -> Array:
    """The estimates of rows, made with other factors than those used; the floors are the same."""
    added = used.floor * rows[f"size {quantity}"].to_numpy()
    if quantity != "peak_slide_error":
        added = added + rows["floor"].to_numpy()
    bare = np.maximum(rows[quantity].to_numpy() - added, 0.0) / used.factor
    return np.asarray(tried.factor * bare + added)


def covered(rows: pd.DataFrame, quantity: str, used: Factor, tried: Factor) -> float:
    """Share of judged rows whose error lies within the estimate."""
    judged = rows[rows["judged"]]
    error = judged[f"true {quantity}"].to_numpy()
    return float(np.mean(error <= estimate_with(judged, quantity, used, tried)))


def places() -> list[Place]:
    """What is judged: scene, set and engine."""
    ordered = [engine for engine in ENGINES if engine_class(engine).order is not None]
    found = []
    for scene in (BLOCK, BODY, STACK):
        for name in SETS:
            for engine in ordered:
                if scene == BODY and engine not in BODY_ENGINES:
                    continue
                if engine == "dem" and (scene, name) not in ((BLOCK, "free"), (BLOCK, "pulses")):
                    continue
                slow = name == "records" or engine not in STACK_ENGINES
                if scene == STACK and engine != "event" and slow:
                    continue
                found.append((scene, name, engine))
    return found


def all_truths(seed: int) -> dict[Place, list[Truth]]:
    """What lanes truly do."""
    found: dict[Place, list[Truth]] = {}
    kept: dict[tuple[str, str, bool], list[Truth]] = {}
    for scene, name, engine in places():
        key = (STACK if scene == STACK else BLOCK, name, engine == "dem")
        if key not in kept:
            drawn = problems(scene, name, seed)
            kept[key] = [Truth.of(engine, problem) for problem in drawn]
            lanes = sum(len(truth.known) for truth in kept[key])
            known = sum(truth.known.sum() for truth in kept[key])
            print(f"seed {seed}, {key}: {lanes} lanes, the truth of {known} known", flush=True)
        found[scene, name, engine] = kept[key]
    return found


def judge(
    truths: Mapping[Place, list[Truth]], table: Mapping[Key, Factor]
) -> dict[Place, pd.DataFrame]:
    """Lanes with the estimates that the factors of a table give."""
    calibration.shipped_factors = lambda: dict(table)  # type: ignore[assignment]
    found = {}
    for (scene, name, engine), each in truths.items():
        rows = []
        for number, truth in enumerate(each):
            if scene == STACK and engine != "event":
                truth = truth.first(SLOW_STACKS)
            problem = as_bodies(truth.problem) if scene == BODY else truth.problem
            part = judge_lanes(engine, problem, truth)
            rows.append(part.assign(lane=part["lane"] + 1000 * number))
        found[scene, name, engine] = pd.concat(rows, ignore_index=True)
    return found


def floor(place: Place, quantity: str) -> float:
    """The floor of an estimate."""
    scene, name, engine = place
    if quantity == "peak_slide_error":
        return SLIDE_FLOOR if engine in ("event", "dem") else 0.0
    if engine == "event":
        return STACK_FLOOR if scene == STACK else 0.0
    return ROTATION_FLOOR if name == "records" else 0.0


def plain_table() -> dict[Key, Factor]:
    """Factors to begin with."""
    return {
        (*place, quantity): Factor(PLAIN, floor(place, quantity))
        for place in places()
        for quantity in QUANTITIES
    }


def covers(rows: pd.DataFrame, quantity: str, used: Factor, tried: Factor, aim: float) -> bool:
    """Whether estimates made with a factor cover as many errors as they have to."""
    large = rows["judged"] & (rows[f"true {quantity}"] > SEEN * rows["angle"])
    if large.sum() >= FEW and covered(rows[large], quantity, used, tried) < SEEN_AIM:
        return False
    return covered(rows, quantity, used, tried) >= aim


def fit(found: Mapping[Place, pd.DataFrame], table: Mapping[Key, Factor]) -> dict[Key, Factor]:
    """The table with the least factors that cover what they have to."""
    new = {}
    for (scene, name, engine, quantity), used in table.items():
        parts = []
        for other in ["records"] if name == "records" else ["free", "pulses"]:
            key = (scene, other, engine, quantity)
            parts.append((table[key], found[key[:3]]))
        aim = OTHER_AIM.get(quantity, AIM[engine_class(engine).order or 1])
        aim = DEM_AIM if engine == "dem" else aim
        for factor in LADDER:
            tried = Factor(factor, used.floor)
            if all(covers(rows, quantity, one, tried, aim) for one, rows in parts):
                break
        if scene == STACK and engine == "event" and name != "records":
            factor = STACKS
        elif quantity == "rotation_error":
            # Half of the way, for this factor changes which lanes run again.
            factor = math.sqrt(used.factor * factor)
        if engine == "dem" and quantity == "peak_rotation_error":
            factor = max(factor, new[scene, name, engine, "rotation_error"].factor)
        new[scene, name, engine, quantity] = Factor(round(factor, 2), used.floor)
    return new


def as_rows(found: Mapping[Place, pd.DataFrame], table: Mapping[Key, Factor]) -> pd.DataFrame:
    """Factors with the coverage that they gave."""
    told = []
    for (scene, name, engine, quantity), used in table.items():
        rows = found[scene, name, engine]
        judged = rows[rows["judged"]]
        error = judged[f"true {quantity}"]
        size = judged["angle"]
        seen = error > SEEN * size
        excess = judged[quantity][seen] / error[seen]
        lanes = rows.groupby("lane").first()
        met = judged["met"]
        off = judged["true rotation_error"] > options.TOLERANCE * judged["angle"]
        told.append(
            {
                "scene": scene,
                "set": name,
                "engine": engine,
                "quantity": quantity,
                "factor": used.factor,
                "floor": used.floor,
                "blocks": len(judged),
                "covered": covered(rows, quantity, used, used),
                "seen": int(seen.sum()),
                "seen_covered": float(np.mean(excess >= 1.0)) if seen.any() else np.nan,
                "excess": excess.median(),
                "ok": lanes["ok"].mean(),
                "met": int(met.sum()),
                "met_but_off": int((met & off).sum()),
                "wrong_outcome": int(lanes["wrong"].sum()),
                "steps": lanes["all_steps"].sum() / lanes["first_steps"].sum(),
            }
        )
    return pd.DataFrame(told)


COLUMNS = {
    "scene": "single boxes in the plane, the same as bodies on contact points, stacks",
    "set": "lanes that it was held against; factors of free lanes and pulses are the same",
    "engine": "engine, default settings",
    "quantity": "estimate",
    "factor": "factor on what the differences of runs tell of the error",
    "floor": "added, over the slenderness angle, or over the peak slide for slides",
    "blocks": "blocks judged: in lanes that are ok and stand, and whose true answer is known",
    "covered": "share of them whose true error lies within the estimate",
    "seen": f"blocks whose true error is above {SEEN:g} of the slenderness angle (slides: metres)",
    "seen_covered": "share of those whose true error lies within the estimate",
    "excess": "median of estimate / true error of those",
    "ok": "share of all lanes of the set whose status is ok",
    "met": "blocks judged whose lane met the default tolerance by its estimates",
    "met_but_off": "of those, blocks whose true error did not",
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


def show(rows: pd.DataFrame) -> None:
    """Prints a table."""
    print(rows.to_string(index=False, float_format="{:.3g}".format), flush=True)


def main() -> None:
    """Fits, verifies, prints the tables, and writes the last one where it is asked to."""
    ask = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    ask.add_argument("-o", dest="path", type=pathlib.Path)
    asked = ask.parse_args()
    start_warp()
    truths, table = all_truths(SEEDS[0]), plain_table()
    for _ in range(FITS):
        found = judge(truths, table)
        show(as_rows(found, table))
        table = fit(found, table)
    rows = as_rows(judge(all_truths(SEEDS[1]), table), table)
    show(rows)
    if asked.path is not None:
        write(asked.path, rows)


if __name__ == "__main__":
    main()
