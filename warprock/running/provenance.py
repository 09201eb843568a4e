"""What a run depends on, and counts of its lanes: the content of `run.json`."""

from __future__ import annotations

import dataclasses
import datetime
from typing import Any

import numpy as np

from warprock.case.assembly_lanes import case_drawings
from warprock.case.case import Case
from warprock.case.ground_motions import case_records
from warprock.case.lanes import LaneSet
from warprock.model.response import FIELDS, SOUND, Response
from warprock.model.undecided import UNDECIDED, cut_short, undecided
from warprock.running import machine
from warprock.running.case_run import CaseRun
from warprock.running.lane_table import words_of
from warprock.running.refinement import count_bad, refinement_counts
from warprock.settings.engines import on_springs

PACKAGES = ("warp-lang", "numpy", "scipy")
"""Distributions whose version can change a number."""


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
        "refinement": lane_counts(run),
        "rotation_error_rad": error_summary(response),
        **duration_facts(run.lane_set),
        "wall_time_s": run.wall_time,
    }


def duration_facts(lane_set: LaneSet) -> dict[str, float]:
    """Length of the longest run of a lane [s], and of the shortest where they differ."""
    found = {"duration_s": lane_set.longest.duration}
    if lane_set.durations is not None:
        found["shortest_duration_s"] = float(lane_set.durations.min())
    return found


def case_facts(case: Case) -> dict[str, Any]:
    """The case as it was run, overrides included.

    Its `folder` is where relative paths in it start from; None of a case that is shipped.
    """
    return {
        "name": case.name,
        "title": case.title,
        "source": case.source_text,
        "file": case.file,
        "folder": None if case.folder is None else str(case.folder.resolve()),
        "resolved": case.raw,
        "overridden": sorted(case.overridden),
        **table_facts(case),
        **drawing_facts(case),
    }


def drawing_facts(case: Case) -> dict[str, Any]:
    """The drawings that a case's assemblies are from, and their hash; nothing where none are."""
    found = [
        {"file": file, "sha256": drawing.sha256, "blocks": len(drawing.blocks)}
        for file, drawing in case_drawings(case).items()
    ]
    return {"drawings": found} if found else {}


def table_facts(case: Case) -> dict[str, Any]:
    """The files whose rows are lanes of a case: which sweep, their hash, and their columns.

    Nothing where there are none.
    """
    found = [
        {
            "sweep": number,
            "file": axis.source.written,
            "sha256": axis.source.sha256,
            "rows": axis.length,
            "keys": list(axis.columns),
            "labelled": axis.labels_differ,
        }
        for number, axis in enumerate(case.axes)
        if axis.source is not None
    ]
    return {"tables": found} if found else {}


def surroundings(case: Case) -> dict[str, Any]:
    """Versions, machine and records that a run depends on, and when it was finished."""
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
    words = words_of(field)
    counts = np.bincount(response[name], minlength=len(words))
    return dict(zip(words, counts.tolist(), strict=True))


def undecided_counts(lane_set: LaneSet, response: Response) -> dict[str, int]:
    """How many lanes a run left undecided, and of how many it cut the ground motion short."""
    motions, ends = lane_set.motions, lane_set.ends
    springs = on_springs(response.engine)
    unknown = undecided(response, lane_set.lanes, motions, ends, springs=springs)
    return {
        UNDECIDED: int(unknown.sum()),
        "motion_cut_short": int(cut_short(motions, ends).sum()),
    }


def bad_lanes(run: CaseRun) -> int:
    """Lanes of a run whose numbers may not be used, or that missed the tolerance."""
    return count_bad(count_words(run.response, "status"), lane_counts(run))


def lane_counts(run: CaseRun) -> dict[str, int]:
    """Lanes of a run by what their refinement came to, see `refinement_counts`."""
    return refinement_counts(run.response, run.lane_set, run.settings, run.options.tolerance)


def error_summary(response: Response) -> dict[str, float] | None:
    """Median and largest estimated rotation error [rad] of the lanes whose run is sound.

    A lane of a stack counts with its largest. None without an estimate, or without such lanes.
    """
    usable = np.isin(response["status"], SOUND)
    if "rotation_error" not in response.fields or not np.any(usable):
        return None
    errors = response["rotation_error"][usable].reshape(int(usable.sum()), -1).max(axis=1)
    return {"median": float(np.median(errors)), "largest": float(errors.max())}
