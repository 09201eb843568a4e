"""Which engine is taken where none is named, and which one a run is held against."""

from __future__ import annotations

import numpy as np
import pytest

import warprock as wr
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import ENGINES, engine_class, preferred_engines, reference_engine
from warprock.model.response import SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.running.engine_choice import another_engine, stays_inside


def test_references_have_no_error_of_a_step() -> None:
    assert [reference_engine(stacked=each) for each in (False, True)] == ["housner", "two-block"]
    for name in ENGINES:
        assert (engine_class(name).reference_of is None) == (engine_class(name).order is not None)


def test_the_preferred_engines_have_an_order() -> None:
    assert preferred_engines() == ["event", "impulse", "dem", "housner"]


@pytest.mark.parametrize(
    ("case", "ran", "other"),
    [
        ("free-b0", "event", "impulse"),
        ("free-b0", "housner", "impulse"),
        ("free-b0", "impulse", "event"),
        ("free-b0", "dem", "event"),
        ("stack-sine-pulse", "two-block", "impulse"),
        ("stack-sine-pulse", "impulse", "event"),
    ],
)
def test_a_run_is_held_against_an_engine_of_the_other_kind(case: str, ran: str, other: str) -> None:
    assert another_engine(ran, expand_lanes(load_case(case)).scene) == other


def test_boxes_on_a_still_base_stay_inside_the_model_of_housner() -> None:
    """Up to restitution 0, 54.7 degrees, on the least friction that `housner` takes.

    What runs find of random boxes is what the closed form says: the friction that they need stays
    below tan(alpha). Where cos(alpha) is above 2/3 it is that of an impact, 3 t / (4 + t^2).
    """
    angle = np.random.default_rng(1).uniform(0.02, 0.95, 64)
    height = np.exp(np.random.default_rng(2).uniform(-2.0, 2.0, 64))
    case = wr.Case(
        block=wr.Block(depth="0.5 m", density="2400 kg/m^3"),
        run=wr.Times(duration="2 s"),
        sweep=wr.Sweep(
            {
                "block.height": [f"{each!r} m" for each in height.tolist()],
                "block.width": [f"{each!r} m" for each in (height * np.tan(angle)).tolist()],
                "contact.friction": (np.tan(angle) * (1.0 + 1e-9)).tolist(),
                "start.rotation_ratio": np.random.default_rng(3).uniform(-0.99, 0.99, 64).tolist(),
            }
        ),
    ).judged
    lane_set = expand_lanes(case)
    assert stays_inside(lane_set.lanes, lane_set.motions)
    found = run_batch("housner", lane_set.lanes, lane_set.motions, SampleTimes(2.0))
    assert found.count(Status.OUTSIDE_MODEL) == 0
    t = lane_set.lanes.width / lane_set.lanes.height
    assert (found["friction_needed"] < t).all()
    struck = (found["impact_count"] > 0) & (np.cos(angle) > 2.0 / 3.0)
    assert 20 < struck.sum() < 64
    expected = 3.0 * t / (4.0 + t**2)
    np.testing.assert_allclose(found["friction_needed"][struck], expected[struck], rtol=1e-9)
