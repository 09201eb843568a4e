"""What a case requires of its engine, and a new case file."""

from __future__ import annotations

import dataclasses
import pathlib
from typing import TYPE_CHECKING, Any

import numpy as np

from warprock.case.assembly import BETWEEN
from warprock.case.assembly_lanes import case_drawings
from warprock.case.axes import Texts
from warprock.case.case import Case
from warprock.case.columns import Columns
from warprock.case.lanes import expand_lanes
from warprock.case.round_base import round_base_note
from warprock.engines import ENGINES, engine_class
from warprock.engines.assembly_packs import LARGE
from warprock.engines.base import KernelEngine
from warprock.engines.launching import Target
from warprock.errors import InputError
from warprock.model.drift import drift_text
from warprock.model.lanes import Lanes
from warprock.model.scene import SceneKind
from warprock.model.undecided import cut_text
from warprock.plugins import brought
from warprock.running.choices import engine_row
from warprock.running.engine_choice import choose_engine
from warprock.running.files import replacing, require_writable_file
from warprock.running.waiting import LONG
from warprock.settings.engines import SETTINGS, declared_settings
from warprock.unmodelled import UNMODELLED

if TYPE_CHECKING:
    from warprock.case.template import Start

JOINTS_SHOWN = 12
"""Joints of an assembly that are named."""

VALUES_SHOWN = 12
"""Distinct values of an input up to which all of them are listed."""

WORDS_SHOWN = 4
"""Words that are named of an input that has more of them than that."""

LETTERS_SHOWN = 240
"""Letters of the texts of an input up to which all of them are listed; of longer ones the first."""

LANES_SHOWN = 100_000
"""Lanes whose inputs are looked through; of more, the first ones."""

ESTIMATE = (
    "`run` estimates every lane's rotation error and halves the step, of the lanes that need it, "
    "until it is within --tolerance; --no-estimate runs every lane once"
)
"""What `explain` says of an engine whose error has an order in the step."""


def explain_case(case: Case) -> dict[str, Any]:
    """What a case requires and how it would be run, ready for JSON.

    Args:
        case: The case.

    Returns:
        The scene, the axes of the sweep and the values of every input. `engine` is the one that
        runs where none is named, and why (`EngineChoice`). Each engine has the reason why it
        declines the case, or the kernel that would run it.
    """
    many = case.lane_count > LANES_SHOWN
    lane_set = expand_lanes(case, range(LANES_SHOWN) if many else None)
    scene = lane_set.scene
    inputs = lane_set.table
    return {
        "case": {
            "name": case.name,
            "title": case.title,
            "source": case.source_text,
            "file": case.file,
        },
        "scene": dataclasses.asdict(scene)
        | {
            "why": _scene_text(scene, several=len(set(inputs.columns.get("blocks", ()))) > 1),
            "left_out": list(scene.left_out),
            "friction_note": scene.friction_note,
            "replaced": round_base_note(inputs) or None,
            "touching": _touching(lane_set.lanes),
            "laid": _laid(case, lane_set.lanes),
        },
        "lanes": case.lane_count,
        "inputs_of_lanes": lane_set.lanes.lane_count,
        "duration_s": max(case.durations),
        "shortest_duration_s": min(case.durations),
        "motion_cut_short": cut_text(lane_set.motions, lane_set.ends) or None,
        "drift": drift_text(lane_set.motions) or None,
        "sample_interval_s": lane_set.longest.interval,
        "sweep": [{"keys": list(axis.columns), "length": axis.length} for axis in case.axes]
        + ([{"keys": ["member"], "length": case.members}] if case.ensemble else []),
        "not_modelled": [each.what for each in UNMODELLED],
        "study": [case.study.plan(name) for name in case.study.engines] if case.study else None,
        "inputs": {str(name): _spread(inputs, name) for name in inputs.columns},
        "engine": dataclasses.asdict(choose_engine(case)),
        "engines": [engine_row(name) | _fitness(case, name, scene) for name in ENGINES],
    }


