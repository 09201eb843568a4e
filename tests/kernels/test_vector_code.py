"""The packed kernels are vector code: a ratio within one run, as a silent cliff would show.

Without vector code the packed form costs as much as the plain one, or more.
"""

import time

import numpy as np
import pytest

from tests.shared.blocks import free_lanes, sines
from tests.shared.speed import require_gain
from warprock.engines.launching import Form
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import SampleTimes
from warprock.records import load_record, record_motions
from warprock.run.batch import run_batch
from warprock.settings.engines import ImpulseSettings

LANES = 9 * 256
"""So many that what a run costs besides its kernel does not count."""
TIMES = SampleTimes(2.0)

# About midway, as a ratio, between scalar code (0.88 to 1.02, measured with -fno-vectorize) and the
# least of 256-bit vectors: housner 2.0 to 3.8, impulse 4.5 to 5.1, event 3.2 to 3.6. 512-bit ones
# give more; a processor whose cores were shared gave event 1.6 to 2.1.
LEAST = {"housner": 1.4, "impulse": 2.5, "event": 1.7}


def motions_of(kind: str) -> GroundMotions:
    if kind == "harmonic":
        return sines(Control.ACCELERATION, np.linspace(6.0, 12.0, LANES), 2.0, 4.0)
    record = load_record("ridgecrest-2019-ccc-090")
    zero = np.zeros(LANES)
    return record_motions([record], index=zero.astype(int), scale=zero + 2.0, start=zero)


def cpu_time(engine: str, motions: GroundMotions, form: Form) -> float:
    lanes = free_lanes().take(np.arange(LANES) % 9)
    settings = ImpulseSettings(substeps=1) if engine == "impulse" else None
    started = time.process_time()
    run_batch(engine, lanes, motions, TIMES, settings=settings, form=form, workers=1)
    return time.process_time() - started


@pytest.mark.speed
@pytest.mark.parametrize("kind", ["harmonic", "record"])
@pytest.mark.parametrize("engine", LEAST)
def test_packed_kernels_are_vectorised(engine: str, kind: str) -> None:
    motions = motions_of(kind)
    for form in (Form.PLAIN, Form.PACKED):
        cpu_time(engine, motions, form)
    require_gain(
        lambda: cpu_time(engine, motions, Form.PLAIN),
        lambda: cpu_time(engine, motions, Form.PACKED),
        LEAST[engine],
    )
