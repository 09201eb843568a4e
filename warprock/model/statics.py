"""Statics of single boxes that turn about an edge of their base: moment, multiplier, work.

A box that leans by theta to a side resists the base's acceleration a with the moment M(theta) of
its weight, its ties and its load on top about the edge,

    I theta'' = -M(theta) - m R cos(alpha - theta) a,

so that it takes a / g = M / (m g R cos(alpha - theta)), the multiplier of horizontal forces in
proportion to the masses, to turn it further. It is the equation of a point of any mass at the
centre of percussion, L = I / (m R) from the edge: with the way of this point along the base,

    D = L [sin(alpha) - sin(alpha - theta)],

D'' = -(multiplier g) - a but for terms in theta'^2: the equivalent system of one degree, whose
capacity is the multiplier over D. A box without anything that holds it has tan(alpha - theta).
Loads on top have weight and no mass; a frame turns by the moments and moves by the masses of all
its columns and its beam, whose ways are 2 R of a column's R.

A box that is led outwards stretches or lets go each tie all along, so that what a tie does is known
from its elongation e alone: nothing up to e0, then k (e - e0) up to its yield force, nothing beyond
its ultimate elongation.
"""

from __future__ import annotations

import dataclasses
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.model.hold import Hold, Ties, TopLoad
from warprock.model.lanes import Lanes
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

MOST_LEAN = 0.5 * np.pi
"""Up to where a box is led [rad]."""
LOOKS = 32
"""Parts of a smooth piece at whose ends its moment is looked at."""
HALVINGS = 60
"""Steps that close a bracket to round-off."""
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
"""Gauss-Legendre rule on (-1, 1): pieces are smooth, and shorter than a quarter turn."""


@dataclasses.dataclass(frozen=True)
class Leaning:
    """Single boxes that lean to one side, shape [lane] each.

    Attributes:
        side: To -x or +x, -1 or 1.
        half_width: From the middle of the base to the edge about which they turn [m].
        half_height: [m].
        weight: m g, of a frame of all that moves with a column's R [N].
        inertia: About the edge, of a frame of all its parts [kg m^2].
        ties: Their ties, shape [lane, tie] each.
        load: On their tops.
        tie_place: Half the width, at which ties are [m].
    """

    side: Array
    half_width: Array
    half_height: Array
    weight: Array
    inertia: Array
    ties: Ties | None
    load: TopLoad | None
    tie_place: Array

    @property
    def radius(self) -> Array:
        """R, from the edge to the centre of mass [m]."""
        return np.hypot(self.half_width, self.half_height)

    @property
    def angle(self) -> Array:
        """Slenderness angle [rad]."""
        return np.arctan2(self.half_width, self.half_height)

    @property
    def length(self) -> Array:
        """L, from the edge to the centre of percussion [m]."""
        return np.asarray(self.inertia * GRAVITY / (self.weight * self.radius))

    def displacement(self, lean: Array) -> Array:
        """D, the way of the centre of percussion along the base [m], shape [lane, ...]."""
        angle, length = _like(self.angle, lean), _like(self.length, lean)
        return np.asarray(length * (np.sin(angle) - np.sin(angle - lean)))

    def multiplier(self, lean: Array, moment: Array) -> Array:
        """Multiplier of horizontal forces that holds a moment in balance [-], shape [lane, ...]."""
        arm = _like(self.radius, lean) * np.cos(_like(self.angle, lean) - lean)
        return np.asarray(moment / (_like(self.weight, lean) * arm))

    def velocity_step(self, work: Array) -> Array:
        """Step of the base's velocity that brings a work into a box at rest [m/s], shape [lane].

        It leaves with theta' = m R cos(alpha) / I times the step.
        """
        pushed = self.weight / GRAVITY * self.half_height
        return np.asarray(np.sqrt(2.0 * np.maximum(work, 0.0) * self.inertia) / pushed)

    def moment(self, lean: Array, inside: Array) -> Array:
        """M, which resists the lean [N m], shape [lane, ...].

        Args:
            lean: [rad], shape [lane, ...].
            inside: A lean of the same smooth piece [rad], by which ties are told apart.
        """
        angle = _like(self.angle, lean)
        moment = _like(self.weight * self.radius, lean) * np.sin(angle - lean)
        if self.load is not None:
            moment = moment - self._load_moment(self.load, lean)
        if self.ties is not None:
            for number in range(self.ties.count):
                moment = moment - self._tie_moment(self.ties, number, lean, inside)
        return np.asarray(moment)

    def _load_moment(self, load: TopLoad, lean: Array) -> Array:
        """Moment of a load towards the side [N m]."""
        s, c = np.sin(lean), np.cos(lean)
        height = _like(2.0 * self.half_height, lean)
        # From the edge, away from the block.
        beside = _like(self.side * load.eccentricity - self.half_width, lean)
        weight, stays = _like(load.weight, lean), _like(load.stays, lean)
        thrust = _like(self.side * load.thrust, lean)
        pressed = weight * np.where(stays, beside, beside * c + height * s)
        return np.asarray(pressed + thrust * (height * c - beside * s))

    def _tie_moment(self, ties: Ties, number: int, lean: Array, inside: Array) -> Array:
        """Moment of a tie towards the side [N m]."""
        height, towards, beside = self._tie_arms(ties, number)
        stretch, middle = (
            -_like(towards, lean)
            * (_like(height, lean) * np.sin(x) - _like(beside, lean) * (1.0 - np.cos(x)))
            for x in (lean, inside)
        )
        k, limit = _like(ties.stiffness[:, number], lean), _like(ties.yield_force[:, number], lean)
        free = _like(ties.free_length[:, number], lean)
        last = _like((ties.slack + ties.ultimate_elongation)[:, number], lean)
        elastic, there = k * (stretch - free), k * (middle - free)
        force = np.where(there > limit, limit, np.where(there < -limit, -limit, elastic))
        loose = (there < 0.0) & ~_like(ties.pushes[:, number], lean)
        force = np.where(loose | (middle > last), 0.0, force)
        arm = _like(height, lean) * np.cos(lean) - _like(beside, lean) * np.sin(lean)
        return np.asarray(_like(towards, lean) * force * arm)

    def _tie_arms(self, ties: Ties, number: int) -> tuple[Array, Array, Array]:
        """Arms of a tie.

        Returns:
            Its height [m]; 1 if it pulls towards the lean, else -1; how far its side is outside the
            edge [m].
        """
        towards = ties.side[:, number] * self.side
        return ties.height[:, number], towards, towards * self.tie_place - self.half_width

    def corners(self) -> Array:
        """Leans at which ties change, and the last one, sorted [rad], shape [lane, corner]."""
        found = [np.full_like(self.side, MOST_LEAN)]
        if self.ties is not None:
            for number in range(self.ties.count):
                reach = self.ties.yield_force[:, number] / self.ties.stiffness[:, number]
                free = self.ties.free_length[:, number]
                last = (self.ties.slack + self.ties.ultimate_elongation)[:, number]
                height, towards, beside = self._tie_arms(self.ties, number)
                for stretch in (free, free + reach, free - reach, last):
                    found.append(_lean_at(-towards * stretch, height, beside))
        return np.sort(np.stack(found, axis=1), axis=1)


