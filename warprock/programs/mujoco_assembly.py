"""Assemblies in MuJoCo: blocks that slide and turn in their plane or in space, on a driven table.

Boxes are boxes, other blocks the hulls of their corners, which need several contacts at a face
(`multiccd`). Contacts are those of `warprock.programs.mujoco`. In the plane blocks have three
joints instead of the six of space: half of the unknowns, and nothing leaves the plane.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.model.assembly import Assembly
from warprock.model.pose import product
from warprock.model.solids import SpatialAssembly
from warprock.model.turning import inverse
from warprock.programs.assembly_scene import Solid, solids, touching
from warprock.programs.scene import PeerRun, PeerScene
from warprock.settings.programs import MujocoSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

MODEL = """
<mujoco>
  <option timestep="{step!r}" gravity="0 0 {gravity!r}" integrator="Euler" solver="Newton"
          cone="elliptic" tolerance="1e-10"><flag multiccd="enable"/></option>
  <default><geom contype="0" conaffinity="0"/></default>
  <asset>{meshes}</asset>
  <worldbody>
    <body gravcomp="1">
      <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{mass!r} {mass!r} {mass!r}"/>
      {table}
      {fixed}
    </body>
    {blocks}
  </worldbody>
  <contact>{pairs}</contact>
</mujoco>
"""
BLOCK = """
<body pos="{place}" quat="{attitude}">
  {joints}
  <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{inertia}"/>
  {geom}
</body>
"""
PAIR = """
<pair geom1="b{first}" geom2="b{second}" condim="3" friction="{friction!r} {friction!r} 0 0 0"
      solref="{time!r} {damping!r}" solimp="{impedance!r} {impedance!r} 1e-6"/>
"""
SLIDE = '<joint type="slide" axis="{}"/>'
IN_PLANE = SLIDE.format("1 0 0") + SLIDE.format("0 0 1") + '<joint type="hinge" axis="0 1 0"/>'
"""Joints of a block in the plane; in space it is free."""
TABLE_RATIO = 1e6
"""Mass of the table over that of all blocks."""


def run_assembly(mujoco: Any, scene: PeerScene, settings: MujocoSettings) -> PeerRun:
    """Runs an assembly; poses of the blocks that can move, and the CPU time of the steps."""
    assert scene.assembly is not None
    steps = scene.steps_per_frame(settings.steps_per_second)
    text = _model_text(scene, scene.frame / steps, settings)
    model = mujoco.MjModel.from_xml_string(text)
    state = mujoco.MjData(model)
    places, velocities = scene.base_steps(steps)
    axes = 3 if isinstance(scene.assembly, SpatialAssembly) else 1
    seen = [state.qpos[axes:].copy()]
    begin = time.process_time()
    for frame in range(scene.frame_count):
        for step in range(frame * steps, (frame + 1) * steps):
            state.qpos[:axes], state.qvel[:axes] = places[step, :axes], velocities[step, :axes]
            mujoco.mj_step(model, state)
        seen.append(state.qpos[axes:].copy())
    cpu_s = time.process_time() - begin
    position, attitude = _poses(scene.assembly, np.array(seen))
    return PeerRun(position, attitude, cpu_s, scene.frame_count * steps)


def _poses(kind: Assembly, seen: Array) -> tuple[Array, Array]:
    """Places [m] and turns since the start of the blocks that can move, by their coordinates."""
    free = ~kind.fixed
    if isinstance(kind, SpatialAssembly):
        found = seen.reshape(len(seen), -1, 7)
        starts = np.array([solid.attitude for solid in solids(kind) if not solid.fixed])
        turned = np.roll(found[..., 3:], -1, axis=-1)
        return found[..., :3], product(turned, inverse(starts))
    found = seen.reshape(len(seen), -1, 3)
    position, attitude = np.zeros((*found.shape[:2], 3)), np.zeros((*found.shape[:2], 4))
    position[..., ::2] = found[..., :2] + kind.centre[free]
    attitude[..., 1], attitude[..., 3] = np.sin(0.5 * found[..., 2]), np.cos(0.5 * found[..., 2])
    return position, attitude


def spaced(numbers: Iterable[float]) -> str:
    """Numbers as MuJoCo's language has them."""
    return " ".join(repr(float(number)) for number in numbers)


def _geom(number: int, solid: Solid, where: str) -> str:
    if solid.box:
        return f'<geom name="b{number}" type="box" size="{spaced(solid.half)}" {where}/>'
    return f'<geom name="b{number}" type="mesh" mesh="b{number}" {where}/>'


def _model_text(scene: PeerScene, step: float, settings: MujocoSettings) -> str:
    """The scene in MuJoCo's language."""
    assert scene.assembly is not None
    spatial = isinstance(scene.assembly, SpatialAssembly)
    table = ("1 0 0", "0 1 0", "0 0 1") if spatial else ("1 0 0",)
    fixed, blocks, meshes = [], [], []
    own = solids(scene.assembly)
    for number, solid in enumerate(own):
        place, attitude = spaced(solid.place), spaced(np.roll(solid.attitude, 1))
        if not solid.box:
            meshes.append(
                f'<mesh name="b{number}" inertia="convex" vertex="{spaced(solid.hull.ravel())}"/>'
            )
        if solid.fixed:
            fixed.append(_geom(number, solid, f'pos="{place}" quat="{attitude}"'))
            continue
        blocks.append(
            BLOCK.format(
                place=place,
                mass=solid.mass,
                inertia=spaced(solid.inertia),
                geom=_geom(number, solid, ""),
                attitude=attitude,
                joints="<freejoint/>" if spatial else IN_PLANE,
            )
        )
    contact = {
        "time": settings.contact_time * step,
        "damping": settings.damping_ratio,
        "impedance": settings.impedance,
    }
    pairs = [
        PAIR.format(first=a, second=b, friction=max(friction, 1e-5), **contact)
        for (a, b), friction in touching(scene.assembly).items()
    ]
    return MODEL.format(
        step=step,
        gravity=-GRAVITY,
        mass=TABLE_RATIO * sum(solid.mass for solid in own if not solid.fixed),
        meshes="".join(meshes),
        table="".join(SLIDE.format(axis) for axis in table),
        fixed="".join(fixed),
        blocks="".join(blocks),
        pairs="".join(pairs),
    )
