"""The seed paper's tables and figures, recomputed beside what it prints.

Every target runs shipped cases with the engines. Targets on single blocks compare engines with
Housner, lane by lane; those on stacks show them beside ensembles. Where the paper may be read in
several ways, each reading has its rows, and the paper's conflicts are named.
"""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
import math
import pathlib
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeAlias

from warprock.case.columns import Columns
from warprock.engines import reference_engine
from warprock.errors import InputError
from warprock.figures.drawing import Drawing, write_drawings
from warprock.paper import conflicts
from warprock.paper.printed import PAPER_COLUMNS, as_number, paper_columns
from warprock.paper.runs import (
    B0,
    B123,
    COLLAPSE,
    ENGINES,
    FAMILIES,
    ORACLE_TIME,
    PULSE,
    PULSE_ENSEMBLE,
    SENSITIVITY,
    SINE,
    SINE_ENSEMBLE,
    SPACE,
    SPACE_ENGINES,
    STACK_ENGINES_OF,
    PaperRuns,
    Reproduction,
    Row,
    lane_evidence,
    write_rows,
    written_number,
)
from warprock.running.files import require_writable
from warprock.verification.beside import ORACLE
from warprock.verification.case_responses import CaseResponses
from warprock.verification.housner import housner_columns
from warprock.verification.plain import plain_row

Maker: TypeAlias = Callable[[str, PaperRuns, pathlib.Path], Reproduction]
"""Makes the rows and files of a target."""

ENGINES_OF: dict[str, dict[str, tuple[str, ...]]] = {
    "table6": {PULSE: FAMILIES},
    "table7": {SINE: ENGINES},
    "table7-spatial": {SPACE: SPACE_ENGINES},
    "fig4": {B0: ENGINES, SENSITIVITY: ()},
    "fig5": {B123: ENGINES},
    "fig7": {PULSE: ENGINES},
    "fig8": {PULSE: ENGINES},
    "fig10": {SINE: ENGINES},
    "fig11": {SINE: ENGINES},
    "dem": {},
    "times": {},
    **STACK_ENGINES_OF,
}
"""Target -> the shipped cases whose responses it shows, and the engines that run each.

`dem` and `times` run lanes of their own, and the sensitivity study its settings.
"""
CASES_OF = {target: tuple(engines_of) for target, engines_of in ENGINES_OF.items()}
"""Target -> the shipped cases whose responses it shows."""
GROUPS: dict[str, tuple[str, ...]] = {
    "single-block": ("table6", "table7", "fig5", "fig7"),
    "all": tuple(CASES_OF),
}
"""Targets that are made together: what the paper says first, which is soon done, and all of it."""
TARGETS: tuple[str, ...] = (*CASES_OF, *GROUPS)
"""What `reproduce` takes."""

ERROR_COLUMNS = (
    "error_5s_ratio",
    "error_run_ratio",
    "peak_error",
    "rest_time_error_s",
    "peak_slide_mm",
    "holds",
    "why",
    "friction_needed",
)
"""Columns of `compare_with_housner` that the rows of an engine carry."""


def reproduce(
    target: str,
    folder: pathlib.Path,
    *,
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
    members: int | None = None,
    full: bool = False,
    drawings: list[Drawing] | None = None,
) -> dict[str, Any]:
    """Recomputes a table or a figure of the paper and writes its CSV and PNG files.

    Args:
        target: One of `TARGETS`.
        folder: Where to write; made if it does not exist.
        workers: Worker threads of a run; None leaves it to the batch runner.
        progress: Called with the number of lanes finished so far.
        members: Members in a cell of an ensemble; None takes fewer than their cases have.
        full: Whether ensembles have all members of their cases where `members` is None.
        drawings: A list that takes the figures, which are written in any case.

    Returns:
        By key:

        - `target`: The target.
        - `rows`: Each has `target`, `frequency_hz`, `amplitude_mm`, `reading`, `source` and
          `peak_rotation_ratio`, which is None where there is none and of a stack is divided by
          9.85 deg. Engines on single blocks have their errors against Housner; stacks the `block`,
          `geometry` and `edges`; the sensitivity study the `knob`, its `value` and the cost; run
          times the scene and what it took.
        - `conflicts`: Each has `item`, `title` and `text`.
        - `files`: What was written.
        - `seconds`: Wall time of each part by its name, with what it waits for.

    Raises:
        InputError: An unknown target, or a folder that cannot be written to.
    """
    if target not in TARGETS:
        raise InputError("TARGET", "", target, f"must be one of {', '.join(TARGETS)}")
    require_writable(folder)
    runs = PaperRuns(workers, progress, members, full)
    targets = GROUPS.get(target, (target,))
    cases = {case for name in targets for case in CASES_OF[name]}
    seconds = dict[str, float]()
    if len(targets) > 1:
        with _clock("kernels", seconds):
            _compile(targets, runs)
    parts = _make_targets(targets, runs, folder, seconds, paged=drawings is not None)
    if drawings is not None:
        drawings += [drawing for part in parts for drawing in part.drawings]
    rows = [row for part in parts for row in part.rows]
    evidence = conflicts.Evidence(
        pulse=lane_evidence(runs, PULSE) if PULSE in cases else None,
        sine=lane_evidence(runs, SINE) if SINE in cases else None,
    )
    named = conflicts.conflicts_of(targets, evidence)
    named += [conflict for part in parts for conflict in part.conflicts]
    if set(targets) & set(STACK_ENGINES_OF):
        from warprock.paper.conflicts_stack import stack_conflicts_of
        from warprock.paper.stack import stack_evidence

        named += stack_conflicts_of(targets, stack_evidence(runs, cases))
    return {
        "target": target,
        "rows": [plain_row(row) for row in rows],
        "conflicts": [dataclasses.asdict(c) for c in sorted(named, key=lambda c: c.item)],
        "files": [str(file) for part in parts for file in part.files],
        "seconds": seconds,
    }


