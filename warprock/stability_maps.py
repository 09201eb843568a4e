"""The maps of the atlas of extremes: which lanes, at which settings, every engine is put through.

Each map has two axes that are drawn and others that are not; an axis is an input of the lanes or a
knob of the engine. The ranges are far wider than any structure: they are there to find out where
an engine stops being right, and whether it says so.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock import rocking
from warprock.engines.settings import SETTINGS
from warprock.lanes import Lanes
from warprock.motion import Control, GroundMotions, StillBase, Waveform, harmonic_motions
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

SLENDERNESS = (0.3, 20.0)
HEIGHTS = (0.05, 50.0)
"""Height / width, and height [m]."""
STARTS = (1e-6, 1e-3, 0.03, 0.2, 0.5, 0.9, 0.99, 0.9999)
"""Rotations at the start over the slenderness angle."""
STEPS = (1e-6, 0.1)
STIFFNESSES = (1e6, 1e13)
SAFETIES = (0.1, 2.0)
"""Time steps [s], contact stiffnesses per area [N/m^3], and steps over the stable one [-]."""
MASS_RATIOS = (1e-4, 1e4)
AMPLITUDES = (0.05, 5.0)
FREQUENCIES = (0.1, 50.0)
FRICTIONS = (1e-3, 10.0)
"""Upper over lower mass, base acceleration / g, frequency [Hz], friction besides none at all."""

DEPTH, DENSITY, HOLDING_FRICTION = 0.5, 2000.0, 10.0
"""Depth [m] and density [kg/m^3] of every block, and a friction that holds all of them."""
STIFFNESS_WIDTH = 0.5
"""Width [m] of the blocks of the maps of stiffness: a corner stands for half of the face."""
STACK_SLENDERNESS, STACK_STEP = 3.0, 1e-3
"""Height / width of the blocks of a stack, and the step [s] of the map of mass ratios."""
STACK_TURNS = {"both": (1.0, 1.0), "upper": (0.0, 1.0), "lower": (1.0, 0.0), "against": (1.0, -1.0)}
"""Rotations at the start of the lower and the upper block, over the lane's start."""
CYCLES = 3.0

AREA_FIELDS, POINT_FIELDS, COMPLIANCE_FIELDS = (
    ("normal_stiffness", "shear_stiffness"),
    ("contact_stiffness",),
    ("compliance",),
)
"""Settings that are a stiffness per area, a stiffness of one corner, and its inverse."""


