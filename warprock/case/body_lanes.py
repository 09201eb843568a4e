"""Bodies that are no boxes from the values of a case, lane by lane, and their input columns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.case.body import Body, StackedBody, profiles
from warprock.case.input_columns import computed, key_column, lane_columns
from warprock.errors import InputError, Said
from warprock.model import rocking
from warprock.model.bodies import Bodies
from warprock.model.hull import LEVEL, lower_hulls
from warprock.model.lanes import Lanes
from warprock.model.turning import inverse, principal_axes, rotate

if TYPE_CHECKING:
    from warprock.case.values import LaneValues

Array = npt.NDArray[np.float64]

DIRECTION = "motion.direction"
"""Key of the direction of shaking."""

_BOX = tuple(f"block.{name}" for name in ("width", "height", "depth"))
"""Keys of the box around a body, in the order of their columns."""

SIDES = ("left", "right")
"""What columns call the sides at -x and at +x."""


def body_of(values: LaneValues) -> Body | None:
    """The table of the case's body; None where its blocks are boxes."""
    block = values.case.tables.block
    return block if isinstance(block, Body) else None


def body_lanes(values: LaneValues, body: Body, *, in_space: bool) -> Lanes:
    """Bodies and their starts.

    Raises:
        InputError: A profile is to move in space or in a direction of its own, corners are rounded
            in space or beyond what their edges hold, or a body starts beyond its balance.
    """
    _refuse_other_model(values, body, in_space=in_space)
    bodies = _in_space(values, body) if in_space else _in_plane(values, body)
    points = bodies.points_in_block_axes
    width = np.ptp(points[..., 0], axis=1)
    depth = np.ptp(points[..., 1], axis=1) if in_space else np.ones_like(width)
    known = values.given("block.height")
    height = values.numbers("block.height") if known else 2.0 * bodies.centre_height
    start = _start(values, bodies, in_space=in_space)
    given = values.given("contact.angular_restitution")
    if given:
        restitution = values.numbers("contact.angular_restitution")
    elif in_space:
        # No engine in space follows it.
        restitution = rocking.angular_restitution(bodies.slenderness_angles.min(axis=1))
    else:
        restitution = bodies.angular_restitutions.min(axis=1)
    return Lanes(
        width=width,
        height=height,
        depth=depth,
        density=bodies.mass / (width * height * depth),
        friction=values.numbers("contact.friction"),
        chamfer=np.zeros_like(width),
        offset=np.zeros_like(width),
        rotation_start=start,
        angular_restitution=restitution,
        body=bodies,
        restitution_given=given,
    )


def _refuse_other_model(values: LaneValues, body: Body, *, in_space: bool) -> None:
    everywhere = np.ones(len(values.lanes), np.bool_)
    if in_space and not body.spatial:
        source, allowed = values.case.source_of("block.base"), "must be points [x, y, z] in space"
        raise InputError(source, "block.base", Said("points [x, z]"), allowed)
    if values.given(DIRECTION) and not body.spatial:
        allowed = "must not be given with a base of points [x, z], which is a plane itself"
        values.refuse(everywhere, DIRECTION, allowed)
    if in_space and values.given("block.corner_radius"):
        allowed = "must be 0, or left out, in space"
        values.refuse(_radius(values) > 0.0, "block.corner_radius", allowed)


def _radius(values: LaneValues) -> Array:
    key = "block.corner_radius"
    return values.numbers(key) if values.given(key) else np.zeros(len(values.lanes))


def _in_space(values: LaneValues, body: Body) -> Bodies:
    moments, axes = principal_axes(body.tensor)
    mass, count = values.numbers("block.mass"), len(values.lanes)
    points = np.tile(body.points, (count, 1, 1))
    points[..., :2] *= values.numbers("block.base_scale")[:, None, None]
    conjugate = inverse(axes)
    return Bodies(
        mass=mass,
        gyration=moments / mass[:, None],
        points=rotate(conjugate, points),
        count=np.full(count, len(body.points), np.int32),
        corner_radius=np.zeros(count),
        axes=np.tile(axes, (count, 1)),
    )


