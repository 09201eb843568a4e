"""Engines and programs beside what was seen: where blocks were, lane by lane, in one run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from warprock.case.case import Case
from warprock.case.lanes import LaneSet
from warprock.model.response import Response
from warprock.verification.check_row import CheckRow
from warprock.verification.lane_names import lane_name
from warprock.verification.plain import plain_row
from warprock.verification.poses import compare_poses, histories_of_errors, read_poses


class Responses(Protocol):
    """Responses by the name of an engine or a program."""

    def __getitem__(self, engine: str) -> Response:
        """The response of one."""


def pose_rows(
    check: Any, case: Case, lane_set: LaneSet, response: Response, lanes_text: str
) -> list[CheckRow]:
    """Rows of a check of observed poses: mean errors of the position and of the rotation.

    Args:
        check: The check.
        case: Its case.
        lane_set: Lanes of the case.
        response: Response of the engine that is checked, with histories of places.
        lanes_text: The lanes that are selected, in words.
    """
    table = compare_poses(lane_set, response, read_poses(case, lane_set, check.file))
    held = table[table["lane_number"].isin(lane_set.select(check.where))]
    rows = []
    for column, what, limit in (
        ("position_error_mm", "position error / mm", 1e3 * check.position),
        ("rotation_error_deg", "rotation error / deg", float(np.rad2deg(check.rotation))),
    ):
        errors = held[column].to_numpy(dtype=float)
        value = float(errors.mean())
        worst = int(held["lane_number"].to_numpy()[int(np.argmax(errors))])
        rows.append(
            CheckRow(
                case=case.name,
                name=f"{what}, mean of lanes over time",
                engine=check.engine,
                lanes=lanes_text,
                value=value,
                limit=limit,
                ok=value <= limit,
                because=check.because,
                note=f"worst lane: {lane_name(lane_set, worst)}",
            )
        )
    return rows


def compare_with_observed(
    case: Case, lane_set: LaneSet, engines: Sequence[str], responses: Responses
) -> dict[str, object]:
    """Engines side by side on a case whose blocks were seen, each held against that.

    Args:
        case: A case with a check of observed poses.
        lane_set: Its lanes.
        engines: Names of engines and programs.
        responses: Their responses, by name.

    Returns:
        `case`, `engines`, `stacked`, `spatial`, `observed` (the file); `rows`, those of
        `compare_poses` with `lane`, its name; and `over_time`, by engine: `time_s`, and means over
        the lanes that are still seen, `position_error_mm` and `rotation_error_deg`.
    """
    file = case.observed_poses
    assert file is not None
    seen = read_poses(case, lane_set, file)
    rows: list[dict[str, object]] = []
    over_time: dict[str, Any] = {}
    for engine in engines:
        table = compare_poses(lane_set, responses[engine], seen)
        names = [lane_name(lane_set, int(lane)) for lane in table["lane_number"]]
        table = table.assign(lane=names, engine=engine)
        rows += [plain_row(row) for row in table.to_dict("records")]
        over_time[engine] = histories_of_errors(responses[engine], seen)
    return {
        "case": case.name,
        "engines": list(engines),
        "stacked": False,
        "spatial": True,
        "observed": file,
        "rows": rows,
        "over_time": over_time,
    }
