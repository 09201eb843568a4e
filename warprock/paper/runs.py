"""Runs of the shipped cases that the paper's tables and figures share, each done once."""

from __future__ import annotations

import contextlib
import csv
import dataclasses
import math
import os
import pathlib
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.columns import Columns
from warprock.case.load import load_case
from warprock.engines import engine_class
from warprock.engines.base import AbstractEngine
from warprock.engines.launching import Form, Target
from warprock.figures.drawing import Drawing
from warprock.model.batch import Batch
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes
from warprock.paper.conflict_texts import Conflict
from warprock.paper.kept import kept
from warprock.running.batch import warm_up_together
from warprock.running.case_run import require_options
from warprock.running.files import replacing
from warprock.running.options import RunOptions
from warprock.verification.case_responses import CaseResponses

if TYPE_CHECKING:
    from warprock.verification.study import StudyRun

Array = npt.NDArray[np.float64]
Row = dict[str, Any]
KernelUse = tuple[AbstractEngine, Lanes, GroundMotions]
"""What needs a kernel."""

ENGINES = ("housner", "impulse")
FAMILIES = (*ENGINES, "event", "direct", "dem")
"""Those, the most accurate one that slides, and our members of the families of the paper's other
programs: Vortex and 3DEC."""
ROUGH_FRICTION = 5.0
"""Friction that bears the velocity steps of the displacement reading without slip."""
FIRST_SWING_TIME = 0.2
"""Time [s] that Fig. 9a of the paper shows."""
READINGS = ("displacement", "acceleration", "double-size")
PULSE, SINE, B0, B123, SENSITIVITY = (
    "single-sine-pulse",
    "single-continuous-sine",
    "free-b0",
    "free-b1-b3",
    "sensitivity-b0",
)
PULSE_ENSEMBLE, SINE_ENSEMBLE = "stack-sine-pulse-ensemble", "stack-continuous-sine-ensemble"
COLLAPSE, SPACE = "stack-collapse", "single-spatial-sine"
STACK_PULSE, STACK_SINE = "stack-sine-pulse", "stack-continuous-sine"
"""The shipped cases that the targets run."""
SPACE_ENGINES = ("impulse", "dem")
"""In space: rigid contact, and the springs of the paper's distinct elements."""
STACK_ENGINES = ("two-block", "event", "impulse", "dem")
ENSEMBLE_ENGINE = "event"
"""Engine of the ensembles: of those that can slide, the one with the smaller error."""
_PULSE: dict[str, tuple[str, ...]] = {STACK_PULSE: STACK_ENGINES}
_SINE: dict[str, tuple[str, ...]] = {STACK_SINE: STACK_ENGINES}
_PULSE_MEMBERS = {PULSE_ENSEMBLE: (ENSEMBLE_ENGINE,)}
_SINE_MEMBERS = {SINE_ENSEMBLE: (ENSEMBLE_ENGINE,)}
STACK_ENGINES_OF: dict[str, dict[str, tuple[str, ...]]] = {
    "table9": _PULSE | _PULSE_MEMBERS,
    "table10": _PULSE | _PULSE_MEMBERS,
    "table11": _SINE | _SINE_MEMBERS,
    "table12": _SINE | _SINE_MEMBERS,
    "fig12": _PULSE,
    "fig13": _PULSE | _PULSE_MEMBERS,
    "fig14": _SINE,
    "fig15": _SINE | _SINE_MEMBERS,
    "collapse": {COLLAPSE: (ENSEMBLE_ENGINE,)},
}
"""Target of stacks -> the shipped cases that it runs, and the engines that run each."""

MEMBERS: dict[tuple[str, ...], int] = {
    (PULSE_ENSEMBLE,): 256,
    (SINE_ENSEMBLE,): 128,
    (COLLAPSE,): 32,
    (SPACE,): 16,
}
"""Members in a cell where not all of a case run: powers of two, as Sobol' points are balanced then.

Of 128 members a quantile lies within 4.4 points of its rank at the median, 1.9 at 5 % (standard
error, at most); against all 2,000 the medians of the pulses move by 4 % at most, those of the sine
by 9 %, and no value of the paper enters or leaves the range from 5 to 95 %. A share has a standard
error of 9 % at most in 32 members. The input under which blocks fall in space keeps all of its own
with the settings of the paper.
"""

