"""What there is to choose from (cases, engines, templates) and what a case requires."""

from __future__ import annotations

import dataclasses
import pathlib
from typing import Any

import pandas as pd

from warprock.case import Case, case_names, load_case, template_text
from warprock.engines import ENGINES, engine_class
from warprock.engines.settings import SETTINGS
from warprock.errors import InputError
from warprock.expansion import expand_lanes
from warprock.files import replacing, require_writable
from warprock.reference.peer_programs import PROGRAMS
from warprock.scene import SceneKind

TWO_BLOCK = "two-block"
"""Engine that runs one lane a thread on any device."""
EVENT = "event"
"""Engine that does so with stacks and with blocks in space."""

ONE_TEXT = ("dem", "xpbd")
"""Engines whose kernels take a single block as a stack of one."""

VALUES_SHOWN = 12
"""Distinct values of an input up to which all of them are listed."""

ESTIMATE = (
    "`run` estimates every lane's rotation error and halves the step, of the lanes that need it, "
    "until it is within --tolerance; --no-estimate runs every lane once"
)
"""What `explain` says of an engine whose error has an order in the step."""


def list_all() -> dict[str, Any]:
    """The shipped cases, the engines, and the programs beside them, ready for JSON."""
    cases = [{"name": name, "title": load_case(name).title} for name in case_names()]
    return {
        "cases": cases,
        "engines": [_engine_row(name) for name in ENGINES],
        "programs": [_program_row(name) for name in PROGRAMS],
    }


def explain_case(case: Case) -> dict[str, Any]:
    """What a case requires and how it would be run, ready for JSON.

    Args:
        case: The case.

    Returns:
        The scene, the axes of the sweep, the values of every input, and for each engine the reason
        why it declines, or the kernel that would run.
    """
    lane_set = expand_lanes(case)
    scene = lane_set.scene
    inputs = lane_set.inputs
    return {
        "case": {
            "name": case.name,
            "title": case.title,
            "source": case.source_text,
            "file": case.file,
        },
        "scene": dataclasses.asdict(scene)
        | {"why": _scene_text(scene), "left_out": list(scene.left_out)},
        "lanes": lane_set.lanes.lane_count,
        "duration_s": lane_set.times.duration,
        "sample_interval_s": lane_set.times.interval,
        "sweep": [{"keys": list(axis.columns), "length": axis.length} for axis in case.axes]
        + ([{"keys": ["member"], "length": case.members}] if case.ensemble else []),
        "study": [case.study.plan(name) for name in case.study.engines] if case.study else None,
        "inputs": {str(name): _spread(inputs[name]) for name in inputs.columns},
        "engines": [_engine_row(name) | _fitness(case, name, scene) for name in ENGINES],
    }


def write_template(kind: str, path: pathlib.Path) -> pathlib.Path:
    """Writes a commented case file to start from.

    Args:
        kind: One of `case.template_kinds()`.
        path: File to write, or a folder to write `case.toml` into.

    Returns:
        The file.

    Raises:
        InputError: Unknown kind, the file exists already, or its folder cannot be written to.
    """
    text = template_text(kind)
    file = path / "case.toml" if path.is_dir() or path.suffix != ".toml" else path
    if file.exists():
        raise InputError("PATH", "", str(file), "must not exist already")
    require_writable(file.parent, "PATH")
    file.parent.mkdir(parents=True, exist_ok=True)
    with replacing(file) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return file


def _scene_text(scene: SceneKind) -> str:
    """What a lane is, in words."""
    if scene.spatial:
        touch = "which can touch its base at four corners"
        if scene.stacked:
            touch = "which touch where the two faces of neighbours overlap, at eight points at most"
        blocks = "one rectangular block" if not scene.stacked else f"{scene.block_count} blocks"
        return f"{blocks} in space, {touch}: the case {scene.spatial_because}"
    if not scene.stacked:
        return "one planar rectangular block, which can touch its base at two corners"
    return (
        f"a planar stack of {scene.block_count} rectangular blocks on a base; each touches what it "
        "stands on at the two ends of their common face at most"
    )


def _engine_row(name: str) -> dict[str, Any]:
    engine = engine_class(name)
    summary = (engine.__doc__ or "").strip().splitlines()[0]
    return {"name": name, "order": engine.order, "summary": summary}


def _program_row(name: str) -> dict[str, Any]:
    program = PROGRAMS[name]
    return {
        "name": name,
        "installed": program.installed,
        "needs": "" if program.installed else program.install,
        "summary": program.text,
    }


def _fitness(case: Case, name: str, scene: SceneKind) -> dict[str, Any]:
    reason = engine_class(name).supports(scene)
    settings = dataclasses.asdict(case.engine_settings(name))
    units = {field.name: field.metadata["unit"] for field in dataclasses.fields(SETTINGS[name])}
    file = name.replace("-", "_") + ("_stack" if scene.stacked and name not in ONE_TEXT else "")
    file = f"spatial_{file}" if scene.spatial else file
    packs = "`packed` on a CPU, `plain`, one lane a thread, on any other device"
    alone = name == TWO_BLOCK or (name == "impulse" and scene.spatial and scene.stacked)
    boxed = scene.spatial and bool(settings.get("friction_box"))
    alone = alone or (name == EVENT and (scene.stacked or boxed))
    form = "one lane a thread on any device" if alone else packs
    kernel = f"kernels/{file}_launch.py for a {scene.motion} base: {form}"
    if name == EVENT and scene.spatial and not alone:
        other = "on a CPU, spatial_event_launch.py, one lane a thread, on any other device"
        kernel = f"kernels/{file}_pack_launch.py for a {scene.motion} base {other}"
    return {
        "declines": reason,
        "kernel": None if reason else kernel,
        "estimate": None if reason or engine_class(name).order is None else ESTIMATE,
        "settings": settings,
        "units": units,
    }


def _spread(values: pd.Series[Any]) -> dict[str, Any]:
    """Distinct values in order of appearance, or least and greatest where there are many."""
    distinct = values.drop_duplicates().tolist()
    if len(distinct) <= VALUES_SHOWN or not pd.api.types.is_numeric_dtype(values):
        return {"values": distinct}
    return {"from": float(values.min()), "to": float(values.max()), "count": len(distinct)}
