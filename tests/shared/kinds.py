"""One small batch in every kind of motion and of scene, for tests that compare across them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from tests.shared.blocks import as_stacks, make_lanes, sines, two_equal
from tests.shared.spatial_blocks import along, in_space
from warprock.model.lanes import Lanes
from warprock.model.motion import (
    Control,
    GroundMotions,
    MotionKind,
    PlanarMotions,
    RecordMotions,
    StillBase,
    mavroeidis_papageorgiou_motions,
    ricker_motions,
)

KINDS = (MotionKind.STILL, MotionKind.HARMONIC, MotionKind.RECORD)
"""Kinds of motion: none, analytic, sampled. The other analytic ones differ in `expand` alone."""

IN_ALL_KINDS = ("housner", "impulse")
"""Engines that tests compare in every kind of motion, in the plane: what moves the base is one text
for all. Their kernels take the shortest to compile."""


def in_every_kind(scenes: Iterable[tuple[str, str]]) -> list[Any]:
    """Engines and scenes, in the analytic kind of motion and some in every kind, as parameters.

    Every kind is a kernel to compile, and in space a long one. The ordinary run has single blocks
    in the plane, as stacks of one, too, in the analytic kind; the rest comes with `thorough`.
    """
    return [
        pytest.param(
            engine,
            scene,
            kind,
            marks=()
            if kind is MotionKind.HARMONIC and scene in ("block", "stack of one")
            else pytest.mark.thorough,
        )
        for engine, scene in scenes
        for kind in KINDS
        if kind is MotionKind.HARMONIC or (engine in IN_ALL_KINDS and "in space" not in scene)
    ]


def record(scale: np.ndarray, interval: float = 0.02) -> RecordMotions:
    """Two bumps of acceleration that leave the base at rest, [m/s^2] times a scale a lane."""
    time = interval * np.arange(round(0.8 / interval) + 1)
    bumps = np.where(time < 0.8, np.sin(2.5 * np.pi * time) * np.sin(1.25 * np.pi * time), 0.0)
    slope = np.append(np.diff(bumps) / interval, 0.0)
    steps = 0.5 * interval * (bumps[1:] + bumps[:-1])
    count, zero = len(scale), np.zeros(len(scale))
    return RecordMotions(
        start=zero,
        scale=scale,
        offset=np.zeros(count, np.int32),
        count=np.full(count, len(time), np.int32),
        interval=np.full(count, interval),
        velocity_step_start=zero,
        velocity_step_stop=zero,
        pool_acceleration=np.append(bumps[:-1], 0.0),
        pool_slope=slope,
        pool_velocity=np.append(0.0, np.cumsum(steps)),
    )


def planar_motions(kind: MotionKind, count: int) -> PlanarMotions:
    """Motions of a kind under which the blocks of `lanes_of` rest, rock, slide or fall."""
    spread = np.linspace(0.7, 1.4, count)
    if kind is MotionKind.STILL:
        return StillBase(count)
    if kind is MotionKind.RECORD:
        return record(4.0 * spread)
    control, zero, frequency = [Control.DISPLACEMENT] * count, np.zeros(count), np.full(count, 2.0)
    if kind is MotionKind.RICKER:
        return ricker_motions(control, 0.02 * spread, frequency, zero)
    if kind is MotionKind.MODULATED:
        cycles = np.full(count, 2.0)
        return mavroeidis_papageorgiou_motions(
            control, 0.02 * spread, frequency, zero, cycles=cycles, phase=zero
        )
    return sines(Control.DISPLACEMENT, 0.02 * spread, 2.0, cycles=1.0)


def motions_of(kind: MotionKind, lanes: Lanes) -> GroundMotions:
    """The same for lanes of any scene: along x where they are in space."""
    motions = planar_motions(kind, lanes.lane_count)
    return along(motions) if lanes.spatial else motions


def lanes_of(scene: str, *, started: bool = False) -> Lanes:
    """Four lanes of a scene, half of which start flat; `started` turns all of them.

    Args:
        scene: block, stack of one, stack, block in space, or stack in space.
        started: Whether every block starts turned: what starts flat on a still base stays so.
    """
    ratio = np.array([0.2, 0.3, 0.5, 0.6]) if started else np.array([0.0, 0.3, 0.0, -0.4])
    block = make_lanes(
        np.array([0.3, 0.2, 0.25, 0.35]), 1.0, ratio, friction=np.array([0.7, 0.9, 1.2, 0.6])
    )
    lanes = {
        "block": lambda: block,
        "stack of one": lambda: as_stacks(block),
        "stack": lambda: two_equal(block),
    }[scene.replace(" in space", "")]()
    return in_space(lanes) if "in space" in scene else lanes


SCENES = ("block", "stack of one", "stack", "block in space", "stack in space")
