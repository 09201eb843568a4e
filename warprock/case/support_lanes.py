"""Ground motions as a floor or an isolator hands them on, and their input columns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from warprock.case.input_columns import computed, key_column
from warprock.case.run import DURATION
from warprock.case.support import Support
from warprock.errors import InputError
from warprock.model.floor import MOST_SAMPLES, Floors, floor_motions, floor_sample_counts
from warprock.model.motion import RecordMotions
from warprock.quantity import NOTHING, Said

if TYPE_CHECKING:
    from warprock.case.values import LaneValues
    from warprock.model.motion import PlanarMotions

PLACE = Support.place


def supported(values: LaneValues) -> bool:
    """Whether the case has a support.

    Raises:
        InputError: It has one, and no motion or one across or upwards.
    """
    tables = values.case.tables
    if tables.support is None:
        return False
    if tables.motion is None:
        allowed = "must be given: [support] stands on a ground that moves"
        raise InputError(values.case.source_of("motion"), "motion", NOTHING, allowed)
    for axis in "yz":
        if getattr(tables.motion, axis) is not None:
            key, allowed = f"motion.{axis}", "must be left out: [support] moves along x alone"
            raise InputError(values.case.source_of(key), key, Said("a table"), allowed)
    return True


def on_support(
    values: LaneValues, ground: PlanarMotions
) -> tuple[RecordMotions, dict[str, object]]:
    """The motions of the supports of lanes, and their columns.

    Raises:
        InputError: The height factor of a support whose ground stops with a velocity step, or more
            samples than are held in memory.
    """
    names = ("frequency", "damping", "height_factor")
    floors = Floors(*(values.numbers(f"{PLACE}.{name}") for name in names))
    stops = (ground.velocity_steps[1] != 0.0) & (floors.height_factor != 1.0)
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
    motions = floor_motions(ground, floors, duration)
    columns: dict[str, object] = {}
    for name in names:
        columns |= key_column(f"{PLACE}.{name}", getattr(floors, name))
    peaks = motions.acceleration_bound() if motions.lane_count else np.zeros(0)
    return motions, columns | computed("support_peak_acceleration", peaks)
