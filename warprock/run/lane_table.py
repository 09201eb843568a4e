"""Writes a run to a folder: the lane table, its provenance, and histories on request."""

from __future__ import annotations

import dataclasses
import datetime
import json
import pathlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from warprock.case.case import Case
from warprock.case.columns import input_meaning
from warprock.case.ground_motions import case_records
from warprock.case.lanes import LaneSet
from warprock.model.response import (
    ESTIMATE_FIELDS,
    FIELDS,
    LANE_FIELDS,
    MODEL_FIELDS,
    SOUND,
    SPATIAL_FIELDS,
    Field,
    Response,
)
from warprock.model.undecided import UNDECIDED, UNDECIDED_TEXT, cut_short, undecided
from warprock.run import machine
from warprock.run.accuracy import accuracy_counts, count_bad
from warprock.run.case_run import CaseRun
from warprock.run.cells import cell_table
from warprock.run.files import replacing, require_writable
from warprock.run.parts import FOOTER

LANE_TABLE = "lanes.parquet"
CELL_TABLE = "cells.csv"
PROVENANCE = "run.json"
HISTORY = "history-lane-{lane}.csv"

PACKAGES = ("warp-lang", "numpy", "scipy")
"""Distributions whose version can change a number."""

PEAK_RATIO = "peak_rotation_ratio"


def lane_table(lane_set: LaneSet, response: Response) -> pd.DataFrame:
    """The table of a run, one row a lane: inputs, dimensionless groups and response.

    Units are in the column names; `DataFrame.attrs["columns"]` holds the unit and the meaning
    of every column that has them. Outcome and status are words.

    Args:
        lane_set: Lanes, motions and inputs.
        response: The engine's answer for the same lanes.
    """
    columns: dict[str, Any] = {"lane": lane_set.first + np.arange(response.lane_count)}
    columns |= {str(name): lane_set.inputs[name].array for name in lane_set.inputs.columns}
    meaning = {name: input_meaning(name) for name in columns}
    optional = (*SPATIAL_FIELDS, *MODEL_FIELDS, *ESTIMATE_FIELDS)
    besides = [name for name in optional if name in response.fields]
    for field in (FIELDS[name] for name in (*LANE_FIELDS, *besides)):
        values = response[field.name]
        of_field: dict[str, Any] = {field.column: values}
        if field.enum is not None:
            of_field = {field.column: pd.Categorical.from_codes(values, pd.Index(_words(field)))}
        if values.ndim == 2:
            of_field = {field.block_column(k): v for k, v in enumerate(values.T, 1)}
        columns |= of_field
        meaning |= dict.fromkeys(of_field, (field.unit, field.text))
    columns[UNDECIDED] = undecided(
        response, lane_set.lanes, lane_set.motions, lane_set.times.duration
    )
    meaning[UNDECIDED] = ("-", UNDECIDED_TEXT)
    ratio = response["peak_rotation"] / lane_set.lanes.slenderness_angle
    ratios = dict(zip(peak_ratio_columns(lane_set), np.atleast_2d(ratio.T), strict=True))
    columns |= ratios
    meaning |= dict.fromkeys(ratios, ("-", "Largest rotation / slenderness angle"))
    table = pd.DataFrame(columns)
    table.attrs["columns"] = {
        name: {"unit": unit, "text": text} for name, (unit, text) in meaning.items()
    }
    return table


def peak_ratio_columns(lane_set: LaneSet) -> list[str]:
    """Columns of the peak rotation / slenderness angle, one for each block of a stack."""
    lanes = lane_set.lanes
    if not lanes.stacked:
        return [PEAK_RATIO]
    return [f"{PEAK_RATIO}_{block}" for block in range(1, lanes.block_count + 1)]


def arrow_table(table: pd.DataFrame) -> pa.Table:
    """An Arrow table whose fields carry the unit and the meaning of their columns."""
    bare = table.copy()
    meaning = bare.attrs.pop("columns", {})
    arrow = pa.Table.from_pandas(bare, preserve_index=False)
    fields = [
        field.with_metadata(meaning[field.name]) if field.name in meaning else field
        for field in arrow.schema
    ]
    return arrow.cast(pa.schema(fields, metadata=arrow.schema.metadata))


def history_table(response: Response, row: int) -> pd.DataFrame:
    """Sampled histories of one lane of a response, one row a sample."""
    columns: dict[str, Any] = {"time_s": response.times}
    for field in (FIELDS[name] for name in response.fields):
        if field.dims == ("lane", "sample"):
            values = response[field.name][row]
            of_field = {field.column: values}
            if values.ndim == 2:
                of_field = {field.block_column(k): v for k, v in enumerate(values, 1)}
            columns |= of_field
    return pd.DataFrame(columns)