def _like(values: npt.NDArray[Any], lean: Array) -> npt.NDArray[Any]:
    """Values of lanes beside arrays whose first axis are the lanes."""
    return values.reshape(values.shape + (1,) * (lean.ndim - 1))


def _lean_at(moved: Array, height: Array, beside: Array) -> Array:
    """The lean at which a point has moved along the base [rad]; `MOST_LEAN` where there is none.

    With t = tan(lean / 2): (2 beside + moved) t^2 - 2 height t + moved = 0.
    """
    square = height**2 - moved * (2.0 * beside + moved)
    with np.errstate(invalid="ignore", over="ignore"):
        lean = 2.0 * np.arctan(moved / (height + np.sqrt(np.maximum(square, 0.0))))
        inside = np.isfinite(moved) & (square >= 0.0) & (lean > 0.0)
    return np.where(inside, np.minimum(lean, MOST_LEAN), MOST_LEAN)


def leaning(lanes: Lanes, side: float) -> Leaning:
    """Single boxes that lean to one side.

    Args:
        lanes: Single boxes in the plane.
        side: -1 or 1.
    """
    hold = lanes.hold or Hold()
    half_width, half_height = 0.5 * lanes.face_width, 0.5 * lanes.height
    square = half_width**2 + half_height**2
    inertia = lanes.mass * ((lanes.width**2 + lanes.height**2) / 12.0 + square)
    weight = lanes.mass * GRAVITY
    if hold.frame is not None:
        inertia = inertia * hold.frame.inertia_factor
        weight = weight * hold.frame.columns * (1.0 + 2.0 * hold.frame.mass_ratio)
    return Leaning(
        side=np.full(lanes.lane_count, side),
        half_width=half_width,
        half_height=half_height,
        weight=weight,
        inertia=inertia,
        ties=hold.ties,
        load=hold.load,
        tie_place=0.5 * lanes.width,
    )


class Capacity(NamedTuple):
    """What boxes bear that are led to one side, shape [lane] each.

    Attributes:
        multiplier: Multiplier of horizontal forces from which on they turn [-].
        multiplier_peak: The largest one on the way [-].
        lean_at_peak: Where that is [rad].
        lean_capacity: Where the moment comes to zero: a box that is led so far falls [rad]; NaN of
            one that resists up to a right angle, as are those that follow.
        displacement_capacity: D there [m].
        work: That it takes to lead a box there [J].
        velocity_step: Step of the velocity of a base at rest that brings it there [m/s].
    """

    multiplier: Array
    multiplier_peak: Array
    lean_at_peak: Array
    lean_capacity: Array
    displacement_capacity: Array
    work: Array
    velocity_step: Array


