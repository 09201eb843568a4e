"""Which engine is taken where none is named, and which one a run is held against."""

from __future__ import annotations

import pytest

from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import ENGINES, engine_class, preferred_engines, reference_engine
from warprock.running.engine_choice import another_engine


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
