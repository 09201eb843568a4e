"""Assemblies in programs of others beside ours: collapse loads, errors of a motion, cost.

Collapse loads are found as an experimenter would: the base accelerates to a load within a second
and holds it for two; what has moved by then by `FAR` has collapsed. Loads that have to come out are
known by limit analysis. The motion is that of a wall of 33 blocks under a sine, which slides and
rocks and does not fall. Its error is the largest distance of any block, at any sample, from where
`assembly` has it at an eighth of its finest step here.

MuJoCo and Bullet run one scene after the other; ours runs as many lanes as a pack has, with loads
and amplitudes spread a little, and its cost is that of a lane of many. Building a scene does not
count, nor does compiling.

In space the wall has 60 bricks, and the sine comes at an angle to it. The walls whose collapse is
looked for are pushed along their plane and out of it. Lanes run one by one there.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines.assembly import Assembly as Engine
from warprock.measure.bench import in_space
from warprock.model import patterns
from warprock.model.assembly import Assemblies, Assembly, Piece, assemble
from warprock.model.lanes import Lanes
from warprock.model.motion import (
    Control,
    GroundMotions,
    HarmonicMotions,
    PlanarMotions,
    SpatialMotions,
    Waveform,
    harmonic_motions,
    no_motion,
)
from warprock.model.record_motion import RecordMotions
from warprock.model.response import SampleTimes
from warprock.model.solids import SpatialAssembly, assemble_solids
from warprock.programs.scene import PeerRun, peer_scenes
from warprock.programs.table import PROGRAMS, adapter_of, run_program
from warprock.settings.engines import AssemblySettings
from warprock.settings.programs import BulletSettings, MujocoSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

FAR = 0.02
"""Displacement of a block from which an assembly has collapsed [m]."""
RISE, HOLD = 1.0, 2.0
"""Time in which a load rises, and for which it stays [s]."""
LOW, HIGH, CLOSE = 0.7, 1.2, 0.01
"""Loads between which a collapse is looked for, and how closely, over the expected one."""
PACK, ONE_BY_ONE = 32, 4
"""Lanes of ours at once: side by side in the plane, one after the other in space."""
SPREAD = 0.05
"""Difference of their loads, over the largest."""
SHAKE, FREQUENCY, SHAKEN = 0.8, 2.0, 1.0
"""Amplitude / g and frequency [Hz] of one cycle of a sine, and how long it is followed [s]."""
THICK = 0.3
"""Thickness of walls in space [m]."""
ASKEW = math.radians(10.0)
"""Angle of the sine to the wall in space: across it the wall does not fall."""
SAMPLE = 0.01
"""Time between two looks at the motion [s]."""
FINER = 8

STEPS = (1.6e-2, 4e-3, 1e-3)
RATES = (500.0, 1000.0, 2000.0)
"""Time steps of ours [s], and steps a second of the programs."""

PEERS: dict[str, Any] = {
    "mujoco": MujocoSettings(impedance=0.99, damping_ratio=8.0),
    "bullet": BulletSettings(iterations=200),
}
"""Programs with the settings that served the wall best of those tried: of MuJoCo impedances of 0.9
to 0.9999, damping ratios of 1 to 8 and its pass against slip, of Bullet 50 and 200 sweeps."""


@dataclasses.dataclass(frozen=True)
class Scene:
    """An assembly whose collapse load is known.

    Attributes:
        name: What it is called in tables.
        kind: The assembly.
        low, high: Sideways load between which it collapses [g].
        direction: In space, to which the load pushes, from +x towards +y [rad].
    """

    name: str
    kind: Assembly
    low: float
    high: float
    direction: float = 0.0


def bench_scenes() -> list[Scene]:
    """Oppenheim's arch, twelve drums, and wall 1 of Ferris and Tin-Loi (2001)."""

    def built(pieces: list[Piece], friction: float) -> Assembly:
        return assemble(pieces, depth=1.0, density=2000.0, friction=friction)

    arch = built(patterns.arch(10.0, 1.5, math.radians(157.5), 7), 100.0)
    drums = built(patterns.column(1.0, 0.5, 12), 0.7)
    wall = built(patterns.wall(0.4, 0.175, 5, 6, whole_first=False), 0.65)
    return [
        Scene("arch", arch, 0.3736, 0.3736),
        Scene("drums", drums, 1.0 / 6.0, 1.0 / 6.0),
        Scene("wall", wall, 0.6399, 0.64286),
    ]


def bench_scenes_in_space() -> list[Scene]:
    """Wall 1 of Ferris and Tin-Loi (2001) extruded, and the same out of its plane."""
    wall = _solid_wall(6, whole_first=False)
    return [
        # The plane's load and the outer bound of limit analysis in space.
        Scene("wall", wall, 0.6399, 0.64735),
        # It falls over its edge: thickness over height.
        Scene("across", wall, THICK / 1.05, THICK / 1.05, 0.5 * math.pi),
    ]


