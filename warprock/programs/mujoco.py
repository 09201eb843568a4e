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

What holds a block: a transverse wall is a box on the base, without friction, with contacts as the
others; ties and loads are forces at points of the block, which Python computes at every step
(`warprock.programs.pulls`). A frame is one column and its part of the beam, a box on the column's
top that slides and does not turn. Contacts push a block out of what it sank in within a step, at up
to 1 / (4 damping_ratio^2) of the rate with which it came: 6 % at 2, which is seen where a block
comes back on its base and on a wall at once; at 20 it is gone.

E. Todorov, T. Erez, Y. Tassa (2012), MuJoCo: a physics engine for model-based control, *IROS*.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.errors import DeclinedError
from warprock.model.hold import Hold
from warprock.model.turning import rotate
from warprock.programs.mujoco_assembly import run_assembly, spaced
from warprock.programs.pulls import Pulls
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
  <worldbody>{base}{blocks}{beam}</worldbody>
  <contact>{pairs}</contact>
</mujoco>
"""
PLANE = '<geom name="0" type="plane" size="50 50 1"/>{wall}'
TABLE = """
<body pos="0 0 -1" gravcomp="1">
  <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{mass!r} {mass!r} {mass!r}"/>
  <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
  <joint type="slide" axis="0 0 1"/>
  <geom name="0" type="box" size="50 50 1"/>{wall}
</body>
"""
WALL = '<geom name="wall" type="box" size="{half}" pos="{middle}"/>'
BEAM = """
<body pos="{place}">
  <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{mass!r} {mass!r} {mass!r}"/>
  <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
  <geom name="beam" type="box" size="{half}"/>
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
<pair geom1="{first}" geom2="{second}" condim="3" friction="{friction!r} {friction!r} 0 0 0"
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
        run_one = _run_scene if scene.assembly is None else run_assembly
        runs.append(run_one(mujoco, scene, settings))
        if finished is not None:
            finished(len(runs))
    return runs


def require_scenes(scenes: Sequence[PeerScene], _settings: MujocoSettings) -> None:
    """Declines blocks that rebound from their transverse wall: its contacts are plastic.

    Raises:
        DeclinedError: A block rebounds.
    """
    if any(s.hold is not None and s.hold.wall is not None and _rebounds(s.hold) for s in scenes):
        raise DeclinedError(
            "its contacts are plastic, and the case lets its block rebound from its wall "
            '(transverse_wall.rebound); "plastic" it can do'
        )


def _rebounds(hold: Hold) -> bool:
    return hold.rebound is not None and bool(np.any(hold.rebound > 0.0))


def _run_scene(mujoco: Any, scene: PeerScene, settings: MujocoSettings) -> PeerRun:
    steps = scene.steps_per_frame(settings.steps_per_second)
    model = mujoco.MjModel.from_xml_string(_model_text(scene, scene.frame / steps, settings))
    state = mujoco.MjData(model)
    places, velocities = scene.base_steps(steps)
    moves = np.asarray(np.any(velocities.reshape(scene.frame_count, -1), axis=1))
    pulls = None if scene.hold is None else Pulls(scene.hold, scene.blocks[0].size)
    pulled = state.xfrc_applied[model.geom("1").bodyid[0]]
    first = 0 if scene.base is None else 3
    last = first + 7 * len(scene.blocks)
    table, drive, poses = state.qpos[:first], state.qvel[:first], state.qpos[first:last]
    # MuJoCo's quaternions begin with their real part.
    poses[:] = np.concatenate(
        [(*block.position, block.attitude[3], *block.attitude[:3]) for block in scene.blocks]
    )
    speeds = np.concatenate([_velocities(block) for block in scene.blocks])
    state.qvel[first : first + len(speeds)] = speeds
    seen = np.empty((scene.frame_count + 1, len(poses)))
    seen[0] = poses
    begin = time.process_time()
    for frame in range(scene.frame_count):
        if moves[frame] or pulls is not None:
            for step in range(frame * steps, (frame + 1) * steps):
                table[:], drive[:] = places[step, :first], velocities[step, :first]
                if pulls is not None:
                    pulled[:] = pulls.wrench(poses.tolist(), float(places[step, 0]))
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


def _block_text(number: int, block: PeerBlock) -> str:
    """A block in MuJoCo's language."""
    if block.body is not None:
        return BODY.format(number=number, mass=block.mass, tensor=spaced(block.body.tensor))
    half = spaced(0.5 * size for size in block.touching_size)
    shape = {"half": half, "middle": spaced(block.middle), "inertia": spaced(block.inertia)}
    return BLOCK.format(number=number, mass=block.mass, **shape)


def _wall_text(scene: PeerScene, ground: float) -> str:
    """A transverse wall beside the block, on a base whose ground is at a height [m]."""
    if scene.hold is None or scene.hold.wall is None:
        return ""
    width, depth, height = scene.blocks[0].size
    side = float(scene.hold.wall[0])
    middle = (side * (0.5 * width + height), 0.0, ground + height)
    return WALL.format(half=spaced((height, depth, height)), middle=spaced(middle))


def _beam_text(scene: PeerScene) -> str:
    """The part of a frame's beam that one column carries, on the higher corner of its top."""
    if scene.hold is None or scene.hold.frame is None:
        return ""
    block = scene.blocks[0]
    width, depth, height = block.size
    corners = 0.5 * np.array([(-width, 0.0, height), (width, 0.0, height)])
    top = np.array(block.position) + rotate(np.array(block.attitude), corners)
    half = (width + height, depth, 0.5 * height)
    place = (block.position[0], 0.0, float(top[:, 2].max()) + half[2])
    mass = float(scene.hold.frame.mass_ratio[0]) * block.mass
    return BEAM.format(place=spaced(place), mass=mass, half=spaced(half)) if mass > 0.0 else ""


def _model_text(scene: PeerScene, step: float, settings: MujocoSettings) -> str:
    """The scene in MuJoCo's language."""
    blocks, pairs, meshes = [], [], []

    def touch(first: object, second: object, friction: float) -> None:
        contact = {
            "friction": max(friction, FRICTION_LEAST),
            "time": settings.contact_time * step,
            "damping": settings.damping_ratio,
            "impedance": settings.impedance,
        }
        pairs.append(PAIR.format(first=first, second=second, **contact))

    for number, block in enumerate(scene.blocks, 1):
        blocks.append(_block_text(number, block))
        if block.body is not None:
            hull = np.array([*block.body.points, *block.body.top])
            meshes.append(MESH.format(number=number, hull=spaced(hull.ravel())))
        touch(number - 1, number, block.friction)
    mass = TABLE_RATIO * sum(block.mass for block in scene.blocks)
    wall = _wall_text(scene, 0.0 if scene.base is None else 1.0)
    beam = _beam_text(scene)
    if wall:
        touch("wall", 1, 0.0)
    if beam:
        touch(1, "beam", scene.blocks[0].friction)
    base = PLANE.format(wall=wall)
    if scene.base is not None:
        base = TABLE.format(mass=mass, wall=wall)
    return MODEL.format(
        step=step,
        gravity=-GRAVITY,
        flags='<flag multiccd="enable"/>' if meshes and len(blocks) > 1 else "",
        meshes="".join(meshes),
        base=base,
        blocks="".join(blocks),
        beam=beam,
        pairs="".join(pairs),
    )


FRICTION_LEAST = 1e-5
"""Least friction that MuJoCo's cones allow."""
