"""Bullet, through pybullet, as a peer: free rocking of one box on a box, of the extra `bullet`.

Settings are the best of those tried on blocks B0 to B3. Bullet's own damping is off; the body has
maximal coordinates; contacts are dropped beyond 0.1 mm, as the 20 mm that it starts with end the
rocking early; and the slop, a penetration that is left alone, is none.

E. Coumans, Y. Bai (2016-2021), PyBullet, a Python module for physics simulation for games, robotics
and machine learning.
"""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from warprock.reference.peer_scene import FreeRocking, PeerRun, missing

SETTINGS = "maximal coordinates, 50 iterations, breaking threshold 1e-4 m, no slop, no damping"

BASE_HALF = (20.0, 20.0, 1.0)
"""Half dimensions of the base [m]."""


def free_rocking(
    scene: FreeRocking, gravity: float, time_step: float, steps_per_sample: int
) -> PeerRun:
    """Free rocking of a block in Bullet.

    Args:
        scene: The block and its start.
        gravity: Acceleration of gravity [m/s^2], a positive number.
        time_step: Time step [s].
        steps_per_sample: Steps between two samples: sub-steps of what Bullet calls a time step.

    Returns:
        Samples every `steps_per_sample * time_step`, and the CPU time of the steps.

    Raises:
        ImportError: pybullet is not installed; one line that names the extra.
    """
    try:
        import pybullet
    except ImportError as error:
        raise missing("pybullet", "bullet", error) from None
    world = pybullet.connect(pybullet.DIRECT)
    frame = steps_per_sample * time_step
    try:
        block = _build(pybullet, world, scene, gravity)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=frame,
            numSubSteps=steps_per_sample,
            numSolverIterations=50,
            contactBreakingThreshold=1e-4,
            contactSlop=0.0,
            physicsClientId=world,
        )
        count = round(scene.duration / frame)
        rotation = np.empty(count + 1)
        rotation[0] = scene.rotation_start
        begin = time.process_time()
        for sample in range(1, count + 1):
            pybullet.stepSimulation(physicsClientId=world)
            _, turn = pybullet.getBasePositionAndOrientation(block, physicsClientId=world)
            rotation[sample] = 2.0 * math.atan2(turn[1], turn[3])
        cpu_s = time.process_time() - begin
    finally:
        pybullet.disconnect(world)
    return PeerRun(np.arange(count + 1, dtype=np.float64) * frame, rotation, cpu_s)


def _build(bullet: Any, world: int, scene: FreeRocking, gravity: float) -> int:
    """The base and the block in a world; the number of the block."""
    bullet.setGravity(0.0, 0.0, -gravity, physicsClientId=world)
    base = bullet.createMultiBody(
        0.0,
        bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=BASE_HALF, physicsClientId=world),
        basePosition=(0.0, 0.0, -BASE_HALF[2]),
        useMaximalCoordinates=1,
        physicsClientId=world,
    )
    half = (0.5 * scene.width, 0.5 * scene.depth, 0.5 * scene.height)
    aside, above = scene.centre_start
    turn = scene.quaternion_start
    block = bullet.createMultiBody(
        scene.density * scene.width * scene.height * scene.depth,
        bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half, physicsClientId=world),
        basePosition=(aside, 0.0, above),
        baseOrientation=(*turn[1:], turn[0]),
        useMaximalCoordinates=1,
        physicsClientId=world,
    )
    # Bullet multiplies the two friction coefficients of a pair.
    for body, friction in ((base, 1.0), (block, scene.friction)):
        bullet.changeDynamics(
            body,
            -1,
            lateralFriction=friction,
            rollingFriction=0.0,
            spinningFriction=0.0,
            restitution=0.0,
            linearDamping=0.0,
            angularDamping=0.0,
            physicsClientId=world,
        )
    return int(block)
