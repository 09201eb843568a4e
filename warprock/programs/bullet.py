"""Bullet, through pybullet, as a program beside ours: boxes on a table, of the extra `bullet`.

Settings are the best of those tried on blocks B0 to B3. Bullet's own damping is off; the bodies
have maximal coordinates; contacts are dropped beyond 0.1 mm, as the 20 mm that it starts with end
the rocking early; and the slop, a penetration that is left alone, is none, as what a velocity step
of the base gives a block depends on it: with 0.1 mm the peaks of the paper's one-cycle sines fall
by up to 4 %, those at 3 and 3.3 Hz to within 1.1 % of the paper's own column of Bullet.

A base that moves is a body a million times as heavy as all blocks, whose place and velocity are set
before every step, its velocity upwards being what gravity is about to take from it: a body without
mass that is moved has no velocity at its contacts. Bullet finds the inertia of a body from the
sizes of its shape: blocks with chamfers are two boxes, one as wide as the faces and as high as the
block, one as wide as the block, for which those sizes are the block's.

E. Coumans, Y. Bai (2016-2021), PyBullet, a Python module for physics simulation for games, robotics
and machine learning.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from warprock.programs.assembly_scene import one_friction
from warprock.programs.bullet_assembly import run_assembly
from warprock.programs.scene import (
    PeerBlock,
    PeerRun,
    PeerScene,
    missing,
    multiplied_frictions,
)
from warprock.settings.programs import BulletSettings
from warprock.units import GRAVITY

BASE_HALF = (20.0, 20.0, 1.0)
"""Half dimensions of the base [m]."""
TABLE_RATIO = 1e6
"""Mass of a base that moves over that of all blocks."""
UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def run(
    scenes: Sequence[PeerScene], settings: BulletSettings, finished: Any = None
) -> list[PeerRun]:
    """Runs scenes, one after the other.

    Args:
        scenes: The scenes.
        settings: Steps a second and what Bullet's contact solver does in one.
        finished: Called with the number of scenes that are done, after each.

    Returns:
        Poses at the frames of each scene, and the CPU time of its steps.

    Raises:
        ImportError: pybullet is not installed; one line that names the extra.
    """
    try:
        import pybullet
    except ImportError as error:
        raise missing("pybullet", 'pip install "warprock[bullet]"', error) from None
    runs = []
    for scene in scenes:
        world = pybullet.connect(pybullet.DIRECT)
        try:
            run_one = _run_scene if scene.assembly is None else run_assembly
            runs.append(run_one(pybullet, world, scene, settings))
        finally:
            pybullet.disconnect(world)
        if finished is not None:
            finished(len(runs))
    return runs


def require_scenes(scenes: Sequence[PeerScene], _settings: BulletSettings) -> None:
    """Declines assemblies whose joints have frictions of their own.

    Raises:
        DeclinedError: One has several.
    """
    for scene in scenes:
        if scene.assembly is not None:
            one_friction(scene.assembly)


def _run_scene(bullet: Any, world: int, scene: PeerScene, settings: BulletSettings) -> PeerRun:
    steps = scene.steps_per_frame(settings.steps_per_second)
    table, blocks = _build(bullet, world, scene, settings.restitution)
    moving = scene.base is not None
    bullet.setPhysicsEngineParameter(
        fixedTimeStep=scene.frame / steps if moving else scene.frame,
        # 0 is one step, as 1 is.
        numSubSteps=0 if moving else steps,
        numSolverIterations=settings.iterations,
        contactBreakingThreshold=settings.breaking_threshold,
        contactSlop=settings.contact_slop,
        physicsClientId=world,
    )
    places, velocities = scene.base_steps(steps)
    if moving:
        places[:, 2] -= BASE_HALF[2]
        velocities[:, 2] += GRAVITY * scene.frame / steps
    pose, step = bullet.getBasePositionAndOrientation, bullet.stepSimulation
    seen = [[pose(block, physicsClientId=world) for block in blocks]]
    begin = time.process_time()
    for frame in range(scene.frame_count):
        if moving:
            for number in range(frame * steps, (frame + 1) * steps):
                bullet.resetBasePositionAndOrientation(
                    table, places[number], UPRIGHT, physicsClientId=world
                )
                bullet.resetBaseVelocity(
                    table, velocities[number], (0.0, 0.0, 0.0), physicsClientId=world
                )
                step(physicsClientId=world)
        else:
            step(physicsClientId=world)
        seen.append([pose(block, physicsClientId=world) for block in blocks])
    cpu_s = time.process_time() - begin
    position = np.array([[place for place, _ in frame] for frame in seen])
    attitude = np.array([[turn for _, turn in frame] for frame in seen])
    return PeerRun(position, attitude, cpu_s, scene.frame_count * steps)


def _build(bullet: Any, world: int, scene: PeerScene, restitution: float) -> tuple[int, list[int]]:
    """The base and the blocks in a world; their numbers."""
    bullet.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=world)
    here = {"physicsClientId": world}
    heavy = TABLE_RATIO * sum(block.mass for block in scene.blocks)
    table = bullet.createMultiBody(
        0.0 if scene.base is None else heavy,
        bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=BASE_HALF, **here),
        basePosition=(0.0, 0.0, -BASE_HALF[2]),
        useMaximalCoordinates=1,
        **here,
    )
    blocks = [
        bullet.createMultiBody(
            block.mass,
            _shape(bullet, block, here),
            basePosition=block.position,
            baseOrientation=block.attitude,
            useMaximalCoordinates=1,
            **here,
        )
        for block in scene.blocks
    ]
    # Restitutions are multiplied, as frictions are.
    bounces = [float(restitution > 0.0)] + [restitution] * len(blocks)
    for body, friction, bounce in zip(
        (table, *blocks), multiplied_frictions(scene), bounces, strict=True
    ):
        bullet.changeDynamics(
            body,
            -1,
            lateralFriction=friction,
            rollingFriction=0.0,
            spinningFriction=0.0,
            restitution=bounce,
            linearDamping=0.0,
            angularDamping=0.0,
            **here,
        )
    for body, block in zip(blocks, scene.blocks, strict=True):
        if not np.allclose(block.inertia, block.even_inertia):
            # Without the mass beside it Bullet takes that away.
            inertia = {"mass": block.mass, "localInertiaDiagonal": block.inertia}
            bullet.changeDynamics(body, -1, **inertia, **here)
        if block.moving:
            bullet.resetBaseVelocity(body, block.velocity, block.spin, **here)
    return int(table), [int(block) for block in blocks]


def _shape(bullet: Any, block: PeerBlock, here: dict[str, int]) -> int:
    """A box that touches as the block does and has its sizes."""
    half = [0.5 * size for size in block.touching_size]
    if not block.chamfered and not any(block.middle):
        return int(bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half, **here))
    cut = 0.5 * (block.size[0] - block.face[0])
    wide = [0.5 * block.size[0], 0.5 * block.size[1], 0.5 * block.size[2] - cut]
    boxes = [half, wide] if block.chamfered else [half]
    shape = bullet.createCollisionShapeArray(
        shapeTypes=[bullet.GEOM_BOX] * len(boxes),
        halfExtents=boxes,
        collisionFramePositions=[block.middle] * len(boxes),
        **here,
    )
    return int(shape)
