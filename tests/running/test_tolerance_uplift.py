"""The estimated error of the uplift time."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.blocks import make_lanes, sines
from tests.shared.marks import first
from warprock.model import rocking
from warprock.model.motion import Control
from warprock.model.response import Response, SampleTimes, Status
from warprock.running.companions import uplift_error, uplift_gap
from warprock.running.options import RunOptions
from warprock.running.tolerance import HALVINGS, run_to_tolerance

COUNT = 60
TOLERANT = RunOptions(tolerance=0.01)


@pytest.mark.parametrize("halvings", first(1, [HALVINGS, 1]))
@pytest.mark.parametrize("engine", ["event", "impulse", "direct", "xpbd"])
def test_uplift_times_err_by_less_than_their_estimates(engine: str, halvings: int) -> None:
    draw = np.random.default_rng(3)
    lanes = make_lanes(draw.uniform(0.15, 0.5, COUNT), 1.0, friction=5.0)
    limit = rocking.uplift_acceleration(lanes.width, lanes.height)
    ratio = draw.uniform(1.02, 3.0, COUNT)
    ratio[:3] = 0.5
    frequency = draw.uniform(0.5, 5.0, COUNT)
    motions = sines(Control.ACCELERATION, limit * ratio, frequency, 1.0, start=0.03)
    found = run_to_tolerance(engine, lanes, motions, SampleTimes(1.2), TOLERANT, halvings=halvings)
    lifts = 0.03 + np.arcsin(np.minimum(1.0 / ratio, 1.0)) / (2.0 * np.pi * frequency)
    errors = np.abs(found["uplift_time"] - lifts)[3:]
    estimates = found["uplift_time_error"][3:]
    # Round-off of a time, which no run shows.
    assert np.all(errors <= estimates + 1e-15)
    assert np.max(estimates) <= (1e-12 if engine == "event" else 2e-2)
    assert np.all(np.isnan(found["uplift_time_error"][:3]))


def lifting(times: list[float], status: Status = Status.OK) -> Response:
    """Runs of lanes that lift at these times [s]."""
    fields = {"uplift_time": np.array(times), "status": np.full(len(times), int(status))}
    return Response(engine="event", fields=fields, times=np.empty(0))


def test_a_lift_that_one_run_alone_sees_has_no_bound() -> None:
    nan, none = np.nan, np.zeros(4)
    ours, theirs = lifting([nan, 1.0, nan, 1.0]), lifting([nan, 1.25, 1.0, nan])
    apart = uplift_gap(ours, theirs)
    np.testing.assert_array_equal(apart, [0.0, 0.25, np.inf, np.inf])
    np.testing.assert_array_equal(uplift_error(ours, apart, none), [nan, 0.25, np.inf, np.inf])
    failed = uplift_gap(ours, lifting([nan, 1.0, nan, 1.0], Status.EVENT_LIMIT))
    assert np.all(np.isinf(failed))
    broken = lifting([nan] * 4, Status.NONFINITE)
    assert np.all(np.isnan(uplift_error(broken, apart, none)))
