"""A scene in motion that tests of pictures share."""

from __future__ import annotations

import dataclasses

import numpy as np

from warprock.model.pose import quaternion
from warprock.running.scene_motion import SceneMotion


def swinging(samples: int = 5, *, spatial: bool = False, drift: float = 0.01) -> SceneMotion:
    """Two blocks that swing on a base which drifts [m]."""
    times = 0.1 * np.arange(samples)
    turn = 0.2 * np.sin(2.0 * np.pi * times)
    still = np.zeros_like(times)
    base = np.stack([drift * times, still, still], axis=-1)
    attitude = quaternion(np.stack([still, turn, still], axis=-1))
    return SceneMotion(
        name="a case, lane 0, event",
        outcome="rocking",
        spatial=spatial,
        times=times,
        sizes=np.array([[0.4, 0.5, 1.0], [0.3, 0.4, 0.6]]),
        position=np.stack([base + np.array([0.0, 0.0, height]) for height in (0.5, 1.3)]),
        attitude=np.stack([attitude, attitude]),
        ratio=np.stack([turn / 0.38, turn / 0.46]),
        base=base,
        acceleration=np.zeros_like(base),
    )


def tumbling(samples: int = 5) -> SceneMotion:
    """A wedge in space that turns about x while it goes along x."""
    times = 0.1 * np.arange(samples)
    still = np.zeros_like(times)
    attitude = quaternion(np.stack([2.0 * times, still, still], axis=-1))
    corners = [
        (x, *place) for x in (-0.1, 0.2) for place in ((-0.2, -0.1), (0.2, -0.1), (0.0, 0.3))
    ]
    return dataclasses.replace(
        swinging(samples, spatial=True),
        sizes=np.array([[0.3, 0.4, 0.4]]),
        position=np.stack([5.0 * times, still, still + 0.5], axis=-1)[None],
        attitude=attitude[None],
        ratio=still[None],
        outline=np.array(corners),
    )
