"""Springs of the soft-spring engine, in NumPy: how they lie, rest, swing and bounce.

Blocks are [lane, block], lowest first, full dimensions; interface k is the one below block k.
"""

from __future__ import annotations

import dataclasses
from typing import Self

import numpy as np
import numpy.typing as npt

from warprock.engines.settings import DemSettings
from warprock.lanes import Lanes
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

EQUILIBRIUM_SWEEPS = 60
"""Trials of which points carry; a handful is enough unless the weight stands near an end."""


@dataclasses.dataclass(frozen=True)
class Springs:
    """The points of every interface of upright stacks.

    Attributes:
        place: To +x of the centre of the block above [m], shape [lane, block, point].
        area: Area that a point stands for [m^2], shape [lane, block, point].
    """

    place: Array
    area: Array

    @classmethod
    def of(cls, lanes: Lanes, subcontacts: int) -> Self:
        """Points spread evenly over each interface from end to end (trapezoidal rule).

        3DEC puts sub-contacts on vertices, so that the outermost ones sit at the very ends and
        stand for half of the area of the others; a block on one edge turns about that edge.
        """
        half = 0.5 * lanes.face_width
        below = np.concatenate([np.full((lanes.lane_count, 1), np.inf), half[:, :-1]], axis=1)
        low = np.maximum(-half, -lanes.offset - below)
        top = np.minimum(half, below - lanes.offset)
        part = 2.0 * np.arange(subcontacts) / (subcontacts - 1) - 1.0
        part = 0.5 * (part - part[::-1])
        weight = np.ones(subcontacts)
        weight[[0, -1]] = 0.5
        length = np.maximum(top - low, 0.0)
        area = length * interface_depth(lanes)
        return cls(
            place=0.5 * ((low + top)[:, :, None] + length[:, :, None] * part),
            area=area[:, :, None] * weight / (subcontacts - 1),
        )


def interface_depth(lanes: Lanes) -> Array:
    """Depth of every interface [m], shape [lane, block]: the smaller one of its two blocks."""
    below = np.concatenate([np.full((lanes.lane_count, 1), np.inf), lanes.depth[:, :-1]], axis=1)
    return np.minimum(lanes.depth, below)


def stiffest_frequency(lanes: Lanes, settings: DemSettings) -> Array:
    """Largest angular frequency of small motions of upright stacks [rad/s], shape [lane].

    The largest root of K - w^2 M over the 3 N motions x, z, rotation of N blocks, every point of
    every interface closed and sticking; NaN where a size is not finite. A block that stands on
    fewer points is softer.
    """
    springs = Springs.of(lanes, settings.subcontacts)
    count, blocks = lanes.width.shape
    stiffness = np.zeros((count, 3 * blocks, 3 * blocks))
    half = 0.5 * lanes.height
    for block in range(blocks):
        for point in range(settings.subcontacts):
            place = springs.place[:, block, point]
            normal, shear = np.zeros((2, count, 3 * blocks))
            normal[:, 3 * block + 1], normal[:, 3 * block + 2] = 1.0, -place
            shear[:, 3 * block], shear[:, 3 * block + 2] = 1.0, -half[:, block]
            if block > 0:
                below = 3 * block - 3
                normal[:, below + 1] = -1.0
                normal[:, below + 2] = place + lanes.offset[:, block]
                shear[:, below], shear[:, below + 2] = -1.0, -half[:, block - 1]
            for row, k in (
                (normal, settings.normal_stiffness),
                (shear, settings.shear_stiffness),
            ):
                area = springs.area[:, block, point]
                stiffness += (k * area)[:, None, None] * row[:, :, None] * row[:, None, :]
    inertia = lanes.mass * (lanes.width**2 + lanes.height**2) / 12.0
    masses = np.stack([lanes.mass, lanes.mass, inertia], axis=2).reshape(count, 3 * blocks)
    scaled = stiffness / np.sqrt(masses[:, :, None] * masses[:, None, :])
    sound = np.isfinite(scaled).all(axis=(1, 2))
    largest = np.linalg.eigvalsh(np.where(sound[:, None, None], scaled, 0.0))[:, -1]
    return np.where(sound, np.sqrt(np.maximum(largest, 0.0)), np.nan)


def stable_step(frequency: Array, settings: DemSettings) -> Array:
    """Largest stable step of central differences with dashpots one half step late [s].

    (2 / w) (sqrt(1 + z^2) - z) with z = beta w / 2 + alpha / (2 w) the damping ratio of the mode.

    Args:
        frequency: Angular frequency w of the stiffest mode [rad/s].
        settings: beta and alpha.

    References:
        Belytschko, Liu and Moran (2000), Nonlinear Finite Elements, section 6.2: the critical
        step of a damped mode.
    """
    ratio = 0.5 * (settings.stiffness_damping * frequency + settings.mass_damping / frequency)
    return np.asarray(2.0 / frequency * (np.sqrt(1.0 + ratio**2) - ratio))


def contact_restitution(damping_ratio: npt.ArrayLike) -> Array:
    """Ratio e of speeds after and before a blow on a spring with a dashpot that cannot pull [-].

    With z the damping ratio and s = sqrt(1 - z^2) the contact ends when its force vanishes:
    e = exp(-(z / s) (pi - atan(2 z s / (s^2 - z^2)))) for z < 1 / sqrt(2), the same without the
    pi beyond, up to the critical z = 1 where e = exp(-2).

    Args:
        damping_ratio: z = beta w / 2 with w = sqrt(k / m) of the contact, 0 <= z < 1.

    References:
        Schwager and Poeschel (2007), Granular Matter 9, 465-469.
    """
    z = np.asarray(damping_ratio, dtype=np.float64)
    s = np.sqrt(1.0 - z**2)
    # The angle lies in (0, pi): one branch for both of theirs.
    return np.asarray(np.exp(-(z / s) * (np.pi - np.arctan2(2.0 * z * s, s**2 - z**2))))


