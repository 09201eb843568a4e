"""Overturning maps: in which way a block falls, over the frequency and the strength of a pulse.

The plane is that of Zhang and Makris (2001): omega_p / p across, the angular frequency of the pulse
over the frequency parameter of the block, and a_p / (g tan(alpha)) up, its peak acceleration over
that which lifts the block. A block overturns without an impact (mode 2), after one or more impacts
(mode 1), or not at all, and rocking is not monotonic: above an area of mode 1 a block may stand
again. The lanes of a case make the grid; `overturning_boundaries` finds what lies between them.

J. Zhang and N. Makris (2001), Rocking response of free-standing blocks under cycloidal pulses,
*Journal of Engineering Mechanics* 127(5).
"""

from __future__ import annotations

import dataclasses
import enum

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.case.axes import crossed_labels
from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.errors import NOTHING, InputError, Said
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, Waveform
from warprock.model.response import USABLE, Outcome, Response
from warprock.model.undecided import decided_after, undecided
from warprock.running.case_run import CaseRun, require_options, run_case
from warprock.running.options import DEFAULT_OPTIONS, RunOptions
from warprock.settings.engines import on_springs

Array = npt.NDArray[np.float64]
Codes = npt.NDArray[np.int8]

MOTION = "motion"
FREQUENCY, AMPLITUDE = f"{MOTION}.frequency", f"{MOTION}.amplitude"
SAME_CYCLES = 1e-3
"""Cycles of a pulse that differ by less are the same."""


class Mode(enum.IntEnum):
    """What a pulse does to a block."""

    SAFE = 0
    WITH_IMPACT = 1
    WITHOUT_IMPACT = 2
    NO_NUMBER = 3
    UNDECIDED = 4

    @property
    def text(self) -> str:
        """The mode in words."""
        return self.name.lower().replace("_", " ")


def modes(response: Response, lanes: Lanes, motions: GroundMotions, duration: float) -> Codes:
    """Mode of every lane by `Mode`, shape [lane].

    No number where the status has none; undecided where a block that has not fallen may yet do so
    when its run ends, see `undecided`.

    Args:
        response: What became of the lanes.
        lanes: Their blocks.
        motions: Their ground motions.
        duration: Of the run [s].
    """
    fell = response["outcome"] == Outcome.OVERTURNED
    hit = response["impact_count"] > 0
    unknown = undecided(response, lanes, motions, duration, springs=on_springs(response.engine))
    found = np.select(
        [fell & hit, fell, unknown],
        [Mode.WITH_IMPACT, Mode.WITHOUT_IMPACT, Mode.UNDECIDED],
        Mode.SAFE,
    )
    usable = np.isin(response["status"], USABLE)
    return np.where(usable, found, Mode.NO_NUMBER).astype(np.int8)


@dataclasses.dataclass(frozen=True)
class OverturningMap:
    """A map.

    Attributes:
        run: The lanes of the grid and what became of them.
        groups: Labels of every group of lanes, a panel each.
        lanes: Numbers of the lanes, weakest first, shape [group, frequency, amplitude].
        boundaries: One row a boundary; see `boundaries.refine`.
        accuracy: Width of a boundary's bracket over its strength; None before it was refined.
        lanes_run: Lanes that were run, those of the grid included.
        stages: Batches after that of the grid.
        wall_time: Time that all took [s].
    """

    run: CaseRun
    groups: tuple[str, ...]
    lanes: npt.NDArray[np.intp]
    boundaries: pd.DataFrame
    accuracy: float | None
    lanes_run: int
    stages: int
    wall_time: float

    @property
    def frequency_ratio(self) -> Array:
        """omega_p / p [-], shape [group, frequency]."""
        inputs = self.run.lane_set.inputs
        rate = 2.0 * np.pi * inputs["frequency_hz"] / inputs["frequency_parameter_rad_s"]
        return np.asarray(rate)[self.lanes[:, :, 0]]

    @property
    def strength(self) -> Array:
        """a_p / (g tan(alpha)) of the grid [-], shape [group, frequency, amplitude]."""
        return strengths(self.run.lane_set)[self.lanes]

    @property
    def mode(self) -> Codes:
        """Modes of the grid, same shape."""
        return self.lane_mode[self.lanes]

    @property
    def lane_mode(self) -> Codes:
        """Mode of every lane of the grid, shape [lane]."""
        found, duration = self.run.lane_set, self.run.lane_set.times.duration
        return modes(self.run.response, found.lanes, found.motions, duration)

    @property
    def decided_after(self) -> float | None:
        """Duration of a run that leaves no lane of the map undecided [s]; None where this did."""
        open_lanes = np.flatnonzero(self.lane_mode == Mode.UNDECIDED)
        if not len(open_lanes) and not (self.boundaries.isin([Mode.UNDECIDED.text])).any(axis=None):
            return None
        lane_set = self.run.lane_set
        return float(np.ceil(decided_after(lane_set.lanes, lane_set.motions).max()))

    def closed_form(self, group: int) -> tuple[str, Array] | None:
        """The strength from which a slender block falls without an impact, where there is a form.

        Returns:
            Name of the pulse and a_p / (g alpha) over `frequency_ratio`; None for pulses other than
            a half or a whole sine of acceleration.
        """
        if self.run.lane_set.lanes.assembly is not None:
            return None
        first = self.run.lane_set.inputs.iloc[int(self.lanes[group, 0, 0])]
        if (first["waveform"], first["control"]) != (Waveform.SINE, Control.ACCELERATION):
            return None
        cycles = (first["stop_s"] - first["start_s"]) * first["frequency_hz"]
        ratio = self.frequency_ratio[group]
        if abs(cycles - 0.5) < SAME_CYCLES:
            return "half sine", rocking.half_sine_overturning_amplitude(ratio)
        if abs(cycles - 1.0) < SAME_CYCLES:
            return "one-cycle sine", rocking.one_cycle_sine_overturning_amplitude(ratio)
        return None


