"""What `run` prints: every lane of a small run, counts and ranges of a large one."""

from __future__ import annotations

import pathlib
from collections.abc import Sequence

from warprock.case.columns import columns_of
from warprock.model.response import Status
from warprock.model.undecided import cut_text
from warprock.run.case_run import CaseRun
from warprock.run.lane_table import lane_table, peak_ratio_columns
from warprock.run.provenance import count_words, error_summary
from warprock.tables.accuracy import run_accuracy_lines
from warprock.tables.terminal import cell_text, print_rows, print_written, wide_stdout

LANES_SHOWN = 40
"""Lanes up to which `run` prints every one; a larger run prints its counts and ranges."""

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


def print_run(run: CaseRun, files: Sequence[pathlib.Path]) -> None:
    """Prints a run: every lane of a small one, counts and ranges of a large one."""
    out = wide_stdout()
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
    print_written(files, out)


def _swept_columns(run: CaseRun) -> list[str]:
    """Columns of the inputs that the case sweeps: `height_m` for the key `block.height`."""
    swept = {name for axis in run.case.axes for key in axis.columns for name in columns_of(key)}
    return [str(name) for name in run.lane_set.inputs.columns if name in swept]


def _range_text(bounds: Sequence[float]) -> str:
    low, high = bounds
    return cell_text(low) if low == high else f"{cell_text(low)} to {cell_text(high)}"
