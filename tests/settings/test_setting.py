"""Bare numbers with bounds, and the settings that are made of them."""

from __future__ import annotations

import math

import pytest

from warprock.settings.engines import (
    DirectSettings,
    FramedSettings,
    ImpulseSettings,
    XpbdSettings,
    build_settings,
    declared_settings,
)
from warprock.settings.setting import SettingKey

STEP = SettingKey("a step", 1e-6, 0.1, "s")
RATE = SettingKey("frames", 1.0, 1e5, "1/s")
STIFFNESS = SettingKey("a stiffness", 1e5, 1e14, "N/m^3")
SWEEPS = SettingKey("sweeps", 1, 1000)
LIMIT = SettingKey("a limit", 0.0, math.inf, low_open=True)


@pytest.mark.parametrize(
    ("key", "got", "value"),
    [
        (STEP, 0.1, 0.1),
        (STEP, 1e-6, 1e-6),
        (STEP, "1e-3 s", 1e-3),
        (STEP, "5 ms", 5e-3),
        (RATE, "0.24 kHz", 240.0),
        (STIFFNESS, "2 MN/m^3", 2e6),
        (SWEEPS, 1000, 1000),
        (LIMIT, 3, 3.0),
    ],
)
def test_values_within_their_bounds_are_read(key: SettingKey, got: float, value: float):
    read = key.value(got)
    assert read == value
    assert isinstance(read, int if key.whole else float)


@pytest.mark.parametrize(
    ("key", "got", "words"),
    [
        (STEP, 0.2, "must be from 1e-06 to 0.1 s"),
        (STEP, math.nan, "must be from 1e-06 to 0.1 s"),
        (STEP, "0.1", "must be from 1e-06 to 0.1 s, a number"),
        (STEP, "1 m", "must be from 1e-06 to 0.1 s, in s, ms, min"),
        (STEP, "1 s", "must be from 1e-06 to 0.1 s"),
        (SWEEPS, "20 s", "must be from 1 to 1000, without a unit"),
        (STEP, True, "must be from 1e-06 to 0.1 s, a number"),
        (SWEEPS, 0, "must be from 1 to 1000"),
        (SWEEPS, 10**400, "must be from 1 to 1000"),
        (SWEEPS, 2.0, "must be from 1 to 1000, a whole number"),
        (LIMIT, 0.0, "must be more than 0"),
        (LIMIT, math.inf, "must be more than 0"),
        (LIMIT, 10**400, "must be more than 0"),
    ],
)
def test_others_are_refused_with_their_bounds(key: SettingKey, got: object, words: str):
    with pytest.raises(ValueError, match=f"^{words}$"):
        key.value(got)


@pytest.mark.parametrize("settings", [ImpulseSettings, DirectSettings, XpbdSettings])
def test_framed_engines_share_their_frames(settings: type[FramedSettings]):
    shared, own = declared_settings(FramedSettings), declared_settings(settings)
    assert {name: own[name] for name in shared} == shared
    made = settings(frames_per_second=100.0, substeps=9)
    assert made.time_step == 1e-3
    assert made.halved().time_step == 5e-4
    assert made.with_step_scaled(3.0).time_step == pytest.approx(3e-3, rel=1e-15)


def test_settings_that_are_made_in_python_are_not_judged():
    # Engines refine a step below what a case may ask for.
    assert ImpulseSettings(substeps=10**6).substeps == 10**6
    with pytest.raises(ValueError, match="from 0 to 10000"):
        build_settings("impulse", {"substeps": 10**6}, "test")