def _compile(targets: Sequence[str], runs: PaperRuns) -> None:
    """Compiles the kernels of all targets side by side."""
    others = runs.study_batches(SENSITIVITY) if "fig4" in targets else []
    if "dem" in targets:
        from warprock.paper.dem import dem_batches

        others += dem_batches(runs)
    if "times" in targets:
        from warprock.paper.times import times_batches

        others += times_batches(runs)
    runs.warm_up(_engines_of(targets), others)


@contextlib.contextmanager
def _clock(part: str, seconds: dict[str, float]) -> Iterator[None]:
    """Notes the wall time of the block [s] under the name of a part."""
    begin = time.perf_counter()
    yield
    seconds[part] = seconds.get(part, 0.0) + time.perf_counter() - begin


def _make_targets(
    targets: Sequence[str],
    runs: PaperRuns,
    folder: pathlib.Path,
    seconds: dict[str, float],
    paged: bool,
) -> list[Reproduction]:
    """Every target; with `paged` its figures as a page shows them, too.

    What tells of run times comes first and has the machine for itself. Then ensembles run beside
    all else, and what waits for them comes last.
    """
    found: dict[str, Reproduction] = {}

    def make(name: str) -> None:
        with _clock(name, seconds):
            found[name] = _MAKERS[name](name, runs, folder)
            for drawing in found[name].drawings if paged else ():
                drawing.svg()

    if "fig4" in targets:
        with _clock("fig4", seconds):
            runs.study(SENSITIVITY)
    if "times" in targets:
        make("times")
    runs.run_ahead(_ensembles(targets, runs))
    for name in sorted((name for name in targets if name not in found), key=_waits_for):
        make(name)
    return [found[name] for name in targets]


def _waits_for(target: str) -> int:
    """Which ensembles a target waits for, in the order in which they run; 0 is none."""
    if target == "table7-spatial":
        return 2
    return int(any(case in _ENSEMBLES for case in CASES_OF[target]))


_ENSEMBLES = (PULSE_ENSEMBLE, SINE_ENSEMBLE, COLLAPSE)
"""The ensembles in the plane, in the order in which they run."""


def _ensembles(targets: Sequence[str], runs: PaperRuns) -> list[tuple[CaseResponses, str]]:
    """The ensembles of targets, each with its engine: the long runs, the longest last."""
    engines_of = _engines_of(targets)
    found = [
        (runs.case(case), engine) for case in _ENSEMBLES for engine in engines_of.get(case, ())
    ]
    if "table7-spatial" in targets:
        from warprock.paper.space import space_ensembles

        found += space_ensembles(runs)
    return found


def _engines_of(targets: Iterable[str]) -> dict[str, set[str]]:
    """The cases of targets, and all engines that run each."""
    found: dict[str, set[str]] = {}
    for target in targets:
        for case, engines in ENGINES_OF[target].items():
            found.setdefault(case, set()).update(engines)
    return found


def _engine_rows(target: str, runs: PaperRuns, name: str) -> list[Row]:
    """Peaks of engines and the oracle, with the engines' errors, one row a lane and source."""
    responses = runs.case(name)
    lane_set = responses.lane_set
    inputs = lane_set.table.records
    rows: list[Row] = []
    for engine in ENGINES_OF[target][name]:
        held = housner_columns(lane_set, responses[engine], responses[reference_engine()])
        rows += [
            _row(target, inputs[lane], engine, found["peak_rotation_ratio"])
            | {column: found[column] for column in ERROR_COLUMNS}
            for lane, found in enumerate(Columns(held).records)
        ]
    if name in ORACLE_TIME:
        rows += [
            _row(target, inputs[lane], ORACLE, peak)
            for lane, peak in enumerate(runs.oracle_peaks(name))
        ]
    return rows


