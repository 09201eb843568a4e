"""Lanes to play: which of a run, and their motion as small whole numbers for the page."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.case.case import Case
from warprock.case.lanes import LaneSet
from warprock.findings.lanes import lane_name, peak_ratio
from warprock.findings.lanes import standing as upright
from warprock.model.assembly import SPACE
from warprock.model.base_path import base_places
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.response import FALLEN_NAMES, Response
from warprock.model.solids import Face, SpatialAssembly
from warprock.model.tie_states import TieState
from warprock.model.words import ASSEMBLY, BLOCK
from warprock.running.case_run import CaseRun, run_lanes
from warprock.running.lane_table import first_break, history_table, lane_pose, lane_table
from warprock.running.provenance import provenance
from warprock.running.scene_motion import last_move, turned_by
from warprock.running.scene_parts import TIE_WORDS, Mover, Part, scene_parts, standing

Array = npt.NDArray[np.float64]

ALL, SOME = 24, 8
"""Lanes up to which a page plays all of them, and how many it chooses of more."""
FEW = 4
"""How many of assemblies, of whose many blocks each has a history."""
SAMPLES = 1500
"""Samples of a lane that a page holds at most: of a longer history every second, third, ..."""
NUMBERS = 160_000
"""Numbers that a page holds at most; where all lanes would need more, some are chosen."""
DIGITS = 20_000
"""Steps into which the largest value of a quantity is divided."""
LEAST, FEWEST = 200, 30
"""Samples that an assembly of many blocks has nevertheless, and one of very many."""
MANY_NUMBERS = 900_000
"""Numbers that a page holds of one assembly at most, where `FEWEST` samples are not more."""
INTERVAL = 0.01
"""Time between samples where the case says nothing of it [s]."""


def scenes_of(run: CaseRun) -> dict[str, Any]:
    """The lanes of a run that a page plays, run again with histories.

    Args:
        run: The run.

    Returns:
        `note`, which lanes these are and why, and `lanes`, ready for JSON.
    """
    table, facts = lane_table(run.lane_set, run.response), provenance(run)
    shown = dataclasses.replace(run, case=sampled(run.case))
    chosen = choose(table, _most(shown.case))
    response = run_lanes(shown, list(chosen))
    lanes = [
        scene(
            history_table(response, row, run.lane_set, lane),
            table.iloc[lane],
            lane_name(facts, table, lane),
            why,
            outlines_of(run.lane_set.lanes, lane),
            surroundings_of(run.lane_set, lane, response, row),
        )
        for row, (lane, why) in enumerate(chosen.items())
    ]
    note = "All lanes of the run."
    if len(chosen) < len(table):
        note = f"{len(chosen)} of {len(table):,} lanes, chosen because they tell most."
    return {"note": note, "lanes": lanes}


def outlines_of(lanes: Lanes, lane: int) -> list[list[list[float]]] | None:
    """Corners of each block from its centre of mass [m]; None where all are boxes."""
    if lanes.assembly is not None and lanes.spatial:
        kind = lanes.assembly.of(lane)
        arms = np.round(kind.corners - kind.centre[:, None], 6)
        return [arms[k].tolist() for k in np.argsort(kind.fixed, kind="stable")]
    if lanes.assembly is not None:
        # Those that can move first, as histories have them, then what is fixed.
        kind = lanes.assembly.of(lane)
        found = [np.unique(c, axis=0, return_index=True)[1] for c in kind.corners]
        arms = kind.corners - kind.centre[:, None]
        order = np.argsort(kind.fixed, kind="stable")
        return [
            np.insert(np.round(arms[k][np.sort(found[k])], 6), 1, 0.0, axis=-1).tolist()
            for k in order
        ]
    one = as_stacks(lanes.take(np.array([lane])))
    if one.body is not None:
        corners = one.body.outline(one.height[:, 0])
    elif one.profiles is not None:
        corners = one.profiles.outlines()[0]
    else:
        return None
    across = corners if one.spatial else np.insert(corners, 1, 0.0, axis=-1)
    rounded: list[list[list[float]]] = np.round(across, 6).tolist()
    return rounded


class Surroundings(NamedTuple):
    """What a page shows besides blocks and their base.

    Attributes:
        parts: What holds the block.
        ground: Displacement of the ground below a support [m], shape [sample, 3]; None without.
        fixed: Centres of the blocks of an assembly that move with the base [m], shape [block, 2],
            in space [block, 3].
        floor: Level of the ground on which it falls [m].
        faces: Of the blocks of an assembly in space the corners of each face, counterclockwise from
            outside.
    """

    parts: Sequence[Part] = ()
    ground: Array | None = None
    fixed: Array | None = None
    floor: float = 0.0
    faces: Sequence[Sequence[Face]] = ()


def surroundings_of(lane_set: LaneSet, lane: int, response: Response, row: int) -> Surroundings:
    """What a page shows of a lane besides its blocks and their base.

    Args:
        lane_set: Lanes of the case.
        lane: Number of the lane among them.
        response: A response with histories.
        row: Row of the lane in it.
    """
    ground = lane_set.ground
    below = None if ground is None else base_places(ground, lane, response.times)
    if lane_set.lanes.assembly is not None:
        kind = lane_set.lanes.assembly.of(lane)
        faces: list[Sequence[Face]] = []
        if isinstance(kind, SpatialAssembly):
            faces = [kind.faces[k] for k in np.argsort(kind.fixed, kind="stable")]
        return Surroundings((), below, kind.centre[kind.fixed], kind.ground, faces)
    if lane_set.lanes.hold is None:
        return Surroundings(ground=below)
    pose, broke = lane_pose(response, row), first_break(response, row)
    alone = lane_set.lanes.take(np.array([lane]))
    return Surroundings(scene_parts(alone, response.times, pose, broke), below)


def sampled(case: Case) -> Case:
    """The case with histories that a page can play."""
    if case.sample_times.interval is not None:
        return case
    run, (shortest, longest) = case.tables.run, case.durations
    interval = min(max(INTERVAL, longest / SAMPLES), shortest)
    of_run = run.model_copy(update={"sample_interval": interval})
    return dataclasses.replace(case, tables=case.tables.model_copy(update={"run": of_run}))


def _most(case: Case) -> int:
    """Lanes of a case that a page plays at most."""
    times = case.sample_times
    assert times.interval is not None
    samples = min(SAMPLES, times.duration / times.interval)
    tables = case.tables
    # The ground below a support, the arrows of loads, the beam of a frame.
    besides = 2 * sum(each is not None for each in (tables.support, tables.frame))
    besides += 4 * (tables.top_load is not None)
    numbers = samples * (2 + 3 * tables.block_count + besides)
    if tables.assembly is not None:
        return FEW
    return ALL if min(case.lane_count, ALL) * numbers <= NUMBERS else SOME


def choose(table: pd.DataFrame, most: int) -> dict[int, str]:
    """The lanes that a page plays, and why: all of a few, of many those that tell most.

    Args:
        table: The lane table.
        most: Lanes up to which all are played.
    """
    if len(table) <= most:
        return dict.fromkeys(range(len(table)), "")
    ratio, up = peak_ratio(table), np.flatnonzero(upright(table))
    found: dict[int, str] = {}

    def add(lanes: Sequence[int] | npt.NDArray[np.intp], why: str) -> None:
        if len(lanes) and len(found) < min(SOME, most):
            found.setdefault(int(lanes[0]), why)

    ranked = up[np.argsort(ratio[up], kind="stable")]
    add(ranked[::-1], "the largest rotation of those that stayed up")
    add(ranked[len(ranked) // 2 :], "the median rotation of those that stayed up")
    fell = ASSEMBLY.fallen if "collapse_time_s" in table else BLOCK.fallen
    for word, why in (("overturned", f"{fell} first"), ("slid_off", "slid off")):
        add(_first(table, "outcome", word), why)
    fallen = np.flatnonzero(table["outcome"] == "overturned")
    add(fallen[::-1], f"{fell}, too")
    for word in ("sensitive", "outside_model", "ambiguous"):
        add(_first(table, "status", word), f"its status is {word.replace('_', ' ')}")
    add(ranked[len(ranked) // 4 :], "a quarter of those that stayed up rotate less")
    add(ranked, "the smallest rotation")
    return found


def _first(table: pd.DataFrame, column: str, word: str) -> npt.NDArray[np.intp]:
    return np.flatnonzero((table[column] == word).to_numpy())


def scene(
    history: pd.DataFrame,
    row: pd.Series[Any],
    name: str,
    why: str,
    outlines: list[list[list[float]]] | None = None,
    beside: Surroundings | None = None,
) -> dict[str, Any]:
    """One lane as a page plays it: whole numbers, and what one of them is worth.

    Args:
        history: Its history, as `running.lane_table.history_table` gives it.
        row: Its row of the lane table.
        name: What sets it apart.
        why: Why it was chosen; empty where all lanes are.
        outlines: Corners of each block from its centre of mass [m], going round where it is in
            the plane; None of boxes.
        beside: What is shown besides blocks and base.
    """
    fixed = None if beside is None else beside.fixed
    stride = _stride(history, outlines, beside)
    shown = history.iloc[::stride].reset_index(drop=True)
    blocks = [f"_{k}" for k in range(1, 10) if f"width_{k}_m" in row] or [""]
    base = {axis: _column(shown, f"base_{axis}_m") for axis in "xyz"}
    acceleration = _column(shown, "base_acceleration_m_s2")
    sway = _column(shown, "base_acceleration_y_m_s2")
    rise = _column(shown, "base_acceleration_z_m_s2")
    if fixed is None or outlines is None:
        parts = [_block(shown, row, number) for number in blocks]
    else:
        parts = _assembled(shown, outlines, fixed, base)
    held = () if beside is None else beside.parts
    below = None if beside is None or beside.ground is None else beside.ground[: len(history)]
    ground = {} if below is None else dict(zip("xyz", below[::stride].T, strict=True))
    paths = [m.path[: len(history)][::stride] for m in _movers(held) if m.path is not None]
    places = [part[axis] for part in parts for axis in "xyz"]
    length = _unit([*places, *base.values(), *ground.values(), *paths])
    angle, rate = _unit([part["r"] for part in parts]), _unit([acceleration, sway, rise])
    times = shown["time_s"].to_numpy()
    end = _end_of_model(row, parts, times)
    about = _about(row, why, stride)
    if end is not None:
        what = "what follows the fall is not modelled"
        if fixed is not None:
            what = "engines.assembly.after_collapse lets it go on"
        about += f" The run ended at {end:.3g} s: {what}."
    spatial = any("q" in part for part in parts)
    return {
        "lane": int(row["lane"]),
        "name": name,
        "about": about,
        "n": len(times),
        "dt": float(f"{times[1] - times[0]:.9g}") if len(times) > 1 else 1.0,
        "spatial": spatial,
        **({} if end is None else {"fell": end}),
        **({} if beside is None or fixed is None else _extent(parts, base, beside.floor)),
        "length": length,
        "angle": angle,
        "rate": rate,
        "attitude": 1.0 / DIGITS,
        "blocks": [
            {name: part[name] for name in ("w", "h", "d", "alpha", "fixed") if name in part}
            | ({} if outlines is None else {"p": outlines[k]})
            | ({"f": beside.faces[k]} if beside is not None and beside.faces else {})
            | {"r": _whole(part["r"], angle)}
            | {axis: _whole(part[axis], length) for axis in "xyz"}
            | ({"q": [_whole(q, 1.0 / DIGITS) for q in part["q"]]} if "q" in part else {})
            for k, part in enumerate(parts)
        ],
        "base": {axis: _whole(values, length) for axis, values in base.items()},
        **({"ground": {a: _whole(v, length) for a, v in ground.items()}} if ground else {}),
        **(_held(held, stride, length, len(times)) if held else {}),
        "acc": _whole(acceleration, rate),
        **({"sway": _whole(sway, rate)} if sway.any() else {}),
        **({"rise": _whole(rise, rate)} if rise.any() else {}),
    }


def _stride(
    history: pd.DataFrame, outlines: list[list[list[float]]] | None, beside: Surroundings | None
) -> int:
    """Which samples a page keeps, every how manyth: fewer of a lane with many blocks."""
    samples = SAMPLES
    if beside is not None and beside.fixed is not None and outlines is not None:
        each = (8 if beside.faces else 3) * len(outlines)
        samples = max(min(SAMPLES, NUMBERS // each), min(LEAST, MANY_NUMBERS // each), FEWEST)
    return -(-(len(history) - 1) // samples) if len(history) > samples + 1 else 1


def _about(row: pd.Series[Any], why: str, stride: int) -> str:
    """What a page says of a lane."""
    outcome = f"{row['outcome']}, {row['status']}".replace("_", " ")
    chosen = f"Chosen because: {why}. " if why else ""
    kept = f" One in {stride} samples of its history is kept here." if stride > 1 else ""
    return f"{chosen}Outcome and status: {outcome}.{kept}"


def _end_of_model(
    row: pd.Series[Any], parts: Sequence[Mapping[str, Any]], times: Array
) -> float | None:
    """When the model of a lane ended, since one of several blocks fell [s]; None without a fall."""
    if len(parts) == 1 or row["outcome"] not in FALLEN_NAMES:
        return None
    end = float(times[last_move(np.stack([part["r"] for part in parts]))])
    collapse = row.get("collapse_time_s", math.nan)
    if math.isnan(collapse):
        return end
    # A lane that goes on after its collapse still moves then.
    return None if end > collapse + 2.0 * (times[1] - times[0]) else float(collapse)


def _movers(parts: Sequence[Part]) -> list[Mover]:
    """What the points of parts are fixed to, each once."""
    return list({id(mover): mover for part in parts for mover in part.movers}.values())


def _held(parts: Sequence[Part], stride: int, length: float, samples: int) -> dict[str, Any]:
    """What holds a block, as a page draws it.

    Args:
        parts: Its parts, with all samples.
        stride: Of which every one in so many is shown.
        length: What a step of a length is worth [m].
        samples: Samples that are shown.
    """
    movers = _movers(parts)
    numbers = {id(mover): number for number, mover in enumerate(movers)}

    def told(mover: Mover) -> dict[str, Any]:
        found: dict[str, Any] = {"on": mover.on, "shift": mover.shift}
        if mover.path is not None:
            along, up = mover.path[::stride][:samples].T
            found |= {"x": _whole(along, length), "z": _whole(up, length)}
        return found

    def drawn(part: Part) -> dict[str, Any]:
        ends = zip(part.movers, np.round(part.points, 6).tolist(), strict=True)
        found: dict[str, Any] = {
            "look": part.look.value,
            "points": [[numbers[id(mover)], *point] for mover, point in ends],
        }
        if part.states is not None:
            states = part.states[::stride][:samples]
            changes = np.flatnonzero(np.diff(states, prepend=-1))
            words = [TIE_WORDS[TieState(state)] for state in states[changes]]
            found["states"] = [list(pair) for pair in zip(changes.tolist(), words, strict=True)]
        return found

    return {
        "span": [round(end, 6) for end in standing(parts)],
        "movers": [told(mover) for mover in movers],
        "parts": [drawn(part) for part in parts],
    }


def _assembled(
    history: pd.DataFrame,
    outlines: list[list[list[float]]],
    fixed: Array,
    base: Mapping[str, Array],
) -> list[dict[str, Any]]:
    """The blocks of an assembly: their sizes and motions, those that move with the base last."""
    parts, moving, still = [], len(outlines) - len(fixed), np.zeros(len(history))
    # Each column of a DataFrame has a copy of all its attributes, and there are thousands of them.
    history = history.copy(deep=False)
    history.attrs = {}
    for k, outline in enumerate(outlines):
        width, depth, height = np.ptp(np.array(outline), axis=0).tolist()
        # No rotation of a single block says how near an assembly is to its collapse.
        found: dict[str, Any] = {"w": width, "h": height, "d": depth, "alpha": [HALF_TURN] * 2}
        if k < moving:
            found |= {axis: _column(history, f"{axis}_{k + 1}_m") for axis in "xyz"}
            found["r"] = _column(history, f"turn_{k + 1}_rad")
            if fixed.shape[1] == SPACE:
                found["q"] = [_column(history, f"attitude_{part}_{k + 1}") for part in "xyzw"]
                found["r"] = turned_by(np.stack(found["q"], axis=-1))
        else:
            place = fixed[k - moving]
            place = place if len(place) == SPACE else np.insert(place, 1, 0.0)
            found |= {axis: base[axis] + at for axis, at in zip("xyz", place, strict=True)}
            found |= {"r": still, "fixed": 1}
        parts.append(found)
    return parts


HALF_TURN = 0.5 * math.pi


def _extent(
    parts: Sequence[Mapping[str, Any]], base: Mapping[str, Array], floor: float
) -> dict[str, Any]:
    """Height of an assembly at the start, how far its blocks come along its base, ground [m]."""
    high = max(part["z"][0] + 0.5 * part["h"] for part in parts)
    low = min(part["z"][0] - 0.5 * part["h"] for part in parts)
    away = np.array([part["x"] - base["x"] for part in parts])
    half = 0.5 * np.array([[part["w"]] for part in parts])
    span = [float(np.nanmin(away - half)), float(np.nanmax(away + half))]
    found = {"assembly": 1, "tall": float(high - low), "span": span, "floor": floor}
    if any("q" in part for part in parts):
        across = np.array([np.abs(part["y"] - base["y"]) + 0.5 * part["d"] for part in parts])
        found["plate"] = max(float(np.nanmax(across)), *np.abs(span))
    return found


def _block(history: pd.DataFrame, row: pd.Series[Any], number: str) -> dict[str, Any]:
    """One block: its sizes and its motion."""
    found: dict[str, Any] = {
        "w": float(row[f"width{number}_m"]),
        "h": float(row[f"height{number}_m"]),
        "d": float(row[f"depth{number}_m"]),
        "alpha": _sides(row, number),
        "r": _column(history, f"rotation{number}_rad"),
    }
    found |= {axis: _column(history, f"{axis}{number}_m") for axis in "xyz"}
    if f"attitude_x{number}" in history:
        found["q"] = [_column(history, f"attitude_{part}{number}") for part in "xyzw"]
    return found


def _sides(row: pd.Series[Any], number: str) -> list[float]:
    """Slenderness angles to -x and to +x [rad]."""
    weaker = f"slenderness_angle{number}_rad"
    sides = [f"slenderness_angle_{side}{number}_rad" for side in ("left", "right")]
    return [float(row[side if side in row else weaker]) for side in sides]


def _column(history: pd.DataFrame, name: str) -> Array:
    if name not in history:
        return np.zeros(len(history))
    return np.asarray(history[name].to_numpy(dtype=float))


def _unit(values: Sequence[Array]) -> float:
    """What one step of a quantity is worth, so that its largest value has `DIGITS` of them."""
    most = max((float(np.nanmax(np.abs(each), initial=0.0)) for each in values), default=0.0)
    return float(f"{most / DIGITS:.3g}") or 1.0


def _whole(values: Array, unit: float) -> list[int]:
    """Values in steps; one number where they all are the same."""
    steps: list[int] = np.round(np.nan_to_num(values) / unit).astype(int).tolist()
    return steps[:1] if len(set(steps)) == 1 else steps


Scenes = Mapping[str, Any]
