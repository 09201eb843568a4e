"""What the commands print: one JSON object, or tables for a terminal.

Results go to stdout, progress to stderr.
"""

from __future__ import annotations

import contextlib
import enum
import json
import math
import pathlib
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import rich.console
import rich.progress
import rich.table
from rich.cells import cell_len

from warprock.model.response import Status
from warprock.tables.accuracy import run_accuracy_lines

if TYPE_CHECKING:
    import pandas as pd

    from warprock.run.case_run import CaseRun

LANES_SHOWN = 40
"""Lanes up to which `run` prints every one; a larger run prints its counts and ranges."""

WIDTH = 200
"""Columns of what is printed into a file or a pipe."""

OUT_OF_PLANE = ("peak_rotation_across_rad", "peak_yaw_rad")
"""What is shown besides of blocks in space."""

RESULT_COLUMNS = (
    "outcome",
    "status",
    "impact_count",
    "rest_time_s",
)
"""Columns of the lane table that `run` prints behind the inputs and the peaks."""


MODEL_COLUMNS = ("friction_needed",)
"""Columns behind those, of engines whose blocks cannot slide."""

OUTSIDE = (
    "outside_model: there the block needs more friction than it has, and would slide, or its base "
    "would have to pull it (inf); with -e event it may slide and leave its base"
)
"""What is said of lanes outside Housner's model."""


