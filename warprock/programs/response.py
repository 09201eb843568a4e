"""From the poses that a program of others answered to a response, as an engine gives it.

Everything is read off poses at frames, so what happens between two frames is seen as far as a
parabola through three of them shows it: peaks. What cannot be told from poses is NaN: the energy
lost. Impacts are changes of the side that a block leans to; a block is at rest, or has not yet
lifted, while it leans by less than `FLAT_RATIO` of its slenderness angle.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes
from warprock.model.pose import rotations
from warprock.model.response import (
    INTEGER_FIELDS,
    LANE_FIELDS,
    SPATIAL_FIELDS,
    Outcome,
    Response,
    SampleTimes,
    Status,
)
from warprock.model.turning import inverse, rotate
from warprock.programs.scene import PeerRun, PeerScene, frames_per_sample

Array = npt.NDArray[np.float64]

FLAT_RATIO = 1e-3
"""Lean / slenderness angle below which a block counts as flat on what is below: several of these
programs let a block that rests sway by some micrometres."""
REST_TIME = 0.25
"""Time for which all blocks have to be flat at the end of a run that is at rest [s]."""
FALLEN_ANGLE = 1.5
"""Angle between a block's axis and the vertical beyond which it has overturned [rad]: a block that
comes to lie on its side stops short of a right angle where contacts are soft or have a margin."""


@dataclasses.dataclass(frozen=True)
class _Seen:
    """What the poses of one lane show, shape [frame, block] unless said otherwise.

    Attributes:
        rotation: Rotation in the plane of rocking [rad].
        across: Rotation across it [rad].
        yaw: Turn about the vertical [rad].
        tilt: Angle between the block's axis and the vertical [rad].
        lean: Angle between the block's axis and that of what it stands on [rad], with the sign of
            the rotation against it.
        slide: Slide along what it stands on, from the start [m], shape [frame, block, 2].
        depth: Depth of its lowest corner in what it stands on [m].
        last: Frame at which a block has overturned, and the run ends; the last one if none has.
        down: Whether each block has overturned by then, [block].
        lying: Rotation and rotation across of the blocks where they would come to lie, on the side
            to which they lean by then [rad], shape [2, block].
    """

    rotation: Array
    across: Array
    yaw: Array
    tilt: Array
    lean: Array
    slide: Array
    depth: Array
    last: int
    down: npt.NDArray[np.bool_]
    lying: Array


def peer_response(
    name: str,
    lanes: Lanes,
    scenes: Sequence[PeerScene],
    runs: Sequence[PeerRun],
    times: SampleTimes,
) -> Response:
    """The response of a program.

    Args:
        name: Its name.
        lanes: The lanes.
        scenes: Their scenes.
        runs: What it answered for each.
        times: Sampling of the histories.

    Returns:
        Every lane field, those of space for blocks in space, histories if asked for.
    """
    rows = [_lane(lanes, i, *pair) for i, pair in enumerate(zip(scenes, runs, strict=True))]
    names = LANE_FIELDS + (SPATIAL_FIELDS if lanes.spatial else ())
    fields: dict[str, npt.NDArray[np.generic]] = {}
    for field in names:
        kind = np.int64 if field in INTEGER_FIELDS else np.float64
        fields[field] = np.array([row[field] for row in rows], kind)
    if times.interval is None:
        return Response(name, fields, np.empty(0))
    every = frames_per_sample(times)
    if times.places and lanes.spatial and not lanes.stacked:
        fields |= _places(runs, every)
    histories = ("rotation", "rotation_across", "yaw") if lanes.spatial else ("rotation",)
    for field in histories:
        whole = np.array([row[f"history_{field}"] for row in rows])
        fields[field] = np.ascontiguousarray(np.moveaxis(whole, 1, -1)[..., ::every])
    return Response(name, fields, times.times)


def _places(runs: Sequence[PeerRun], every: int) -> dict[str, npt.NDArray[np.generic]]:
    """Histories of the centres of mass and the attitudes of single blocks, [lane, sample] each."""
    position = np.stack([run.position[::every, 0] for run in runs])
    attitude = np.stack([run.attitude[::every, 0] for run in runs])
    found: dict[str, npt.NDArray[np.generic]] = dict(
        zip("xyz", np.moveaxis(position, -1, 0), strict=True)
    )
    return found | {f"attitude_{name}": attitude[..., k] for k, name in enumerate("xyzw")}


def _lane(lanes: Lanes, lane: int, scene: PeerScene, run: PeerRun) -> dict[str, object]:
    """Every field of one lane; blocks first where the lane is a stack."""
    seen = _look(scene, run, spatial=lanes.spatial, thrown=lanes.thrown)
    slenderness = np.atleast_1d(lanes.slenderness_angle[lane])
    peaks = [_peak(seen.rotation[: seen.last + 1, k], scene.frame) for k in range(len(slenderness))]
    peak, peak_time = (np.array(part) for part in zip(*peaks, strict=True))
    across = np.abs(seen.across[: seen.last + 1]).max(axis=0)
    peak, across = (
        np.where(seen.down, np.maximum(most, np.abs(lying)), most)
        for most, lying in zip((peak, across), seen.lying, strict=True)
    )
    until = slice(0, seen.last + 1)
    finite = bool(np.isfinite(run.position).all() and np.isfinite(run.attitude).all())
    slide = np.linalg.norm(seen.slide[until], axis=-1).max(axis=0)
    blocks = {
        "peak_rotation": peak,
        "peak_time": peak_time,
        "residual_slide": seen.slide[seen.last, :, 0],
        "peak_slide": slide,
        "peak_tilt": np.where(seen.down, 0.5 * np.pi, seen.tilt[until].max(axis=0)),
        "peak_rotation_across": across,
        "peak_yaw": np.abs(seen.yaw[until] - seen.yaw[0]).max(axis=0),
        "residual_yaw": seen.yaw[seen.last] - seen.yaw[0],
        "residual_slide_across": seen.slide[seen.last, :, 1],
        "history_rotation": _hold(seen.rotation, seen, seen.lying[0]),
        "history_rotation_across": _hold(seen.across, seen, seen.lying[1]),
        "history_yaw": _hold(seen.yaw, seen, seen.yaw[seen.last]),
    }
    if not lanes.stacked:
        blocks = {key: value[..., 0] for key, value in blocks.items()}
    moved = np.any(np.abs(seen.lean[until]) > FLAT_RATIO * slenderness, axis=1)
    return {
        **blocks,
        **_times(np.asarray(moved), scene.frame, fallen=bool(seen.down.any())),
        "status": Status.OK if finite else Status.NONFINITE,
        "impact_count": sum(
            _side_changes(seen.lean[until, k], FLAT_RATIO * angle)
            for k, angle in enumerate(slenderness)
        ),
        "peak_penetration": max(0.0, float(seen.depth[until].max())),
        "energy_lost": np.nan,
        "step_count": run.step_count,
    }


def _look(scene: PeerScene, run: PeerRun, *, spatial: bool, thrown: bool) -> _Seen:
    """Rotations and places of the blocks of one lane against what is below them.

    In the plane a block lies flat on its side, however little the program let it leave the plane. A
    thrown block never falls, and its slide is the way of its centre.
    """
    attitude, position = run.attitude, run.position
    base = scene.base.displacement(scene.times) if scene.base else np.zeros((len(scene.times), 3))
    rotation, across, yaw = rotations(attitude)
    upwards = np.zeros((*rotation.shape, 3))
    upwards[..., 2] = 1.0
    axis = rotate(attitude, upwards)
    tilt = np.arctan2(np.hypot(axis[..., 0], axis[..., 1]), axis[..., 2])
    falls = np.inf if thrown else FALLEN_ANGLE
    fallen = np.flatnonzero((tilt >= falls).any(axis=1))
    last = int(fallen[0]) if len(fallen) else len(rotation) - 1
    down = tilt[last] >= falls
    # Twists run on where a turn passes half of a round.
    yaw = np.unwrap(yaw, axis=0)
    below = np.zeros_like(attitude[:, 0])
    below[:, 3] = 1.0
    floor, leans, slides, depths = base, [], [], []
    for k, block in enumerate(scene.blocks):
        back = inverse(below)
        seen_axis = rotate(back, axis[:, k])
        angle = np.arctan2(np.hypot(seen_axis[:, 0], seen_axis[:, 1]), seen_axis[:, 2])
        leans.append(np.where(seen_axis[:, 0] < 0.0, -angle, angle))
        corners, stood = _corners(scene, k)
        places = position[:, k, None] + rotate(attitude[:, k, None], corners)
        against = rotate(back[:, None], places - floor[:, None])
        lowest = np.argmin(against[..., 2], axis=1)
        frames = np.arange(len(against))
        slides.append(against[frames, lowest, :2] - stood[lowest])
        depths.append(-against[frames, lowest, 2])
        top = np.array(block.middle)
        top[2] += 0.5 * block.size[2]
        floor = position[:, k] + rotate(attitude[:, k], np.broadcast_to(top, position[:, k].shape))
        below = attitude[:, k]
    return _Seen(
        rotation=rotation,
        across=across,
        yaw=yaw,
        tilt=tilt,
        lean=np.stack(leans, axis=1),
        slide=position[..., :2] - position[0, :, :2] if thrown else np.stack(slides, axis=1),
        depth=np.stack(depths, axis=1),
        last=last,
        down=down,
        lying=_lying(axis[last], spatial=spatial),
    )


def _corners(scene: PeerScene, block: int) -> tuple[Array, Array]:
    """Corners of the stretch of a block's bottom that lies on what is below, or a body's points.

    Returns:
        The corners in body axes, shape [corner, 3], and where they would stand if the block were
        flat, from the middle of the face below and along its axes, shape [corner, 2] [m].
    """
    own = scene.blocks[block]
    if own.body is not None:
        points = np.array(own.body.points)
        below = scene.blocks[block - 1].stands if block else (0.0, 0.0)
        away = np.subtract(own.stands, below) - (own.body.middle, 0.0)
        return points, away + _turn_by(own.yaw, points[:, :2])
    half, offset, yaw = 0.5 * np.array(own.face), np.zeros(2), own.yaw
    low, high = -half, half
    if block > 0:
        lower = scene.blocks[block - 1]
        under = 0.5 * np.array(lower.face)
        offset = _turn_by(-lower.yaw, np.subtract(own.stands, lower.stands))
        low, high = np.maximum(low, -under - offset), np.minimum(high, under - offset)
        yaw -= lower.yaw
    flat = np.array([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])])
    bottom = np.pad(flat, ((0, 0), (0, 1)), constant_values=-0.5 * own.size[2])
    return bottom + np.array(own.middle), offset + _turn_by(yaw, flat)


def _turn_by(angle: float, vectors: Array) -> Array:
    """Vectors in the plane turned from +x to +y, shape [..., 2]."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)


