"""What `housner` hands its kernel of bodies: the feet of a convex base, and the edges between."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines.blocks import speed_columns
from warprock.engines.launching import NEVER
from warprock.model.bodies import Bodies
from warprock.model.lanes import Lanes
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

FLATTEST = 1e-7
"""Angle between two edges [rad] up to which they count as one, without a foot between them: it
would part from the ground before anything could be seen of it."""


def body_inputs(lanes: Lanes, rest_ratio: float) -> dict[str, Any]:
    """Feet, edges and starts of bodies, by the names of the kernel's arguments, and their blocks.

    Args:
        lanes: Bodies in the plane.
        rest_ratio: Part of the slenderness angle below which swings are left out.
    """
    body = lanes.body
    assert body is not None
    feet, last = _feet(body)
    x, z = feet[..., 0], feet[..., 1]
    lows, highs = _ranges(x, z, last)
    radius = body.corner_radius[:, None]
    reach = np.hypot(x, z)
    square = body.gyration[:, None] + radius**2 + reach**2
    home = np.argmin(np.abs(highs), axis=1)
    edges = _edges(body, x, z, highs, home, lanes)
    start = lanes.rotation_start
    place = np.sum(start[:, None] > highs, axis=1)
    omega = speed_columns(lanes)["omega"]
    # From the flat base it turns about the foot at the end that goes down.
    foot = np.minimum(home + (omega > 0.0), last)
    place = np.where(start == 0.0, foot, np.minimum(place, last))
    angles = body.slenderness_angles
    grip = np.arctan(np.minimum(lanes.friction, 1.0))
    outer = np.take_along_axis(np.arctan2(x, -z), last[:, None], axis=1)[:, 0]
    shortest = body.gyration[:, None] + (radius - reach) ** 2
    blocks = {
        "gravity": np.full_like(start, GRAVITY),
        "radius": body.corner_radius,
        "fall_left": np.maximum(angles[:, 0], -np.arctan2(x[:, 0], -z[:, 0])) + grip,
        "fall_right": np.maximum(angles[:, 1], outer) + grip,
        "rest_rotation": angles.min(axis=1) * rest_ratio,
    }
    return {
        "blocks": blocks,
        "feet": {
            "alpha": np.arctan2(x, -z),
            "reach": reach,
            "p2": GRAVITY * reach / square,
            "q": reach / square,
            "rho": radius / square,
            "eps": 2.0 * radius * reach / square,
            "low": lows,
            "high": highs,
        },
        "edges": edges,
        "starts": {"theta": start, "omega": omega, "place": place, "last": last},
        "rate": np.sqrt((GRAVITY * reach / shortest).max(axis=1)),
    }


def _feet(body: Bodies) -> tuple[Array, npt.NDArray[np.intp]]:
    """Centres of the arcs at the corners of the hull [m], [lane, foot, 2], and the last foot."""
    points = np.array(body.centres)
    low = points[..., 1].min(axis=1, keepdims=True)
    # Points that the body stands on are level, whatever the digits of a file say.
    points[..., 1] = np.where(body.standing, low, points[..., 1])
    step = np.diff(points, axis=1)
    slope = np.arctan2(step[..., 1], step[..., 0])
    count = body.count[:, None]
    number = np.arange(points.shape[1])
    kept = (number < count) & np.ones_like(points[..., 0], np.bool_)
    bends = np.diff(slope, axis=1) > FLATTEST
    kept[:, 1:-1] &= bends | (number[1:-1] == count - 1)
    order = np.argsort(~kept, axis=1, kind="stable")
    last = kept.sum(axis=1) - 1
    order = np.take_along_axis(order, np.minimum(number, last[:, None]), axis=1)
    most = int(last.max()) + 1
    return np.take_along_axis(points, order[:, :most, None], axis=1), last


def _ranges(x: Array, z: Array, last: npt.NDArray[np.intp]) -> tuple[Array, Array]:
    """Rotations from which and up to which each foot touches [rad], shape [lane, foot]."""
    angle = np.arctan2(np.diff(z, axis=1), np.diff(x, axis=1))
    # The last foot, and its copies that pad the row, touch up to a right angle.
    real = np.arange(angle.shape[1]) < last[:, None]
    angle = np.where(real, angle, 0.5 * np.pi)
    ends = np.full((len(x), 1), 0.5 * np.pi)
    return np.concatenate([-ends, angle], axis=1), np.concatenate([angle, ends], axis=1)


def _edges(
    body: Bodies, x: Array, z: Array, highs: Array, home: npt.NDArray[np.intp], lanes: Lanes
) -> dict[str, Array]:
    """Fields of the struct `Edge`, shape [lane, edge] each."""
    turn = highs[:, :-1]
    c, s = np.cos(turn), np.sin(turn)
    left = x[:, :-1] * c + z[:, :-1] * s
    right = x[:, 1:] * c + z[:, 1:] * s
    height = body.corner_radius[:, None] + x[:, :-1] * s - z[:, :-1] * c
    below = body.gyration[:, None] + height**2
    inertia_left, inertia_right = below + left**2, below + right**2
    kept = below + left * right
    kept_left, kept_right = kept / inertia_left, kept / inertia_right
    if lanes.restitution_given:
        stood = np.arange(turn.shape[1]) == home[:, None]
        given = lanes.angular_restitution[:, None]
        kept_left, kept_right = (np.where(stood, given, each) for each in (kept_left, kept_right))
    return {
        "hold_left": GRAVITY * -left / height,
        "hold_right": GRAVITY * right / height,
        "weight_left": GRAVITY * -left / inertia_left,
        "weight_right": GRAVITY * right / inertia_right,
        "pull_left": height / inertia_left,
        "pull_right": height / inertia_right,
        "inertia_left": inertia_left,
        "inertia_right": inertia_right,
        "kept_left": kept_left,
        "kept_right": kept_right,
        "slip_left": _slip(height, kept_left, right, left),
        "slip_right": _slip(height, kept_right, left, right),
    }


def _slip(height: Array, kept: Array, old: Array, new: Array) -> Array:
    """Friction that an impact needs on the end `new` after one on the end `old`, [lane, edge].

    The centre of mass comes with the velocity (H, x_old) per unit of rate and leaves with eta
    (H, x_new): the impulse is the difference. None is enough where it would have to pull.
    """
    eta = np.maximum(kept, 0.0)
    along, upwards = height * np.abs(1.0 - eta), np.sign(new - old) * (eta * new - old)
    return np.divide(along, upwards, out=np.full_like(along, NEVER), where=upwards > 0.0)