def plain(value: Any) -> Any:
    """The same value from types that JSON has; NaN and infinities become null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, set, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, (enum.Enum, pathlib.PurePath)):
        return str(value)
    return value


def print_json(found: Mapping[str, Any]) -> None:
    """Prints one JSON object on stdout."""
    sys.stdout.write(json.dumps(plain(found), indent=2, allow_nan=False, ensure_ascii=False) + "\n")


def print_rows_json(
    facts: Mapping[str, Any], rows: pd.DataFrame, files: Sequence[pathlib.Path]
) -> None:
    """Prints facts, the rows of a table and the files that were written as one JSON object."""
    print_json({**facts, "rows": rows.to_dict("records"), "files": files})


@contextlib.contextmanager
def lane_progress(text: str, total: int | None) -> Iterator[Callable[[int], None]]:
    """A progress bar on stderr while the block runs; nothing where stderr is no terminal.

    Args:
        text: What is running.
        total: Number of lanes; None if it is not known.

    Yields:
        A function to call with the number of lanes finished so far.
    """
    console = rich.console.Console(stderr=True)
    columns = (
        rich.progress.TextColumn("{task.description}"),
        rich.progress.BarColumn(),
        rich.progress.MofNCompleteColumn(),
        rich.progress.TimeElapsedColumn(),
    )
    bar = rich.progress.Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    )
    with bar:
        task = bar.add_task(text, total=total)
        yield lambda done: bar.update(task, completed=done)


def print_listing(found: Mapping[str, Any]) -> None:
    """Prints what `catalogue.list_all` found."""
    print_rows("Cases", found["cases"])
    print_rows("Engines", found["engines"])
    print_rows("Programs of others, for compare", found["programs"])


def print_explanation(found: Mapping[str, Any]) -> None:
    """Prints what `catalogue.explain_case` found."""
    out = _stdout()
    case, scene = found["case"], found["scene"]
    out.print(f"{case['name']}: {case['title']}", style="bold")
    out.print(case["source"].strip())
    out.print(f"\nScene: {scene['why']}.")
    restitution = "given by the case" if scene["restitution_given"] else "Housner's closed form"
    if scene["stacked"] or scene["spatial_because"]:
        restitution = "from the contact laws of the engine"
    sampling = found["sample_interval_s"]
    facts = [
        ("blocks", scene["block_count"]),
        ("contact points", scene["contact_point_count"]),
        ("ground motion", scene["motion"]),
        ("angular restitution", restitution),
        (
            "smallest friction / base acceleration in g that makes a block rock",
            scene["friction_ratio"],
        ),
        ("lanes", found["lanes"]),
        ("duration [s]", found["duration_s"]),
        ("histories every [s]", "not asked for" if sampling is None else sampling),
    ]
    for name, value in facts:
        out.print(f"  {name}: {_text(value)}")
    if found["motion_cut_short"]:
        out.print(f"  {found['motion_cut_short']}", soft_wrap=True)
    if scene["friction_note"]:
        out.print(f"  friction: {scene['friction_note']}")
    for axis in found["sweep"]:
        keys = ", ".join(axis["keys"])
        out.print(f"  sweep: {keys} ({axis['length']} values)")
    out.print("\nLeft out, because nothing here needs it:")
    for text in scene["left_out"]:
        out.print(f"  {text}")
    if found["study"]:
        _print_study_plan(out, found["study"])
    part = found["inputs_of_lanes"] < found["lanes"]
    first = f" (of the first {found['inputs_of_lanes']:,} lanes)" if part else ""
    out.print(f"\nInputs{first}:")
    for name, spread in found["inputs"].items():
        out.print(f"  {name}: {_spread_text(spread)}")
    engine = found["engine"]
    out.print(f"\nWhere no engine is named, {engine['engine']} runs: {engine['why']}.")
    out.print("\nEngines:")
    for engine in found["engines"]:
        _print_engine(out, engine)


def print_run(run: CaseRun, files: Sequence[pathlib.Path]) -> None:
    """Prints a run: every lane of a small one, counts and ranges of a large one."""
    from warprock.model.undecided import cut_text
    from warprock.run.lane_table import lane_table, peak_ratio_columns
    from warprock.run.provenance import count_words, error_summary

    out = _stdout()
    response = run.response
    table = lane_table(run.lane_set, response)
    peaks = peak_ratio_columns(run.lane_set)
    title = f"{run.case.name}: {response.engine}, {response.lane_count} lanes"
    if response.lane_count <= LANES_SHOWN:
        shown = ["lane", *_swept_columns(run), *peaks]
        if "peak_time_s" in table:
            shown.append("peak_time_s")
        slides = [column for column in map(str, table) if column.startswith("peak_slide_")]
        in_mm = {column: f"{column.removesuffix('_m')}_mm" for column in slides}
        table = table.assign(**{mm: 1e3 * table[column] for column, mm in in_mm.items()})
        shown += in_mm.values()
        shown += [column for column in OUT_OF_PLANE if column in table]
        errors = [column for column in map(str, table) if column.startswith("rotation_error_")]
        for column in errors:
            table[column] = table[column].map("{:.1e}".format)
        needed = [column for column in MODEL_COLUMNS if column in table]
        columns = [*shown, *RESULT_COLUMNS, *needed, *errors]
        print_rows(title, table[columns].to_dict("records"))
    else:
        out.print(title, style="bold")
        for name in peaks:
            bounds = [float(table[name].min()), float(table[name].max())]
            out.print(f"  {name}: {_range_text(bounds)}")
    for name in ("outcome", "status"):
        counts = count_words(response, name)
        words = ", ".join(f"{count} {word}" for word, count in counts.items() if count)
        out.print(f"{name}: {words}")
    cut = cut_text(run.lane_set.motions, run.lane_set.times.duration)
    if cut:
        out.print(cut, soft_wrap=True)
    if run.lane_set.scene.friction_note and response.engine not in ("housner", "two-block"):
        out.print(f"friction: {run.lane_set.scene.friction_note}")
    if "friction_needed" in response.fields and response.count(Status.OUTSIDE_MODEL):
        out.print(OUTSIDE)
    error = error_summary(response)
    if error is not None:
        out.print(
            f"estimated error of the rotations, lanes that are ok: median {error['median']:.2g} "
            f"rad, largest {error['largest']:.2g} rad"
        )
    for line in run_accuracy_lines(run):
        out.print(line, soft_wrap=True)
    out.print(f"wall time: {run.wall_time:.3g} s")
    for path in files:
        out.print(f"wrote {path}", soft_wrap=True)


def print_examination(found: Mapping[str, Any]) -> None:
    """Prints what `doctor.examine` found."""
    out = _stdout()
    for name, version in found["versions"].items():
        out.print(f"{name}: {version or 'missing'}")
    out.print(f"cpu: {found['cpu']}, {found['cores']} cores")
    flags = ", ".join(found["vector_flags"]) or "not listed by this system"
    out.print(f"vector instructions: {flags}")
    for device in found["devices"]:
        out.print(f"device {device['device']}: {device['name']}")
    cache = found["kernel_cache"]
    text = f"kernel cache: {cache['folder']}, {cache['built_modules']} built modules"
    out.print(text, soft_wrap=True)
    out.print(f"kernel sources: sha256 {found['kernel_sha256'][:16]}")
    for name, state in found["engines"].items():
        out.print(f"engine {name}: {state}")
    for note in found["notes"]:
        out.print(f"note: {note}")
    for thing in found["missing"]:
        out.print(f"missing: {thing}", style="bold red")
    if not found["missing"]:
        out.print("nothing is missing")


def print_bench(found: Mapping[str, Any]) -> None:
    """Prints what `bench.run_bench` and `peers.compare` measured."""
    facts = found["machine"]
    flags = " ".join(facts["vector_flags"])
    print_rows(
        f"Measured here and now: {facts['cpu']}, {facts['cores']} cores, {flags}", found["rows"]
    )
    print_rows("Ratios", [{"ratio": k, "value": v} for k, v in found["ratios"].items()])
    print_rows("Block B0, free rocking over 5 s: error and its cost, one core", found["accuracy"])
    peers = found["peers"]
    if peers["rows"]:
        hidden = ("settings", "cpu_s")
        rows = [{k: v for k, v in row.items() if k not in hidden} for row in peers["rows"]]
        print_rows("The same block in peers, one core, beside event at no larger an error", rows)
        for name, settings in {row["peer"]: row["settings"] for row in peers["rows"]}.items():
            _stdout().print(f"{name}: {settings}")
    print_rows("Steps of a block in space in a CPU second, one core", [peers["space"]])
    for line in peers["missing"]:
        _stdout().print(f"peer not installed: {line}")
    print_rows("Commands", [{"command": k, "seconds": v} for k, v in found["commands"].items()])


def _stdout() -> rich.console.Console:
    # Without a terminal there is no width to fit into.
    width = None if sys.stdout.isatty() else WIDTH
    return rich.console.Console(width=width, highlight=False, markup=False)


def print_rows(title: str, rows: Sequence[Mapping[Any, Any]]) -> None:
    """Prints rows as a table whose columns are their keys."""
    out = _stdout()
    names = list(dict.fromkeys(str(name) for row in rows for name in row))
    cells = [[_text(row.get(name)) for name in names] for row in rows]
    gaps = 2 * (len(names) - 1)
    widths = _column_widths(names, cells, out.width - gaps)
    table = rich.table.Table(title=title, title_justify="left", box=None, pad_edge=False)
    for name, width in zip(names, widths, strict=True):
        table.add_column(name, overflow="fold", width=width)
    for row in cells:
        table.add_row(*row)
    out.width = max(out.width, sum(widths) + gaps)
    out.print(table)


def _column_widths(names: Sequence[str], cells: Sequence[Sequence[str]], room: int) -> list[int]:
    """Characters of each column: headings are folded to fit, no word and no number of a cell."""
    columns = list(zip(*cells, strict=True))
    needed = [
        max(cell_len(part) for cell in column for part in ("", *cell.split())) for column in columns
    ]
    wanted = [
        max(cell_len(text) for text in (name, *column))
        for name, column in zip(names, columns, strict=True)
    ]
    found = wanted
    for most in range(max(wanted, default=0), 0, -1):
        found = [max(least, min(full, most)) for least, full in zip(needed, wanted, strict=True)]
        if sum(found) <= room:
            break
    return found


def _swept_columns(run: CaseRun) -> list[str]:
    """Columns of the inputs that the case sweeps: `height_m` for the key `block.height`."""
    from warprock.case.columns import columns_of

    swept = {name for axis in run.case.axes for key in axis.columns for name in columns_of(key)}
    return [str(name) for name in run.lane_set.inputs.columns if name in swept]


def _print_engine(out: rich.console.Console, engine: Mapping[str, Any]) -> None:
    if engine["declines"]:
        out.print(f"  {engine['name']}: declines: {engine['declines']}")
        return
    out.print(f"  {engine['name']}: {engine['kernel']}")
    for name, value in engine["settings"].items():
        unit = engine["units"][name]
        suffix = "" if unit == "-" else f" {unit}"
        out.print(f"    {name} = {_text(value)}{suffix}")
    if engine["estimate"]:
        out.print(f"    {engine['estimate']}")


def _print_study_plan(out: rich.console.Console, study: Sequence[Mapping[str, Any]]) -> None:
    """What `run` will run of a study."""
    out.print("\nStudy: `run` varies one setting at a time; check and compare run the case's own.")
    for plan in study:
        out.print(f"  {plan['engine']}: {plan['runs']} runs")
        for row in plan["vary"]:
            unit = "" if row["unit"] == "-" else f" [{row['unit']}]"
            values = ", ".join(_text(value) for value in row["values"])
            own = _text(row["baseline"])
            out.print(f"    {row['setting']}{unit}: {values} (the case's own: {own})")
        if plan["lacks"]:
            out.print(f"    it has no {', no '.join(plan['lacks'])}")


def _spread_text(spread: Mapping[str, Any]) -> str:
    if "values" in spread:
        return ", ".join(_text(value) for value in spread["values"])
    return f"{_text(spread['from'])} to {_text(spread['to'])}, {spread['count']} values"


def _range_text(bounds: Sequence[float]) -> str:
    low, high = bounds
    return _text(low) if low == high else f"{_text(low)} to {_text(high)}"


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, (float, np.floating)):
        return "-" if math.isnan(value) else f"{value:.6g}"
    return str(value)
