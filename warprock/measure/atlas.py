"""The atlas of extremes: runs every engine on every map, and judges every lane.

A lane ends in one of four ways: its engine says that its numbers may not be used (a status), they
are sound, they are sound but energy grew, or they are absurd although the status lets them pass.
The last is a defect of the engine. A launch is cut to `AtlasSize.steps` steps: one at 1e-6 s covers
20 ms of motion, enough for small blocks and small rotations to come down, not for tall ones.

Every finished part (map, engine, precision) is kept, see `warprock.running.parts`; one whose file
holds what would be run again is read, not run.
"""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import pyarrow as pa

import warprock
from warprock.engines import ENGINES, engine_class, reference_engine
from warprock.engines.launching import Target
from warprock.engines.soundness import energy_gained, find_exploded
from warprock.measure.atlas_lanes import AtlasSize, LaneGrid
from warprock.measure.atlas_maps import MAPS, AtlasMap, Launch
from warprock.model.response import SOUND, USABLE, Outcome, Response, SampleTimes, Status, names_of
from warprock.model.scene import scene_kind
from warprock.running.batch import run_batch
from warprock.running.case_run import PRECISIONS
from warprock.running.machine import kernel_hash
from warprock.running.options import DEFAULT_OPTIONS, RunOptions
from warprock.running.parts import State, find_part, read_part, write_part
from warprock.verification.housner import SLIDE_BOUND

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.intp]

GROWTH_BOUND = 1e-2
"""Energy gained without base motion over the energy held at the start, above which it grew."""
ROTATION_SLACK = 1e-5
"""What a peak rotation may exceed pi/2 by [rad]: the last digits of float32."""
STEP_SPAN = 4.0
"""Ratio of the steps of lanes that run for the same time."""
SAMPLES = 100
"""Samples of a history in which errors are looked for."""
FOLDER = "maps"


@dataclasses.dataclass(frozen=True)
class Part:
    """One engine and precision on one map."""

    map: AtlasMap
    engine: str
    precision: str

    @property
    def file(self) -> str:
        """Name of the file that keeps it."""
        return f"{self.map.name}--{self.engine}--{self.precision}.parquet"


def run_atlas(
    folder: pathlib.Path,
    size: AtlasSize | None = None,
    *,
    engines: Sequence[str] | None = None,
    maps: Sequence[AtlasMap] = MAPS,
    precisions: Sequence[str] = PRECISIONS,
    options: RunOptions = DEFAULT_OPTIONS,
) -> pd.DataFrame:
    """Runs the maps of the atlas, but for the parts that the folder holds already.

    Args:
        folder: Results; parts are kept in `FOLDER` below it.
        size: How much is run; all of it where None.
        engines: Names in `ENGINES`; all of them where None.
        maps: The maps to run.
        precisions: "float64", "float32" or both.
        options: How lanes are run, but for the precision; the progress counts parts.

    Returns:
        One row a lane and launch: `map`, `engine`, `precision`, the inputs and knobs of the map
        (NaN where it has none), `duration_s`, and what `measure` returns.
    """
    size = size or AtlasSize()
    parts = all_parts(engines, maps, precisions)
    tables = []
    for done, part in enumerate(parts):
        path = folder / FOLDER / part.file
        of = {"atlas": _fingerprint(part, size)}
        table = _read_kept(path, of)
        if table is None:
            table = run_part(part, size, options)
            write_part(path, pa.Table.from_pandas(table, preserve_index=False), of)
        tables.append(table)
        if options.progress is not None:
            options.progress(done + 1)
    filled = [table for table in tables if len(table)]
    return pd.concat(filled, ignore_index=True) if filled else pd.DataFrame()


def all_parts(
    engines: Sequence[str] | None = None,
    maps: Sequence[AtlasMap] = MAPS,
    precisions: Sequence[str] = PRECISIONS,
) -> list[Part]:
    """The parts of an atlas, map by map."""
    names = tuple(ENGINES) if engines is None else engines
    return [Part(*key) for key in itertools.product(maps, names, precisions)]


