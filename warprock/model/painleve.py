"""Friction at which the law of a rigid contact has several solutions, or none: Painleve's paradox.

A homogeneous rectangle of mass 1, half sizes b and h and inertia (b^2 + h^2) / 3 touches its base
at one corner. The line from there to the centre of mass leans by phi against the vertical: by the
slenderness angle while it stands, by less the more it is turned. Normal and tangential impulse n, f
change the velocity of the corner by (kn n + k f, k n + kt f) with

    kn = 1 + 3 sin^2 phi,   kt = 1 + 3 cos^2 phi,   |k| = 3 sin phi cos phi.

While mu |k| < kn the law has one solution, whatever the load. Above

    mu = (1 + 3 sin^2 phi) / (3 sin phi cos phi),   least 4/3 at tan phi = 1/2,

friction can press a corner that slides towards the block harder on its base than the block itself
does. At a velocity step of the base, which moves no corner up or down, "sticks" obeys the law then,
and "no impulse, slides" does, too; a corner that slides that way has no solution under its weight,
and several once the block turns so fast that the corner would rise without contact. A corner that
slides the other way has one solution; but sweeps from contact to contact (projected Gauss-Seidel)
do not come to it: their error grows by mu |k| / kn a sweep.

So a lane has one answer only below the limit, or where no corner slides. A slide of zero decides
nothing. Sticking leaves it at a velocity step, and so does a slide without impulse: it ends where
it begins, since under the weight of the block only an impulse that stops it can follow.

References:
    Painleve (1895), Comptes Rendus 121; Genot and Brogliato (1999), Eur. J. Mech. A/Solids 18.
"""

from __future__ import annotations

from typing import cast

import numpy as np
import numpy.typing as npt

from warprock.model.bodies import Bodies
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.response import Response, Status
from warprock.model.turning import inverse, rotate

Array = npt.NDArray[np.float64]

WORST_LEAN = float(np.arctan(0.5))
"""Lean of the corner's lever at which the least friction is enough [rad]."""
SLID = 1e-4
"""Slide from which a block counts as one that slid, over its width: sweeps creep by less."""
ROCKED = 1e-3
"""Rotation from which a block in space has rocked across, over the angle at which it falls."""

TILTS, DIRECTIONS = 8, 24
"""Tilts of a body, and directions of them, at which the limit is looked up."""
TINY = 1e-12
"""Keeps a quotient by zero finite."""


def friction_limit(
    width: npt.ArrayLike, height: npt.ArrayLike, turned: npt.ArrayLike = 0.0
) -> Array:
    """Friction coefficient above which a contact law has several solutions, or none, [-].

    Args:
        width: Full widths [m].
        height: Full heights [m].
        turned: Largest rotation that the block takes [rad]: the limit is the least of all up to it.
    """
    angle = np.arctan2(width, height)
    lean = np.clip(WORST_LEAN, angle - np.abs(turned), angle)
    s, c = np.sin(lean), np.cos(lean)
    return np.asarray((1.0 + 3.0 * s * s) / (3.0 * s * c))


def body_limit(body: Bodies) -> Array:
    """Least friction coefficient [-] of bodies up to which rigid contact has one solution, [lane].

    In the plane it is `least_limit`; in space the least of all tilts and directions.
    """
    if body.spatial:
        return spatial_limit(body, np.full(len(body.mass), 0.5 * np.pi))
    return least_limit(body.gyration, body.points)


def least_limit(gyration: Array, points: Array) -> Array:
    """The least limit of bodies at any lean [-], shape [lane]; in space it is at least this.

    Of a point R (s, c) from the centre of mass that touches alone the limit is (k^2 + R^2 s^2) /
    (R^2 s c), k the radius of gyration; over all leans the least is 2 sqrt(q (1 + q)), q = k^2 /
    R^2, which is 4/3 for a rectangle. The farthest point has the least. In space let w be the
    impulse's moment, J w the turn it makes and b = w J w. The point moves by 1 + b along the
    impulse and by sqrt(R^2 |J w|^2 - b^2) across it at most, and |J w|^2 is at most b over the
    least k^2. Their quotient is at least the same number, with the least k.

    Args:
        gyration: Squares of the least radii of gyration [m^2], shape [lane].
        points: Contact points from the centre of mass [m], shape [lane, point, 2 or 3].
    """
    part = gyration / np.sum(points**2, axis=-1).max(axis=1)
    return np.asarray(2.0 * np.sqrt(part * (1.0 + part)))