ORACLE_TIME = {PULSE: 3.0, SINE: 5.0}
"""Time [s] that the oracle follows a case for its peaks.

The pulses end within 0.34 s, after which the block only loses energy; under continuous sine every
lane peaks within its first cycles. A later peak of an engine shows in the table as a difference.
"""


@dataclasses.dataclass(frozen=True)
class Reproduction:
    """What one target found.

    Attributes:
        rows: Tidy rows, ours and the paper's.
        files: Files written.
        conflicts: Conflicts that these rows alone can tell of.
        drawings: Its figures, which are among the files.
    """

    rows: list[Row]
    files: list[pathlib.Path]
    conflicts: tuple[Conflict, ...] = ()
    drawings: Sequence[Drawing] = ()


def write_rows(rows: list[Row], path: pathlib.Path) -> pathlib.Path:
    """Writes rows as CSV, whole or not at all; what is missing or no number is an empty cell."""
    path.parent.mkdir(parents=True, exist_ok=True)
    table = Columns.of(rows)
    cells = [_cells(table.columns[name]) for name in table]
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator=os.linesep).writerows(
            [[*table], *zip(*cells, strict=True)]
        )
    return path


def _cells(values: Sequence[Any]) -> list[Any]:
    """The cells of a column: whole numbers are written as others are where some are missing."""
    missing = [value is None or value != value for value in values]
    whole = [type(value) is int for value in values]
    mixed = any(whole) and all(
        none or type(value) in (int, float) for none, value in zip(missing, values, strict=True)
    )
    kind = float if mixed and not all(whole) else lambda value: value
    return ["" if none else kind(value) for none, value in zip(missing, values, strict=True)]


def written_number(value: Any) -> float | None:
    """An input as the case file has it: 8 mm, not 8.000000000000002."""
    return None if value is None else float(f"{value:.12g}")


class PaperRuns:
    """Runs of the shipped cases, each done once however many targets want it."""

    def __init__(
        self,
        workers: int | None = None,
        progress: Callable[[int], None] | None = None,
        members: int | None = None,
        full: bool = False,
    ) -> None:
        """Holds nothing yet.

        Args:
            workers: Worker threads of a run; None leaves it to the batch runner.
            progress: Called with the number of lanes finished so far, over all runs.
            members: Members in a cell of an ensemble; None takes those of `MEMBERS`.
            full: Whether ensembles have all members of their cases where `members` is None.
        """
        self._workers, self._progress = workers, progress
        self._members, self._full = members, full
        self._cases: dict[tuple[str, ...], CaseResponses] = {}
        self._oracle_peaks: dict[str, Array] = {}
        self._studies: dict[str, StudyRun] = {}
        self._lanes_done, self._counting = 0, threading.Lock()

    def case(self, name: str, *overrides: str, fewer: int | None = None) -> CaseResponses:
        """The responses of a shipped case, run when they are asked for.

        Args:
            name: The case.
            overrides: Changes of it.
            fewer: Members in a cell of its ensemble where not all run; None takes those of
                `MEMBERS`.
        """
        key = (name, *overrides)
        if key not in self._cases:
            case = load_case(name, overrides)
            members = self._members or (None if self._full else MEMBERS.get(key, fewer))
            if case.ensemble is not None and members is not None:
                case = load_case(name, [*overrides, f"ensemble.members={members}"])
            self._cases[key] = CaseResponses(case, self._workers, finished=self._note)
        return self._cases[key]

    def warm_up(
        self, engines_of: Mapping[str, Iterable[str]], others: Iterable[KernelUse] = ()
    ) -> None:
        """Compiles or loads the kernels of cases, by their engines, and of others, side by side."""
        batches = list(others)
        for name, engines in engines_of.items():
            responses = self.case(name)
            lanes, motions = responses.lane_set.lanes, responses.lane_set.motions
            settings = responses.case.engine_settings
            batches += [(engine_class(e)(settings(e)), lanes, motions) for e in engines]
        warm_up_together(batches)

    def run_ahead(self, wanted: Iterable[tuple[CaseResponses, str]]) -> None:
        """Runs engines on cases on a thread of its own; who asks for one in hand waits for it.

        A run that fails there is run again, and fails, where it is asked for.
        """

        def run() -> None:
            with contextlib.suppress(Exception):
                for responses, engine in wanted:
                    responses[engine]

        threading.Thread(target=run, daemon=True).start()

    def study_batches(self, name: str) -> list[KernelUse]:
        """What the study of a shipped case runs, for its kernels."""
        responses = self.case(name)
        study, lane_set = responses.case.study, responses.lane_set
        assert study is not None
        plain = Target(form=Form.PLAIN)
        return [
            (engine_class(engine)(variation.settings, plain), lane_set.lanes, lane_set.motions)
            for engine in study.engines
            for variation in study.variations(engine)
        ]

    def study(self, name: str) -> StudyRun:
        """The study of a shipped case, run when it is first asked for."""
        from warprock.verification.study import run_study

        if name not in self._studies:
            options = RunOptions(workers=self._workers)
            self._studies[name] = run_study(load_case(name), options=options, finished=self._note)
        return self._studies[name]

    def oracle_peaks(self, name: str) -> Array:
        """Peak rotation ratios of the oracle in the first `ORACLE_TIME` of a case, shape [lane]."""
        if name not in self._oracle_peaks:
            lane_set = self.case(name).lane_set
            times = SampleTimes(min(ORACLE_TIME[name], lane_set.times.duration))
            batch = Batch(lane_set.lanes, lane_set.motions, times)
            peaks = kept(lambda: _oracle_peaks(batch), *batch)
            self._oracle_peaks[name] = peaks / lane_set.lanes.slenderness_angle
            self._note(lane_set.lanes.lane_count)
        return self._oracle_peaks[name]

    def timed(
        self,
        engine: str,
        batch: Batch,
        *,
        settings: Any = None,
        repeats: int = 1,
        enough: float = math.inf,
    ) -> tuple[Response, float]:
        """A response, and the CPU time that it took one core [s], kernels built and loaded before.

        Args:
            engine: Name in `ENGINES`.
            batch: What it runs.
            settings: Settings of the engine; its defaults where None.
            repeats: Runs, of which the quickest counts.
            enough: CPU time of all runs [s] after which no more are made.

        Raises:
            InputError: No engine has that name.
        """
        require_options(engine)
        built = engine_class(engine)(settings)
        built.warm_up(batch.lanes, batch.motions)
        least, spent = math.inf, 0.0
        for _ in range(repeats):
            begin = time.thread_time()
            response = built.run(*batch)
            took = time.thread_time() - begin
            least, spent = min(least, took), spent + took
            if spent >= enough:
                break
        self._note(batch.lanes.lane_count)
        return response, least

    def _note(self, lane_count: int) -> None:
        with self._counting:
            self._lanes_done += lane_count
            if self._progress is not None:
                self._progress(self._lanes_done)


