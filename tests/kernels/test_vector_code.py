"""The packed kernels are vector code: a ratio within one run, as a silent cliff would show.

Without vector code the packed form costs as much as the plain one, or more.
"""

import dataclasses
import itertools
import time
from typing import Any

import numpy as np
import pytest

from tests.shared.blocks import free_lanes, make_lanes, sines
from tests.shared.spatial_blocks import along, spatial_stack
from tests.shared.speed import require_gain
from warprock.engines.launching import Form
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import SampleTimes
from warprock.recordings import load_record, record_motions
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings, ImpulseSettings

LANES = 9 * 256
"""So many that what a run costs besides its kernel does not count."""


@dataclasses.dataclass(frozen=True)
class Scene:
    """Lanes that spend their steps in one loop of a kernel.

    Attributes:
        engine: Its name.
        lanes: The lanes.
        duration: How long they run [s].
        settings: Settings of the engine; None for its own.
        least: About midway, as a ratio, between scalar code (0.88 to 1.02, measured with
            -fno-vectorize) and the least of 256-bit vectors; 512-bit ones give more.
    """

    engine: str
    lanes: Lanes
    duration: float
    settings: Any
    least: float


def scenes() -> dict[str, Scene]:
    rocking = free_lanes().take(np.arange(LANES) % 9)
    # `event` has a loop for steps without events, and one for all others. Lanes of a pack that do
    # not agree wait for one another, which says nothing about either: the plain form does not.
    wide = make_lanes(np.full(LANES, 1.0), np.linspace(0.8, 1.2, LANES), 0.0, 0.9)
    slippery = make_lanes(np.linspace(0.3, 0.5, LANES), 2.0, 0.5, 0.08)
    pair = spatial_stack([0.2, 0.2], [0.6, 0.6], depth=0.4)
    pairs = SpatialLanes(**{k: np.repeat(v, LANES, axis=0) for k, v in pair.arrays.items()})
    return {
        # 2.0 to 3.8.
        "housner": Scene("housner", rocking, 2.0, None, 1.4),
        # 4.5 to 5.1.
        "impulse": Scene("impulse", rocking, 2.0, ImpulseSettings(substeps=1), 2.5),
        # 3.0.
        "impulse in space": Scene("impulse", pairs, 0.05, None, 1.6),
        # 1.6 to 2.1: short text, whose state is read and written in every step.
        "event at rest": Scene("event", wide, 2.0, EventSettings(time_step=1e-3), 1.25),
        # 2.1 to 2.5.
        "event sliding": Scene("event", slippery, 0.5, EventSettings(time_step=2e-3), 1.5),
    }


def motions_of(kind: str, name: str) -> GroundMotions:
    if kind == "harmonic":
        # Below what lifts the wide blocks.
        most = 5.0 if name == "event at rest" else 12.0
        motions = sines(Control.ACCELERATION, np.linspace(0.5 * most, most, LANES), 2.0, 4.0)
        return along(motions) if name == "impulse in space" else motions
    record = load_record("ridgecrest-2019-ccc-090")
    zero = np.zeros(LANES)
    return record_motions([record], index=zero.astype(int), scale=zero + 2.0, start=zero)


def cpu_time(scene: Scene, motions: GroundMotions, form: Form) -> float:
    times = SampleTimes(scene.duration)
    started = time.process_time()
    run_batch(
        scene.engine, scene.lanes, motions, times, settings=scene.settings, form=form, workers=1
    )
    return time.process_time() - started


@pytest.mark.speed
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *itertools.product(
            ["housner", "impulse", "event at rest", "event sliding"], ["harmonic", "record"]
        ),
        ("impulse in space", "harmonic"),
    ],
)
def test_packed_kernels_are_vectorised(name: str, kind: str) -> None:
    scene, motions = scenes()[name], motions_of(kind, name)
    for form in (Form.PLAIN, Form.PACKED):
        cpu_time(scene, motions, form)
    require_gain(
        lambda: cpu_time(scene, motions, Form.PLAIN),
        lambda: cpu_time(scene, motions, Form.PACKED),
        scene.least,
    )