def provenance(run: CaseRun) -> dict[str, Any]:
    """Everything that is needed to run a run again and to judge it, ready for JSON."""
    response = run.response
    return {
        "case": case_facts(run.case),
        "engine": {"name": response.engine, "settings": dataclasses.asdict(run.settings)},
        "precision": run.options.precision,
        "device": run.options.device,
        "workers": run.options.workers,
        **surroundings(run.case),
        "lanes": response.lane_count,
        "status": count_words(response, "status"),
        "outcome": count_words(response, "outcome"),
        **undecided_counts(run.lane_set, response),
        "estimate": run.options.tolerance is not None,
        "tolerance": run.options.tolerance,
        "accuracy": accuracy_counts(response, run.lane_set, run.settings, run.options.tolerance),
        "rotation_error_rad": error_summary(response),
        "duration_s": run.lane_set.times.duration,
        "wall_time_s": run.wall_time,
    }


def case_facts(case: Case) -> dict[str, Any]:
    """What was run: the case as resolved, overrides included."""
    return {
        "name": case.name,
        "title": case.title,
        "source": case.source_text,
        "file": case.file,
        "resolved": case.raw,
    }


def surroundings(case: Case) -> dict[str, Any]:
    """What a run depends on beside its case and its settings, and when it was finished."""
    return {
        "versions": machine.package_versions(PACKAGES),
        "kernel_sha256": machine.kernel_hash(),
        "machine": {
            "cpu": machine.cpu_name(),
            "cores": machine.core_count(),
            "vector_flags": machine.cpu_vector_flags(),
        },
        "records": record_rows(case),
        "finished": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
    }


def record_rows(case: Case) -> list[dict[str, str]]:
    """The records that a case follows, with their licence and SHA-256."""
    return [
        {
            "name": record.name,
            "sha256": record.sha256,
            "source": record.source,
            "licence": record.licence,
            "processing": record.processing,
            "original_sha256": record.original_sha256,
        }
        for record in case_records(case)
    ]


def count_words(response: Response, name: str) -> dict[str, int]:
    """How many lanes have each word of `outcome` or `status`, words without a lane included."""
    field = FIELDS[name]
    words = _words(field)
    counts = np.bincount(response[name], minlength=len(words))
    return dict(zip(words, counts.tolist(), strict=True))


def undecided_counts(lane_set: LaneSet, response: Response) -> dict[str, int]:
    """How many lanes a run left undecided, and of how many it cut the ground motion short."""
    motions, duration = lane_set.motions, lane_set.times.duration
    return {
        UNDECIDED: int(undecided(response, lane_set.lanes, motions, duration).sum()),
        "motion_cut_short": int(cut_short(motions, duration).sum()),
    }


def bad_lanes(run: CaseRun) -> int:
    """Lanes of a run whose numbers may not be used, or that missed the tolerance."""
    tolerance = run.options.tolerance
    counts = accuracy_counts(run.response, run.lane_set, run.settings, tolerance)
    return count_bad(count_words(run.response, "status"), counts)


def error_summary(response: Response) -> dict[str, float] | None:
    """Median and largest estimated rotation error [rad] of the lanes whose run is sound.

    A lane of a stack counts with its largest. None without an estimate, or without such lanes.
    """
    usable = np.isin(response["status"], SOUND)
    if "rotation_error" not in response.fields or not np.any(usable):
        return None
    errors = response["rotation_error"][usable].reshape(int(usable.sum()), -1).max(axis=1)
    return {"median": float(np.median(errors)), "largest": float(errors.max())}


def write_run(
    run: CaseRun, folder: pathlib.Path, histories: Mapping[int, Response] | None = None
) -> list[pathlib.Path]:
    """Writes the lane table, that of cells of an ensemble, `run.json` and histories asked for.

    Args:
        run: The run.
        folder: Where to; made if it does not exist.
        histories: One-lane responses with histories, by number of the lane.

    Returns:
        The files, in the order in which they were written; `run.json` comes last.

    Raises:
        InputError: The folder cannot be written to.
    """
    require_writable(folder)
    folder.mkdir(parents=True, exist_ok=True)
    written, facts = [], provenance(run)
    path = folder / LANE_TABLE
    with replacing(path) as temporary:
        table = arrow_table(lane_table(run.lane_set, run.response))
        footer = json.dumps({name: facts[name] for name in ("engine", "estimate", "tolerance")})
        meaning = {**(table.schema.metadata or {}), FOOTER: footer.encode()}
        pq.write_table(table.replace_schema_metadata(meaning), temporary)
    written.append(path)
    if run.case.ensemble is not None:
        path = folder / CELL_TABLE
        with replacing(path) as temporary:
            cell_table(run.lane_set, run.response).to_csv(temporary, index=False)
        written.append(path)
    for lane, response in (histories or {}).items():
        path = folder / HISTORY.format(lane=lane)
        with replacing(path) as temporary:
            history_table(response, 0).to_csv(temporary, index=False)
        written.append(path)
    path = folder / PROVENANCE
    with replacing(path) as temporary:
        text = json.dumps(facts, indent=2, ensure_ascii=False)
        temporary.write_text(text + "\n", encoding="utf-8")
    written.append(path)
    return written


def _words(field: Field) -> list[str]:
    """The words of a field that holds codes, which count from 0."""
    assert field.enum is not None
    return [code.name.lower() for code in sorted(field.enum)]
