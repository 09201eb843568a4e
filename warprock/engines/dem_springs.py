"""Springs of the soft-spring engine, in NumPy: how they lie, rest, swing and bounce.

Blocks are [lane, block], lowest first, full dimensions; interface k is the one below block k.
"""

from __future__ import annotations

import dataclasses
from typing import Self

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes
from warprock.model.stacking import sum_above
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

EQUILIBRIUM_SWEEPS = 60
"""Iterations that find which points carry; a handful suffices unless the weight is near an end."""


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
    return np.asarray(np.minimum(lanes.depth, below))


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
            place, area = springs.place[:, block, point], springs.area[:, block, point]
            below = place + lanes.offset[:, block], half[:, block - 1]
            add_point(stiffness, block, (place, -half[:, block]), below, settings, area)
    inertia = lanes.mass * (lanes.width**2 + lanes.height**2) / 12.0
    return round_frequency(largest_frequency(stiffness, lanes.mass, inertia))


def add_point(
    stiffness: Array,
    block: int,
    own: tuple[Array, Array],
    below: tuple[Array, Array],
    settings: DemSettings,
    area: Array,
) -> None:
    """Adds the springs of a point of the interface below a block to stiffness matrices.

    Args:
        stiffness: Over x, z and rotation of all blocks, shape [lane, 3 block, 3 block].
        block: Number of the block above the interface, from 0.
        own: The point from the centre of that block, x and z [m], shape [lane] each.
        below: The same from the centre of the block below; of the lowest block it is not read.
        settings: Stiffness of the springs for each area.
        area: Area that the point stands for [m^2], shape [lane].
    """
    normal, shear = np.zeros((2, *stiffness.shape[:2]))
    at = 3 * block
    normal[:, at + 1], normal[:, at + 2] = 1.0, -own[0]
    shear[:, at], shear[:, at + 2] = 1.0, own[1]
    if block > 0:
        normal[:, at - 2], normal[:, at - 1] = -1.0, below[0]
        shear[:, at - 3], shear[:, at - 1] = -1.0, -below[1]
    for row, k in ((normal, settings.normal_stiffness), (shear, settings.shear_stiffness)):
        stiffness += (k * area)[:, None, None] * row[:, :, None] * row[:, None, :]


def largest_frequency(stiffness: Array, mass: Array, inertia: Array) -> Array:
    """Root of the largest w^2 of K - w^2 M [rad/s], shape [lane]; NaN where K is not finite.

    Args:
        stiffness: K over x, z and rotation of all blocks, shape [lane, 3 block, 3 block].
        mass: Of the blocks [kg], shape [lane, block].
        inertia: Moments of inertia about their centres [kg m^2], shape [lane, block].
    """
    masses = np.stack([mass, mass, inertia], axis=2).reshape(stiffness.shape[:2])
    scaled = stiffness / np.sqrt(masses[:, :, None] * masses[:, None, :])
    sound = np.asarray(np.isfinite(scaled).all(axis=(1, 2)))
    largest = np.linalg.eigvalsh(np.where(sound[:, None, None], scaled, 0.0))[:, -1]
    return np.where(sound, np.sqrt(np.maximum(largest, 0.0)), np.nan)


def round_frequency(frequency: Array) -> Array:
    """Frequencies to 30 bits: the last digits of a solver are not those of the mirrored stack."""
    part, power = np.frexp(frequency)
    return np.asarray(np.ldexp(np.round(part * 2.0**30) / 2.0**30, power))


def standing_ratio(lanes: Lanes, settings: DemSettings) -> Array:
    """Rocking stiffness of the springs / that needed to stand [-], [lane, block].

    All that stands on an interface turns on its springs like one rigid body: they resist by
    k_n I, I the second moment of their area, its weight drives by W times the height of its centre
    above them. A stack of which one ratio is not above 1 buckles on its springs (Euler 1744).
    """
    springs = Springs.of(lanes, settings.subcontacts)
    return standing_on(lanes, settings.normal_stiffness, springs.place, springs.area)


