"""What runs on the lanes of a case beside the engines: the oracle, and programs of others."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from warprock.case.case import Case
from warprock.case.lanes import LaneSet
from warprock.engines import ENGINES
from warprock.errors import DeclinedError, InputError
from warprock.model.response import Response, SampleTimes
from warprock.programs.table import PROGRAMS, PeerAnswer, require_scenes, run_program
from warprock.running.case_run import require_support
from warprock.verification.settings import OPTION, case_asked, plain_name

ORACLE = "oracle"
"""Name of the SciPy reference in `compare`; not an engine."""


def require_scene(case: Case, lane_set: LaneSet, name: str) -> None:
    """Refuses lanes that what runs them cannot do, before anything runs.

    Args:
        case: The case, which may hold settings of the engine or of the program.
        lane_set: Its lanes.
        name: Name of an engine, of the oracle or of a program.

    Raises:
        InputError: It cannot do the scene, with its reason.
    """
    if name in ENGINES:
        require_support(case, lane_set, name)
        return
    reason: object = None
    if name == ORACLE:
        reason = _beyond_the_oracle(lane_set)
    else:
        batch = (lane_set.lanes, lane_set.motions, lane_set.times)
        try:
            require_scenes(name, *batch, case.peer_settings(name))
        except DeclinedError as error:
            reason = error
    if reason is not None:
        raise InputError(case.file, OPTION, name, f"cannot do this scene: {reason}")


def _beyond_the_oracle(lane_set: LaneSet) -> str | None:
    """Why the SciPy reference cannot do lanes; None where it can."""
    reason = lane_set.scene.beyond_the_plane
    if lane_set.scene.moving:
        return f"it lets blocks go from rest, and the case {lane_set.scene.moving}"
    if reason is None and lane_set.scene.bodies:
        return "it knows boxes alone, and the case has a body (block.base)"
    if reason is not None or not lane_set.lanes.stacked:
        return reason
    from warprock.oracle.pair_lanes import why_not

    return why_not(lane_set.lanes)


def run_oracle(case: Case, lane_set: LaneSet) -> Response:
    """Runs the lanes of a case with the SciPy reference, of one block or of two.

    Raises:
        InputError: It cannot do the scene.
    """
    require_scene(case, lane_set, ORACLE)
    if not lane_set.lanes.stacked:
        from warprock.oracle.block import oracle_response

        return oracle_response(lane_set.lanes, lane_set.motions, lane_set.times)
    from warprock.oracle.pair_lanes import two_block_response

    return two_block_response(lane_set.lanes, lane_set.motions, lane_set.times)


def require_programs(names: Iterable[str]) -> None:
    """Refuses programs that are not installed, before anything runs.

    Raises:
        InputError: One is not; the text says what installs it.
    """
    for name in names:
        if name in PROGRAMS and not PROGRAMS[name].installed:
            program = PROGRAMS[name]
            absent = " and ".join(p for p in program.packages if not program.has(p))
            allowed = f"needs {absent}, which {program.install} installs"
            raise InputError(OPTION, "", name, allowed)


def run_peer(
    case: Case, lane_set: LaneSet, name: str, finished: Callable[[int], None] | None = None
) -> PeerAnswer:
    """Runs the lanes of a case in a program.

    Args:
        case: The case, which may hold settings of the program.
        lane_set: Its lanes.
        name: Name in `PROGRAMS`.
        finished: Called with the number of lanes done so far.

    Raises:
        InputError: It is not installed, or cannot do the scene.
        ChildProcessError: It runs in a process of its own, which failed.
    """
    require_programs([name])
    # An ensemble has too many lanes to hold the histories of.
    times = lane_set.times
    if case.ensemble is not None:
        times = SampleTimes(times.duration)
    require_scene(case, lane_set, name)
    settings = case.peer_settings(name)
    try:
        return run_program(name, lane_set.lanes, lane_set.motions, times, settings, finished)
    except ImportError as error:
        raise InputError(OPTION, "", name, f"does not start: {error}") from None


def cost_rows(case: Case, answers: Mapping[str, PeerAnswer]) -> list[dict[str, Any]]:
    """What the programs' runs cost: one row a program, ready for JSON.

    Returns:
        engine, settings (by name), steps_per_s (taken, of each lane), cpu_s (of the steps alone)
        and cpu_s_per_simulated_s, of one block.
    """
    return [
        {
            "engine": name,
            "settings": dataclasses.asdict(case_asked(case, name).peer_settings(plain_name(name))),
            "steps_per_s": answer.steps_per_s,
            "cpu_s": answer.cpu_s,
            "cpu_s_per_simulated_s": answer.cost,
        }
        for name, answer in answers.items()
    ]
