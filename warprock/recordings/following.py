"""Lanes that follow records: all records in one pool, each stored once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.model.motion import RecordMotions
from warprock.recordings.record import Record

Array = npt.NDArray[np.float64]


def record_motions(
    records: Sequence[Record], *, index: npt.ArrayLike, scale: npt.ArrayLike, start: npt.ArrayLike
) -> RecordMotions:
    """Motions of lanes that follow records, each under the control of its own quantity.

    Args:
        records: The records; every one is stored once, however many lanes follow it.
        index: Record of each lane, shape [lane].
        scale: Factor on the motion, shape [lane] or one for all.
        start: Time at which the record starts [s], shape [lane] or one for all.
    """
    which = np.asarray(index, dtype=np.intp)
    pieces = [record.pieces for record in records]
    counts = np.array([len(piece.velocity) for piece in pieces])
    offsets = np.concatenate([[0], np.cumsum(counts)[:-1]])

    def lanes(values: npt.ArrayLike) -> Array:
        return np.broadcast_to(np.asarray(values, dtype=np.float64), which.shape).copy()

    return RecordMotions(
        start=lanes(start),
        scale=lanes(scale),
        offset=offsets[which].astype(np.int32),
        count=counts[which].astype(np.int32),
        interval=np.array([record.interval for record in records])[which],
        velocity_step_start=np.array([piece.step_start for piece in pieces])[which],
        velocity_step_stop=np.array([piece.step_stop for piece in pieces])[which],
        pool_acceleration=np.concatenate([piece.acceleration for piece in pieces]),
        pool_slope=np.concatenate([piece.slope for piece in pieces]),
        pool_velocity=np.concatenate([piece.velocity for piece in pieces]),
    )
