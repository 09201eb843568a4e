"""Blender's rigid-body world, through bpy, in a process of its own.

It is Bullet in float32 with Blender's ways around it: it has frames, between which the base moves
along straight lines and after which results exist, and sub-steps in each. bpy is a whole program
that takes over the process it is imported into, so `blender_process` runs it in another one;
scenes go there, and poses come back, as JSON. It is the extra `blender`, for Python 3.11 alone, and
brings NumPy 1.26; installed without its dependencies it runs beside a later NumPy, too.

The collision shape is Blender's box, its convex hull, or a mesh of triangles; its body takes its
inertia from that shape, so a block with chamfers has the inertia of a box as wide as its faces: for
the stacks of the paper 1 % less about its centre.

Blender Foundation (2025), Blender 4.5.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import math
import pathlib
import subprocess
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from warprock.errors import DeclinedError
from warprock.programs.scene import (
    PeerRun,
    PeerScene,
    missing,
    multiplied_frictions,
)
from warprock.settings.programs import BlenderSettings
from warprock.units import GRAVITY

PROCESS = pathlib.Path(__file__).with_name("blender_process.py")
INSTALL = 'pip install "warprock[blender]"'
SHAPES = ("BOX", "CONVEX_HULL", "MESH")
"""Blender's names of the collision shapes, by their number in the settings."""


def run(
    scenes: Sequence[PeerScene],
    settings: BlenderSettings,
    finished: Callable[[int], None] | None = None,
) -> list[PeerRun]:
    """Runs scenes, one after the other, in one process.

    Args:
        scenes: The scenes.
        settings: Steps, shape and what Blender's contact solver does in a step.
        finished: Called with the number of scenes once all are done.

    Returns:
        Poses at the frames of each scene, and the CPU time of its frames.

    Raises:
        ImportError: bpy is not installed; one line that names the extra.
        DeclinedError: It cannot do a scene.
        ChildProcessError: The process failed; one line with the last that it said.
    """
    if importlib.util.find_spec("bpy") is None:
        raise missing("bpy", INSTALL, ModuleNotFoundError("No module named 'bpy'"))
    require_scenes(scenes, settings)
    plans = [_Plan.of(scene, settings) for scene in scenes]
    asked = {
        "scenes": [_pack_scene(s, plan) for s, plan in zip(scenes, plans, strict=True)],
        "settings": {
            "substeps": plans[0].substeps,
            "iterations": settings.iterations,
            "shape": SHAPES[settings.collision_shape],
            "margin": settings.collision_margin,
        },
    }
    answers = _ask(asked)
    if finished is not None:
        finished(len(scenes))
    return [
        _run(answer, scene.frame_count * plan.frames * plan.substeps)
        for answer, scene, plan in zip(answers, scenes, plans, strict=True)
    ]


def require_scenes(scenes: Sequence[PeerScene], settings: BlenderSettings) -> None:
    """Declines what Blender's shapes cannot be.

    Raises:
        DeclinedError: A centre of mass beside the middle of a box.
    """
    if settings.collision_shape == 0 and any(any(b.middle) for s in scenes for b in s.blocks):
        raise DeclinedError(
            "its box has its centre of mass in the middle; peers.blender.collision_shape = 1, the "
            "convex hull, need not"
        )


@dataclasses.dataclass(frozen=True)
class _Plan:
    """Blender's frames in one of ours, and its sub-steps in each of them."""

    frames: int
    substeps: int

    @classmethod
    def of(cls, scene: PeerScene, settings: BlenderSettings) -> _Plan:
        steps = scene.steps_per_frame(settings.steps_per_second)
        frames = min(steps, scene.steps_per_frame(settings.frames_per_second))
        return cls(frames, math.ceil(steps / frames))


def _pack_scene(scene: PeerScene, plan: _Plan) -> dict[str, Any]:
    """A scene as the process takes it."""
    count = scene.frame_count * plan.frames
    frame = scene.frame / plan.frames
    times = np.arange(count + 1, dtype=np.float64) * frame
    return {
        "frame": frame,
        "frame_count": count,
        "frames_per_result": plan.frames,
        "gravity": GRAVITY,
        "base": [] if scene.base is None else scene.base.displacement(times).tolist(),
        "frictions": multiplied_frictions(scene),
        "blocks": [
            {
                "half": [0.5 * size for size in block.touching_size],
                "middle": block.middle,
                "mass": block.mass,
                "position": block.position,
                # Blender's quaternions begin with their real part.
                "attitude": (block.attitude[3], *block.attitude[:3]),
            }
            for block in scene.blocks
        ],
    }


def _ask(asked: dict[str, Any]) -> list[dict[str, Any]]:
    """Runs the process and reads its answer."""
    done = subprocess.run(
        [sys.executable, str(PROCESS)],
        input=json.dumps(asked),
        capture_output=True,
        text=True,
        check=False,
    )
    lines = done.stdout.strip().splitlines()
    if done.returncode != 0 or not lines:
        said = [line.strip() for line in done.stderr.splitlines() if line.strip()]
        why = said[-1] if said else "it said nothing"
        raise ChildProcessError(f"blender: its process ended with code {done.returncode}: {why}")
    answers: list[dict[str, Any]] = json.loads(lines[-1])
    return answers


def _run(answer: dict[str, Any], step_count: int) -> PeerRun:
    poses = np.asarray(answer["poses"], dtype=np.float64)
    return PeerRun(poses[..., :3], poses[..., [4, 5, 6, 3]], answer["cpu_s"], step_count)