def _solid_wall(courses: int, *, whole_first: bool) -> SpatialAssembly:
    pieces = patterns.wall(0.4, 0.175, 5, courses, whole_first=whole_first)
    return assemble_solids(patterns.extruded(pieces, THICK), density=2000.0, friction=0.65)


def run_assembly_bench(
    report: Callable[[str], None] | None = None,
    *,
    space: bool = False,
) -> dict[str, Any]:
    """Measures assemblies.

    Args:
        report: Called with what is about to be measured.
        space: Whether walls lie in space.

    Returns:
        rows, one an engine or program and step: engine, step_ms, the collapse load of each scene
        [g], error_mm and moved_mm of the wall's motion, cpu_ms (of a lane's second of it);
        cheaper (how many times, by `cheaper_than`); expected (collapse loads by limit analysis,
        by scene); missing (what is not installed).
    """
    scenes = bench_scenes_in_space() if space else bench_scenes()
    wall: Assembly = _solid_wall(11, whole_first=True) if space else scenes[-1].kind
    at_once = ONE_BY_ONE if space else PACK
    exact, _ = _own_motion(wall, min(STEPS) / FINER, 1)
    rows = []
    for step in STEPS:
        if report is not None:
            report(f"bench assembly: assembly at {1e3 * step:g} ms")
        _own_motion(wall, step, at_once)
        path, cpu = _own_motion(wall, step, at_once)
        loads = {each.name: _collapse(each, _own_moves(each, step), at_once) for each in scenes}
        rows.append(_row("assembly", step, loads, path, exact, cpu))
    missing = []
    for name, settings in PEERS.items():
        if not PROGRAMS[name].installed:
            missing.append(f"{name} is not installed; {PROGRAMS[name].install} installs it")
            continue
        for rate in RATES:
            if report is not None:
                report(f"bench assembly: {name} at {1e3 / rate:g} ms")
            own = dataclasses.replace(settings, steps_per_second=rate)
            path, cpu = _peer_motion(name, wall, own)
            loads = {each.name: _collapse(each, _peer_moves(each, name, own), 1) for each in scenes}
            rows.append(_row(name, 1.0 / rate, loads, path, exact, cpu))
    expected = {each.name: [each.low, each.high] for each in scenes}
    return {
        "rows": rows, "cheaper": cheaper_than(rows), "expected": expected, "missing": missing,
    }  # fmt: skip


def cheaper_than(rows: list[dict[str, Any]]) -> dict[str, float]:
    """How many times a lane of ours is cheaper than a program at an error that is not larger.

    Of every run of a program, by the cheapest run of ours that errs no more; the least of these.
    """
    found: dict[str, float] = {}
    ours = [row for row in rows if row["engine"] == "assembly"]
    for row in rows:
        able = [own["cpu_ms"] for own in ours if own["error_mm"] <= row["error_mm"]]
        if row["engine"] != "assembly" and able:
            times = row["cpu_ms"] / min(able)
            found[row["engine"]] = min(times, found.get(row["engine"], math.inf))
    return found


def _row(
    name: str, step: float, loads: dict[str, float], path: Array, exact: Array, cpu: float
) -> dict[str, Any]:
    off = np.linalg.norm(path - exact, axis=-1)
    moved = np.linalg.norm(path - path[0], axis=-1)
    return {
        "engine": name,
        "step_ms": 1e3 * step,
        **{f"{scene}_load_g": load for scene, load in loads.items()},
        "error_mm": 1e3 * float(off.max()),
        "moved_mm": 1e3 * float(moved.max()),
        "cpu_ms": 1e3 * cpu / SHAKEN,
    }


def lanes_of(kind: Assembly, count: int) -> Lanes:
    """So many lanes of one assembly."""
    width, height = kind.size[0], kind.size[-1]
    mass = kind.mass[~kind.fixed].sum()
    nothing, one = np.zeros(count), np.ones(count)
    lanes = Lanes(
        width=width * one,
        height=height * one,
        depth=kind.depth * one,
        density=mass / (width * height * kind.depth) * one,
        friction=float(kind.joints.friction.max()) * one,
        chamfer=nothing,
        offset=nothing,
        rotation_start=nothing,
        angular_restitution=nothing,
        assembly=Assemblies((kind,), np.zeros(count, dtype=np.intp)),
    )
    return in_space(lanes) if kind.spatial else lanes