def _oracle_peaks(batch: Batch) -> Array:
    """Peak rotations of the oracle [rad], shape [lane]."""
    from warprock.oracle.block import oracle_response

    return oracle_response(*batch)["peak_rotation"]


def lane_evidence(runs: PaperRuns, name: str) -> Columns:
    """The lanes of a forced case as the conflicts need them; see `conflicts.Evidence`."""
    responses = runs.case(name)
    lane_set, housner = responses.lane_set, responses["housner"]
    slenderness = lane_set.lanes.slenderness_angle
    ratio = housner["rotation"] / slenderness[:, None]
    inputs = lane_set.table
    table = {name: inputs[name] for name in ("reading", "frequency_hz", "amplitude_mm")} | {
        "housner": housner["peak_rotation"] / slenderness,
        "impulse": responses["impulse"]["peak_rotation"] / slenderness,
        "slide_mm": 1e3 * responses["impulse"]["peak_slide"],
        "first_swing": _first_swing(inputs, ratio[:, housner.times <= FIRST_SWING_TIME + 1e-9]),
    }
    if name == PULSE:
        rough = runs.case(name, f"contact.friction={ROUGH_FRICTION}")["impulse"]
        table["impulse_rough"] = rough["peak_rotation"] / slenderness
    return Columns(table)


def _first_swing(table: Columns, ratio: Array) -> Array:
    """Each lane's rotation ratio when the displacement reading of its input swings furthest."""
    inputs = list(zip(table["frequency_hz"], table["amplitude_mm"], strict=True))
    displaced = np.flatnonzero(table.among("reading", ["displacement"]))
    sample = {inputs[lane]: int(np.argmax(np.abs(ratio[lane]))) for lane in displaced}
    return np.array([ratio[lane, sample[key]] for lane, key in enumerate(inputs)])
