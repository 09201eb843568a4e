"""What accuracy costs: every engine with a range of its own settings, on fixed scenes, row by row.

The table is written again after every row, so that a run that was stopped can be continued.
Rows that were measured with other kernels or on another processor are measured anew if asked for.
"""

from __future__ import annotations

import datetime
import json
import pathlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from warprock.engines import ENGINES, engine_class
from warprock.errors import InputError, Said
from warprock.measure.price import LEVELS
from warprock.measure.trade_knobs import TRADE_KNOBS, Settings
from warprock.measure.trade_scenes import TRADE_SCENES, lane_errors
from warprock.model.batch import Batch
from warprock.model.response import SOUND, Response, SampleTimes
from warprock.model.scene import scene_kind
from warprock.running import machine
from warprock.running.batch import LANE_QUANTUM, run_batch
from warprock.running.case_run import PRECISIONS, require_choice
from warprock.running.files import replacing
from warprock.running.lane_table import arrow_table
from warprock.running.parts import State, find_part, read_part, write_part
from warprock.running.provenance import PACKAGES
from warprock.settings.engines import build_settings

TABLE, CSV = "trade.parquet", "trade.csv"

COST_SECONDS = 0.3
"""CPU time that a measurement of cost aims at [s]; a coarser one would be noise."""

COST_LANES_MOST = 2**16
"""Lanes up to which a measurement that would be too short takes more of them."""

REPEATS = 3
"""Measurements of a cost; the smallest counts, the others met other work on the machine."""

COLUMNS: dict[str, tuple[str, str]] = {
    "scene": ("-", "Class of scene"),
    "engine": ("-", "Engine"),
    "settings": ("-", "Settings that differ from the defaults, as JSON"),
    "precision": ("-", "Precision"),
    "error_max": (
        "-",
        "Largest |rotation - right one| / slenderness angle over run, blocks, lanes",
    ),
    "error_median": ("-", "Median over the lanes of that error of a lane"),
    "ok_share": ("-", "Share of lanes with the status ok"),
    "cpu_s_per_simulated_s": ("-", "CPU time of a simulated second of one block of many"),
    "steps_per_simulated_s": ("1/s", "Time steps of a lane in a simulated second, without samples"),
    "block_steps_per_cpu_s": ("1/s", "Time steps times blocks in a second of CPU time"),
    "cpu": ("-", "Processor"),
    "kernel_sha256": ("-", "Hash of the kernel sources"),
    "measured": ("-", "Date of the measurement"),
}
"""Columns of the table, with their units and meanings."""

KEYS = ["scene", "engine", "settings", "precision"]
PLACE = ["cpu", "kernel_sha256"]


class Entry(NamedTuple):
    """What one row of the table measures."""

    scene: str
    engine: str
    settings: Settings
    precision: str

    @property
    def key(self) -> tuple[str, str, str, str]:
        """Its values in the columns `KEYS`."""
        return self.scene, self.engine, json.dumps(dict(self.settings)), self.precision


def settings_text(settings: Mapping[str, Any]) -> str:
    """Settings in words, such as `time_step=0.001`; `defaults` where none differs."""
    return ", ".join(f"{k}={v:g}" for k, v in settings.items()) or "defaults"


def all_entries(
    scenes: Sequence[str] = tuple(TRADE_SCENES),
    engines: Sequence[str] | None = None,
    knobs: Mapping[str, Sequence[Settings]] = TRADE_KNOBS,
    precisions: Sequence[str] = PRECISIONS,
) -> list[Entry]:
    """Every row that a trade has: engines that can run a scene, over their knobs.

    Args:
        scenes: Keys of `TRADE_SCENES`.
        engines: Names of engines; all of them where None.
        knobs: Settings of each engine; its defaults where it has none.
        precisions: "float64", "float32" or both.

    Raises:
        InputError: An unknown scene or engine.
    """
    for scene in scenes:
        require_choice("--scene", scene, tuple(TRADE_SCENES))
    for engine in engines or ():
        require_choice("--engine", engine, tuple(ENGINES))
    entries = []
    for scene in scenes:
        lanes, motions = TRADE_SCENES[scene].build()
        kind = scene_kind(lanes, motions, restitution_given=False)
        for engine in engines or ENGINES:
            if engine_class(engine).supports(kind) is None:
                entries += [
                    Entry(scene, engine, settings, precision)
                    for settings in knobs.get(engine, ({},))
                    for precision in precisions
                ]
    return entries


