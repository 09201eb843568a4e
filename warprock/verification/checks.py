"""What a case expects of its engines, checked: one function a kind of check, one row a result."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from warprock.analysis.boundaries import boundaries_at
from warprock.case.case import Case
from warprock.engines import ENGINES, reference_engine
from warprock.errors import InputError
from warprock.model.response import Status
from warprock.programs.table import PROGRAMS
from warprock.running.cells import compare_cells
from warprock.verification.assemblies import compare_assemblies
from warprock.verification.beside import (
    ORACLE,
    cost_rows,
    require_programs,
    require_scene,
)
from warprock.verification.blocks import compare_blocks
from warprock.verification.case_responses import CaseResponses
from warprock.verification.check_row import CheckRow
from warprock.verification.housner import compare_with_housner
from warprock.verification.lane_names import lane_name
from warprock.verification.observed_poses import compare_with_observed, pose_rows
from warprock.verification.outcomes import outcome_rows
from warprock.verification.plain import plain_row
from warprock.verification.settings import case_asked, plain_name, require_known

__all__ = ["CHECKS", "ORACLE", "CheckRow", "compare", "compare_with_housner", "run_checks"]


def _selection_text(where: Mapping[str, str]) -> str:
    return ", ".join(f"{label} = {value}" for label, value in where.items()) or "all"


def _check_peaks(check: Any, responses: CaseResponses) -> list[CheckRow]:
    """Peak rotation ratios of the selected lanes against the values in the case."""
    lane_set = responses.lane_set
    lanes = np.asarray(lane_set.select(check.where))
    response = responses[check.engine]
    ratio = response["peak_rotation"][lanes] / lane_set.lanes.slenderness_angle[lanes]
    of_block = ""
    if check.block is not None:
        ratio, of_block = ratio[:, check.block - 1], f" of block {check.block}"
    if len(ratio) != len(check.values):
        raise InputError(
            str(responses.case.file),
            "check.values",
            len(check.values),
            f"the selection has {len(ratio)} lanes; overrides changed the sweep",
        )
    difference = np.abs(ratio - np.asarray(check.values))
    difference[~np.isfinite(difference)] = np.inf
    worst = int(np.argmax(difference))
    note = (
        f"worst lane: {lane_name(lane_set, int(lanes[worst]))}, "
        f"{ratio[worst]:.5f} for {check.values[worst]:.5f}"
    )
    return [
        CheckRow(
            case=responses.case.name,
            name=f"peak rotation ratio{of_block}, largest difference",
            engine=check.engine,
            lanes=_selection_text(check.where),
            value=float(difference[worst]),
            limit=check.tolerance,
            ok=bool(difference[worst] <= check.tolerance),
            because=check.because,
            note=note,
            outside=response.count(Status.OUTSIDE_MODEL, lanes),
        )
    ]


def _check_housner(check: Any, responses: CaseResponses) -> list[CheckRow]:
    """Histories of the selected lanes against Housner's, where Housner holds."""
    lane_set = responses.lane_set
    lanes = np.asarray(lane_set.select(check.where))
    table = compare_with_housner(lane_set, responses[check.engine], responses[reference_engine()])
    selected = table.iloc[lanes]
    held = selected[selected["holds"]]
    left_out = [
        f"{lane_name(lane_set, int(lane))} left out ({why})"
        for lane, why in zip(lanes, selected["why"], strict=True)
        if why
    ]
    limits = [("error_5s_ratio", "over 5 s", check.limit_5s)]
    if check.limit_run is not None:
        limits.append(("error_run_ratio", "over the run", check.limit_run))
    rows = []
    for column, span, limit in limits:
        errors = held[column].to_numpy(dtype=float)
        errors = np.where(np.isfinite(errors), errors, np.inf)
        value = float(errors.max()) if len(errors) else np.nan
        note = left_out.copy()
        if len(errors):
            worst = lane_name(lane_set, int(held.index[int(np.argmax(errors))]))
            note.insert(0, f"worst lane: {worst}")
        else:
            note.insert(0, "Housner holds in none of these lanes, so nothing was checked")
        rows.append(
            CheckRow(
                case=responses.case.name,
                name=f"max |rotation - Housner| / slenderness angle {span}",
                engine=check.engine,
                lanes=_selection_text(check.where),
                value=value,
                limit=limit,
                ok=bool(len(errors) and value <= limit),
                because=check.because,
                note="; ".join(note),
                outside=responses[reference_engine()].count(Status.OUTSIDE_MODEL, lanes),
            )
        )
    return rows


def _check_boundaries(check: Any, responses: CaseResponses) -> list[CheckRow]:
    """Boundaries of a map of overturning against the values in the case."""
    case, ratio = responses.case, check.frequency_ratio
    tolerance = 0.1 * check.tolerance / max(check.values)
    found = boundaries_at(case, check.engine, check.where, ratio, accuracy=tolerance)
    same = len(found) == len(check.values)
    value = float(np.abs(found - check.values).max()) if same else np.inf
    return [
        CheckRow(
            case=case.name,
            name=f"boundaries at omega_p / p = {ratio:g}, largest difference",
            engine=check.engine,
            lanes=_selection_text(check.where),
            value=value,
            limit=check.tolerance,
            ok=value <= check.tolerance,
            because=check.because,
            note=f"found {', '.join(f'{each:.4f}' for each in found) or 'none'}",
        )
    ]


