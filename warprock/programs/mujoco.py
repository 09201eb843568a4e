"""MuJoCo as a program beside ours: boxes on a plane or on a driven table, of the extra `mujoco`.

A body is the convex hull of its contact points and of its top, with its own mass and inertia; a
profile in the plane is as deep as the box around it. On another block it needs several contacts at
once (`multiccd`).

Settings at their defaults serve blocks B0 to B3 well: the contact must be stiffer with every
shorter step (a time constant of two steps, the least that MuJoCo allows, twice critically damped)
and hard from the first micrometre on (`solimp`). Each block touches what it stands on alone, as
pairs with the friction of that face.

A body that is moved by its place alone (`mocap`) has no velocity at its contacts, and what stands
on it does not feel it move. So the table is a body on slides, a million times as heavy as all
blocks, whose place and velocity are set at every step in which the base moves.

E. Todorov, T. Erez, Y. Tassa (2012), MuJoCo: a physics engine for model-based control, *IROS*.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.model.turning import rotate
from warprock.programs.scene import PeerBlock, PeerRun, PeerScene, missing
from warprock.settings.programs import MujocoSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

MODEL = """
<mujoco>
  <option timestep="{step!r}" gravity="0 0 {gravity!r}" integrator="Euler" solver="Newton"
          cone="elliptic" tolerance="1e-12">{flags}</option>
  <default><geom contype="0" conaffinity="0"/></default>
  <asset>{meshes}</asset>
  <worldbody>{base}{blocks}</worldbody>
  <contact>{pairs}</contact>
</mujoco>
"""
PLANE = '<geom name="0" type="plane" size="50 50 1"/>'
TABLE = """
<body pos="0 0 -1" gravcomp="1">
  <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{mass!r} {mass!r} {mass!r}"/>
  <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
  <joint type="slide" axis="0 0 1"/>
  <geom name="0" type="box" size="50 50 1"/>
</body>
"""
BLOCK = """
<body>
  <freejoint/><inertial pos="0 0 0" mass="{mass!r}" diaginertia="{inertia}"/>
  <geom name="{number}" type="box" size="{half}" pos="{middle}"/>
</body>
"""
MESH = '<mesh name="{number}" vertex="{hull}"/>'
BODY = """
<body>
  <freejoint/><inertial pos="0 0 0" mass="{mass!r}" fullinertia="{tensor}"/>
  <geom name="{number}" type="mesh" mesh="{number}"/>
</body>
"""
PAIR = """
<pair geom1="{below}" geom2="{number}" condim="3" friction="{friction!r} {friction!r} 0 0 0"
      solref="{time!r} {damping!r}" solimp="{impedance!r} {impedance!r} 1e-6"/>
"""
TABLE_RATIO = 1e6
"""Mass of the table over that of all blocks."""


def run(
    scenes: Sequence[PeerScene], settings: MujocoSettings, finished: Any = None
) -> list[PeerRun]:
    """Runs scenes, one after the other.

    Args:
        scenes: The scenes.
        settings: Steps a second and what a contact is.
        finished: Called with the number of scenes that are done, after each.

    Returns:
        Poses at the frames of each scene, and the CPU time of its steps.

    Raises:
        ImportError: MuJoCo is not installed; one line that names the extra.
    """
    try:
        import mujoco
    except ImportError as error:
        raise missing("mujoco", 'pip install "warprock[mujoco]"', error) from None
    runs = []
    for scene in scenes:
        runs.append(_run_scene(mujoco, scene, settings))
        if finished is not None:
            finished(len(runs))
    return runs


def _run_scene(mujoco: Any, scene: PeerScene, settings: MujocoSettings) -> PeerRun:
    steps = scene.steps_per_frame(settings.steps_per_second)
    model = mujoco.MjModel.from_xml_string(_model_text(scene, scene.frame / steps, settings))
    state = mujoco.MjData(model)
    places, velocities = scene.base_steps(steps)
    moves = np.asarray(np.any(velocities.reshape(scene.frame_count, -1), axis=1))
    first = 0 if scene.base is None else 3
    table, drive, poses = state.qpos[:first], state.qvel[:first], state.qpos[first:]
    # MuJoCo's quaternions begin with their real part.
    poses[:] = np.concatenate(
        [(*block.position, block.attitude[3], *block.attitude[:3]) for block in scene.blocks]
    )
    state.qvel[first:] = np.concatenate([_velocities(block) for block in scene.blocks])
    seen = np.empty((scene.frame_count + 1, len(poses)))
    seen[0] = poses
    begin = time.process_time()
    for frame in range(scene.frame_count):
        if moves[frame]:
            for step in range(frame * steps, (frame + 1) * steps):
                table[:], drive[:] = places[step], velocities[step]
                mujoco.mj_step(model, state)
        else:
            table[:], drive[:] = places[frame * steps, :first], 0.0
            mujoco.mj_step(model, state, steps)
        seen[frame + 1] = poses
    cpu_s = time.process_time() - begin
    found = seen.reshape(len(seen), -1, 7)
    return PeerRun(found[..., :3], found[..., [4, 5, 6, 3]], cpu_s, scene.frame_count * steps)


def _velocities(block: PeerBlock) -> Array:
    """Velocity in the axes of the base [m/s], angular velocity in those of the block [rad/s]."""
    x, y, z, w = block.attitude
    return np.concatenate([block.velocity, rotate(np.array([-x, -y, -z, w]), np.array(block.spin))])


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def _block_text(number: int, block: PeerBlock) -> str:
    """A block in MuJoCo's language."""
    if block.body is not None:
        return BODY.format(number=number, mass=block.mass, tensor=_text(block.body.tensor))
    half = _text(0.5 * size for size in block.touching_size)
    shape = {"half": half, "middle": _text(block.middle), "inertia": _text(block.inertia)}
    return BLOCK.format(number=number, mass=block.mass, **shape)


def _model_text(scene: PeerScene, step: float, settings: MujocoSettings) -> str:
    """The scene in MuJoCo's language."""
    blocks, pairs, meshes = [], [], []
    for number, block in enumerate(scene.blocks, 1):
        blocks.append(_block_text(number, block))
        if block.body is not None:
            hull = np.array([*block.body.points, *block.body.top])
            meshes.append(MESH.format(number=number, hull=_text(hull.ravel())))
        friction = max(block.friction, FRICTION_LEAST)
        contact = {
            "friction": friction,
            "time": settings.contact_time * step,
            "damping": settings.damping_ratio,
            "impedance": settings.impedance,
        }
        pairs.append(PAIR.format(below=number - 1, number=number, **contact))
    mass = TABLE_RATIO * sum(block.mass for block in scene.blocks)
    return MODEL.format(
        step=step,
        gravity=-GRAVITY,
        flags='<flag multiccd="enable"/>' if meshes and len(blocks) > 1 else "",
        meshes="".join(meshes),
        base=PLANE if scene.base is None else TABLE.format(mass=mass),
        blocks="".join(blocks),
        pairs="".join(pairs),
    )


FRICTION_LEAST = 1e-5
"""Least friction that MuJoCo's cones allow."""