def run_trade(
    entries: Sequence[Entry],
    folder: pathlib.Path,
    progress: Callable[[int], None] | None = None,
) -> pd.DataFrame:
    """Measures what is not yet in a folder's table, and writes the table after every row.

    Args:
        entries: The rows wanted.
        folder: Where the table lies; made if it does not exist.
        progress: Called with the number of rows that are there.

    Returns:
        The table, by scene and engine: the rows wanted, then others that the folder had.
    """
    here = {"cpu": machine.cpu_name(), "kernel_sha256": machine.kernel_hash()}
    rows = _read_rows(folder / TABLE)
    missing = [entry for entry in entries if not here.items() <= rows.get(entry.key, {}).items()]
    done = len(entries) - len(missing)
    for entry, row in _measure_all(missing, here):
        rows[entry.key] = row
        write_part(folder / TABLE, arrow_table(_as_table(rows, entries)), here)
        done += 1
        if progress is not None:
            progress(done)
    table = _as_table(rows, entries)
    write_part(folder / TABLE, arrow_table(table), here)
    return table


def _read_rows(path: pathlib.Path) -> dict[Any, dict[str, Any]]:
    """Rows of a table, by their keys; none where it is not there, or of another form.

    Raises:
        InputError: It cannot be read.
    """
    part = find_part(path, {})
    if part.state is State.MISSING:
        return {}
    try:
        table: pd.DataFrame = read_part(path).to_pandas()
    except OSError:
        allowed = "must be a table as it was written: delete it, and all rows are measured anew"
        raise InputError(str(path), "", Said("no Parquet"), allowed) from None
    if list(table) != list(COLUMNS):
        return {}
    rows = [{str(k): v for k, v in row.items()} for row in table.to_dict("records")]
    return {tuple(row[name] for name in KEYS): row for row in rows}


def _as_table(rows: Mapping[Any, Mapping[str, Any]], entries: Sequence[Entry]) -> pd.DataFrame:
    """Rows as a table, by scene and engine; else in the order of the entries, then others."""
    keys = [entry.key for entry in entries if entry.key in rows]
    keys += [key for key in rows if key not in set(keys)]
    scenes = {name: place for place, name in enumerate(TRADE_SCENES)}
    engines = {name: place for place, name in enumerate(ENGINES)}
    keys = [key for key in keys if key[0] in scenes and key[1] in engines]
    keys.sort(key=lambda key: (scenes[key[0]], engines[key[1]]))
    table = pd.DataFrame([rows[key] for key in keys], columns=list(COLUMNS))
    table.attrs["columns"] = {
        k: {"unit": unit, "text": text} for k, (unit, text) in COLUMNS.items()
    }
    return table


def write_csv(table: pd.DataFrame, folder: pathlib.Path) -> pathlib.Path:
    """Writes a table in the form in which one is shipped: where it comes from, then its rows."""
    versions = machine.package_versions(PACKAGES)
    lines = [
        "Error and cost of every engine's settings, measured by `warprock trade`.",
        *(f"{name}: {text}" for name, (_, text) in COLUMNS.items() if name not in PLACE),
        f"machine: {', '.join(table['cpu'].unique())}; one worker",
        f"vector instructions: {' '.join(machine.cpu_vector_flags())}",
        f"versions: {', '.join(f'{name} {version}' for name, version in versions.items())}",
        *(f"kernel sources: sha256 {digest}" for digest in table["kernel_sha256"].unique()),
    ]
    path = folder / CSV
    rounded = table.drop(columns=PLACE).round({"ok_share": 4})
    with replacing(path) as temporary:
        head = "".join(f"# {line}\n" for line in lines)
        rows = rounded.to_csv(index=False, float_format="%.4g")
        temporary.write_text(head + rows, encoding="utf-8")
    return path