def _check_outcomes(check: Any, responses: CaseResponses) -> list[CheckRow]:
    """What became of the selected lanes against what tests showed."""
    lane_set, response = responses.lane_set, responses[check.engine]
    text = _selection_text(check.where)
    return outcome_rows(check, responses.case, lane_set, response, text)


def _check_poses(check: Any, responses: CaseResponses) -> list[CheckRow]:
    """Where the selected lanes are, against where their blocks were seen."""
    lane_set, response = responses.lane_set, responses[check.engine]
    text = _selection_text(check.where)
    return pose_rows(check, responses.case, lane_set, response, text)


CHECKS: dict[str, Callable[[Any, CaseResponses], list[CheckRow]]] = {
    "peaks": _check_peaks,
    "housner": _check_housner,
    "boundaries": _check_boundaries,
    "outcomes": _check_outcomes,
    "poses": _check_poses,
}
"""Kind of a check -> the function that makes its rows."""


def run_checks(case: Case) -> list[CheckRow]:
    """Runs the engines that a case's checks need and makes the checks' rows.

    Args:
        case: The case.

    Returns:
        The rows in the order of the checks; empty for a case without checks.
    """
    if not case.checks:
        return []
    responses = CaseResponses(case)
    return [row for check in case.checks for row in CHECKS[check.kind](check, responses)]


def compare(
    case: Case,
    engines: Sequence[str],
    workers: int | None = None,
    progress: Callable[[int], None] | None = None,
) -> dict[str, object]:
    """Engines side by side on one case: a row a lane and engine, with its errors.

    Args:
        case: The case.
        engines: Engines' names, with settings of their own (`case_asked`) or without; "oracle" is
            the SciPy reference, names in `PROGRAMS` are programs that we did not write.
        workers: Worker threads of a run; None leaves it to the batch runner.
        progress: Called with the number of lanes finished so far in all runs.

    Returns:
        `case`, `engines`, `stacked`, `spatial`, `costs` (`beside.cost_rows`) and `rows`:
        those of `compare_with_housner`, or of `compare_blocks` against the first engine for stacks
        and in space, of `compare_assemblies` for assemblies (`assembly` is there, too), with `lane`
        (its name); a value that does not exist is None. For an ensemble,
        what `compare_distributions` returns; of a case that has a check of observed poses, what
        `compare_with_observed` does.

    Raises:
        InputError: No engine, an unknown one, a program that is not installed, or a single engine
            for an ensemble.
        ChildProcessError: A program that runs in a process of its own failed.
    """
    require_known(engines, [*ENGINES, ORACLE, *PROGRAMS])
    require_programs(map(plain_name, engines))
    responses = CaseResponses(case, workers, progress=progress)
    for engine in engines:
        require_scene(case_asked(case, engine), responses.lane_set, plain_name(engine))
    if case.ensemble is not None:
        return compare_distributions(responses, engines)
    if case.observed_poses is not None:
        found = compare_with_observed(case, responses.lane_set, engines, responses)
        return found | {"costs": cost_rows(case, responses.answers)}
    stacked, scene = case.tables.stacked, responses.lane_set.scene
    spatial, side_by_side = scene.spatial, stacked or scene.spatial or scene.assembly
    reference = engines[0] if side_by_side else reference_engine()
    hold = compare_blocks if side_by_side else compare_with_housner
    hold = compare_assemblies if scene.assembly else hold
    rows: list[dict[str, object]] = []
    for engine in engines:
        table = hold(responses.lane_set, responses[engine], responses[reference])
        numbers = table["lane_number"] if side_by_side else range(len(table))
        names = [lane_name(responses.lane_set, lane) for lane in numbers]
        named = table.assign(lane=names, engine=engine)
        if side_by_side:
            named["reference"] = reference
        rows += [plain_row(row) for row in named.to_dict("records")]
    return {
        "case": case.name,
        "engines": list(engines),
        "stacked": stacked,
        "spatial": spatial,
        **({"assembly": True} if scene.assembly else {}),
        "costs": cost_rows(case, responses.answers),
        "rows": rows,
    }


def compare_distributions(responses: CaseResponses, engines: Sequence[str]) -> dict[str, object]:
    """Engines side by side on an ensemble, whose lanes are draws and not to be compared singly.

    Args:
        responses: Responses of a case with an ensemble.
        engines: Engines' names; each is held against the first.

    Returns:
        `case`, `engines`, `members`, `stacked`, `blocks` and `rows`, those of
        `running.cells.compare_cells` cell by cell with `engine_a`, `engine_b`; a median among
        overturned lanes is "overturned".

    Raises:
        InputError: A single engine.
    """
    if len(engines) < 2:
        raise InputError("--engine", "", engines[0], "must be given twice for an ensemble")
    lane_set, first = responses.lane_set, engines[0]
    rows = [
        {"engine_a": first, "engine_b": engine}
        | {key: "overturned" if value == np.inf else value for key, value in row.items()}
        for engine in engines[1:]
        for row in compare_cells(lane_set, responses[first], responses[engine]).to_dict("records")
    ]
    rows.sort(key=lambda row: int(row["cell"]))
    return {
        "case": responses.case.name,
        "engines": list(engines),
        "members": lane_set.members,
        "stacked": lane_set.lanes.stacked,
        "blocks": lane_set.lanes.block_count,
        "costs": cost_rows(responses.case, responses.answers),
        "rows": [plain_row(row) for row in rows],
    }