def _lying(axis: Array, *, spatial: bool) -> Array:
    """Rotation and rotation across of axes [block, 3] that lie level in their direction [rad]."""
    x, y = axis[:, 0], axis[:, 1] if spatial else np.zeros(len(axis))
    return np.arctan2([x, y], np.abs([y, x]))


def _hold(history: Array, seen: _Seen, lying: Array) -> Array:
    """A history that stays where it was once the run has ended, a fallen block where it lies."""
    held = history.copy()
    held[seen.last + 1 :] = held[seen.last]
    held[seen.last :, seen.down] = lying[seen.down]
    return held


def _peak(rotation: Array, frame: float) -> tuple[float, float]:
    """Largest |rotation| [rad] and its time [s], of the parabola through the frames around it."""
    size = np.abs(rotation)
    top = int(np.argmax(size))
    if not 0 < top < len(size) - 1:
        return float(size[top]), top * frame
    before, middle, after = size[top - 1], size[top], size[top + 1]
    bend = before - 2.0 * middle + after
    if not bend < 0.0:
        return float(middle), top * frame
    aside = 0.5 * (before - after) / bend
    return float(middle - 0.25 * (before - after) * aside), (top + aside) * frame


def _side_changes(lean: Array, least: float) -> int:
    """How often a block that leans by more than a least angle has changed the side."""
    sides = np.sign(lean[np.abs(lean) > least])
    return int(np.count_nonzero(np.diff(sides)))


def _times(moved: npt.NDArray[np.bool_], frame: float, *, fallen: bool) -> dict[str, object]:
    """When the blocks first lifted and when they came to rest [s], and where they are."""
    lifted = np.flatnonzero(moved)
    uplift = lifted[0] * frame if len(lifted) else np.nan
    still_since = (lifted[-1] + 1) * frame if len(lifted) else 0.0
    resting = not fallen and (len(moved) - 1) * frame - still_since >= REST_TIME
    outcome = Outcome.AT_REST if resting else Outcome.ROCKING
    return {
        "uplift_time": uplift,
        "rest_time": still_since if resting else np.nan,
        "outcome": Outcome.OVERTURNED if fallen else outcome,
    }