@dataclasses.dataclass(frozen=True)
class AtlasSize:
    """How much of an atlas is run.

    Attributes:
        points: Values along an axis; of time steps at most 11, two a decade.
        steps: Most time steps of a launch; its duration is cut to them.
        duration: Longest time that a launch covers [s].
        iterations: Sweeps of the contact solver that are tried; a kernel is built for each.
    """

    points: int = 16
    steps: int = 26_000
    duration: float = 5.0
    iterations: tuple[int, ...] = (1, 10, 100, 1000)

    def along(self, ends: tuple[float, float], most: int | None = None) -> Array:
        """Values of an axis, evenly in their logarithm."""
        count = self.points if most is None else min(self.points, most)
        return np.asarray(np.geomspace(*ends, count))

    def some(self, values: tuple[float, ...]) -> Array:
        """At most half as many of some values as an axis has points, their ends among them."""
        count = min(max(2, self.points // 2), len(values))
        shown = np.linspace(0, len(values) - 1, count).round().astype(int)
        return np.array([values[at] for at in shown])


@dataclasses.dataclass(frozen=True)
class LaneGrid:
    """Lanes of a map.

    Attributes:
        lanes: The lanes.
        motions: Their ground motions.
        inputs: What sets them apart, one row a lane, units in the column names.
        free: Whether a lane's base stands still, shape [lane].
        held: Energy at the start above the flat state [J], shape [lane].
    """

    lanes: Lanes
    motions: GroundMotions
    inputs: pd.DataFrame
    free: npt.NDArray[np.bool_]
    held: Array


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
    fields = {field.name: field for field in dataclasses.fields(settings)}
    if "time_step" in fields:
        return dataclasses.replace(settings, time_step=step)
    most = fields["frames_per_second"].metadata["high"]
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


def _crossed(**axes: Iterable[Hashable]) -> pd.DataFrame:
    """One row for each set of values, the last axis the fastest."""
    values = [list(each) for each in axes.values()]
    return pd.MultiIndex.from_product(values, names=list(axes)).to_frame(index=False)


def _single_blocks(inputs: pd.DataFrame, motions: GroundMotions | None = None) -> LaneGrid:
    """Single blocks from the columns slenderness, height_m, start_ratio and friction, if given."""
    height = inputs["height_m"].to_numpy(float)
    width = height / inputs["slenderness"].to_numpy(float)
    angle = rocking.slenderness_angle(width, height)
    start = angle * inputs["start_ratio"].to_numpy(float)
    count = len(inputs)
    friction = inputs.get("friction", pd.Series(np.full(count, HOLDING_FRICTION)))
    lanes = Lanes(
        width=width,
        height=height,
        depth=np.full(count, DEPTH),
        density=np.full(count, DENSITY),
        friction=friction.to_numpy(float),
        chamfer=np.zeros(count),
        offset=np.zeros(count),
        rotation_start=start,
        angular_restitution=rocking.angular_restitution(angle),
    )
    still = motions is None
    return LaneGrid(
        lanes=lanes,
        motions=StillBase(count) if motions is None else motions,
        inputs=inputs,
        free=np.full(count, still) if still else inputs["amplitude_g"].to_numpy(float) == 0.0,
        held=rocking.energy(width, height, lanes.depth, lanes.density, start, 0.0),
    )


def _released(size: AtlasSize) -> LaneGrid:
    return _single_blocks(
        _crossed(
            slenderness=size.along(SLENDERNESS),
            height_m=size.along(HEIGHTS, max(2, size.points // 2)),
            start_ratio=size.some(STARTS),
        )
    )


def _released_evenly_wide(size: AtlasSize) -> LaneGrid:
    inputs = _crossed(
        slenderness=size.along(SLENDERNESS, 6), start_ratio=size.some((1e-3, 0.03, 0.2, 0.9))
    )
    return _single_blocks(inputs.assign(height_m=STIFFNESS_WIDTH * inputs["slenderness"]))


def _sines(inputs: pd.DataFrame) -> GroundMotions:
    """Bursts of sine from the columns amplitude_g, frequency_hz and control."""
    frequency = inputs["frequency_hz"].to_numpy(float)
    control = inputs["control"].to_numpy(str)
    rate = np.where(control == Control.DISPLACEMENT, 2.0 * np.pi * frequency, 1.0)
    return harmonic_motions(
        Waveform.SINE,
        control,
        GRAVITY * inputs["amplitude_g"].to_numpy(float) / rate**2,
        frequency,
        np.zeros(len(inputs)),
        CYCLES / frequency,
    )


def _shaken(size: AtlasSize) -> LaneGrid:
    inputs = _crossed(
        amplitude_g=size.along(AMPLITUDES),
        frequency_hz=size.along(FREQUENCIES),
        control=[str(Control.ACCELERATION), str(Control.DISPLACEMENT)],
        slenderness=size.some((0.5, 2.0, 5.0, 12.0)),
    ).assign(height_m=1.0, start_ratio=0.0)
    return _single_blocks(inputs, _sines(inputs))


def _sliding(size: AtlasSize) -> LaneGrid:
    scenes = pd.DataFrame(
        {
            "start_ratio": [0.03, 0.5, 0.9, 0.0, 0.0],
            "amplitude_g": [0.0, 0.0, 0.0, 0.5, 2.0],
            "frequency_hz": [1.0, 1.0, 1.0, 1.0, 3.0],
        }
    ).assign(control=str(Control.ACCELERATION), height_m=1.0)
    inputs = _crossed(
        friction=[0.0, *size.along(FRICTIONS)[1:]], slenderness=size.along(SLENDERNESS)
    ).merge(scenes, how="cross")
    return _single_blocks(inputs, _sines(inputs))


def _stacked(size: AtlasSize) -> LaneGrid:
    inputs = _crossed(
        mass_ratio=size.along(MASS_RATIOS, 9),
        turned=list(STACK_TURNS),
        start_ratio=size.some((0.01, 0.1, 0.2, 0.4)),
        height_m=size.some((0.05, 0.5, 5.0, 50.0)),
    )
    count = len(inputs)
    height = np.tile(inputs["height_m"].to_numpy(float)[:, None], 2)
    width = height / STACK_SLENDERNESS
    factor = np.sqrt(inputs["mass_ratio"].to_numpy(float))
    density = DENSITY * np.stack([1.0 / factor, factor], axis=1)
    turn = np.array([STACK_TURNS[name] for name in inputs["turned"]])
    start = turn * inputs["start_ratio"].to_numpy(float)[:, None] / STACK_SLENDERNESS
    lanes = Lanes(
        width=width,
        height=height,
        depth=np.full((count, 2), DEPTH),
        density=density,
        friction=np.full((count, 2), HOLDING_FRICTION),
        chamfer=np.zeros((count, 2)),
        offset=np.zeros((count, 2)),
        rotation_start=start,
        angular_restitution=np.ones(count),
    )
    free = np.full(count, True)
    return LaneGrid(lanes, StillBase(count), inputs, free, stack_energy(lanes))


def stack_energy(lanes: Lanes) -> Array:
    """Energy above the upright state of two blocks of one width let go from rest [J].

    Each block has its lower corner on the face beneath. With half sizes b and h the centre of the
    lower one is at h0 cos(t0) + b |sin(t0)|, and the upper one's
    h0 cos(t0) + h1 cos(t1) + b |sin(t1) - sin(t0)| above it.

    Args:
        lanes: Stacks of two.

    Returns:
        Shape [lane].
    """
    half = 0.5 * lanes.height
    sine, cosine = np.sin(lanes.rotation_start), np.cos(lanes.rotation_start)
    turned = np.abs(np.diff(sine, axis=1, prepend=0.0))
    drop = half * (cosine - 1.0)
    rise = drop + 0.5 * lanes.width * turned
    rise[:, 1] += rise[:, 0] + drop[:, 0]
    return np.asarray(GRAVITY * (lanes.mass * rise).sum(axis=1))


MAPS = (
    AtlasMap(
        "step",
        "free rocking, heights 0.05 to 50 m",
        "step_s",
        "slenderness",
        _released,
        _by_step,
        other_y="start_ratio",
    ),
    AtlasMap(
        "stiffness",
        "free rocking, blocks 0.5 m wide",
        "step_s",
        "stiffness_n_m3",
        _released_evenly_wide,
        _by_step_and_stiffness,
        soft=True,
    ),
    AtlasMap(
        "safety",
        "free rocking, blocks 0.5 m wide",
        "step_safety",
        "stiffness_n_m3",
        _released_evenly_wide,
        _by_safety_and_stiffness,
        soft=True,
    ),
    AtlasMap(
        "mass",
        "two blocks let go, heights 0.05 to 50 m",
        "iterations",
        "mass_ratio",
        _stacked,
        _by_iterations,
        longest=1.0,
    ),
    AtlasMap(
        "shaking",
        "sine bursts of three cycles, blocks 1 m high, default settings",
        "frequency_hz",
        "amplitude_g",
        _shaken,
        _as_it_comes,
    ),
    AtlasMap(
        "friction",
        "free rocking and sine bursts, blocks 1 m high, default settings",
        "friction",
        "slenderness",
        _sliding,
        _as_it_comes,
    ),
)
"""The maps of the atlas, in the order in which they run."""
