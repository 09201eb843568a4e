"""From a case to its lanes: blocks, starts, ground motions and the table of inputs.

Lane i is a pure function of the case and i: its digits in mixed radix over the sweep's axes pick
one value of each. All work is done on whole arrays; what can be wrong with one value alone was
refused when the case was read, and what can be wrong with a combination is refused here.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np
import numpy.typing as npt

from warprock import rocking
from warprock.axes import LABEL
from warprock.case import Case
from warprock.case_ensemble import CELL_COLUMNS
from warprock.case_keys import Said
from warprock.case_stacks import stack_columns, stack_lanes
from warprock.case_tables import PeaksCheck
from warprock.case_values import LaneValues
from warprock.errors import InputError
from warprock.lanes import Lanes
from warprock.motion import Control, GroundMotions, StillBase, Waveform
from warprock.response import FIELDS, SampleTimes
from warprock.scene import SceneKind, scene_kind
from warprock.stacking import uplift_ratio
from warprock.units import GRAVITY, Dimension
from warprock.waveforms import harmonic_motions, ricker_motions

if TYPE_CHECKING:
    import pandas as pd

    from warprock.records import Record

Array = npt.NDArray[np.float64]

_DERIVATIVE = {Control.DISPLACEMENT: 0, Control.VELOCITY: 1, Control.ACCELERATION: 2}
_DIMENSION = {
    Control.DISPLACEMENT: Dimension.LENGTH,
    Control.VELOCITY: Dimension.VELOCITY,
    Control.ACCELERATION: Dimension.ACCELERATION,
}
_ORDER = {_DIMENSION[control]: order for control, order in _DERIVATIVE.items()}
"""Dimension of an amplitude -> how often displacement was differentiated to reach it."""

_AMPLITUDE_COLUMN = {
    Dimension.LENGTH: ("amplitude_mm", 1000.0),
    Dimension.VELOCITY: ("amplitude_m_s", 1.0),
    Dimension.ACCELERATION: ("amplitude_m_s2", 1.0),
}

# Largest |acceleration| of a Ricker pulse per unit of amplitude x rate^n, rate = pi frequency,
# n = derivatives between the controlled quantity and acceleration. n = 1: the extremum of
# (4 x^3 - 6 x) exp(-x^2) at x^2 = (3 - sqrt 6)/2; n = 2: |-6| at the centre.
_RICKER_SQUARE = 0.5 * (3.0 - np.sqrt(6.0))
_RICKER_PEAK = np.array(
    [
        1.0,
        np.sqrt(_RICKER_SQUARE) * (6.0 - 4.0 * _RICKER_SQUARE) * np.exp(-_RICKER_SQUARE),
        6.0,
    ]
)


@dataclasses.dataclass(frozen=True)
class LaneSet:
    """A case as lanes.

    Attributes:
        lanes: Blocks and starts, shape [lane].
        motions: Ground motions of the same lanes.
        times: Length of the run and sampling of its histories.
        scene: What the case requires of an engine.
        inputs: One row a lane: labels, then physical inputs with their units in the column names.
        labels: Names of the label columns.
        shape: Lengths of the case's axes, first one slowest.
        members: Lanes in a cell of the sweep, 1 without an ensemble; cells are slower.
        cells: Inputs of every cell without their spread; None without an ensemble, or where only
            some lanes were asked for.
        step_factors: Factor on the engine's time step, shape [lane]; None is 1 for all.
    """

    lanes: Lanes
    motions: GroundMotions
    times: SampleTimes
    scene: SceneKind
    inputs: pd.DataFrame
    labels: tuple[str, ...]
    shape: tuple[int, ...]
    members: int = 1
    cells: pd.DataFrame | None = None
    step_factors: Array | None = None

    def select(self, where: Mapping[str, str]) -> npt.NDArray[np.intp]:
        """Lanes with certain labels, in lane order.

        Args:
            where: Label -> value; empty selects every lane.

        Raises:
            InputError: No such label, or no lane has that value.
        """
        chosen = np.ones(self.lanes.lane_count, dtype=bool)
        for label, value in where.items():
            if label not in self.labels:
                known = ", ".join(self.labels) or "none"
                raise InputError("where", label, value, f"must be a label of the case ({known})")
            chosen &= np.asarray(self.inputs[label] == value)
            if not chosen.any():
                raise InputError("where", label, value, "must select at least one lane")
        return np.flatnonzero(chosen)


def expand_lanes(case: Case, lanes: range | None = None) -> LaneSet:
    """The lanes of a case.

    Args:
        case: The case.
        lanes: Numbers of the lanes wanted; None is all of them.

    Returns:
        Lanes, motions, sampling, kind of scene and the table of inputs.

    Raises:
        InputError: A combination of values that no engine could use.
    """
    import pandas as pd

    values = LaneValues(case, range(case.lane_count) if lanes is None else lanes)
    if not values.lanes:
        raise InputError(case.file, "sweep", Said("0 lanes"), "must make at least 1 lane")
    blocks, motions, columns = _scene(values)
    scene = scene_kind(
        blocks, motions, restitution_given=values.given("contact.angular_restitution")
    )
    step_factors, cells = None, None
    if case.ensemble is not None:
        step_factors = case.ensemble.step_factors(values.members)
        columns |= {"member": values.members}
        if step_factors is not None:
            columns |= {"time_step_factor": step_factors}
        if lanes is None:
            firsts = LaneValues(case, range(0, case.lane_count, case.members), spread=False)
            cells = pd.DataFrame(firsts.labels() | _scene(firsts)[2])
    _refuse_labels(case, columns)
    lane_set = LaneSet(
        lanes=blocks,
        motions=motions,
        times=case.sample_times,
        scene=scene,
        inputs=pd.DataFrame(values.labels() | columns),
        labels=case.labels,
        shape=case.shape,
        members=case.members,
        cells=cells,
        step_factors=step_factors,
    )
    if lanes is None and not case.overridden:
        _refuse_checks(case, lane_set)
    return lane_set


def _scene(values: LaneValues) -> tuple[Lanes, GroundMotions, dict[str, object]]:
    """Blocks, ground motions, and the columns of both in the table of inputs."""
    stacked = values.case.tables.stacked
    blocks = stack_lanes(values) if stacked else _blocks(values)
    motions, columns = _motions(values, blocks)
    return blocks, motions, (stack_columns(blocks) if stacked else _block_columns(blocks)) | columns


def _blocks(values: LaneValues) -> Lanes:
    """Blocks and their starts."""
    width, height = values.numbers("block.width"), values.numbers("block.height")
    angle = np.arctan2(width, height)
    rotation_start = np.zeros_like(width)
    if values.given("start.rotation_ratio"):
        rotation_start = angle * values.numbers("start.rotation_ratio")
    elif values.given("start.rotation"):
        rotation_start = values.numbers("start.rotation")
        beyond = np.abs(rotation_start) >= angle
        if beyond.any():
            limit = np.rad2deg(angle[int(np.argmax(beyond))])
            allowed = f"must be less than the block's slenderness angle, {limit:.6g} deg"
            values.refuse(beyond, "start.rotation", allowed)
    if values.given("contact.angular_restitution"):
        restitution = values.numbers("contact.angular_restitution")
    else:
        restitution = rocking.angular_restitution(angle)
        values.refuse(
            restitution <= 0.0,
            "block.width",
            "must be less than 1.41 times block.height: a wider block keeps no angular velocity "
            "at an impact (give contact.angular_restitution to run it all the same)",
        )
    return Lanes(
        width=width,
        height=height,
        depth=values.numbers("block.depth"),
        density=values.numbers("block.density"),
        friction=values.numbers("contact.friction"),
        chamfer=np.zeros_like(width),
        offset=np.zeros_like(width),
        rotation_start=rotation_start,
        angular_restitution=restitution,
    )


def _block_columns(lanes: Lanes) -> dict[str, object]:
    angle = lanes.slenderness_angle
    return {
        "width_m": lanes.width,
        "height_m": lanes.height,
        "depth_m": lanes.depth,
        "density_kg_m3": lanes.density,
        "friction": lanes.friction,
        "angular_restitution": lanes.angular_restitution,
        "slenderness_angle_rad": angle,
        "half_diagonal_m": rocking.half_diagonal(lanes.width, lanes.height),
        "frequency_parameter_rad_s": rocking.frequency_parameter(lanes.width, lanes.height),
        "rotation_start_rad": lanes.rotation_start,
        "rotation_ratio_start": lanes.rotation_start / angle,
    }


def _motions(values: LaneValues, lanes: Lanes) -> tuple[GroundMotions, dict[str, object]]:
    """Ground motions and their columns of the table of inputs."""
    case = values.case
    if case.tables.motion is None:
        return StillBase(lanes.lane_count), {}
    start = values.numbers("motion.start")
    duration = case.sample_times.duration
    values.refuse(
        start >= duration, "motion.start", f"must be before the end of the run, {duration:g} s"
    )
    waveforms = set(values.texts("motion.waveform")[0])
    if waveforms <= {Waveform.SINE, Waveform.COSINE}:
        motions, columns, peak = _harmonic(values, start)
    elif waveforms == {Waveform.RICKER}:
        motions, columns, peak = _ricker(values, start)
    elif waveforms == {Waveform.RECORD}:
        motions, columns, peak = _records(values, start)
    else:
        raise InputError(
            case.source_of("motion.waveform"),
            "motion.waveform",
            Said(", ".join(sorted(waveforms))),
            "must be of one family in a case: sine and cosine, ricker, or record",
        )
    before: dict[str, object] = {"waveform": values.column("motion.waveform")}
    uplift = uplift_ratio(lanes).min(axis=1) if lanes.stacked else lanes.width / lanes.height
    return motions, before | columns | {
        "start_s": start,
        "peak_acceleration_m_s2": peak,
        "normalised_acceleration": peak / (GRAVITY * uplift),
    }


Motions = tuple[GroundMotions, dict[str, object], Array]
"""Ground motions, their columns, and the peak acceleration [m/s^2], shape [lane]."""


def _controls(values: LaneValues) -> tuple[npt.NDArray[np.str_], npt.NDArray[np.intp]]:
    """Controlled quantity, and its derivatives counted from displacement, shape [lane]."""
    names, codes = values.texts("motion.control")
    order = np.array([_DERIVATIVE[Control(name)] for name in names], dtype=np.intp)
    return np.array(names)[codes], order[codes]


def _amplitude_columns(values: LaneValues) -> dict[str, object]:
    name, factor = _AMPLITUDE_COLUMN[values.dimension("motion.amplitude")]
    amplitude = values.numbers("motion.amplitude")
    return {
        "control": values.column("motion.control"),
        "frequency_hz": values.numbers("motion.frequency"),
        # Written in mm, so 8 mm shall read 8 and not 8.000000000000002.
        name: np.round(amplitude * factor, 12) if factor != 1.0 else amplitude,
    }


def _harmonic(values: LaneValues, start: Array) -> Motions:
    """Sines and cosines.

    With w = 2 pi frequency, an amplitude of another kind than the control is the amplitude that
    a sine of that frequency has: displacement x w = velocity, velocity x w = acceleration.
    """
    names, codes = values.texts("motion.waveform")
    waveform = np.array(names)[codes]
    control, order = _controls(values)
    values.refuse(
        (waveform == Waveform.COSINE) & (control == Control.DISPLACEMENT),
        "motion.control",
        "must be velocity or acceleration with waveform cosine, whose displacement would jump",
    )
    frequency = values.numbers("motion.frequency")
    w = 2.0 * np.pi * frequency
    written = _ORDER[values.dimension("motion.amplitude")]
    amplitude = values.numbers("motion.amplitude") * w ** (order - written).astype(float)
    if values.given("motion.cycles"):
        duration = values.numbers("motion.cycles") / frequency
    else:
        duration = values.numbers("motion.duration")
    each = cast("Sequence[Waveform]", waveform)
    motions = harmonic_motions(each, control, amplitude, frequency, start, duration)
    columns = _amplitude_columns(values) | {"stop_s": motions.stop}
    return motions, columns, np.abs(motions.acceleration_amplitude)


def _ricker(values: LaneValues, start: Array) -> Motions:
    """Ricker pulses, whose amplitude is that of the controlled quantity."""
    control, order = _controls(values)
    dimension = values.dimension("motion.amplitude")
    values.refuse(
        order != _ORDER[dimension],
        "motion.amplitude",
        "must be of the kind of motion.control with waveform ricker: a length for displacement, a "
        "velocity for velocity, an acceleration for acceleration",
    )
    frequency = values.numbers("motion.frequency")
    amplitude = values.numbers("motion.amplitude")
    left = 2 - order
    peak = np.abs(amplitude) * (np.pi * frequency) ** left * _RICKER_PEAK[left]
    motions = ricker_motions(control, amplitude, frequency, start)
    return motions, _amplitude_columns(values) | {"stop_s": motions.stop}, peak


def case_records(case: Case) -> list[Record]:
    """The records that a case's lanes follow; none unless its waveform is a record.

    Raises:
        InputError: A record that does not exist or cannot be used.
    """
    values = LaneValues(case, range(1))
    if not values.given("motion.record"):
        return []
    from warprock.records import load_record

    records = []
    for name in values.texts("motion.record")[0]:
        try:
            records.append(load_record(name, relative_to=case.folder))
        except InputError as error:
            if error.key != "record":
                raise
            source = case.source_of("motion.record")
            raise InputError(source, "motion.record", name, error.allowed) from None
    return records


def _records(values: LaneValues, start: Array) -> Motions:
    """Records times a scale."""
    from warprock.records import record_motions

    records = case_records(values.case)
    codes = values.texts("motion.record")[1]
    scale = values.numbers("motion.scale")
    motions = record_motions(records, index=codes, scale=scale, start=start)
    peaks = np.array([record.peak_acceleration for record in records])
    columns: dict[str, object] = {"record": values.column("motion.record"), "scale": scale}
    return motions, columns, np.abs(scale) * peaks[codes]


def _refuse_labels(case: Case, columns: Mapping[str, object]) -> None:
    """Refuses a label that would hide an input or a result in the lane table."""
    results = (FIELDS.keys() | {field.column for field in FIELDS.values()}) | {
        field.block_column(block)
        for field in FIELDS.values()
        for block in range(1, case.tables.block_count + 1)
    }
    for label in case.labels:
        if label in {"lane", *CELL_COLUMNS, *columns} | results:
            allowed = "must not be the name of an input or of a result"
            raise InputError(case.file, f"sweep.{LABEL}{label}", label, allowed)


def _refuse_checks(case: Case, lane_set: LaneSet) -> None:
    """Refuses a check that has another number of values than lanes to compare them with."""
    for number, check in enumerate(case.checks):
        if isinstance(check, PeaksCheck):
            count = len(lane_set.select(check.where))
            if len(check.values) != count:
                raise InputError(
                    case.file,
                    f"check[{number}].values",
                    Said(f"{len(check.values)} values"),
                    f"must be {count}, one for each lane selected",
                )
