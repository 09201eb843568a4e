"""Responses of one case, each engine run once however many checks or tables ask for it."""

from __future__ import annotations

import threading
from collections.abc import Callable

from warprock.case.case import Case
from warprock.case.lanes import expand_lanes
from warprock.model.response import Response
from warprock.programs.table import PROGRAMS, PeerAnswer
from warprock.running.case_run import run_case
from warprock.running.options import RunOptions
from warprock.verification.beside import ORACLE, run_oracle, run_peer
from warprock.verification.settings import case_asked, plain_name


class CaseResponses:
    """The responses of a case."""

    def __init__(
        self,
        case: Case,
        workers: int | None = None,
        finished: Callable[[int], None] | None = None,
        progress: Callable[[int], None] | None = None,
    ) -> None:
        """Holds the case; nothing runs yet.

        Args:
            case: The case, with its overrides.
            workers: Worker threads of a run; None leaves it to the batch runner.
            finished: Called after each run with its number of lanes.
            progress: Called with the number of lanes finished so far in all runs, and by the
                programs beside the engines within theirs.
        """
        self.case = case
        self.lane_set = expand_lanes(case)
        self._workers, self._finished = workers, finished
        self._responses: dict[str, Response] = {}
        self.answers: dict[str, PeerAnswer] = {}
        self._progress, self._done = progress, 0
        self._running = threading.RLock()

    def __getitem__(self, engine: str) -> Response:
        # Whoever asks for what another thread runs waits for it.
        with self._running:
            if engine not in self._responses:
                self._responses[engine] = self._run(engine)
                if self._finished is not None:
                    self._finished(self.lane_set.lanes.lane_count)
                self._done += self.lane_set.lanes.lane_count
                self._report(0)
            return self._responses[engine]

    def _report(self, lanes: int) -> None:
        """Reports lanes finished of the run at hand beside those of the runs before it."""
        if self._progress is not None:
            self._progress(self._done + lanes)

    def _run(self, engine: str) -> Response:
        case, name = case_asked(self.case, engine), plain_name(engine)
        if name == ORACLE:
            return run_oracle(case, self.lane_set)
        if name in PROGRAMS:
            self.answers[engine] = run_peer(case, self.lane_set, name, self._report)
            return self.answers[engine].response
        # An ensemble has too many lanes to hold the histories of.
        histories = None if self.case.ensemble is None else False
        # Engines are compared at the step asked for, not at the finer one that a lane may need.
        options = RunOptions(workers=self._workers, tolerance=None)
        return run_case(case, name, options, histories=histories).response