def write_case(start: Start, path: pathlib.Path, source: str = "PATH") -> list[pathlib.Path]:
    """Writes a case file to start from, and what it needs beside it.

    Args:
        start: What `case.template.start_case` made.
        path: File to write, or a folder to write `case.toml` into.
        source: Argument or option that names it, as errors say.

    Returns:
        The files, the case file first.

    Raises:
        InputError: A file exists already, or its folder cannot be written to.
    """
    file = path / "case.toml" if path.is_dir() or path.suffix != ".toml" else path
    contents = {file: start.text.encode()}
    contents |= {file.parent / name: content for name, content in start.beside.items()}
    for each in contents:
        if each.exists():
            raise InputError(source, "", str(each), "must not exist already")
        require_writable_file(each, source)
    file.parent.mkdir(parents=True, exist_ok=True)
    for each, content in reversed(contents.items()):
        with replacing(each) as temporary:
            temporary.write_bytes(content)
    return list(contents)


def _touching(lanes: Lanes) -> str | None:
    """Which blocks of the first lane touch, in words; None where it is no assembly."""
    if lanes.assembly is None:
        return None
    first = lanes.assembly.of(0)
    pairs = [f"{first.names[a]}{BETWEEN}{first.names[b]}" for a, b in first.joints.blocks]
    more = len(pairs) - JOINTS_SHOWN
    left = f"; {more:,} more" if more > 0 else ""
    return f"{'; '.join(pairs[:JOINTS_SHOWN])}{left}"


def _laid(case: Case, lanes: Lanes) -> list[str]:
    """What the first lane's assembly is, in sentences; nothing where it is none."""
    if lanes.assembly is None:
        return []
    first = lanes.assembly.of(0)
    fixed = [name for name, still in zip(first.names, first.fixed, strict=True) if still]
    named = ", ".join(fixed[:JOINTS_SHOWN]) + ", ..." * (len(fixed) > JOINTS_SHOWN)
    width, *across, height = first.size
    deep = f", {across[0]:.4g} m deep" if across else ""
    mass = float(first.mass[~first.fixed].sum())
    free, joints = first.count - len(fixed), first.joints.count
    found = [
        f"{free:,} block{'s' * (free != 1)}, {mass:,.4g} kg, {width:.4g} m wide{deep} and "
        f"{height:.4g} m high; fixed: {named}; {joints:,} joint{'s' * (joints != 1)}"
    ]
    found += _size_note(case, lanes)
    for file, drawing in case_drawings(case).items():
        besides = f"; left out: {drawing.left_out}" if drawing.left_out else ""
        kind = "bodies" if drawing.solids else "outlines"
        found.append(f"{file}: {len(drawing.blocks):,} {kind}{besides}")
    return found


STEP_COST, POWER = 7.4e-9, 1.8
"""CPU time of a step of a wall that stands: so many seconds times its joints to this power, from 22
to 29,850 joints within a factor of two (`warprock bench blocks`)."""

COST_IN_SPACE, POWER_IN_SPACE = 1.3e-5, 0.95
"""The same in space, from 22 to 841 joints within a factor of two (`warprock bench blocks
--space`)."""

BYTES_A_JOINT = 4_000
"""Memory of a large lane over its joints: about 120 MB for 10,000 blocks."""


def _size_note(case: Case, lanes: Lanes) -> list[str]:
    """Memory of a large assembly, and how long a run takes that takes more than a minute."""
    assert lanes.assembly is not None
    found: list[str] = []
    joints = np.array([kind.joints.count for kind in lanes.assembly.kinds])
    each = joints[lanes.assembly.lane].astype(float)
    cost, power = STEP_COST, POWER
    if lanes.assembly.spatial:
        cost, power = COST_IN_SPACE, POWER_IN_SPACE
    elif joints.max() > LARGE:
        memory = 1e-6 * BYTES_A_JOINT * joints.max()
        found.append(f"a large lane, run by all threads together, in some {memory:,.0f} MB")
    steps = max(case.durations) / case.engine_settings("assembly").time_step
    seconds = steps * cost * (each**power).sum() * case.lane_count / len(each)
    if seconds > LONG:
        found.append(
            f"some {seconds / 60:,.0f} core minutes while blocks stand, without an estimate of the "
            "error (--no-estimate); three times as many with it"
        )
    return found


