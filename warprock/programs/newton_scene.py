"""The scenes of lanes in Newton: articulated shake tables, and blocks as free bodies on them.

Each lane is a world of its own in one model. Its table is a kinematic body on a prismatic joint, or
on one with three linear axes where the base moves in space; place and velocity are written to its
body and to its joint before every step, since some solvers read the one and some the other. The
table's face is an endless plane, or a box for a solver without planes that move. A block touches
what it stands on alone.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import newton
import numpy as np
import warp as wp

from warprock.programs.assembly_scene import Solid, one_friction, solids, touching
from warprock.programs.scene import PeerBlock, PeerScene
from warprock.units import GRAVITY

GAP = 5e-3
"""Distance at which two faces are looked at as a contact [m]."""
TABLE_RATIO = 1e3
"""Mass of a table over that of its blocks, for solvers that use the mass of a kinematic body."""
TABLE_HALF = (20.0, 20.0, 0.5)
"""Half sizes of a table that is a box [m]."""

SPRING_RATE, SPRING_DAMPING, FRICTION_RATE = 0.1, 0.5, 0.1
"""Contacts that are springs: natural frequency of the lightest block on one spring times the step,
damping over the critical one, slope of the friction over mass / step. Stiffer or less damped ones
were tried; with them a block of B1 to B3 jumped, or the error was larger."""


@wp.kernel(enable_backward=False)  # type: ignore[untyped-decorator]
def drive_tables(
    step: int,
    axes: int,
    bodies: wp.array2d[wp.int32],
    places: wp.array2d[wp.vec3],
    velocities: wp.array2d[wp.vec3],
    body_q: wp.array[wp.transform],
    body_qd: wp.array[wp.spatial_vector],
    joint_q: wp.array[wp.float32],
    joint_qd: wp.array[wp.float32],
) -> None:
    """Puts each world's table where the base is at the start of a step, with the step's velocity.

    The rows of `bodies` are a table's body, first coordinate and first speed.
    """
    world = wp.tid()
    place = places[step, world]
    velocity = velocities[step, world]
    body_q[bodies[world, 0]] = wp.transform(place, wp.quat_identity())
    body_qd[bodies[world, 0]] = wp.spatial_vector(velocity, wp.vec3())
    for axis in range(axes):
        joint_q[bodies[world, 1] + axis] = place[axis]
        joint_qd[bodies[world, 2] + axis] = velocity[axis]


class NewtonScene:
    """Scenes as the worlds of one model."""

    def __init__(
        self, scenes: Sequence[PeerScene], *, step: float, plane: bool, register: Any = None
    ) -> None:
        """Builds the model.

        Args:
            scenes: The scenes, all with the same number of blocks.
            step: Time step [s], which springs in contacts follow from.
            plane: Whether the table's face is a plane; otherwise it is a box.
            register: Registers attributes that a solver needs with the builder.
        """
        builder = newton.ModelBuilder(up_axis=newton.Axis.Z, gravity=(0.0, 0.0, -GRAVITY))
        if register is not None:
            register(builder)
        self._axes = 3 if any(s.base is not None and any(s.base.paths[1:]) for s in scenes) else 1
        for scene in scenes:
            builder.begin_world()
            _add_world(builder, scene, _material(scene, step), plane=plane, axes=self._axes)
            builder.end_world()
        builder.color()
        self.model = builder.finalize(device="cpu")
        self._block_count = scenes[0].block_count
        # The table comes first in its world: one body, its axes, then seven coordinates and six
        # speeds of each block.
        strides = (
            1 + self._block_count,
            self._axes + 7 * self._block_count,
            self._axes + 6 * self._block_count,
        )
        numbers = np.outer(np.arange(len(scenes)), strides).astype(np.int32)
        self._bodies = wp.array(numbers, dtype=wp.int32, device="cpu")

    def drive(self, state: Any, step: int, places: Any, velocities: Any) -> None:
        """Drives the tables of a state before a step.

        Args:
            state: State of the model, which is changed.
            step: Row of the arrays.
            places: Places at the start of steps [m], shape [step, world].
            velocities: Velocities over steps [m/s], shape [step, world].
        """
        wp.launch(
            drive_tables,
            dim=self._bodies.shape[0],
            inputs=[step, self._axes, self._bodies, places, velocities],
            outputs=[state.body_q, state.body_qd, state.joint_q, state.joint_qd],
            device="cpu",
        )

    def poses(self, state: Any) -> Any:
        """Poses of the blocks, shape [world, block, 7]: place and quaternion (x, y, z, w)."""
        found = state.body_q.numpy().reshape(-1, 1 + self._block_count, 7)
        return found[:, 1:].astype(np.float64)


def _material(scene: PeerScene, step: float) -> dict[str, float]:
    """Friction of all shapes, and springs for solvers that have them in contacts."""
    if scene.assembly is None:
        mass, friction = min(block.mass for block in scene.blocks), scene.blocks[0].friction
    else:
        own = scene.assembly
        mass, friction = float(own.mass[~own.fixed].min()), one_friction(own)
    stiffness = mass * (SPRING_RATE / step) ** 2
    return {
        "mu": friction,
        "ke": stiffness,
        "kd": 2.0 * SPRING_DAMPING * (stiffness * mass) ** 0.5,
        "kf": FRICTION_RATE * mass / step,
    }


def _add_world(
    builder: Any, scene: PeerScene, material: dict[str, float], *, plane: bool, axes: int
) -> None:
    """One lane: the table and its joint, then the blocks."""
    config = newton.ModelBuilder.ShapeConfig(
        density=0.0, gap=GAP, mu_torsional=0.0, mu_rolling=0.0, restitution=0.0, **material
    )
    whole = sum(block.mass for block in scene.blocks)
    if scene.assembly is not None:
        whole = float(scene.assembly.mass[~scene.assembly.fixed].sum())
    mass = TABLE_RATIO * whole
    table = builder.add_link(
        mass=mass, inertia=wp.mat33(np.eye(3) * mass), lock_inertia=True, is_kinematic=True
    )
    if axes == 1:
        joint = builder.add_joint_prismatic(-1, table, axis=newton.Axis.X)
    else:
        linear = [newton.ModelBuilder.JointDofConfig(axis=a) for a in newton.Axis]
        joint = builder.add_joint_d6(-1, table, linear_axes=linear)
    builder.add_articulation([joint])
    if scene.assembly is not None:
        _add_solids(builder, scene, table, config)
        return
    if plane:
        shapes = [builder.add_shape_plane(body=table, width=0.0, length=0.0, cfg=config)]
    else:
        hx, hy, hz = TABLE_HALF
        below = wp.transform((0.0, 0.0, -hz), wp.quat_identity())
        shapes = [builder.add_shape_box(table, xform=below, hx=hx, hy=hy, hz=hz, cfg=config)]
    for block in scene.blocks:
        shape = _add_block(builder, block, config)
        for other in shapes[:-1]:
            builder.add_shape_collision_filter_pair(other, shape)
        shapes.append(shape)


def _add_block(builder: Any, block: PeerBlock, config: Any) -> int:
    """A free body with its mass and inertia, and a box that touches as the block does."""
    hx, hy, hz = (0.5 * size for size in block.touching_size)
    body = builder.add_body(
        xform=wp.transform(block.position, wp.quat(*block.attitude)),
        mass=block.mass,
        inertia=wp.mat33(np.diag(block.inertia)),
        lock_inertia=True,
    )
    middle = wp.transform(block.middle, wp.quat_identity())
    return int(builder.add_shape_box(body, xform=middle, hx=hx, hy=hy, hz=hz, cfg=config))


def _add_solids(builder: Any, scene: PeerScene, table: int, config: Any) -> None:
    """The blocks of an assembly: fixed ones as shapes of the table, all others as free bodies."""
    assert scene.assembly is not None
    shapes = []
    for solid in solids(scene.assembly):
        place = wp.transform(tuple(map(float, solid.place)), wp.quat_identity())
        if solid.fixed:
            shapes.append(_add_solid(builder, solid, table, place, config))
            continue
        body = builder.add_body(
            xform=place,
            mass=solid.mass,
            inertia=wp.mat33(np.diag(solid.inertia)),
            lock_inertia=True,
        )
        shapes.append(_add_solid(builder, solid, body, wp.transform_identity(), config))
    pairs = touching(scene.assembly)
    for a, b in itertools.combinations(range(len(shapes)), 2):
        if (a, b) not in pairs:
            builder.add_shape_collision_filter_pair(shapes[a], shapes[b])


def _add_solid(builder: Any, solid: Solid, body: int, place: Any, config: Any) -> int:
    """A box, or the hull of the corners of a solid."""
    if solid.box:
        hx, hy, hz = solid.half
        return int(builder.add_shape_box(body, xform=place, hx=hx, hy=hy, hz=hz, cfg=config))
    hull = solid.hull
    mesh = newton.Mesh(hull.astype(np.float32), _faces(len(hull) // 2), compute_inertia=False)
    return int(builder.add_shape_convex_hull(body, xform=place, mesh=mesh, cfg=config))


def _faces(corners: int) -> Any:
    """Triangles of a prism whose corners are those of one end, counterclockwise, then the other."""
    found = []
    for k in range(corners):
        after = (k + 1) % corners
        found += [(k, after, corners + k), (after, corners + after, corners + k)]
    for k in range(1, corners - 1):
        found += [(0, k + 1, k), (corners, corners + k, corners + k + 1)]
    return np.array(found, dtype=np.int32).ravel()
