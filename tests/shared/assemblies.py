"""Assemblies and pushes that several test files share."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tests.shared.vertical_motion import sampled
from warprock.model import patterns
from warprock.model.assembly import Assemblies, Assembly, Piece, assemble
from warprock.model.harmonic import HarmonicMotions
from warprock.model.lanes import Lanes
from warprock.model.record_motion import RecordMotions
from warprock.units import GRAVITY

NO_SLIDING = 100.0
"""A friction coefficient at which nothing slides."""


def built(pieces: list[Piece], friction: float) -> Assembly:
    return assemble(pieces, depth=1.0, density=2000.0, friction=friction)


def oppenheim(voussoirs: int = 7) -> Assembly:
    """The arch of Oppenheim (1992), with a mean radius of 10 m."""
    return built(patterns.arch(10.0, 1.5, np.radians(157.5), voussoirs), NO_SLIDING)


def wall_1(friction: float = 0.65) -> Assembly:
    """Wall 1 of Ferris and Tin-Loi (2001): running bond, 5 blocks wide, 6 courses."""
    return built(patterns.wall(0.4, 0.175, 5, 6, whole_first=False), friction)


def tilted_wall() -> list[Piece]:
    """A wall of 182 bricks with two openings and a lintel, 2 m x 1.5 m.

    Hua, Buzzetti, Pingaro, da Silva and Milani (2025) have it fall at 16.73 degrees, by associative
    limit analysis on a tilting table at a friction of 26 degrees (program LACT3, sample `wall`).
    """
    course = 1.5 / 27
    openings = [
        patterns.Opening(0.25, course, 0.25, 24 * course),
        patterns.Opening(0.875, 2 * course, 0.5, 22 * course),
    ]
    bricks = patterns.wall(0.25, course, 8, 27, whole_first=True, openings=openings)
    lintel = Piece("lintel", patterns.rectangle(0.75, 24 * course, 1.5, 25 * course))
    (left, bottom), (right, top) = lintel.corners.min(axis=0), lintel.corners.max(axis=0)
    middles = np.array([brick.corners.mean(axis=0) for brick in bricks])
    inside = (middles > (left, bottom)) & (middles < (right, top))
    return [*(bricks[k] for k in np.flatnonzero(~inside.all(axis=1))), lintel]


def assembly_lanes(kinds: Sequence[Assembly], lane: Sequence[int] | None = None) -> Lanes:
    """Lanes of assemblies; one of each where no places among them are given."""
    places = np.arange(len(kinds)) if lane is None else np.asarray(lane)
    own = [kinds[place] for place in places]
    size = np.array([kind.size for kind in own])
    mass = np.array([kind.mass[~kind.fixed].sum() for kind in own])
    depth = np.array([kind.depth for kind in own])
    nothing = np.zeros(len(own))
    return Lanes(
        width=size[:, 0],
        height=size[:, 1],
        depth=depth,
        density=mass / (size.prod(axis=1) * depth),
        friction=np.array([kind.joints.friction.max(initial=0.0) for kind in own]),
        chamfer=nothing,
        offset=nothing,
        rotation_start=nothing,
        angular_restitution=nothing,
        assembly=Assemblies(tuple(kinds), places),
    )


def pushes(load: npt.ArrayLike, rise: float, end: float) -> RecordMotions:
    """Bases whose acceleration to -x rises linearly to a load / g and stays, shape [lane].

    The blocks feel it to +x.
    """
    scale = -GRAVITY * np.asarray(load, dtype=np.float64)
    interval = rise
    count = int(np.ceil(end / interval)) + 2
    acceleration = np.minimum(np.arange(count, dtype=np.float64), 1.0)
    slope = np.append(np.diff(acceleration) / interval, 0.0)
    steps = 0.5 * interval * (acceleration[1:] + acceleration[:-1])
    velocity = np.concatenate([[0.0], np.cumsum(steps)])
    lanes = len(scale)
    return RecordMotions(
        start=np.zeros(lanes),
        scale=scale,
        offset=np.zeros(lanes, dtype=np.int32),
        count=np.full(lanes, count, dtype=np.int32),
        interval=np.full(lanes, interval),
        velocity_step_start=np.zeros(lanes),
        velocity_step_stop=np.zeros(lanes),
        pool_acceleration=acceleration,
        pool_slope=slope,
        pool_velocity=velocity,
    )


def as_records(motions: HarmonicMotions, interval: float = 4e-5) -> RecordMotions:
    """The same motions in samples, so that the kernel of pushes runs them, too.

    Another kind of motion takes 5 s to compile. At 4 Hz and less samples of 0.04 ms leave 2e-7 of
    the acceleration.
    """
    count = round(float(np.max(motions.end - motions.start)) / interval) + 1
    times = motions.start[:, None] + interval * np.arange(count)
    values = [motions.acceleration(each, lane) for lane, each in enumerate(times)]
    return dataclasses.replace(sampled(np.array(values), interval), start=motions.start)