def towards(kind: Assembly, motions: PlanarMotions, angle: float) -> GroundMotions:
    """Motions along x; for an assembly in space at an angle to x [rad]."""
    if not kind.spatial:
        return motions
    parts = (np.full(motions.lane_count, f(angle)) for f in (np.cos, np.sin))
    x, y = (motions.scaled(part) for part in parts)
    return SpatialMotions(x, y, no_motion(motions))


def sines(size: Array, frequency: float) -> HarmonicMotions:
    """One cycle of a sine of each acceleration [m/s^2] at a frequency [Hz]."""
    same = np.ones(len(size))
    control = [Control.ACCELERATION] * len(size)
    return harmonic_motions(
        Waveform.SINE, control, size, frequency * same, 0.0 * same, same / frequency
    )


def _shakes(kind: Assembly, count: int) -> GroundMotions:
    """The sine, and somewhat larger ones beside it."""
    size = SHAKE * GRAVITY * np.linspace(1.0, 1.0 + SPREAD, count)
    return towards(kind, sines(size, FREQUENCY), ASKEW)


def pushes(loads: Array) -> RecordMotions:
    """Bases whose acceleration to -x rises within `RISE` to loads [g] and stays, shape [lane]."""
    count, lanes = math.ceil((RISE + HOLD) / RISE) + 2, len(loads)
    acceleration = np.minimum(np.arange(count, dtype=np.float64), 1.0)
    mean = 0.5 * RISE * (acceleration[1:] + acceleration[:-1])
    return RecordMotions(
        start=np.zeros(lanes),
        scale=-GRAVITY * loads,
        offset=np.zeros(lanes, dtype=np.int32),
        count=np.full(lanes, count, dtype=np.int32),
        interval=np.full(lanes, RISE),
        velocity_step_start=np.zeros(lanes),
        velocity_step_stop=np.zeros(lanes),
        pool_acceleration=acceleration,
        pool_slope=np.append(np.diff(acceleration) / RISE, 0.0),
        pool_velocity=np.concatenate([[0.0], np.cumsum(mean)]),
    )


Moves = Callable[[Assembly, Array], Array]
"""How far blocks of an assembly move under loads [g]: displacement [m], shape [load]."""


def _collapse(scene: Scene, moves: Moves, at_once: int) -> float:
    """The load at which a scene collapses [g], by loads that are tried so many at once."""
    middle = 0.5 * (scene.low + scene.high)
    low, high = LOW * middle, HIGH * middle
    while high - low > CLOSE * middle:
        loads = np.linspace(low, high, at_once + 2)
        fell = moves(scene.kind, loads[1:-1]) > FAR
        first = int(np.argmax(fell)) if fell.any() else at_once
        low, high = float(loads[first]), float(loads[first + 1])
    return 0.5 * (low + high)


def _own_moves(scene: Scene, step: float) -> Moves:
    engine = Engine(settings=AssemblySettings(time_step=step))

    def moves(kind: Assembly, loads: Array) -> Array:
        motions = towards(kind, pushes(loads), scene.direction)
        found = engine.run(lanes_of(kind, len(loads)), motions, SampleTimes(RISE + HOLD))
        return np.asarray(found["peak_displacement"])

    return moves


def _peer_moves(scene: Scene, name: str, settings: Any) -> Moves:
    def moves(kind: Assembly, loads: Array) -> Array:
        lanes, times = lanes_of(kind, len(loads)), SampleTimes(RISE + HOLD)
        motions = towards(kind, pushes(loads), scene.direction)
        found = run_program(name, lanes, motions, times, settings).response
        return np.asarray(found["peak_displacement"])

    return moves


def _own_motion(kind: Assembly, step: float, lanes: int) -> tuple[Array, float]:
    """Path of the first lane's blocks [m], [sample, block, axis], and CPU time of a lane [s]."""
    engine = Engine(settings=AssemblySettings(time_step=step))
    times = SampleTimes(SHAKEN, SAMPLE, places=True)
    begin = time.process_time()
    found = engine.run(lanes_of(kind, lanes), _shakes(kind, lanes), times)
    cpu = (time.process_time() - begin) / lanes
    free = int((~kind.fixed).sum())
    axes = "xyz" if kind.spatial else "xz"
    places = np.stack([found[axis][0, :free] for axis in axes], axis=-1)
    return np.moveaxis(places, 1, 0), cpu


def _peer_motion(name: str, kind: Assembly, settings: Any) -> tuple[Array, float]:
    scenes = peer_scenes(lanes_of(kind, 1), _shakes(kind, 1), SampleTimes(SHAKEN, SAMPLE))
    runs: list[PeerRun] = adapter_of(name).run(scenes, settings)
    base = scenes[0].base
    assert base is not None
    axes = [0, 1, 2] if kind.spatial else [0, 2]
    path = runs[0].position - base.displacement(scenes[0].times)[:, None]
    return path[..., axes], runs[0].cpu_s