def _row(target: str, inputs: Any, source: str, ratio: float | None) -> Row:
    row: Row = {
        "target": target,
        "frequency_hz": written_number(inputs.get("frequency_hz")),
        "amplitude_mm": written_number(inputs.get("amplitude_mm")),
        "reading": str(inputs.get("reading", "")) or None,
        "source": source,
        "peak_rotation_ratio": ratio,
    }
    if "block" in inputs:
        row["block"] = str(inputs["block"])
        row["rotation_ratio_start"] = float(inputs["rotation_ratio_start"])
    return row


def _table6(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
    rows = _engine_rows(target, runs, PULSE)
    for printed in paper_columns("table6").records:
        rows += [
            _row(target, printed | {"reading": "as printed"}, f"paper-{name}", float(printed[name]))
            for name in PAPER_COLUMNS
        ]
    return Reproduction(rows, [write_rows(rows, folder / "table6.csv")])


def _table7(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
    rows = _engine_rows(target, runs, SINE)
    routes = conflicts.inferred_experiment(lane_evidence(runs, SINE))
    for index, printed in enumerate(paper_columns("table7").records):
        as_printed = printed | {"reading": "as printed"}
        for name in PAPER_COLUMNS:
            number = as_number(printed[name])
            row = _row(target, as_printed, f"paper-{name}", None)
            row["abs_error_pct"] = None if math.isnan(number) else number
            if printed[name] == "collapsed":
                row["why"] = "printed as collapsed: it overturned, where the test did not"
            rows.append(row)
        for column, reading, values in zip(
            ("analytical", "bullet"), ("double-size", "displacement"), routes, strict=True
        ):
            row = _row(target, printed | {"reading": reading}, "inferred-experiment", values[index])
            row["why"] = f"`housner` / (1 - error of the paper's {column} column), not measured"
            rows.append(row)
    return Reproduction(rows, [write_rows(rows, folder / "table7.csv")])


def _figure(draw: Callable[[PaperRuns], list[Drawing]], cases: Sequence[str]) -> Maker:
    """A maker that draws a figure and gives the rows of its cases."""

    def make(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
        folder.mkdir(parents=True, exist_ok=True)
        rows = [row for name in cases for row in _engine_rows(target, runs, name)]
        drawings = draw(runs)
        files = [write_rows(rows, folder / f"{target}.csv"), *write_drawings(drawings, folder)]
        return Reproduction(rows, files, drawings=drawings)

    return make


def _figure4(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
    """B0 free, and the paper's study of what the settings of two programs do to it."""
    from warprock.paper.study import draw_figures, study_conflict
    from warprock.verification.study import COLUMNS as STUDY_COLUMNS

    free = _figure(_drawn("figure4"), (B0,))(target, runs, folder)
    study = runs.study(SENSITIVITY)
    rows = [
        _row(target, found, str(found["engine"]), float(found["peak_rotation_ratio"]))
        | {"case": SENSITIVITY, "lane": found["lane"]}
        | {column: found[column] for column in STUDY_COLUMNS}
        for found in study.table.to_dict("records")
    ]
    table = write_rows(rows, folder / "fig4-study.csv")
    drawings = draw_figures(study)
    files = [*free.files, table, *write_drawings(drawings, folder)]
    conflict = study_conflict(study)
    return Reproduction(free.rows + rows, files, (conflict,), [*free.drawings, *drawings])


def _drawn(name: str) -> Callable[[PaperRuns], list[Drawing]]:
    """A function of `paper.figures`, which is imported once it draws."""

    def draw(runs: PaperRuns) -> list[Drawing]:
        from warprock.paper import figures

        drawings: list[Drawing] = getattr(figures, name)(runs)
        return drawings

    return draw


def _of(module: str, name: str) -> Maker:
    """A maker in a file of this room, which is imported once it makes something."""

    def make(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
        own: Maker = getattr(importlib.import_module(f"warprock.paper.{module}"), name)
        return own(target, runs, folder)

    return make


_MAKERS: dict[str, Maker] = {
    "table6": _table6,
    "table7": _table7,
    "table7-spatial": _of("space", "run_space"),
    "fig4": _figure4,
    "fig5": _figure(_drawn("figure5"), CASES_OF["fig5"]),
    "fig7": _figure(_drawn("figure7"), CASES_OF["fig7"]),
    "fig8": _figure(_drawn("figure8"), CASES_OF["fig8"]),
    "fig10": _figure(_drawn("figure10"), CASES_OF["fig10"]),
    "fig11": _figure(_drawn("figure11"), CASES_OF["fig11"]),
    "dem": _of("dem", "run_dem_study"),
    "times": _of("times", "run_times"),
    **{target: _of("stack", "run_stack") for target in STACK_ENGINES_OF},
}