def standing_on(lanes: Lanes, stiffness: float, place: Array, area: Array) -> Array:
    """The standing ratio about one axis, from places and areas of springs; see `Springs`."""
    whole = area.sum(axis=-1)
    middle = (area * place).sum(axis=-1) / np.where(whole > 0.0, whole, 1.0)
    second = (area * (place - middle[..., None]) ** 2).sum(axis=-1)
    mass, top = lanes.mass, np.cumsum(lanes.height, axis=1)
    above = sum_above(mass)
    centres = sum_above(mass * (top - 0.5 * lanes.height)) / above
    driven = GRAVITY * above * (centres - (top - lanes.height))
    return np.asarray(stiffness * second / driven)


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


@dataclasses.dataclass(frozen=True)
class Start:
    """Where the blocks start, shape [lane, block] each.

    Attributes:
        x: Centres [m].
        settlement: Height of the centres over those of an upright stack of rigid blocks [m].
        rotation: [rad].
        stretch: Stretch of the shear springs of the interface below [m].
        own: Whether those springs lie on the face of the block above, else of the one below.
    """

    x: Array
    settlement: Array
    rotation: Array
    stretch: Array
    own: npt.NDArray[np.bool_]


def start_at_rest(lanes: Lanes, settings: DemSettings) -> Start:
    """Blocks as `Lanes` tells, pressed into one another by what they bear.

    A stack in which nothing is turned is in static equilibrium, eccentric as it may be. Of a
    stack that is released, every interface bears the weight above it: where its blocks are turned
    against each other on the end they stand on, else evenly but for the offset.
    """
    springs = Springs.of(lanes, settings.subcontacts)
    turned = np.sin(np.diff(lanes.rotation_start, axis=1, prepend=0.0))
    resting = np.all(lanes.rotation_start == 0.0, axis=1)
    depth, tilt, stretch = np.zeros_like(turned), turned.copy(), np.zeros_like(turned)
    start = _pile(lanes, depth, tilt, stretch)
    for _ in range(EQUILIBRIUM_SWEEPS):
        before = np.stack([depth, tilt])
        for block in range(lanes.block_count):
            place = springs.place[:, block]
            place = place + np.where(start.own[:, block], 0.0, lanes.offset[:, block])[:, None]
            area = springs.area[:, block]
            closed = depth[:, block, None] + tilt[:, block, None] * place > 0.0
            normal, shear, moment = _bearing(lanes, start, block, resting, place, area * closed)
            depth[:, block], tilt[:, block] = _equilibrium(
                place, settings.normal_stiffness * area, normal, moment, turned[:, block]
            )
            bears = settings.shear_stiffness * _total(area * closed)
            stretch[:, block] = -shear / np.where(bears > 0.0, bears, 1.0)
        start = _pile(lanes, depth, tilt, stretch)
        if np.allclose(before, [depth, tilt], rtol=1e-14, atol=1e-18, equal_nan=True):
            break
    return start


