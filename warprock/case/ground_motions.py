"""Ground motions from the values of a case, lane by lane, and their input columns."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.axes import Texts
from warprock.case.body_lanes import DIRECTION
from warprock.case.case import Case
from warprock.case.input_columns import SPECTRAL, computed, key_column
from warprock.case.keys import KEYS
from warprock.case.run import DURATION
from warprock.case.space import UPWARDS
from warprock.case.support_lanes import on_support, supported
from warprock.case.values import LaneValues
from warprock.case.waveforms import FAMILIES, FAMILY_OF
from warprock.errors import InputError, Said
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import (
    GroundMotions,
    PlanarMotions,
    SpatialMotions,
    StillBase,
    UprightMotions,
    Waveform,
    no_motion,
)
from warprock.model.stacking import uplift_ratio
from warprock.quantity import NumberKey
from warprock.units import GRAVITY

if TYPE_CHECKING:
    from warprock.recordings import Record

Array = npt.NDArray[np.float64]

ALONG, ACROSS = "motion", "motion.y"
"""Tables of a case that move the base along x and y; `UPWARDS` moves it along z."""

_PEAK_VELOCITY = "peak_velocity_m_s"


def lane_motions(
    values: LaneValues, lanes: Lanes
) -> tuple[GroundMotions, GroundMotions | None, dict[str, object]]:
    """Motions of the bases of lanes, and their columns of the table of inputs.

    The columns of the motion across and of the vertical one end in _y and _z.

    Returns:
        The motions of the bases; those of the ground below their supports, None without supports;
        the columns.
    """
    on_floor = supported(values)
    if values.case.tables.motion is None:
        still = StillBase(lanes.lane_count)
        return (SpatialMotions(still, still, still) if lanes.spatial else still), None, {}
    tables = _tables(values)
    _refuse_families(values, tables)
    found = {table: _component(values, table) for table in tables}
    _, columns, peak = found[ALONG]
    # In the plane a direction has turned the body.
    turn = values.numbers(DIRECTION) if lanes.spatial and values.given(DIRECTION) else None
    uplift = (
        _uplift(lanes, ALONG, turn) if lanes.assembly is None else np.tan(lanes.slenderness_angle)
    )
    _add_normalised(columns, lanes, peak, uplift)
    parts = {table: motion for table, (motion, _, _) in found.items()}
    floors: dict[str, PlanarMotions] = {}
    for table in parts if on_floor else ():
        floors[table], more = on_support(values, table, parts[table])
        found[table][1].update(more)
    for table, (_, more, peak) in found.items():
        if table == ACROSS and not lanes.stacked:
            more |= {"normalised_acceleration": peak / (GRAVITY * _uplift(lanes, ACROSS))}
        if table != ALONG:
            columns |= {f"{name}_{table[-1]}": column for name, column in more.items()}
    if turn is not None and lanes.body is None:
        columns |= key_column(DIRECTION, turn)
    ground = _together(parts, lanes, turn)
    if on_floor:
        return _together(floors, lanes, turn), ground, columns
    return ground, None, columns


def _add_normalised(columns: dict[str, object], lanes: Lanes, peak: Array, uplift: Array) -> None:
    """Adds the peaks of a motion over what uplifts a block, and over what overturns it.

    No closed form says when one of the many blocks of an assembly begins to move: its own are over
    the tangent of its slenderness angle.
    """
    columns |= {"normalised_acceleration": peak / (GRAVITY * uplift)}
    if _PEAK_VELOCITY in columns and not lanes.stacked:
        p = lanes.frequency_parameter
        columns["normalised_velocity"] = (
            p * np.asarray(columns[_PEAK_VELOCITY]) / (GRAVITY * uplift)
        )


def _together(
    parts: Mapping[str, PlanarMotions], lanes: Lanes, turn: Array | None
) -> GroundMotions:
    """The motion of a base from those of the tables that say how it moves.

    Args:
        parts: Table -> its motion.
        lanes: The blocks.
        turn: Angle by which the motion along x is turned in space [rad], shape [lane].
    """
    along = parts[ALONG]
    if not lanes.spatial:
        return UprightMotions(along, parts[UPWARDS]) if UPWARDS in parts else along
    rest = no_motion(along)
    across, upwards = (parts.get(table, rest) for table in (ACROSS, UPWARDS))
    if turn is not None:
        along, across = along.scaled(np.cos(turn)), along.scaled(np.sin(turn))
    return SpatialMotions(along, across, upwards)


def _uplift(lanes: Lanes, table: str, turn: Array | None = None) -> Array:
    """Base acceleration / g along a direction, x or y, from which on a lane begins to rock [-].

    There the resultant of weight and inertia leaves the face on which a block stands. In space that
    is over whichever edge is met first, to either side, from below an eccentric centre of mass and
    across a face that is turned by the yaw.

    Args:
        lanes: The lanes.
        table: Whether along x or y.
        turn: Angle by which the direction is turned in space [rad], shape [lane].
    """
    if lanes.assembly is not None:
        return np.tan(lanes.slenderness_angle)
    if lanes.stacked:
        return np.asarray(uplift_ratio(lanes).min(axis=1))
    if not isinstance(lanes, SpatialLanes):
        if lanes.body is not None or (lanes.hold is not None and lanes.hold.strip is not None):
            return np.asarray(lanes.uplift_ratios.min(axis=1))
        return lanes.width / lanes.height
    angle = lanes.yaw_start if turn is None else turn - lanes.yaw_start
    if lanes.body is not None:
        ahead = (
            turn if turn is not None else np.full(lanes.lane_count, 0.5 * np.pi * (table == ACROSS))
        )
        ends = lanes.body.reach(ahead - lanes.yaw_start)
        return np.asarray(np.abs(ends).min(axis=1) / lanes.body.centre_height)
    along, across = np.abs([np.cos(angle), np.sin(angle)])
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
    if not any(waveforms <= set(family.waveforms) for family in FAMILIES):
        *first, last = (" and ".join(family.waveforms) for family in FAMILIES)
        key, allowed = f"{tables[-1]}.waveform", f"{', '.join(first)}, or {last}"
        raise InputError(
            values.case.source_of(key),
            key,
            Said(", ".join(sorted(waveforms))),
            f"must be of one family in a case: {allowed}",
        )


def _component(values: LaneValues, table: str) -> Motions:
    """The motion of one direction."""
    start = values.numbers(f"{table}.start")
    duration, key = values.numbers(DURATION), f"{table}.start"
    late = start >= duration
    at = int(np.argmax(late))
    values.refuse(late, key, f"must be before the end of the run, {duration[at]:g} s")
    family = FAMILY_OF[Waveform(values.texts(f"{table}.waveform")[0][0])]
    columns: dict[str, object] = {"waveform": values.column(f"{table}.waveform")}
    if family.follow is None:
        motions, of_records, peak = _records(values, table, start)
        columns |= of_records
    else:
        motions, peak = family.follow(values, table, start)
        for name in filter(lambda each: values.given(f"{table}.{each}"), family.shown):
            columns |= _column(values, table, name)
        columns |= computed("stop", motions.end)
    columns |= key_column("motion.start", start)
    return motions, columns | computed("peak_acceleration", peak), peak


def _column(values: LaneValues, table: str, name: str) -> dict[str, object]:
    """The column of a key of a table that moves the base."""
    key, general = f"{table}.{name}", f"{ALONG}.{name}"
    if not isinstance(KEYS[general], NumberKey):
        return {name: values.column(key)}
    several = len(KEYS[general].columns) > 1
    dimension = values.dimension(key) if several else None
    return {**key_column(general, values.numbers(key), dimension=dimension)}


Motions = tuple[PlanarMotions, dict[str, object], Array]
"""Ground motions, their columns, and the peak acceleration [m/s^2], shape [lane]."""


def case_records(case: Case) -> list[Record]:
    """The records that a case's lanes follow; none unless its waveform is a record.

    Raises:
        InputError: A record that does not exist or cannot be used.
    """
    from warprock.recordings import load_record

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
    from warprock.recordings import record_motions

    records = case_records(values.case)
    before = [key for key, _ in _record_names(values)].index(f"{table}.record")
    codes = before + values.texts(f"{table}.record")[1]
    peaks = np.array([record.peak_acceleration for record in records])
    spectral = _spectral(values, table, records)
    scale = _scale(values, table, peaks[codes], None if spectral is None else spectral[codes])
    # The lanes asked for may follow few of them.
    used, index = np.unique(codes, return_inverse=True)
    followed = [records[each] for each in used]
    motions = record_motions(followed, index=index, scale=scale, start=start)
    columns: dict[str, object] = {"record": values.column(f"{table}.record")}
    for name in _PROVENANCE:
        columns[f"record_{name}"] = _words([getattr(each, name) for each in records], codes)
    velocities = np.array([record.peak_velocity for record in records])
    columns |= key_column(f"{ALONG}.scale", scale)
    if spectral is not None:
        columns |= key_column(f"{ALONG}.sa_period", values.numbers(f"{table}.sa_period"))
        columns |= computed(SPECTRAL, np.abs(scale) * spectral[codes])
    for target in TARGETS:
        if values.given(f"{table}.{target}"):
            columns |= key_column(f"{ALONG}.{target}", values.numbers(f"{table}.{target}"))
    columns |= computed("peak_velocity", np.abs(scale) * velocities[codes])
    return motions, columns, np.abs(scale) * peaks[codes]


TARGETS = ("target_pga", "target_sa")
"""Keys of a motion that say what its record is scaled to."""

MOST_SCALE = 1000.0
"""Largest factor on a record, given or found."""


def _scale(values: LaneValues, table: str, peaks: Array, spectral: Array | None) -> Array:
    """Factor on the record of each lane, given or from what it is scaled to, shape [lane].

    Args:
        values: Values of the case.
        table: Table of the motion.
        peaks: PGA of each lane's record [m/s^2], shape [lane].
        spectral: Its spectral acceleration [m/s^2], where the case has a period for it.
    """
    for target, own in zip(TARGETS, (peaks, spectral), strict=True):
        key = f"{table}.{target}"
        if values.given(key) and own is not None:
            with np.errstate(divide="ignore"):
                scale = np.asarray(values.numbers(key) / own)
            allowed = f"must be at most {MOST_SCALE:g} times what the record has"
            values.refuse(~(scale <= MOST_SCALE), key, allowed)
            return scale
    return values.numbers(f"{table}.scale")


def _spectral(values: LaneValues, table: str, records: Sequence[Record]) -> Array | None:
    """Spectral acceleration of every record [m/s^2], shape [record]; None without a period."""
    from warprock.recordings.intensity import FINEST

    key = f"{table}.sa_period"
    if not values.given(key):
        return None
    period = float(values.numbers(key)[0])
    for record in records:
        shortest = record.interval / FINEST
        if period < shortest:
            allowed = f"must be at least {shortest:g} s for the record {record.name}"
            raise InputError(values.case.source_of(key), key, f"{period:g} s", allowed)
    return np.array([_spectral_acceleration(record, period) for record in records])


@functools.lru_cache(maxsize=4096)
def _spectral_acceleration(record: Record, period: float) -> float:
    from warprock.recordings.intensity import spectral_accelerations

    return float(spectral_accelerations(record, period)[0])


_PROVENANCE = ("source", "licence", "sha256", "processing")
"""What every lane says of its record."""


def _words(words: Sequence[str], codes: npt.NDArray[np.integer[Any]]) -> Texts:
    """A word for each lane as a column, each word stored once."""
    known = list(dict.fromkeys(words))
    places = np.array([known.index(word) for word in words])
    return Texts(tuple(known), places[codes].astype(np.int32))
