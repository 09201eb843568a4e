"""Engines and programs beside what was seen: where blocks were, lane by lane, in one run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from warprock.compare.beside import cost_rows
from warprock.compare.lane_names import lane_name
from warprock.compare.plain import plain_row
from warprock.compare.poses import compare_poses, histories_of_errors, read_poses

if TYPE_CHECKING:
    from warprock.compare.checks import CaseResponses


def compare_with_observed(responses: CaseResponses, engines: Sequence[str]) -> dict[str, object]:
    """Engines side by side on a case whose blocks were seen, each held against that.

    Args:
        responses: Responses of a case with a check of observed poses.
        engines: Names of engines and programs.

    Returns:
        `case`, `engines`, `stacked`, `spatial`, `observed` (the file), `costs`; `rows`, those of
        `compare_poses` with `lane`, its name; and `over_time`, by engine: `time_s`, and means over
        the lanes that are still seen, `position_error_mm` and `rotation_error_deg`.
    """
    case, lane_set = responses.case, responses.lane_set
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
        "costs": cost_rows(case, responses.answers),
        "rows": rows,
        "over_time": over_time,
    }