def run_part(part: Part, size: AtlasSize, options: RunOptions = DEFAULT_OPTIONS) -> pd.DataFrame:
    """Runs one part; see `run_atlas` for the columns. Empty where the engine supports no lane."""
    launches = part.map.launches(part.engine, size)
    whole = part.map.lanes(size) if launches else None
    chosen = None if whole is None else supported_lanes(part.engine, whole)
    if whole is None or chosen is None or not len(chosen):
        return pd.DataFrame()
    grid = take_lanes(whole, chosen)
    uncounted = options.without_progress()
    own = dataclasses.replace(uncounted, precision=part.precision)
    references: dict[tuple[float, bytes], tuple[Numbers, Response]] = {}
    tables = []
    for launch in launches:
        for duration, numbers in _batches(part, size, grid, launch):
            batch = take_lanes(grid, numbers)
            times = SampleTimes(duration, duration / SAMPLES)
            key = (duration, numbers.tobytes())
            if key not in references:
                references[key] = _reference(batch, times, uncounted)
            response = run_batch(
                part.engine,
                batch.lanes,
                batch.motions,
                times,
                settings=launch.settings,
                **own.of_batch,
            )
            tables.append(
                batch.inputs.assign(
                    map=part.map.name,
                    engine=part.engine,
                    precision=part.precision,
                    **launch.knobs,
                    duration_s=duration,
                    **measure(batch, response, *references[key], rigid=not part.map.soft),
                )
            )
    return pd.concat(tables, ignore_index=True)


def supported_lanes(engine: str, grid: LaneGrid) -> Numbers:
    """Numbers of the lanes that an engine runs, each asked about by itself."""
    supports = engine_class(engine).supports

    def runs(lane: int) -> bool:
        one = slice(lane, lane + 1)
        kind = scene_kind(grid.lanes.take(one), grid.motions.take(one), restitution_given=False)
        return supports(kind) is None

    return np.flatnonzero([runs(lane) for lane in range(grid.lanes.lane_count)])


def take_lanes(grid: LaneGrid, chosen: Numbers) -> LaneGrid:
    """Some of the lanes of a grid, by number."""
    return LaneGrid(
        lanes=grid.lanes.take(chosen),
        motions=grid.motions.take(chosen),
        inputs=grid.inputs.iloc[chosen].reset_index(drop=True),
        free=grid.free[chosen],
        held=grid.held[chosen],
    )


def measure(
    grid: LaneGrid,
    response: Response,
    compared: Numbers,
    reference: Response,
    *,
    rigid: bool = True,
) -> dict[str, Any]:
    """What became of every lane.

    Args:
        grid: The lanes.
        response: The engine's answer for them, with histories.
        compared: Numbers of the lanes that the reference answers.
        reference: Its answer for those.
        rigid: Whether a block that turned further than it was let go must have gained energy; soft
            contacts may hold it no longer.

    Returns:
        Columns, shape [lane] each: `status`, `outcome`, `usable` (the status lets the numbers
        pass), `finite`, `growth` (energy gained over energy held, NaN where the base moves),
        `grew` (usable, growth over `GROWTH_BOUND`), `absurd` (usable, but not finite, turned
        further than pi/2, or energy more than doubled, see `engines.soundness.find_exploded`),
        `error` (largest |rotation - reference| / slenderness angle while both stand; NaN where not
        usable or without a reference), `penetration` (deepest / height of the highest block; NaN
        where not usable), `compared` (there is one that holds, and the blocks came down in it once
        if let go), `same_outcome` (1 if both or neither overturned, NaN alike), `peak_ratio` and
        `step_count`.
    """
    status = response["status"]
    usable = np.isin(status, USABLE)
    peak = _by_block(np.abs(response["peak_rotation"])).max(axis=1)
    finite = _finite(response)
    held = grid.held
    gained = -response["energy_lost"]
    if rigid and not grid.lanes.stacked:
        gained = energy_gained(grid.lanes, response["energy_lost"], response["peak_rotation"])
    growth = np.where(grid.free, gained / np.where(held > 0.0, held, 1.0), np.nan)
    too_much = grid.free & find_exploded(grid.lanes, held, gained)
    error, same = _errors(grid, response, compared, reference)
    angle = _by_block(grid.lanes.slenderness_angle)
    tallest = _by_block(grid.lanes.height).max(axis=1)
    return {
        "status": names_of(Status, status),
        "outcome": names_of(Outcome, response["outcome"]),
        "usable": usable,
        "finite": finite,
        "growth": growth,
        "grew": usable & (growth > GROWTH_BOUND),
        "absurd": usable & (~finite | (peak > 0.5 * np.pi + ROTATION_SLACK) | too_much),
        "error": np.where(usable & finite, error, np.nan),
        "penetration": np.where(usable & finite, response["peak_penetration"] / tallest, np.nan),
        "compared": np.isfinite(same),
        "same_outcome": np.where(usable, same, np.nan),
        "peak_ratio": (_by_block(np.abs(response["peak_rotation"])) / angle).max(axis=1),
        "step_count": response["step_count"],
    }


def _read_kept(path: pathlib.Path, of: Mapping[str, str]) -> pd.DataFrame | None:
    """The table of a part, if it is there, whole, and of just that; else None."""
    if find_part(path, of).state is not State.DONE:
        return None
    try:
        found: pd.DataFrame = read_part(path).to_pandas()
    except OSError:
        return None
    return found


