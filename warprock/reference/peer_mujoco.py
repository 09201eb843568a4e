"""MuJoCo as a peer: free rocking of one box on a plane, of the extra `mujoco`.

Settings are the best of those tried on blocks B0 to B3: the contact must be stiffer with every
shorter step (a time constant of two steps, the least that MuJoCo allows, twice critically damped)
and hard from the first micrometre on (`solimp`).

E. Todorov, T. Erez, Y. Tassa (2012), MuJoCo: a physics engine for model-based control, *IROS*.
"""

from __future__ import annotations

import math
import time

import numpy as np

from warprock.reference.peer_scene import FreeRocking, PeerRun, missing

SETTINGS = "Newton solver, elliptic cones, solref (2 dt, 2), solimp .9999 .9999 1e-6"

MODEL = """
<mujoco>
  <option timestep="{time_step!r}" gravity="0 0 {gravity!r}" integrator="Euler" solver="Newton"
          cone="elliptic" tolerance="1e-12"/>
  <default>
    <geom condim="3" friction="{friction!r} 0 0" solref="{reaction!r} 2"
          solimp=".9999 .9999 1e-6"/>
  </default>
  <worldbody>
    <geom type="plane" size="50 50 1"/>
    <body><freejoint/><geom type="box" size="{half}" density="{density!r}"/></body>
  </worldbody>
</mujoco>
"""


def free_rocking(
    scene: FreeRocking, gravity: float, time_step: float, steps_per_sample: int
) -> PeerRun:
    """Free rocking of a block in MuJoCo.

    Args:
        scene: The block and its start.
        gravity: Acceleration of gravity [m/s^2], a positive number.
        time_step: Time step [s].
        steps_per_sample: Steps between two samples.

    Returns:
        Samples every `steps_per_sample * time_step`, and the CPU time of the steps.

    Raises:
        ImportError: MuJoCo is not installed; one line that names the extra.
    """
    try:
        import mujoco
    except ImportError as error:
        raise missing("mujoco", "mujoco", error) from None
    half = (0.5 * scene.width, 0.5 * scene.depth, 0.5 * scene.height)
    text = MODEL.format(
        time_step=time_step,
        gravity=-gravity,
        friction=scene.friction,
        reaction=2.0 * time_step,
        half=" ".join(map(repr, half)),
        density=scene.density,
    )
    model = mujoco.MjModel.from_xml_string(text)
    state = mujoco.MjData(model)
    aside, above = scene.centre_start
    state.qpos[:] = (aside, 0.0, above, *scene.quaternion_start)
    count = round(scene.duration / (steps_per_sample * time_step))
    rotation = np.empty(count + 1)
    rotation[0] = scene.rotation_start
    place = state.qpos
    begin = time.process_time()
    for sample in range(1, count + 1):
        mujoco.mj_step(model, state, steps_per_sample)
        rotation[sample] = 2.0 * math.atan2(place[5], place[3])
    cpu_s = time.process_time() - begin
    return PeerRun(
        np.arange(count + 1, dtype=np.float64) * (steps_per_sample * time_step), rotation, cpu_s
    )
