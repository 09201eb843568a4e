"""Assemblies in MuJoCo: blocks that slide and turn in their plane, on a driven table.

Boxes are boxes, other blocks the hulls of their corners, which need several contacts at a face
(`multiccd`). Contacts are those of `warprock.programs.mujoco`. Blocks have the three joints of a
plane instead of six of space: half of the unknowns, and nothing leaves the plane.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from warprock.programs.assembly_scene import Prism, prisms, touching
from warprock.programs.scene import PeerRun, PeerScene
from warprock.settings.programs import MujocoSettings
from warprock.units import GRAVITY

MODEL = """
<mujoco>
  <option timestep="{step!r}" gravity="0 0 {gravity!r}" integrator="Euler" solver="Newton"
          cone="elliptic" tolerance="1e-10"><flag multiccd="enable"/></option>
  <default><geom contype="0" conaffinity="0"/></default>
  <asset>{meshes}</asset>
  <worldbody>
    <body gravcomp="1">
      <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{mass!r} {mass!r} {mass!r}"/>
      <joint type="slide" axis="1 0 0"/>
      {fixed}
    </body>
    {blocks}
  </worldbody>
  <contact>{pairs}</contact>
</mujoco>
"""
BLOCK = """
<body pos="{place}">
  <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/>
  <joint type="hinge" axis="0 1 0"/>
  <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{inertia}"/>
  {geom}
</body>
"""
PAIR = """
<pair geom1="b{first}" geom2="b{second}" condim="3" friction="{friction!r} {friction!r} 0 0 0"
      solref="{time!r} {damping!r}" solimp="{impedance!r} {impedance!r} 1e-6"/>
"""
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
    seen = [state.qpos[1:].copy()]
    begin = time.process_time()
    for frame in range(scene.frame_count):
        for step in range(frame * steps, (frame + 1) * steps):
            state.qpos[0], state.qvel[0] = places[step, 0], velocities[step, 0]
            mujoco.mj_step(model, state)
        seen.append(state.qpos[1:].copy())
    cpu_s = time.process_time() - begin
    found = np.array(seen).reshape(len(seen), -1, 3)
    start = scene.assembly.centre[~scene.assembly.fixed]
    position, attitude = np.zeros((*found.shape[:2], 3)), np.zeros((*found.shape[:2], 4))
    position[..., ::2] = found[..., :2] + start
    attitude[..., 1], attitude[..., 3] = np.sin(0.5 * found[..., 2]), np.cos(0.5 * found[..., 2])
    return PeerRun(position, attitude, cpu_s, scene.frame_count * steps)


def _text(numbers: Any) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def _geom(number: int, prism: Prism, place: str) -> str:
    if prism.box:
        return f'<geom name="b{number}" type="box" size="{_text(prism.half)}" pos="{place}"/>'
    return f'<geom name="b{number}" type="mesh" mesh="b{number}" pos="{place}"/>'


def _model_text(scene: PeerScene, step: float, settings: MujocoSettings) -> str:
    """The scene in MuJoCo's language."""
    assert scene.assembly is not None
    fixed, blocks, meshes = [], [], []
    own = prisms(scene.assembly)
    for number, prism in enumerate(own):
        place = _text((prism.place[0], 0.0, prism.place[1]))
        if not prism.box:
            meshes.append(
                f'<mesh name="b{number}" inertia="convex" vertex="{_text(prism.hull.ravel())}"/>'
            )
        if prism.fixed:
            fixed.append(_geom(number, prism, place))
            continue
        blocks.append(
            BLOCK.format(
                place=place,
                mass=prism.mass,
                inertia=_text(prism.inertia),
                geom=_geom(number, prism, "0 0 0"),
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
        mass=TABLE_RATIO * sum(prism.mass for prism in own if not prism.fixed),
        meshes="".join(meshes),
        fixed="".join(fixed),
        blocks="".join(blocks),
        pairs="".join(pairs),
    )
