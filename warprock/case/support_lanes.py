"""Ground motions as a floor or an isolator hands them on, and their input columns."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import numpy as np

from warprock.case.input_columns import computed, key_column
from warprock.case.motion import Motion
from warprock.case.run import DURATION
from warprock.case.space import UPWARDS
from warprock.case.support import Support
from warprock.errors import NOTHING, InputError, Said
from warprock.model.motion import RecordMotions

if TYPE_CHECKING:
    from warprock.case.values import LaneValues
    from warprock.model.motion import PlanarMotions

PLACE = Support.place


def supported(values: LaneValues) -> bool:
    """Whether the case has a support.

    Raises:
        InputError: It has one, and no motion.
    """
    tables = values.case.tables
    if tables.support is None:
        return False
    if tables.motion is None:
        allowed = "must be given: [support] stands on a ground that moves"
        raise InputError(values.case.source_of("motion"), "motion", NOTHING, allowed)
    return True


def on_support(
    values: LaneValues, table: str, ground: PlanarMotions
) -> tuple[RecordMotions, dict[str, object]]:
    """The motions of the supports of lanes in one direction, and their columns.

    Upwards a support is rigid: it moves as the ground does, which `floor_motions` samples with a
    height factor of 0.

    Args:
        values: Values of the case.
        table: Table of the motion of this direction.
        ground: Motion of the ground.

    Raises:
        InputError: The height factor of a support whose ground stops with a velocity step, a rigid
            one of such a ground, or more samples than are held in memory.
    """
    from warprock.model.floor import MOST_SAMPLES, Floors, floor_motions, floor_sample_counts

    rigid = table == UPWARDS
    given = {name: values.numbers(f"{PLACE}.{name}") for name in Support.declared()}
    floors = Floors(**given)
    if rigid:
        floors = dataclasses.replace(floors, height_factor=np.zeros_like(floors.height_factor))
    stops = (ground.velocity_steps[1] != 0.0) & (floors.height_factor != 1.0)
    if rigid:
        allowed = f"must end at rest below [support]: the velocity of {table} steps at its stop"
        values.refuse(stops, f"{table}.waveform", allowed)
    allowed = "must be 1 where the velocity of the ground steps at its stop"
    values.refuse(stops, f"{PLACE}.height_factor", allowed)
    duration = values.numbers(DURATION)
    count = int(floor_sample_counts(ground, floors, duration).sum())
    if count > MOST_SAMPLES:
        allowed = (
            f"must make at most {MOST_SAMPLES:,} in one run: fewer lanes, or lower frequencies"
        )
        source = values.case.source_of(PLACE)
        raise InputError(source, PLACE, Said(f"{count:,} samples of supports"), allowed)
    motions, ways = floor_motions(ground, floors, duration)
    if rigid:
        return motions, {}
    columns: dict[str, object] = {}
    if table == Motion.place:
        for name, numbers in given.items():
            columns |= key_column(f"{PLACE}.{name}", numbers)
    peaks = motions.acceleration_bound() if motions.lane_count else np.zeros(0)
    columns |= computed("support_peak_acceleration", peaks)
    return motions, columns | computed("support_peak_displacement", ways)