def capacity(boxes: Leaning) -> Capacity:
    """What boxes bear that are led to one side."""
    ends = boxes.corners()
    starts = np.concatenate([np.zeros((len(ends), 1)), ends[:, :-1]], axis=1)
    part = np.linspace(0.0, 1.0, LOOKS + 1)
    lean = starts[..., None] + (ends - starts)[..., None] * part
    inside = (0.5 * (starts + ends))[..., None]
    moment = boxes.moment(lean, np.broadcast_to(inside, lean.shape))
    last, falls = _first_zero(boxes, lean, inside, moment)
    before = lean <= last[:, None, None]
    multiplier = boxes.multiplier(lean, moment)
    peak, lean_at_peak = _largest(boxes, lean, inside, np.where(before, multiplier, -np.inf), last)
    stops = np.minimum(ends, last[:, None])
    half = 0.5 * np.maximum(stops - starts, 0.0)
    nodes = starts[..., None] + half[..., None] * (1.0 + _NODES)
    work = half * np.sum(
        _WEIGHTS * boxes.moment(nodes, np.broadcast_to(inside, nodes.shape)), axis=-1
    )
    whole = np.where(falls, work.sum(axis=1), np.nan)
    last = np.where(falls, last, np.nan)
    return Capacity(
        multiplier=multiplier[:, 0, 0],
        multiplier_peak=peak,
        lean_at_peak=lean_at_peak,
        lean_capacity=last,
        displacement_capacity=boxes.displacement(last),
        work=whole,
        velocity_step=boxes.velocity_step(whole),
    )


def _first_zero(
    boxes: Leaning, lean: Array, inside: Array, moment: Array
) -> tuple[Array, npt.NDArray[np.bool_]]:
    """The first lean from which on the moment is not positive [rad], and whether there is one."""
    lanes = np.arange(len(lean))
    empty = lean[..., -1:] <= lean[..., :1]
    flat = ((moment <= 0.0) & ~empty).reshape(len(lean), -1)
    first = np.argmax(flat, axis=1)
    falls = flat[lanes, first]
    piece, look = np.divmod(first, LOOKS + 1)
    high = lean[lanes, piece, look]
    low = np.where(look > 0, lean[lanes, piece, np.maximum(look - 1, 0)], high)
    middle_of_piece = inside[lanes, piece, 0]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        up = boxes.moment(middle, middle_of_piece) > 0.0
        low, high = np.where(up, middle, low), np.where(up, high, middle)
    return np.where(falls, high, MOST_LEAN), falls


def _largest(
    boxes: Leaning, lean: Array, inside: Array, multiplier: Array, last: Array
) -> tuple[Array, Array]:
    """The largest multiplier up to a lean, and where it is [rad], shape [lane] each."""
    lanes = np.arange(len(lean))
    piece, look = np.divmod(np.argmax(multiplier.reshape(len(lean), -1), axis=1), LOOKS + 1)
    at, found = lean[lanes, piece, look], multiplier[lanes, piece, look]
    low = lean[lanes, piece, np.maximum(look - 1, 0)]
    high = np.minimum(lean[lanes, piece, np.minimum(look + 1, LOOKS)], np.maximum(last, low))
    middle = inside[lanes, piece, 0]

    def value(x: Array) -> Array:
        return boxes.multiplier(x, boxes.moment(x, middle))

    for _ in range(HALVINGS):
        one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        right = value(one) < value(other)
        low, high = np.where(right, one, low), np.where(right, high, other)
    best = value(low)
    return np.where(best > found, best, found), np.where(best > found, low, at)


class Curve(NamedTuple):
    """A box that is led to one side, shape [point] each.

    Attributes:
        lean: [rad].
        moment: [N m].
        multiplier: [-].
        displacement: D [m].
    """

    lean: Array
    moment: Array
    multiplier: Array
    displacement: Array


POINTS = 100
"""Points of a curve, evenly apart, besides its corners."""


def curve(box: Leaning, most: float) -> Curve:
    """Moment, multiplier and displacement of one box up to a lean, and twice at its corners.

    Args:
        box: The box alone, of one lane.
        most: The last lean [rad].
    """
    ends = np.unique(np.minimum(box.corners()[0], most))
    starts = np.concatenate([[0.0], ends[:-1]])
    pieces, insides = [], []
    for start, end in zip(starts, ends, strict=True):
        count = 2 + int(POINTS * (end - start) / most)
        pieces.append(np.linspace(start, end, count))
        insides.append(np.full(count, 0.5 * (start + end)))
    lean = np.concatenate(pieces)[None]
    moment = box.moment(lean, np.concatenate(insides)[None])
    return Curve(lean[0], moment[0], box.multiplier(lean, moment)[0], box.displacement(lean)[0])