def spatial_limit(body: Bodies, tilt: Array) -> Array:
    """The same friction of bodies in space that tilt up to an angle [rad], shape [lane].

    With n the vertical in the principal axes, p the point that then is lowest and J the inverse
    inertia for unit mass, an impulse along n moves that point by c = n + J (p x n) x p: the limit
    is the part of c along n over the one across it.
    """
    angle = np.arange(DIRECTIONS) * (2.0 * np.pi / DIRECTIONS)
    least = np.full(len(body.mass), np.inf)
    back = inverse(body.axes)[:, None]
    for part in np.arange(1, TILTS + 1) / TILTS:
        s, c = np.sin(part * tilt)[:, None], np.cos(part * tilt)[:, None]
        parts = np.broadcast_arrays(-s * np.cos(angle), -s * np.sin(angle), c)
        up = rotate(back, np.stack(parts, axis=-1))
        lowest = np.argmin(up @ np.swapaxes(body.points, 1, 2), axis=-1)
        point = np.take_along_axis(body.points, lowest[..., None], axis=1)
        moved = up + np.cross(np.cross(point, up) / body.gyration[:, None], point)
        along = np.sum(moved * up, axis=-1)
        across = np.linalg.norm(moved - along[..., None] * up, axis=-1)
        least = np.minimum(least, (along / np.maximum(across, TINY)).min(axis=1))
    return least


def above_limit(lanes: Lanes) -> tuple[npt.NDArray[np.bool_], Array]:
    """Lanes with friction above the least limit of their block, and that limit, shape [lane] each.

    Blocks of higher stacks are not judged: what they stand on moves, too.
    """
    if lanes.block_count > 1 or lanes.assembly is not None:
        return np.zeros(lanes.lane_count, np.bool_), np.full(lanes.lane_count, np.inf)
    body = lanes.body if lanes.profiles is None else lanes.profiles.of(0)
    if body is not None:
        limit = body_limit(body)
        return lanes.friction.reshape(lanes.lane_count) > limit, limit
    limit = friction_limit(lanes.face_width, lanes.height, 0.5 * np.pi).reshape(lanes.lane_count)
    return lanes.friction.reshape(lanes.lane_count) > limit, limit


def ambiguous(lanes: Lanes, response: Response) -> npt.NDArray[np.bool_]:
    """Lanes of single blocks that slid with friction above the limit, shape [lane]."""
    count = lanes.lane_count
    if lanes.block_count > 1 or lanes.assembly is not None:
        return np.zeros(count, dtype=np.bool_)
    if lanes.bodies:
        slid = response["peak_slide"].reshape(count) > SLID * lanes.width.reshape(count)
        if not (lanes.spatial and lanes.body is not None):
            return np.asarray(above_limit(lanes)[0] & slid)
        body, friction = lanes.body, lanes.friction.reshape(count)
        doubtful = slid & (friction > least_limit(body.gyration.min(axis=1), body.points))
        (some,) = np.nonzero(doubtful)
        if some.size:
            tilt = response["peak_tilt"].reshape(count)
            doubtful[some] = friction[some] > spatial_limit(body.take(some), tilt[some])
        return np.asarray(doubtful)
    one = {name: response[name].reshape(count) for name in ("peak_rotation", "peak_slide")}
    width, height, friction = (
        values.reshape(count) for values in (lanes.face_width, lanes.height, lanes.friction)
    )
    above = friction > friction_limit(width, height, one["peak_rotation"])
    if lanes.spatial:
        depth = cast(SpatialLanes, lanes).face_depth.reshape(count)
        across = response["peak_rotation_across"].reshape(count)
        rocked = across > ROCKED * np.arctan2(depth, height)
        above |= rocked & (friction > friction_limit(depth, height, across))
    return np.asarray(above & (one["peak_slide"] > SLID * width))


def mark_ambiguous(lanes: Lanes, response: Response) -> Response:
    """The response with the status AMBIGUOUS for lanes that have no other and are `ambiguous`."""
    marked = (response["status"] == Status.OK) & ambiguous(lanes, response)
    status = np.where(marked, np.int64(Status.AMBIGUOUS), response["status"])
    return Response(response.engine, {**response.fields, "status": status}, response.times)