def seen_in_plane(
    values: LaneValues, body: Body | StackedBody
) -> tuple[Array, npt.NDArray[np.int32], Array]:
    """A body as the plane sees it: what can touch; of a body in space, in the plane of its motion.

    Returns:
        Points from the centre of mass [m], shape [lane, point, 2], how many each lane has, and
        moments of inertia [kg m^2], shape [lane].
    """
    count = len(values.lanes)
    if body.spatial:
        given = values.given(DIRECTION)
        direction = values.numbers(DIRECTION) if given else np.zeros(count)
        distinct, place = np.unique(direction, return_inverse=True)
        hulls, counts = profiles(body.points, distinct)
        normal = np.stack([-np.sin(distinct), np.cos(distinct), np.zeros_like(distinct)], axis=1)
        inertia = np.einsum("ij,jk,ik->i", normal, body.tensor, normal)[place]
    else:
        hulls, counts = lower_hulls(body.points[None])
        place = np.zeros(count, np.intp)
        inertia = np.full(count, body.inertia[0])
    return hulls[place], counts[place], inertia


def _in_plane(values: LaneValues, body: Body) -> Bodies:
    count, mass = len(values.lanes), values.numbers("block.mass")
    points, counts, inertia = seen_in_plane(values, body)
    points[..., 0] *= values.numbers("block.base_scale")[:, None]
    bodies = Bodies(
        mass=mass,
        gyration=inertia / mass,
        points=points,
        count=counts,
        corner_radius=_radius(values),
        axes=np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)),
    )
    x = bodies.base_ends
    # Arcs that overtake one another leave no edge between them.
    behind = (
        np.diff(bodies.centres[..., 0], axis=1) < -LEVEL * np.ptp(points[..., 0], axis=1)[:, None]
    )
    narrow = behind.any(axis=1) | (x[:, 0] >= 0.0) | (x[:, 1] <= 0.0)
    allowed = "must leave an edge between two corners, and flat base below the centre of mass"
    if values.given("block.corner_radius"):
        values.refuse(narrow, "block.corner_radius", allowed)
    elif values.given(DIRECTION):
        allowed = "must leave the centre of mass above the lowest contact points"
        values.refuse(narrow, DIRECTION, allowed)
    return bodies


def _start(values: LaneValues, bodies: Bodies, *, in_space: bool) -> Array:
    """Rotation at the start [rad], shape [lane]."""
    sides = bodies.slenderness_angles
    for key in ("start.rotation_ratio", "start.rotation"):
        if not values.given(key):
            continue
        given = values.numbers(key)
        angle = np.where(given < 0.0, sides[:, 0], sides[:, 1])
        if key == "start.rotation_ratio":
            return np.asarray(angle * given)
        beyond = (np.abs(given) >= angle) & (not in_space)
        if beyond.any():
            limit = np.rad2deg(angle[int(np.argmax(beyond))])
            allowed = f"must be less than the slenderness angle of that side, {limit:.6g} deg"
            values.refuse(beyond, key, allowed)
        return given
    return np.zeros(len(values.lanes))


def body_columns(values: LaneValues, table: Body, lanes: Lanes) -> dict[str, object]:
    """Input columns of bodies."""
    body = lanes.body
    assert body is not None
    columns: dict[str, object] = {**key_column("block.mass", body.mass)}
    # Whatever an ensemble or a sweep moves is given in the table of its first lane, too.
    given = table.model_fields_set
    for name in ("base_scale", "corner_radius"):
        if name in given:
            columns |= key_column(f"block.{name}", values.numbers(f"block.{name}"))
    columns |= lane_columns(_BOX, lanes)
    columns |= lane_columns(["contact.friction", "contact.angular_restitution"], lanes)
    columns |= computed("slenderness_angle", lanes.slenderness_angle)
    for side, angle in zip(SIDES, lanes.slenderness_angles.T, strict=True):
        columns |= computed(f"slenderness_angle_{side}", angle)
    columns |= computed("half_diagonal", body.reaches.min(axis=1))
    columns |= computed("frequency_parameter", body.frequency_parameter)
    if values.given(DIRECTION):
        columns |= key_column(DIRECTION, values.numbers(DIRECTION))
    columns |= lane_columns(["start.rotation"], lanes)
    left, right = lanes.slenderness_angles.T
    side = np.where(lanes.rotation_start < 0.0, left, right)
    return columns | key_column("start.rotation_ratio", lanes.rotation_start / side)
