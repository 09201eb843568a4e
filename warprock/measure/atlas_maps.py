"""The maps of the atlas of extremes: which lanes, at which settings, every engine is put through.

Each map has two axes that are drawn and others that are not; an axis is an input of the lanes or a
knob of the engine.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Any

from warprock.measure.atlas_lanes import (
    DEPTH,
    STIFFNESS_WIDTH,
    AtlasSize,
    LaneGrid,
    release_blocks,
    release_evenly_wide,
    shaken,
    sliding,
    stack_pairs,
)
from warprock.settings.engines import SETTINGS, declared_settings

STEPS = (1e-6, 0.1)
STIFFNESSES = (1e6, 1e13)
SAFETIES = (0.1, 2.0)
"""Time steps [s], contact stiffnesses per area [N/m^3], and steps over the stable one [-]."""
STACK_STEP = 1e-3
"""Time step of the map of mass ratios [s]."""

AREA_FIELDS, POINT_FIELDS, COMPLIANCE_FIELDS = (
    ("normal_stiffness", "shear_stiffness"),
    ("contact_stiffness",),
    ("compliance",),
)
"""Settings that are a stiffness per area, a stiffness of one corner, and its inverse."""


@dataclasses.dataclass(frozen=True)
class Launch:
    """Settings that all lanes of a map run with, and the knobs that they were made from."""

    settings: Any
    knobs: Mapping[str, float]


@dataclasses.dataclass(frozen=True)
class AtlasMap:
    """One map.

    Attributes:
        name: Name in files.
        title: What is put through what, in words.
        x: Column across.
        y: Column up.
        lanes: Its lanes for a size.
        launches: Its launches for an engine; none where the engine lacks the knobs.
        other_y: A column that is drawn up in a second figure.
        soft: Whether its contacts are soft, so that blocks need not stand where rigid ones do.
        runs_longer: Its steps over those of the size: it has few lanes.
        longest: Longest time that it is run for [s], the size's if that is shorter.
    """

    name: str
    title: str
    x: str
    y: str
    lanes: Callable[[AtlasSize], LaneGrid]
    launches: Callable[[str, AtlasSize], list[Launch]]
    other_y: str | None = None
    soft: bool = False
    runs_longer: int = 1
    longest: float = math.inf


LABELS = {
    "step_s": "time step [s]",
    "slenderness": "height / width [-]",
    "start_ratio": "rotation at the start / slenderness angle [-]",
    "stiffness_n_m3": "contact stiffness per area [N/m$^3$]",
    "step_safety": "time step / largest stable one [-]",
    "mass_ratio": "mass of the upper / lower block [-]",
    "iterations": "sweeps of the contact solver [-]",
    "frequency_hz": "frequency of the base [Hz]",
    "amplitude_g": "base acceleration amplitude [g]",
    "friction": "friction coefficient [-]",
}
"""Columns of the maps as axis labels."""


def at_step(settings: Any, step: float) -> Any:
    """Settings with a time step [s], within their bounds, whichever way they state it."""
    declared = declared_settings(type(settings))
    if "time_step" in declared:
        return dataclasses.replace(settings, time_step=step)
    most = declared["frames_per_second"].high
    parts = math.ceil(1.0 / (step * most) - 1e-9)
    frames = min(1.0 / (step * parts), most)
    return dataclasses.replace(settings, frames_per_second=frames, substeps=parts - 1)


def at_stiffness(settings: Any, stiffness: float) -> Any:
    """Settings with a contact stiffness [N/m^3]; None where there is none to set.

    A setting of one corner takes half of the face of the blocks of the maps of stiffness.
    """
    corner = stiffness * 0.5 * STIFFNESS_WIDTH * DEPTH
    names = {field.name for field in dataclasses.fields(settings)}
    values = {name: stiffness for name in AREA_FIELDS if name in names}
    values |= {name: corner for name in POINT_FIELDS if name in names}
    values |= {name: 1.0 / corner for name in COMPLIANCE_FIELDS if name in names}
    return dataclasses.replace(settings, **values) if values else None


def has_knob(engine: str, name: str) -> bool:
    """Whether an engine has a setting or a time step of that name."""
    return hasattr(SETTINGS[engine](), name)


def _by_step(engine: str, size: AtlasSize) -> list[Launch]:
    settings = SETTINGS[engine]()
    if not has_knob(engine, "time_step"):
        return [Launch(settings, {"step_s": math.nan})]
    steps = size.along(STEPS, 11)
    return [Launch(at_step(settings, step), {"step_s": step}) for step in steps]


def _by_step_and_stiffness(engine: str, size: AtlasSize) -> list[Launch]:
    settings = SETTINGS[engine]()
    if at_stiffness(settings, 1e9) is None:
        return []
    return [
        Launch(
            at_stiffness(at_step(settings, step), stiffness),
            {"step_s": step, "stiffness_n_m3": stiffness},
        )
        for step in size.along(STEPS, 11)
        for stiffness in size.along(STIFFNESSES, 8)
    ]


def _by_safety_and_stiffness(engine: str, size: AtlasSize) -> list[Launch]:
    if not has_knob(engine, "step_safety"):
        return []
    settings = at_step(SETTINGS[engine](), STEPS[1])
    return [
        Launch(
            at_stiffness(dataclasses.replace(settings, step_safety=safety), stiffness),
            {"step_safety": safety, "stiffness_n_m3": stiffness},
        )
        for safety in size.along(SAFETIES, 14)
        for stiffness in size.along(STIFFNESSES, 8)
    ]


def _by_iterations(engine: str, size: AtlasSize) -> list[Launch]:
    settings = SETTINGS[engine]()
    if has_knob(engine, "time_step"):
        settings = at_step(settings, STACK_STEP)
    if not has_knob(engine, "iterations"):
        return [Launch(settings, {"iterations": math.nan})]
    return [
        Launch(dataclasses.replace(settings, iterations=count), {"iterations": float(count)})
        for count in size.iterations
    ]


def _as_it_comes(engine: str, _size: AtlasSize) -> list[Launch]:
    return [Launch(SETTINGS[engine](), {})]


MAPS = (
    AtlasMap(
        "step",
        "free rocking, heights 0.05 to 50 m",
        "step_s",
        "slenderness",
        release_blocks,
        _by_step,
        other_y="start_ratio",
    ),
    AtlasMap(
        "stiffness",
        "free rocking, blocks 0.5 m wide",
        "step_s",
        "stiffness_n_m3",
        release_evenly_wide,
        _by_step_and_stiffness,
        soft=True,
        runs_longer=8,
    ),
    AtlasMap(
        "safety",
        "free rocking, blocks 0.5 m wide",
        "step_safety",
        "stiffness_n_m3",
        release_evenly_wide,
        _by_safety_and_stiffness,
        soft=True,
    ),
    AtlasMap(
        "mass",
        "two blocks let go, heights 0.05 to 50 m",
        "iterations",
        "mass_ratio",
        stack_pairs,
        _by_iterations,
        longest=1.0,
    ),
    AtlasMap(
        "shaking",
        "sine bursts of three cycles, blocks 1 m high, default settings",
        "frequency_hz",
        "amplitude_g",
        shaken,
        _as_it_comes,
    ),
    AtlasMap(
        "friction",
        "free rocking and sine bursts, blocks 1 m high, default settings",
        "friction",
        "slenderness",
        sliding,
        _as_it_comes,
    ),
)
"""The maps of the atlas, in the order in which they run."""
