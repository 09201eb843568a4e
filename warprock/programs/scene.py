"""A lane as programs of others are given it to run, and what they answer.

A scene is boxes in space: x in the plane of rocking, y across it, z upwards, the base at z = 0 at
the start. Everything is as a program of rigid bodies takes it: full sizes, masses and moments of
inertia, the position of the centre of mass and the attitude as a quaternion at the start, its
velocities there, one friction coefficient for each face, and a base that translates as it is told.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.model.assembly import Assembly
from warprock.model.base_path import BasePath, base_path
from warprock.model.hold import Hold
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import GroundMotions
from warprock.model.pose import start_poses
from warprock.model.profiles import Profiles
from warprock.model.response import SampleTimes
from warprock.model.stacking import centre_height, steps_along
from warprock.model.turning import rotate

Array = npt.NDArray[np.float64]

FRAME_LONGEST = 0.01
"""Longest time between two frames, at which poses are asked for [s]."""


@dataclasses.dataclass(frozen=True)
class PeerBody:
    """What a body is that is no box, in the axes of the block from the centre of mass.

    Attributes:
        points: Contact points [m]; of a body in the plane at both ends of its depth.
        tensor: Moments of inertia xx, yy, zz, xy, xz and yz, entries of the tensor [kg m^2].
        top: Corners of its top [m]; none where the points surround the centre of mass.
        middle: In a stack, how far what it stands on at rest has its middle to +x of it [m].
    """

    points: Sequence[Sequence[float]]
    tensor: Sequence[float]
    top: Sequence[Sequence[float]]
    middle: float = 0.0


@dataclasses.dataclass(frozen=True)
class PeerBlock:
    """One box, or a body in the box around it; SI units, full dimensions.

    Attributes:
        size: Width, depth and height [m].
        face: Width and depth over which its faces touch others [m]: less than its size where its
            edges are chamfered.
        middle: Middle of the box as seen from its centre of mass, in body axes [m].
        mass: [kg].
        inertia: Moments of inertia about the centre of mass, along the body axes [kg m^2].
        friction: Coulomb friction coefficient between it and what it stands on.
        position: Centre of mass at the start [m].
        attitude: Quaternion (x, y, z, w) at the start.
        stands: Where its middle stands when all blocks are flat, x and y from the middle of the
            lowest block [m].
        yaw: Turn about the vertical at the start [rad].
        velocity: Of the centre of mass at the start, in the axes of the base [m/s].
        spin: Angular velocity at the start, in the axes of the base [rad/s].
        body: What it is if it is no box; its size and middle are for pictures then.
    """

    size: Sequence[float]
    face: Sequence[float]
    middle: Sequence[float]
    mass: float
    inertia: Sequence[float]
    friction: float
    position: Sequence[float]
    attitude: Sequence[float]
    stands: Sequence[float]
    yaw: float
    velocity: Sequence[float] = (0.0, 0.0, 0.0)
    spin: Sequence[float] = (0.0, 0.0, 0.0)
    body: PeerBody | None = None

    @property
    def moving(self) -> bool:
        """Whether it starts in motion."""
        return any(self.velocity) or any(self.spin)

    @property
    def even_inertia(self) -> list[float]:
        """Moments of inertia of a box that is the same all through [kg m^2]."""
        squares = [size**2 for size in self.size]
        return [self.mass / 12.0 * (sum(squares) - square) for square in squares]

    @property
    def chamfered(self) -> bool:
        """Whether its faces are smaller than its sections."""
        return list(self.face) != list(self.size[:2])

    @property
    def touching_size(self) -> Sequence[float]:
        """Sizes of the box that touches as this one does: as wide as its faces [m]."""
        return [*self.face, self.size[2]]


@dataclasses.dataclass(frozen=True)
class PeerScene:
    """One lane: blocks on a base.

    Attributes:
        blocks: Lowest first; each touches the one before, the first one the base.
        base: Where the base is at any time; None where it stands still.
        frame: Time between two frames [s].
        frame_count: Frames after that of the start.
        hold: What holds the block, of this one lane; None of blocks that stand free.
        assembly: The blocks of an assembly, which has no `blocks`; None of all others.
    """

    blocks: tuple[PeerBlock, ...]
    base: BasePath | None
    frame: float
    frame_count: int
    hold: Hold | None = None
    assembly: Assembly | None = None

    @property
    def block_count(self) -> int:
        """Blocks that can move."""
        return len(self.blocks) if self.assembly is None else int((~self.assembly.fixed).sum())

    @property
    def times(self) -> Array:
        """Times of the frames, the start among them [s], shape [frame]."""
        return np.arange(self.frame_count + 1, dtype=np.float64) * self.frame

    def steps_per_frame(self, steps_per_second: float) -> int:
        """Steps in a frame, so that there are at least so many in a second."""
        return max(1, math.ceil(steps_per_second * self.frame * (1.0 - 1e-9)))

    def base_steps(self, steps_per_frame: int) -> tuple[Array, Array]:
        """What a table has to do to be where the base is at the end of every step.

        Args:
            steps_per_frame: Steps in a frame.

        Returns:
            Its place at the start of each step [m] and its velocity over the step [m/s], shape
            [step, 3]. A step of the base's velocity is in the mean of the step it lies in.
        """
        count = self.frame_count * steps_per_frame
        if self.base is None:
            return np.zeros((count, 3)), np.zeros((count, 3))
        step = self.frame / steps_per_frame
        place = self.base.displacement(np.arange(count + 1, dtype=np.float64) * step)
        return place[:-1], np.diff(place, axis=0) / step


@dataclasses.dataclass(frozen=True)
class PeerRun:
    """What a program answered for one scene.

    Attributes:
        position: Centres of mass at the frames [m], shape [frame, block, 3].
        attitude: Quaternions (x, y, z, w), shape [frame, block, 4].
        cpu_s: CPU time of the stepping alone [s].
        step_count: Steps taken.
    """

    position: Array
    attitude: Array
    cpu_s: float
    step_count: int


def peer_scenes(lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> list[PeerScene]:
    """The scenes of lanes.

    Frames are the samples of the histories, or lie between them where those are far apart; without
    histories they are `FRAME_LONGEST` apart at most, the last one at the end of the run.
    """
    if times.interval is None:
        frames = math.ceil(times.duration / FRAME_LONGEST)
        frame = times.duration / frames
    else:
        parts = frames_per_sample(times)
        frame, frames = times.interval / parts, parts * (len(times.times) - 1)
    if lanes.assembly is not None:
        own = lanes.assembly
        return [
            PeerScene((), base_path(motions, k), frame, frames, assembly=own.of(k))
            for k in range(lanes.lane_count)
        ]
    position, attitude = _starts(lanes)
    return [
        PeerScene(
            tuple(_blocks(lanes, lane, position[lane], attitude[lane])),
            base_path(motions, lane),
            frame,
            frames,
            None if lanes.hold is None else lanes.hold.take(slice(lane, lane + 1)),
        )
        for lane in range(lanes.lane_count)
    ]


def frames_per_sample(times: SampleTimes) -> int:
    """Frames from one sample of the histories to the next."""
    return 1 if times.interval is None else math.ceil(times.interval / FRAME_LONGEST - 1e-9)


def missing(package: str, command: str, error: Exception) -> ImportError:
    """What to raise where a program cannot be imported: one line with the command that mends it."""
    reason = " ".join(str(error).split())
    return ImportError(f"{package}: {reason}; {command} installs it")


def multiplied_frictions(scene: PeerScene) -> list[float]:
    """Coefficients of the base and of the blocks, lowest first, whose products are the frictions.

    For programs that multiply the coefficients of two bodies that touch, as Bullet does.
    """
    found = [1.0]
    for block in scene.blocks:
        found.append(block.friction / found[-1] if found[-1] > 0.0 else 0.0)
    return found


def _blocks(lanes: Lanes, lane: int, position: Array, attitude: Array) -> list[PeerBlock]:
    """The blocks of one lane, from places and attitudes of shape [block, ...]."""

    def of(name: str) -> Array:
        values = getattr(lanes, name, None)
        found = np.zeros(lanes.block_count) if values is None else values[lane]
        return np.atleast_1d(np.asarray(found, dtype=np.float64))

    size = np.stack([of("width"), of("depth"), of("height")], axis=-1)
    mass = of("mass") if lanes.bodies else of("density") * size.prod(axis=-1)
    squares = size**2
    inertia = mass[:, None] / 12.0 * (squares.sum(axis=-1, keepdims=True) - squares)
    velocity, spin = np.zeros((2, *position.shape))
    if lanes.release is not None:
        velocity[0], spin[0] = lanes.release.velocity[lane], lanes.release.angular_velocity[lane]
        if lanes.release.gyration is not None:
            inertia = mass[:, None] * lanes.release.gyration[lane]
    # In the plane of rocking only the edges across it are chamfered.
    depth = of("face_depth") if lanes.spatial else of("depth")
    face = np.stack([of("face_width"), depth], axis=-1)
    beside = np.stack([-of("centre_offset_x"), -of("centre_offset_y")], axis=-1)
    middle = np.pad(beside, ((0, 0), (0, 1)))
    friction = np.broadcast_to(of("friction"), mass.shape)
    stands = np.cumsum(np.stack([of("offset"), of("offset_across")], axis=-1), axis=0)
    yaw = of("yaw_start")
    rows: tuple[Any, ...] = (size, face, middle, mass, inertia, friction)
    rows += (position, attitude, stands, yaw, velocity, spin)
    found: Any = zip(*(part.tolist() for part in rows), strict=True)
    blocks = [PeerBlock(*parts) for parts in found]
    if lanes.profiles is not None:
        return _profile_blocks(blocks, lanes.profiles.take(slice(lane, lane + 1)))
    if lanes.body is not None:
        return [dataclasses.replace(each, body=_body(lanes, lane)) for each in blocks]
    return blocks


def _profile_blocks(blocks: list[PeerBlock], profiles: Profiles) -> list[PeerBlock]:
    """The blocks of a stack in the plane as they are, those that are bodies as such."""
    found = []
    for k, block in enumerate(blocks):
        if not profiles.is_body[k]:
            found.append(block)
            continue
        (left, right, high), depth = profiles.top[0, k].tolist(), block.size[1]
        base = profiles.points[0, k, : profiles.count[0, k]]
        points, top = (
            np.concatenate([np.insert(part, 1, y, axis=1) for y in (-0.5 * depth, 0.5 * depth)])
            for part in (base, np.array([[left, high], [right, high]]))
        )
        # Those of a sheet; nothing turns about the other axes.
        about_y = block.mass * float(profiles.gyration[0, k])
        other = 0.5 * about_y + block.mass * depth**2 / 12.0
        body = PeerBody(
            points=points.tolist(),
            tensor=[other, about_y, other, 0.0, 0.0, 0.0],
            top=top.tolist(),
            middle=float(profiles.base_ends[0, k].mean()) if k else 0.0,
        )
        middle = [0.5 * (left + right), 0.0, high - 0.5 * block.size[2]]
        found.append(
            dataclasses.replace(block, middle=middle, face=[right - left, depth], body=body)
        )
    return found


def _body(lanes: Lanes, lane: int) -> PeerBody:
    """The body of one lane, in space, raised by its height to make a solid of it."""
    assert lanes.body is not None
    body = lanes.body.take(slice(lane, lane + 1))
    points = body.points_in_block_axes[0, : body.count[0]]
    axes = rotate(body.axes, np.eye(3))
    xx, yy, zz = (body.mass[0] * body.gyration[0]) @ (axes**2)
    tensor = (axes.T * (body.mass[0] * body.gyration[0])) @ axes
    six = [xx, yy, zz, tensor[0, 1], tensor[0, 2], tensor[1, 2]]
    closed = bool(body.inner_radius[0] > 0.0)
    raised = points + np.array([0.0, 0.0, lanes.height[lane]])
    return PeerBody(points.tolist(), six, [] if closed else raised.tolist())


def _starts(lanes: Lanes) -> tuple[Array, Array]:
    """Centres of mass and attitudes at the start, shape [lane, block, 3] and [lane, block, 4]."""
    if isinstance(lanes, SpatialLanes):
        position, attitude = start_poses(lanes)
        if lanes.stacked:
            return position, attitude
        return position[:, None], attitude[:, None]
    if lanes.profiles is not None:
        return _upright(lanes)
    shape = (lanes.lane_count, lanes.block_count)
    width, height, offset, turn = (
        part.reshape(shape)
        for part in (lanes.face_width, lanes.height, lanes.offset, lanes.rotation_start)
    )
    position, attitude = np.zeros((*shape, 3)), np.zeros((*shape, 4))
    attitude[..., 1], attitude[..., 3] = np.sin(0.5 * turn), np.cos(0.5 * turn)
    # Middle, turn and half width of the face below: of the endless base first.
    face, tilt, half = np.zeros((shape[0], 2)), np.zeros(shape[0]), np.full(shape[0], np.inf)
    for block in range(shape[1]):
        # A block stands on the end of the common face to which it leans against what is below.
        side = np.where(turn[:, block] >= tilt, 1.0, -1.0)
        end = side * np.minimum(half, 0.5 * width[:, block] + side * offset[:, block])
        foot = face + _turn(end, np.zeros_like(end), tilt)
        to_centre = _turn(offset[:, block] - end, 0.5 * height[:, block], turn[:, block])
        centre = foot + to_centre
        position[:, block, ::2] = centre
        top = _turn(np.zeros_like(end), 0.5 * height[:, block], turn[:, block])
        face, tilt, half = centre + top, turn[:, block], 0.5 * width[:, block]
    return position, attitude


def _upright(lanes: Lanes) -> tuple[Array, Array]:
    """Centres and attitudes of stacks with bodies at the start, where all stand upright."""
    x = np.cumsum(steps_along(lanes), axis=1)
    z = np.cumsum(lanes.height, axis=1) - lanes.height + centre_height(lanes)
    attitude = np.zeros((*x.shape, 4))
    attitude[..., 3] = 1.0
    return np.stack([x - x[:, :1], np.zeros_like(x), z], axis=-1), attitude


def _turn(x: Array, z: Array, rotation: Array) -> Array:
    """Vectors (x, z) turned from +z towards +x, shape [lane, 2]."""
    sine, cosine = np.sin(rotation), np.cos(rotation)
    return np.stack([x * cosine + z * sine, z * cosine - x * sine], axis=-1)