def _scene_text(scene: SceneKind, *, several: bool) -> str:
    """What a lane is, in words.

    Args:
        scene: The scene.
        several: Whether assemblies of different lanes have different numbers of blocks.
    """
    count = scene.block_count
    blocks = f"{'at most ' * several}{count} block{'s' * (count != 1)} that can move"
    if scene.assembly and scene.spatial:
        return (
            f"an assembly in space of {blocks}; blocks touch at the corners of the polygons over "
            f"which their faces overlap: the case {scene.spatial_because}"
        )
    if scene.assembly:
        return (
            f"a planar assembly of {blocks}; blocks touch at the two ends of every edge that they "
            "share, and in assembly wherever they come to meet; dem has no springs there, and says "
            "outside_model of a lane that would need them"
        )
    if scene.held == ("strip",):
        return "a strip of wall between two floors, two planar bodies with a hinge between them"
    if scene.held == ("ground",):
        return "one planar block on compliant ground: springs and dampers below its base"
    if scene.bodies and scene.stacked:
        return (
            f"a planar stack of {scene.block_count} blocks on a base, bodies among them; each "
            "touches what it stands on at up to three points"
        )
    if scene.bodies:
        where = f"in space: the case {scene.spatial_because}" if scene.spatial else "in the plane"
        corners = ", their corners rounded" if scene.rounded else ""
        return f"one body on at most {scene.contact_point_count} points{corners}, {where}"
    if scene.spatial:
        touch = "which can touch its base at four corners"
        if scene.stacked:
            touch = "which touch where the two faces of neighbours overlap, at eight points at most"
        blocks = "one rectangular block" if not scene.stacked else f"{scene.block_count} blocks"
        return f"{blocks} in space, {touch}: the case {scene.spatial_because}"
    if scene.held == ("frame",):
        return "columns capped by a beam, which rock as one planar block does"
    if not scene.stacked:
        held = f"; the case holds it by {' and '.join(scene.held)}" if scene.held else ""
        return f"one planar rectangular block, which can touch its base at two corners{held}"
    return (
        f"a planar stack of {scene.block_count} rectangular blocks on a base; each touches what it "
        "stands on at the two ends of their common face at most"
    )


def _fitness(case: Case, name: str, scene: SceneKind) -> dict[str, Any]:
    reason = engine_class(name).supports(scene)
    settings = dataclasses.asdict(case.engine_settings(name))
    units = {key: declared.unit for key, declared in declared_settings(SETTINGS[name]).items()}
    return {
        "declines": reason,
        "kernel": None if reason else _kernel_text(case, name, scene),
        "estimate": None if reason or engine_class(name).order is None else ESTIMATE,
        "settings": settings,
        "units": units,
    }


def _kernel_text(case: Case, name: str, scene: SceneKind) -> str:
    """The kernel that an engine runs a case with, on a CPU and on any other device."""
    settings = case.engine_settings(name)
    engine = engine_class(name)
    if not issubclass(engine, KernelEngine):
        return f"{engine.__module__}, of the package {brought()[name][1]}"
    here, there = (
        engine(settings, Target(device=device)).kernel_of(scene) for device in ("cpu", "cuda:0")
    )
    found = f"kernels/{here.file}.py for a {scene.motion} base"
    if here == there:
        note = engine(settings).kernel_note(scene)
        return f"{found}: one lane a thread on any device" + (note and f"; {note}")
    if here.file == there.file:
        return f"{found}: `packed` on a CPU, `plain`, one lane a thread, on any other device"
    return f"{found}: `packed` on a CPU; {there.file}.py, one lane a thread, on any other device"


def _spread(inputs: Columns, name: str) -> dict[str, Any]:
    """Distinct values in order of appearance, or least and greatest where there are many.

    Of many words the first ones, of long texts the first one, and how many there are.
    """
    distinct, values = inputs.distinct(name), inputs.columns[name]
    letters = sum(map(len, map(str, distinct))) if isinstance(values, Texts) else 0
    if len(distinct) > 1 and letters > LETTERS_SHOWN:
        return {"values": distinct[:1], "count": len(distinct)}
    if len(distinct) <= VALUES_SHOWN:
        return {"values": distinct}
    if isinstance(values, Texts) or values.dtype.kind not in "biuf":
        return {"values": distinct[:WORDS_SHOWN], "count": len(distinct)}
    return {"from": float(values.min()), "to": float(values.max()), "count": len(distinct)}
