"""Ground motions from the values of a case, lane by lane, and their input columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import numpy.typing as npt

from warprock.case.case import Case
from warprock.case.values import LaneValues
from warprock.errors import InputError
from warprock.model import rocking
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import (
    Control,
    GroundMotions,
    PlanarMotions,
    SpatialMotions,
    StillBase,
    Waveform,
    harmonic_motions,
    mavroeidis_papageorgiou_motions,
    modulated_peak_acceleration,
    no_motion,
    ricker_motions,
)
from warprock.model.stacking import uplift_ratio
from warprock.quantity import Said
from warprock.units import GRAVITY, Dimension

if TYPE_CHECKING:
    import pandas as pd

    from warprock.records import Record

Array = npt.NDArray[np.float64]

ALONG, ACROSS, UPWARDS = "motion", "motion.y", "motion.z"
"""Tables of a case that move the base along x, y and z."""

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


def lane_motions(values: LaneValues, lanes: Lanes) -> tuple[GroundMotions, dict[str, object]]:
    """Ground motions and their columns of the table of inputs.

    Of blocks in space the columns of the motion across and of the vertical one end in _y and _z.
    """
    if values.case.tables.motion is None:
        still = StillBase(lanes.lane_count)
        return SpatialMotions(still, still, still) if lanes.spatial else still, {}
    tables = _tables(values)
    _refuse_families(values, tables)
    found = {table: _component(values, table) for table in tables}
    along, columns, peak = found[ALONG]
    uplift = _uplift(lanes, ALONG)
    columns |= {"normalised_acceleration": peak / (GRAVITY * uplift)}
    if _PEAK_VELOCITY in columns and not lanes.stacked:
        p = rocking.frequency_parameter(lanes.width, lanes.height)
        columns["normalised_velocity"] = (
            p * np.asarray(columns[_PEAK_VELOCITY]) / (GRAVITY * uplift)
        )
    if not lanes.spatial:
        return along, columns
    for table, (_, more, peak) in found.items():
        if table == ACROSS and not lanes.stacked:
            more |= {"normalised_acceleration": peak / (GRAVITY * _uplift(lanes, ACROSS))}
        if table != ALONG:
            columns |= {f"{name}_{table[-1]}": column for name, column in more.items()}
    rest = no_motion(along)
    across, upwards = (found[t][0] if t in found else rest for t in (ACROSS, UPWARDS))
    return SpatialMotions(along, across, upwards), columns


def _uplift(lanes: Lanes, table: str) -> Array:
    """Base acceleration / g along a direction, x or y, from which on a lane begins to rock [-].

    There the resultant of weight and inertia leaves the face on which a block stands. In space that
    is over whichever edge is met first, to either side, from below an eccentric centre of mass and
    across a face that is turned by the yaw.
    """
    if lanes.stacked:
        return np.asarray(uplift_ratio(lanes).min(axis=1))
    if not isinstance(lanes, SpatialLanes):
        return np.asarray(lanes.width / lanes.height)
    along, across = np.abs([np.cos(lanes.yaw_start), np.sin(lanes.yaw_start)])
    if table == ACROSS:
        along, across = across, along
    with np.errstate(divide="ignore"):
        width = (0.5 * lanes.face_width - np.abs(lanes.centre_offset_x)) / along
        depth = (0.5 * lanes.face_depth - np.abs(lanes.centre_offset_y)) / across
    return np.asarray(np.minimum(width, depth) / (0.5 * lanes.height))


def _tables(values: LaneValues) -> list[str]:
    """The tables of the case that say how its base moves, one for each direction."""
    given = values.case.tables.constant
    return [t for t in (ALONG, ACROSS, UPWARDS) if given(t) is not None]


def _refuse_families(values: LaneValues, tables: Sequence[str]) -> None:
    """Refuses motions of several families, each of which has kernels of its own."""
    waveforms = {name for table in tables for name in values.texts(f"{table}.waveform")[0]}
    if not any(waveforms <= family for family in _FAMILIES):
        others = (Waveform.RICKER, Waveform.MAVROEIDIS_PAPAGEORGIOU)
        key = f"{tables[-1]}.waveform"
        raise InputError(
            values.case.source_of(key),
            key,
            Said(", ".join(sorted(waveforms))),
            f"must be of one family in a case: sine and cosine, {', '.join(others)}, or record",
        )


def _component(values: LaneValues, table: str) -> Motions:
    """The motion of one direction."""
    start = values.numbers(f"{table}.start")
    duration = values.case.sample_times.duration
    values.refuse(
        start >= duration, f"{table}.start", f"must be before the end of the run, {duration:g} s"
    )
    waveforms = set(values.texts(f"{table}.waveform")[0])
    family = next(read for family, read in _READERS if waveforms <= family)
    motions, columns, peak = family(values, table, start)
    before: dict[str, object] = {"waveform": values.column(f"{table}.waveform")}
    after = {"start_s": start, "peak_acceleration_m_s2": peak}
    return motions, before | columns | after, peak


Motions = tuple[PlanarMotions, dict[str, object], Array]
"""Ground motions, their columns, and the peak acceleration [m/s^2], shape [lane]."""


def _controls(values: LaneValues, table: str) -> tuple[npt.NDArray[np.str_], npt.NDArray[np.intp]]:
    """Controlled quantity, and its derivatives counted from displacement, shape [lane]."""
    names, codes = values.texts(f"{table}.control")
    order = np.array([_DERIVATIVE[Control(name)] for name in names], dtype=np.intp)
    return np.array(names)[codes], order[codes]


def _amplitude_columns(values: LaneValues, table: str) -> dict[str, object]:
    name, factor = _AMPLITUDE_COLUMN[values.dimension(f"{table}.amplitude")]
    amplitude = values.numbers(f"{table}.amplitude")
    return {
        "control": values.column(f"{table}.control"),
        "frequency_hz": values.numbers(f"{table}.frequency"),
        # Written in mm, so 8 mm shall read 8 and not 8.000000000000002.
        name: np.round(amplitude * factor, 12) if factor != 1.0 else amplitude,
    }


def _harmonic(values: LaneValues, table: str, start: Array) -> Motions:
    """Sines and cosines.

    With w = 2 pi frequency, an amplitude of another kind than the control is the amplitude that
    a sine of that frequency has: displacement x w = velocity, velocity x w = acceleration.
    """
    names, codes = values.texts(f"{table}.waveform")
    waveform = np.array(names)[codes]
    control, order = _controls(values, table)
    values.refuse(
        (waveform == Waveform.COSINE) & (control == Control.DISPLACEMENT),
        f"{table}.control",
        "must be velocity or acceleration with waveform cosine, whose displacement would jump",
    )
    frequency = values.numbers(f"{table}.frequency")
    w = 2.0 * np.pi * frequency
    written = _ORDER[values.dimension(f"{table}.amplitude")]
    amplitude = values.numbers(f"{table}.amplitude") * w ** (order - written).astype(float)
    if values.given(f"{table}.cycles"):
        duration = values.numbers(f"{table}.cycles") / frequency
    else:
        duration = values.numbers(f"{table}.duration")
    each = cast("Sequence[Waveform]", waveform)
    motions = harmonic_motions(each, control, amplitude, frequency, start, duration)
    columns = _amplitude_columns(values, table) | {"stop_s": motions.stop}
    return motions, columns, np.abs(motions.acceleration_amplitude)


def _ricker(values: LaneValues, table: str, start: Array) -> Motions:
    """Ricker pulses, whose amplitude is that of the controlled quantity."""
    control, order = _controls(values, table)
    _refuse_kinds(values, table, order)
    frequency = values.numbers(f"{table}.frequency")
    amplitude = values.numbers(f"{table}.amplitude")
    left = 2 - order
    peak = np.abs(amplitude) * (np.pi * frequency) ** left * _RICKER_PEAK[left]
    motions = ricker_motions(control, amplitude, frequency, start)
    return motions, _amplitude_columns(values, table) | {"stop_s": motions.stop}, peak


def _mavroeidis_papageorgiou(values: LaneValues, table: str, start: Array) -> Motions:
    """Near-fault pulses, whose amplitude is that of the controlled quantity."""
    control, order = _controls(values, table)
    _refuse_kinds(values, table, order)
    cycles = values.numbers(f"{table}.cycles")
    values.refuse(
        cycles <= 1.0, f"{table}.cycles", "must be above 1 with waveform mavroeidis-papageorgiou"
    )
    frequency, phase = values.numbers(f"{table}.frequency"), values.numbers(f"{table}.phase")
    amplitude = values.numbers(f"{table}.amplitude")
    motions = mavroeidis_papageorgiou_motions(
        control, amplitude, frequency, start, cycles=cycles, phase=phase
    )
    columns = _amplitude_columns(values, table)
    columns |= {"cycles": cycles, "phase_rad": phase, "stop_s": motions.stop}
    return motions, columns, modulated_peak_acceleration(motions)


def _refuse_kinds(values: LaneValues, table: str, order: npt.NDArray[np.intp]) -> None:
    """Refuses an amplitude of another kind than the control: these pulses have no one frequency."""
    waveform = values.texts(f"{table}.waveform")[0][0]
    values.refuse(
        order != _ORDER[values.dimension(f"{table}.amplitude")],
        f"{table}.amplitude",
        f"must be of the kind of {table}.control with waveform {waveform}: a length for "
        "displacement, a velocity for velocity, an acceleration for acceleration",
    )


def case_records(case: Case) -> list[Record]:
    """The records that a case's lanes follow; none unless its waveform is a record.

    Raises:
        InputError: A record that does not exist or cannot be used.
    """
    from warprock.records import load_record

    records = []
    for key, name in _record_names(LaneValues(case, range(1))):
        try:
            records.append(load_record(name, relative_to=case.folder))
        except InputError as error:
            if error.key != "record":
                raise
            raise InputError(case.source_of(key), key, name, error.allowed) from None
    return records


def _record_names(values: LaneValues) -> list[tuple[str, str]]:
    """Key and name of every record, those of all directions behind one another."""
    keys = [f"{table}.record" for table in _tables(values) if values.given(f"{table}.record")]
    return [(key, name) for key in keys for name in values.texts(key)[0]]


def _records(values: LaneValues, table: str, start: Array) -> Motions:
    """Records times a scale."""
    from warprock.records import record_motions

    records = case_records(values.case)
    # All directions share the samples of all records.
    before = [key for key, _ in _record_names(values)].index(f"{table}.record")
    codes = before + values.texts(f"{table}.record")[1]
    scale = values.numbers(f"{table}.scale")
    motions = record_motions(records, index=codes, scale=scale, start=start)
    peaks = np.array([record.peak_acceleration for record in records])
    columns: dict[str, object] = {"record": values.column(f"{table}.record")}
    for name in _PROVENANCE:
        columns[f"record_{name}"] = _words([getattr(each, name) for each in records], codes)
    velocities = np.array([record.peak_velocity for record in records])
    columns |= {"scale": scale, _PEAK_VELOCITY: np.abs(scale) * velocities[codes]}
    return motions, columns, np.abs(scale) * peaks[codes]


_PEAK_VELOCITY = "peak_velocity_m_s"

_PROVENANCE = ("source", "licence", "sha256", "processing")
"""What every lane says of its record."""


def _words(words: Sequence[str], codes: npt.NDArray[np.integer[Any]]) -> pd.Categorical[str]:
    """A word for each lane as a categorical column, each word stored once."""
    import pandas as pd

    known = list(dict.fromkeys(words))
    places = np.array([known.index(word) for word in words])
    return pd.Categorical.from_codes(places[codes], pd.Index(known))


_READERS: tuple[tuple[frozenset[str], Callable[[LaneValues, str, Array], Motions]], ...] = (
    (frozenset({Waveform.SINE, Waveform.COSINE}), _harmonic),
    (frozenset({Waveform.RICKER}), _ricker),
    (frozenset({Waveform.MAVROEIDIS_PAPAGEORGIOU}), _mavroeidis_papageorgiou),
    (frozenset({Waveform.RECORD}), _records),
)
"""Waveforms of one family, and what reads them."""
_FAMILIES = tuple(family for family, _ in _READERS)