def _fingerprint(part: Part, size: AtlasSize) -> str:
    """What decides the numbers of a part: the sizes, the settings and the kernels."""
    settings = [(launch.settings, launch.knobs) for launch in part.map.launches(part.engine, size)]
    text = repr((part.file, size, settings, warprock.__version__, kernel_hash()))
    return hashlib.sha256(text.encode()).hexdigest()


def _batches(
    part: Part, size: AtlasSize, grid: LaneGrid, launch: Launch
) -> list[tuple[float, Numbers]]:
    """Durations [s] and the numbers of the lanes that run for them.

    Lanes that the engine refuses do not run. No lane takes more than the steps of the size by its
    step. Lanes whose steps differ by more
    than `STEP_SPAN` run apart, so that the quick ones do not end the runs of the others.
    """
    longest = min(size.duration, part.map.longest)
    found = engine_class(part.engine)
    if found.order is None:
        return [(longest, np.arange(grid.lanes.lane_count))]
    engine = found(launch.settings, Target(part.precision))
    step = engine.longest_step(grid.lanes, grid.motions)
    most = np.minimum(longest, part.map.runs_longer * size.steps * step)
    kind = np.floor(np.log(longest / most) / np.log(STEP_SPAN)).astype(np.intp)
    reserve = engine.reserve(grid.lanes)
    able = np.ones(len(kind), dtype=bool) if reserve is None else reserve[0] > 1.0
    groups = [np.flatnonzero(able & (kind == each)) for each in np.unique(kind[able])]
    return [(float(most[numbers].min()), numbers) for numbers in groups]


def _reference(grid: LaneGrid, times: SampleTimes, options: RunOptions) -> tuple[Numbers, Response]:
    """The lanes that the reference supports, and its float64 answer for them (for one at least)."""
    name = reference_engine(stacked=grid.lanes.stacked)
    chosen = supported_lanes(name, grid)
    lanes = chosen if len(chosen) else np.arange(1)
    part = take_lanes(grid, lanes)
    return chosen, run_batch(name, part.lanes, part.motions, times, **options.of_batch)


def _by_block(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values of lanes with what follows the lane, if anything, in one axis."""
    return values.reshape(len(values), -1)


def _finite(response: Response) -> Mask:
    """Whether all numbers are finite that have no reason to be missing, shape [lane]."""
    names = (
        "peak_rotation",
        "residual_slide",
        "peak_slide",
        "peak_penetration",
        "energy_lost",
        "rotation",
    )
    sound = [np.isfinite(_by_block(response[name])).all(axis=1) for name in names]
    return np.asarray(np.all(sound, axis=0))


def _errors(
    grid: LaneGrid,
    response: Response,
    compared: Numbers,
    reference: Response,
) -> tuple[Array, Array]:
    """Error and agreement of the outcomes, as `measure` explains, shape [lane] each.

    A lane in which both overturn is compared up to the slenderness angle: that sees when it falls.
    """
    error, same = np.full((2, grid.lanes.lane_count), np.nan)
    part = take_lanes(grid, compared)
    if not len(compared):
        return error, same
    fell = response["outcome"][compared] == Outcome.OVERTURNED
    reference_fell = reference["outcome"] == Outcome.OVERTURNED
    shape = (len(compared), -1, reference["rotation"].shape[-1])
    ours = response["rotation"][compared].reshape(shape)
    theirs = reference["rotation"].reshape(shape)
    angle = _by_block(part.lanes.slenderness_angle)[:, :, None]
    limit = np.where((fell & reference_fell)[:, None, None], angle, 0.5 * np.pi - 1e-6)
    beyond = (np.maximum(np.abs(ours), np.abs(theirs)) >= limit).any(axis=1)
    standing = (np.cumsum(beyond, axis=1) == 0)[:, None, :]
    difference = np.where(standing, np.abs(ours - theirs), 0.0) / angle
    holds = _reference_holds(part, response["peak_slide"][compared])
    holds &= np.isin(reference["status"], SOUND)
    # A released block that has not come down yet has tried no contact.
    holds &= ~part.free | (reference["impact_count"] > 0) | reference_fell
    error[compared] = np.where(holds, difference.max(axis=(1, 2)), np.nan)
    same[compared] = np.where(holds, fell == reference_fell, np.nan)
    return error, same


def _reference_holds(grid: LaneGrid, slide: Array) -> Mask:
    """Whether the engine's blocks stay where the reference has them, shape [lane].

    What friction the reference needs, its status says. On a still base a slide is an error of the
    engine; the stacks of the atlas have friction enough.
    """
    return np.asarray(grid.free | _by_block(slide <= SLIDE_BOUND * grid.lanes.width).all(axis=1))