def _pile(lanes: Lanes, depth: Array, tilt: Array, stretch: Array) -> Start:
    """Blocks one above the other, from what each is pressed into and turned against the next.

    Args:
        lanes: Stacks.
        depth: Overlap of an interface at the middle of the face that bears its springs [m].
        tilt: Sine of the rotation of the upper block against the lower one [-].
        stretch: Handed on.
    """
    x, z, rotation = np.zeros((3, *depth.shape))
    own = np.ones(depth.shape, dtype=bool)
    below_x, below_z, below_turn, below_high, level = np.zeros((5, lanes.lane_count))
    below_face = np.full(lanes.lane_count, np.inf)
    for block in range(lanes.block_count):
        face, high = 0.5 * lanes.face_width[:, block], 0.5 * lanes.height[:, block]
        offset, sine = lanes.offset[:, block], tilt[:, block]
        cosine = np.sqrt(1.0 - sine**2)
        side = np.where(np.where(sine == 0.0, offset, sine) < 0.0, -1.0, 1.0)
        mine = side * offset + face <= below_face
        sign = np.where(mine, -1.0, 1.0)
        plane = np.where(mine, below_turn, below_turn + np.arcsin(sine))
        reach, tall = np.where(mine, face, below_face), np.where(mine, high, below_high)
        # The end that it leans to has not slid from where it is on the upright stack.
        along = offset - sign * (side * reach * (1.0 - cosine) + tall * sine)
        apart = np.where(mine, below_high, high) + tall * cosine - depth[:, block]
        below_x = below_x + along * np.cos(plane) + apart * np.sin(plane)
        below_z = below_z + apart * np.cos(plane) - along * np.sin(plane)
        below_turn = below_turn + np.arcsin(sine)
        level = level + below_high + high
        x[:, block], z[:, block], rotation[:, block] = below_x, below_z - level, below_turn
        own[:, block], below_face, below_high = mine, face, high
    return Start(x, z, rotation, stretch.copy(), own)


def _bearing(
    lanes: Lanes,
    start: Start,
    block: int,
    resting: npt.NDArray[np.bool_],
    place: Array,
    closed_area: Array,
) -> tuple[Array, Array, Array]:
    """Finds the load on the springs below a block, as the blocks lie.

    Args:
        lanes: Stacks.
        start: Where the blocks are.
        block: Number of the block above the interface.
        resting: Lanes in static equilibrium; the others bear the weight across the interface.
        place: Of the points, along the face that bears the springs [m], shape [lane, point].
        closed_area: Area of the points that are closed, 0 of the others [m^2].

    Returns:
        Force along the normal and along the direction of the plane [N], moment of the normal
        forces about the middle of the face that bears the springs [N m], shape [lane] each.
    """
    mass = lanes.mass[:, block:]
    total = mass.sum(axis=1)
    weight = GRAVITY * total
    heights = np.cumsum(lanes.height, axis=1) - 0.5 * lanes.height
    z = start.settlement + heights
    own, turn, high = start.own[:, block], start.rotation[:, block], 0.5 * lanes.height[:, block]
    foot_x, foot_z = start.x[:, block] - high * np.sin(turn), z[:, block] - high * np.cos(turn)
    plane = np.zeros_like(turn)
    if block > 0:
        below, under = start.rotation[:, block - 1], 0.5 * lanes.height[:, block - 1]
        foot_x = np.where(own, foot_x, start.x[:, block - 1] + under * np.sin(below))
        foot_z = np.where(own, foot_z, z[:, block - 1] + under * np.cos(below))
        plane = np.where(own, below, turn)
    dx = (mass * start.x[:, block:]).sum(axis=1) / total - foot_x
    dz = (mass * z[:, block:]).sum(axis=1) / total - foot_z
    s, c = np.where(resting, np.sin(plane), 0.0), np.where(resting, np.cos(plane), 1.0)
    normal, shear = weight * c, -weight * s
    # All forces at the points have no moment about the centre of mass of what stands above.
    first, bears = _total(closed_area * place), _total(closed_area)
    first = shear * first / np.where(bears > 0.0, bears, 1.0)
    tilted = np.where(resting, turn - (start.rotation[:, block - 1] if block > 0 else 0.0), 0.0)
    moment = normal * (dx * c - dz * s) - shear * (dx * s + dz * c)
    moment = (moment + np.where(own, -1.0, 1.0) * np.sin(tilted) * first) / np.cos(tilted)
    aside = np.cumsum(lanes.offset[:, block:], axis=1) - lanes.offset[:, block][:, None]
    upright = weight * (mass * aside).sum(axis=1) / total
    upright = upright + weight * np.where(own, 0.0, lanes.offset[:, block])
    return normal, shear, np.where(resting, moment, upright)


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
    """Sums over the points so that a mirrored stack has exactly the mirrored sum, shape [lane]."""
    return np.asarray(0.5 * (values + values[:, ::-1]).sum(axis=1))