def strengths(lane_set: LaneSet) -> Array:
    """a_p / (g tan(alpha)) of every lane [-], shape [lane]."""
    return lane_set.inputs["normalised_acceleration"].to_numpy(dtype=np.float64)


def run_grid(
    case: Case,
    engine: str,
    options: RunOptions = DEFAULT_OPTIONS,
) -> OverturningMap:
    """Runs the coarse grid: every lane of a case.

    Args:
        case: A case of one block that sweeps the frequency and the amplitude of a pulse.
        engine: Name of the engine.
        options: How the lanes are run, each once whatever the tolerance: near a boundary every lane
            is sensitive, and how far a step moves the boundary is seen with half of the step.

    Raises:
        InputError: An option or a case that no map can be made of.
    """
    groups, lanes = _layout(case)
    once = dataclasses.replace(options, tolerance=None)
    require_options(engine, once)
    strength = strengths(expand_lanes(case))
    lanes = np.take_along_axis(lanes, np.argsort(strength[lanes], axis=2, kind="stable"), axis=2)
    if not (np.all(strength > 0.0) and np.all(np.diff(strength[lanes], axis=2) > 0.0)):
        allowed = "must move the base, and no two of the same strength, in every lane of a column"
        raise InputError(case.source_of("sweep"), AMPLITUDE, Said("the grid"), allowed)
    run = run_case(case, engine, once, histories=False)
    return OverturningMap(
        run=run,
        groups=groups,
        lanes=lanes,
        boundaries=pd.DataFrame(),
        accuracy=None,
        lanes_run=lanes.size,
        stages=0,
        wall_time=run.wall_time,
    )


def _layout(case: Case) -> tuple[tuple[str, ...], npt.NDArray[np.intp]]:
    """Groups of a case, and the numbers of their lanes, shape [group, frequency, amplitude].

    Raises:
        InputError: The case does not sweep what a map needs, or cannot be a map.
    """
    source = case.source_of("sweep")
    tables = case.tables
    for given, key, what in (
        (tables.stacked, "block", "a stack: a map is of one block"),
        (case.ensemble is not None, "ensemble", "given: a map has its own lanes"),
        (case.study is not None, "study", "given: a map has one engine"),
    ):
        if given:
            raise InputError(case.source_of(key), key, Said("the table"), f"must not be {what}")
    if tables.motion is None:
        raise InputError(case.file, "motion", NOTHING, "must be given: a map needs a pulse")
    if tables.motion.waveform in (Waveform.PUSH, Waveform.TILT):
        allowed = (
            "must be a pulse: `warprock limit --push` finds the load of a push, and of a tilting "
            "table, by halving, for all lanes of a sweep"
        )
        key = f"{MOTION}.waveform"
        raise InputError(case.source_of(key), key, Said(tables.motion.waveform.value), allowed)
    places = {}
    for key in (FREQUENCY, AMPLITUDE):
        found = [n for n, axis in enumerate(case.axes) if key in axis.columns]
        if not found or case.axes[found[0]].sample is not None:
            allowed = "must be swept, a [[sweep]] of its own: it is an axis of the map"
            raise InputError(source, key, Said("no list of values"), allowed)
        places[key] = found[0]
    if places[FREQUENCY] == places[AMPLITUDE]:
        allowed = f"must not be zipped with {FREQUENCY}: write another [[sweep]] to cross them"
        raise InputError(source, AMPLITUDE, Said("one axis for both"), allowed)
    lanes = np.arange(case.lane_count, dtype=np.intp).reshape(case.shape)
    lanes = np.moveaxis(lanes, (places[FREQUENCY], places[AMPLITUDE]), (-2, -1))
    lanes = lanes.reshape(-1, *lanes.shape[-2:])
    return crossed_labels(case.axes, set(places.values()), source), lanes
