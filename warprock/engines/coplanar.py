"""Responses in space of stacks that move in one vertical plane, from their responses there."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.engines.places import spatial_places
from warprock.model.coplanar import Coplanar
from warprock.model.lanes import SpatialLanes
from warprock.model.pose import product, quaternion, rotations
from warprock.model.response import Response

Array = npt.NDArray[np.float64]


def response_in_space(
    lanes: SpatialLanes, found: Coplanar, rows: npt.NDArray[np.intp], planar: Response
) -> Response:
    """The response in space of lanes that move in one vertical plane.

    Args:
        lanes: All lanes.
        found: Which move in a plane.
        rows: Numbers of those that the response has.
        planar: Their response in the plane.
    """
    some, unit = lanes.take(rows), found.unit[rows]
    c, s = unit.T[..., None]
    fields = dict(planar.fields)
    tilt, slide = planar["peak_rotation"], planar["residual_slide"]
    rotation, across, _yaw = rotations(_attitudes(some, unit, tilt[..., None]))
    rotation, across = np.abs(rotation[..., 0]), np.abs(across[..., 0])
    fields |= {
        "peak_rotation": rotation,
        "peak_rotation_across": across,
        "peak_tilt": tilt,
        "peak_time": np.where(rotation > 0.0, planar["peak_time"], 0.0),
        "peak_yaw": np.zeros_like(tilt),
        "residual_yaw": np.zeros_like(tilt),
        "residual_slide": c * slide,
        "residual_slide_across": s * slide,
    }
    if "rotation" in fields:
        attitude = _attitudes(some, unit, planar["rotation"])
        angles = rotations(attitude)
        fields |= dict(zip(("rotation", "rotation_across", "yaw"), angles, strict=True))
        if "x" in fields:
            s, c, x, slide = s[..., None], c[..., None], planar["x"], planar["slide"]
            places = np.stack([c * x, s * x, planar["z"]], axis=-1)
            fields |= spatial_places(some, attitude, places)
            fields |= {"slide": c * slide, "slide_across": s * slide}
    return Response(engine=planar.engine, fields=fields, times=planar.times)


def _attitudes(lanes: SpatialLanes, unit: Array, rotation: Array) -> Array:
    """Attitudes of blocks that lean in a vertical plane each.

    Args:
        lanes: The lanes.
        unit: Unit vectors along x and y of those planes, shape [lane, 2].
        rotation: Rotations in that plane [rad], shape [lane, block, sample].

    Returns:
        Quaternions, shape [lane, block, sample, 4].
    """
    zero, one = np.zeros_like(rotation), np.ones_like(rotation)
    c, s = unit.T[..., None, None]
    lean = np.stack([-s * rotation, c * rotation, zero], axis=-1)
    yaw = np.stack([zero, zero, lanes.yaw_start[..., None] * one], axis=-1)
    return product(quaternion(lean), quaternion(yaw))
