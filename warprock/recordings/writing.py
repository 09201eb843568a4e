"""Records as CSV files, with where they are from and what was done with them in the header."""

from __future__ import annotations

from collections.abc import Sequence

from warprock.model.motion import Control
from warprock.recordings.processing import Step, process
from warprock.recordings.record import Record
from warprock.recordings.sample_file import csv_text
from warprock.recordings.stochastic import GroundNoise, stochastic_motion

UNITS = {Control.ACCELERATION: "m/s^2", Control.VELOCITY: "m/s", Control.DISPLACEMENT: "m"}
"""Unit that samples are written in."""

NOT_STATED = "not stated"


def format_imported(
    record: Record,
    steps: Sequence[Step],
    *,
    name: str,
    source: str = "",
    licence: str = "",
    displacement: Record | None = None,
) -> bytes:
    """The CSV file of a record after some steps; the same record and steps, the same bytes.

    Args:
        record: The record.
        steps: What to do with it, in order.
        name: Name of the new record.
        source: Where it is from, where its file does not say it or not well.
        licence: Its licence, likewise.
        displacement: What another instrument measured beside it, for the step `merge`.

    Raises:
        InputError: A step that this record has no room for.
    """
    motion, said = process(record, steps, displacement=displacement)
    entries = {
        "name": name,
        "unit": UNITS[motion.quantity],
        "interval": f"{float(motion.interval)!r} s",
        "source": source or record.source or NOT_STATED,
        "licence": licence or record.licence or NOT_STATED,
        "original-sha256": record.original_sha256 or record.sha256,
        "processing": said or "none",
    }
    return csv_text(entries, motion.samples).encode()


def format_generated(noise: GroundNoise, name: str) -> bytes:
    """The CSV file of a stochastic motion; the same values, the same bytes.

    Args:
        noise: What makes the motion.
        name: Name of the record.
    """
    motion = stochastic_motion(noise)
    entries = {
        "name": name,
        "unit": UNITS[Control.ACCELERATION],
        "interval": f"{float(motion.interval)!r} s",
        "source": noise.text,
        "licence": "none needed: computed by warprock",
        "processing": "none: generated",
    }
    return csv_text(entries, motion.samples).encode()
