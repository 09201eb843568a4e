"""Assemblies in Bullet: boxes and hulls in space, on bodies that move with the base.

Settings are those of `warprock.programs.bullet`. Hulls have no margin, with which Bullet would hold
the blocks apart. Bullet multiplies the frictions of two bodies that touch.
"""

from __future__ import annotations

import itertools
import time
from typing import Any

import numpy as np

from warprock.model.pose import product
from warprock.model.turning import inverse
from warprock.programs.assembly_scene import Solid, one_friction, solids, touching
from warprock.programs.scene import PeerRun, PeerScene
from warprock.settings.programs import BulletSettings
from warprock.units import GRAVITY

TABLE_RATIO = 1e6
"""Mass of what moves with the base over that of all blocks."""


def run_assembly(bullet: Any, world: int, scene: PeerScene, settings: BulletSettings) -> PeerRun:
    """Runs an assembly; poses of the blocks that can move, and the CPU time of the steps."""
    assert scene.assembly is not None
    here = {"physicsClientId": world}
    steps = scene.steps_per_frame(settings.steps_per_second)
    step = scene.frame / steps
    own = solids(scene.assembly)
    bodies = _build(bullet, here, scene, settings, own)
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=step,
        numSubSteps=0,
        numSolverIterations=settings.iterations,
        contactBreakingThreshold=settings.breaking_threshold,
        contactSlop=settings.contact_slop,
        **here,
    )
    places, velocities = scene.base_steps(steps)
    velocities[:, 2] += GRAVITY * step
    driven = [
        (body, solid.place, solid.attitude)
        for body, solid in zip(bodies, own, strict=True)
        if solid.fixed
    ]
    free = [body for body, solid in zip(bodies, own, strict=True) if not solid.fixed]
    pose = bullet.getBasePositionAndOrientation
    seen = [[pose(body, **here) for body in free]]
    begin = time.process_time()
    for frame in range(scene.frame_count):
        for number in range(frame * steps, (frame + 1) * steps):
            for body, place, attitude in driven:
                bullet.resetBasePositionAndOrientation(
                    body, places[number] + place, attitude, **here
                )
                bullet.resetBaseVelocity(body, velocities[number], (0.0, 0.0, 0.0), **here)
            bullet.stepSimulation(**here)
        seen.append([pose(body, **here) for body in free])
    cpu_s = time.process_time() - begin
    position = np.array([[place for place, _ in frame] for frame in seen])
    turned = np.array([[turn for _, turn in frame] for frame in seen])
    starts = np.array([solid.attitude for solid in own if not solid.fixed])
    since = product(turned, inverse(starts))
    return PeerRun(position, since, cpu_s, scene.frame_count * steps)


def _build(
    bullet: Any, here: dict[str, int], scene: PeerScene, settings: BulletSettings, own: list[Solid]
) -> list[int]:
    """The blocks in a world; their numbers."""
    assert scene.assembly is not None
    bullet.setGravity(0.0, 0.0, -GRAVITY, **here)
    heavy = TABLE_RATIO * sum(solid.mass for solid in own if not solid.fixed)
    root = one_friction(scene.assembly) ** 0.5
    bodies = []
    for solid in own:
        if solid.box:
            shape = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=solid.half, **here)
        else:
            shape = bullet.createCollisionShape(
                bullet.GEOM_MESH, vertices=solid.hull.tolist(), **here
            )
        body = bullet.createMultiBody(
            heavy if solid.fixed else solid.mass,
            shape,
            basePosition=solid.place,
            baseOrientation=solid.attitude,
            useMaximalCoordinates=1,
            **here,
        )
        dynamics: dict[str, Any] = {} if solid.box else {"collisionMargin": 0.0}
        bullet.changeDynamics(
            body,
            -1,
            lateralFriction=root,
            rollingFriction=0.0,
            spinningFriction=0.0,
            restitution=settings.restitution,
            linearDamping=0.0,
            angularDamping=0.0,
            **dynamics,
            **here,
        )
        if not solid.fixed:
            inertia = {"mass": solid.mass, "localInertiaDiagonal": solid.inertia}
            bullet.changeDynamics(body, -1, **inertia, **here)
        bodies.append(int(body))
    pairs = touching(scene.assembly)
    for a, b in itertools.combinations(range(len(bodies)), 2):
        bullet.setCollisionFilterPair(bodies[a], bodies[b], -1, -1, int((a, b) in pairs), **here)
    return bodies