@dataclasses.dataclass(frozen=True)
class Start:
    """Where the blocks start.

    Attributes:
        x: Centres [m], shape [lane, block].
        settlement: Height of the centres over those of a stack of rigid blocks that stand on one
            another's whole faces [m], shape [lane, block].
        rotation: [rad], shape [lane, block].
    """

    x: Array
    settlement: Array
    rotation: Array


def start_at_rest(lanes: Lanes, settings: DemSettings) -> Start:
    """Blocks as `Lanes` tells, pressed into one another by what they bear.

    An interface whose blocks are not turned against each other is in static equilibrium under
    the weight above it, eccentric as it may be. Where they are turned, the end that they stand on
    bears that weight: they are held by a couple until they are let go.
    """
    springs = Springs.of(lanes, settings.subcontacts)
    half_face, half_height = 0.5 * lanes.face_width, 0.5 * lanes.height
    x, z, rotation = np.zeros((3, *lanes.width.shape))
    turned = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    below_x, below_z, below_turn, below_high = np.zeros((4, lanes.lane_count))
    below_face, level = np.full(lanes.lane_count, np.inf), np.zeros(lanes.lane_count)
    for block in range(lanes.block_count):
        face, high, offset = half_face[:, block], half_height[:, block], lanes.offset[:, block]
        weight, centre = _bearing(lanes, block)
        depth, tilt = _equilibrium(
            springs.place[:, block],
            settings.normal_stiffness * springs.area[:, block],
            weight,
            weight * centre,
            np.sin(turned[:, block]),
        )
        turn = np.where(turned[:, block] == 0.0, np.arcsin(tilt), turned[:, block])
        side = np.where(turn < 0.0, -1.0, 1.0)
        own = side * (offset + side * face) <= below_face
        sign = np.where(own, -1.0, 1.0)
        plane = np.where(own, below_turn, below_turn + turn)
        slave_face, slave_high = np.where(own, face, below_face), np.where(own, high, below_high)
        # The lower block's points lie at the offset from the upper one's.
        depth = depth + np.where(own, 0.0, -offset * np.sin(turn))
        along = offset - sign * (slave_face * side * (1.0 - np.cos(turn)) + slave_high * np.sin(turn))
        apart = np.where(own, below_high, high) + slave_high * np.cos(turn) - depth
        below_x = below_x + along * np.cos(plane) + apart * np.sin(plane)
        below_z = below_z + apart * np.cos(plane) - along * np.sin(plane)
        level = level + below_high + high
        below_turn = below_turn + turn
        x[:, block], z[:, block], rotation[:, block] = below_x, below_z - level, below_turn
        below_face, below_high = face, high
    return Start(x, z, rotation)


def _bearing(lanes: Lanes, block: int) -> tuple[Array, Array]:
    """Weight that the interface below a block bears [N], to +x of the block's centre [m]."""
    mass = lanes.mass[:, block:]
    aside = np.cumsum(lanes.offset[:, block:], axis=1) - lanes.offset[:, block : block + 1]
    total = mass.sum(axis=1)
    return GRAVITY * total, np.asarray((mass * aside).sum(axis=1) / total)


def _equilibrium(
    place: Array, stiffness: Array, weight: Array, moment: Array, turned: Array
) -> tuple[Array, Array]:
    """Depth at the middle [m] and tilt [-] of springs that bear a weight without tension.

    Args:
        place: Of the springs [m], shape [lane, point].
        stiffness: [N/m], shape [lane, point].
        weight: [N], shape [lane].
        moment: Weight times its lever [N m], shape [lane]; it counts where nothing is turned.
        turned: Prescribed tilt [-], shape [lane]; 0 asks for that of the equilibrium.
    """
    free = turned == 0.0
    tilt = turned.copy()
    # The highest point of what stands turned touches first.
    depth = np.where(free, 0.0, -(tilt[:, None] * place).max(axis=1))
    carries = np.where(free[:, None], True, tilt[:, None] * place >= -depth[:, None])
    for _ in range(EQUILIBRIUM_SWEEPS):
        k = np.where(carries, stiffness, 0.0)
        k0, k1, k2 = _total(k), _total(k * place), _total(k * place**2)
        determinant = k0 * k2 - k1**2
        solvable = free & (determinant > 1e-9 * k0 * k2)
        safe = np.where(solvable, determinant, 1.0)
        tilt = np.where(solvable, (k0 * moment - k1 * weight) / safe, tilt)
        depth = (weight - k1 * tilt) / np.where(k0 > 0.0, k0, 1.0)
        now = depth[:, None] + tilt[:, None] * place > 0.0
        if np.array_equal(now, carries):
            break
        carries = np.where(now.any(axis=1, keepdims=True), now, carries)
    return depth, tilt


def _total(values: Array) -> Array:
    """Sum over the points that is an exact mirror image in a mirrored stack, shape [lane]."""
    return np.asarray(0.5 * (values + values[:, ::-1]).sum(axis=1))