def _measure_all(
    entries: Sequence[Entry], here: Mapping[str, str]
) -> Iterator[tuple[Entry, dict[str, Any]]]:
    """Measures rows one by one; a scene and its right answer are made once."""
    scenes: dict[str, tuple[Batch, Response]] = {}
    for entry in entries:
        if entry.scene not in scenes:
            scene = TRADE_SCENES[entry.scene]
            batch = Batch(*scene.build(), scene.times)
            scenes[entry.scene] = batch, scene.solve(*batch)
        numbers = measure(entry, *scenes[entry.scene])
        today = datetime.datetime.now(datetime.UTC).date().isoformat()
        keys = dict(zip(KEYS, entry.key, strict=True))
        yield entry, {**keys, **numbers, **here, "measured": today}


def measure(entry: Entry, batch: Batch, reference: Response) -> dict[str, Any]:
    """Error and cost of one setting of an engine on one scene.

    Args:
        entry: What to run.
        batch: The scene.
        reference: The right answer for them.

    Returns:
        The columns that hold measured numbers.
    """
    settings = build_settings(entry.engine, entry.settings, "trade")
    options = {"settings": settings, "precision": entry.precision}
    response = run_batch(entry.engine, *batch, **options)
    errors = lane_errors(response, reference, batch.lanes)
    cost, steps = cpu_cost(entry.engine, batch, options)
    return {
        "error_max": float(errors.max()),
        "error_median": float(np.median(errors)),
        "ok_share": float(np.mean(np.isin(response["status"], SOUND))),
        "cpu_s_per_simulated_s": cost,
        "steps_per_simulated_s": steps,
        "block_steps_per_cpu_s": steps / cost,
    }


def cpu_cost(engine: str, batch: Batch, options: dict[str, Any]) -> tuple[float, float]:
    """What a simulated second takes of one block of many, on one worker: CPU time [s] and steps.

    The lanes are repeated until they fill packs and take long enough; kernels are built already.
    There are no samples, for which `housner` would step ten times as often: both are of one run.

    Args:
        engine: Name in `ENGINES`.
        batch: A scene, of which samples are left out.
        options: Settings and precision.
    """
    lanes, motions, times = batch
    duration = times.duration

    def run(count: int) -> tuple[float, float]:
        places = np.arange(count) % lanes.lane_count
        many, moved = lanes.take(places), motions.take(places)
        begin = time.process_time()
        response = run_batch(
            engine, many, moved, SampleTimes(duration), workers=1, chunk_size=count, **options
        )
        took = time.process_time() - begin
        whole = lanes.lane_count * (count // lanes.lane_count)
        return took, float(np.mean(response["step_count"][:whole]))

    count = LANE_QUANTUM
    while (found := run(count))[0] < 0.3 * COST_SECONDS and count < COST_LANES_MOST:
        count *= 4
    spent, (least, steps) = found[0], found
    for _ in range(REPEATS - 1):
        if spent > COST_SECONDS:
            break
        took, _ = run(count)
        spent, least = spent + took, min(least, took)
    return least / (count * lanes.block_count * duration), steps / duration


def cheapest(table: pd.DataFrame, tolerance: float) -> pd.DataFrame:
    """Rows of a table that meet a tolerance in every lane, the cheapest first."""
    met = table[(table["error_max"] <= tolerance) & (table["ok_share"] == 1.0)]
    return met.sort_values("cpu_s_per_simulated_s", kind="stable")


def level_rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    """What each error level costs: one row a scene, engine and level that the engine met.

    Returns:
        scene, engine, error level, settings in words, precision, error_max and
        cpu_s_per_simulated_s of the cheapest setting that met it.
    """
    rows = []
    for (scene, engine), group in table.groupby(["scene", "engine"], sort=False):
        for level in LEVELS:
            found = cheapest(group, level)
            if len(found):
                best = found.iloc[0]
                rows.append(
                    {
                        "scene": scene,
                        "engine": engine,
                        "level": level,
                        "settings": settings_text(json.loads(best["settings"])),
                        "precision": best["precision"],
                        "error_max": float(best["error_max"]),
                        "cpu_s_per_simulated_s": float(best["cpu_s_per_simulated_s"]),
                    }
                )
    return rows
