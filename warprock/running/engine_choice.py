"""Which engine runs a case if none is named, and why.

The rule, in this order:

0. `assembly` for assemblies of many blocks.
1. `event` for stacks and for blocks in space; for stacks that it declines `impulse`, or `dem`.
2. `event` where a block slides before it rocks (friction < tan(slenderness angle)).
3. `housner` where the case prescribes how much angular velocity an impact leaves: that is its law;
   contact engines have one of their own, and `event` puts the prescribed one in its place.
4. `housner` runs on the lanes, on 1,000 spread evenly over a larger case. If one of them is outside
   its model, because the block would slide or its base would have to pull it, `event`. A box that
   is let go from rest on a still base cannot leave it: none runs.
5. Else `housner`: it has no error of a time step, and is the cheapest.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.case.case import Case
from warprock.case.lanes import expand_lanes
from warprock.engines import ENGINES, engine_class, preferred_engines, reference_engine
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, MotionKind
from warprock.model.response import SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import on_springs

LANES_JUDGED = 1000
"""Lanes up to which all are run: a second or two of work, even of long records."""


@dataclasses.dataclass(frozen=True)
class EngineChoice:
    """An engine, chosen by the rule of this file.

    Attributes:
        engine: Its name.
        why: Why, in words; empty where it was named.
        outside: Lanes outside the model of `housner`, of those that were tried.
        planar_block: Whether it is for one block in the plane, which `housner` might run.
        named: Whether it was named, not chosen.
    """

    engine: str
    why: str = ""
    outside: int = 0
    planar_block: bool = True
    named: bool = False

    @property
    def surprises(self) -> bool:
        """Whether a single block is run by another engine than `housner` though none was named."""
        return self.planar_block and not self.named and engine_class(self.engine).order is not None

    @property
    def text(self) -> str:
        """The choice in one line."""
        return f"engine {self.engine}: {self.why}"


def slides(engine: str) -> bool:
    """Whether an engine lets blocks slide."""
    return engine_class(engine).slides


def choose_engine(case: Case, factors: Sequence[float] = (1.0,)) -> EngineChoice:
    """The engine of a case where none is named; see the head of this file.

    Args:
        case: The case.
        factors: On its motion: those at which it will run.

    Raises:
        InputError: A combination of values in the case that no engine could use.
    """
    lanes = lanes_to_try(case.lane_count)
    lane_set = expand_lanes(case, lanes)
    scene = lane_set.scene
    analytical = reference_engine()
    contact, *others = (each for each in preferred_engines() if engine_class(each).slides)
    if scene.assembly:
        able = (name for name in ENGINES if engine_class(name).assemblies)
        runs_it = next(name for name in able if not on_springs(name))
        return EngineChoice(runs_it, "it is an assembly of many blocks", planar_block=False)
    if scene.spatial:
        return EngineChoice(contact, "the blocks move in space", planar_block=False)
    if scene.stacked:
        declined = engine_class(contact).supports(scene)
        if declined is not None:
            able = (each for each in others if engine_class(each).supports(scene) is None)
            return EngineChoice(next(able, others[0]), declined, planar_block=False)
        return EngineChoice(contact, "it is a stack", planar_block=False)
    declined = engine_class(analytical).supports(scene)
    if declined is not None:
        return EngineChoice(contact, declined)
    declined = engine_class(contact).supports(scene)
    if declined is not None:
        return EngineChoice(analytical, declined)
    if scene.restitution_given:
        why = "the case prescribes what an impact leaves (contact.angular_restitution)"
        return EngineChoice(analytical, why)
    runs = np.array(lanes_to_try(len(lanes) * len(factors)))
    chosen, factor = runs // len(factors), np.asarray(factors)[runs % len(factors)]
    ends = np.broadcast_to(lane_set.ends, len(lanes))[chosen]
    outside = outside_model(
        lane_set.lanes.take(chosen), lane_set.motions.take(chosen).scaled(factor), ends
    )
    whole = case.lane_count * len(factors)
    part = "its lane" if whole == 1 else f"{outside or 'none'} of {len(runs)} lanes"
    if len(runs) < whole:
        part += f", spread over {whole:,},"
    if outside:
        why = f"in {part} Housner's block would slide or its base would have to pull it"
        return EngineChoice(contact, why, outside)
    would = "neither slide nor" if whole == 1 else "slide or"
    why = f"in {part} Housner's block would {would} be pulled"
    return EngineChoice(analytical, why, outside)


def another_engine(ran: str, scene: SceneKind) -> str | None:
    """An engine to compare a run with; None if no other can run its scene.

    If the run's engine locates events, the most preferred engine that steps over them is taken. If
    it steps over them, one that locates them. If there is no such engine, the most preferred other.
    """
    others = [name for name in preferred_engines() if name != ran]
    able = [name for name in others if engine_class(name).supports(scene) is None]
    located = engine_class(ran).locates_events
    return min(able, key=lambda name: engine_class(name).locates_events == located, default=None)


def outside_model(lanes: Lanes, motions: GroundMotions, ends: npt.NDArray[np.float64]) -> int:
    """Counts single blocks that would slide, or be pulled down, in Housner's model.

    Args:
        lanes: The blocks.
        motions: Their ground motions.
        ends: When their runs end [s], shape [lane].
    """
    if stays_inside(lanes, motions):
        return 0
    from warprock.running.batch import run_batch
    from warprock.running.devices import start_warp

    start_warp()
    found = 0
    for end in sorted(set(ends.tolist())):
        alike = np.flatnonzero(ends == end)
        batch = lanes.take(alike), motions.take(alike), SampleTimes(end)
        found += run_batch(reference_engine(), *batch).count(Status.OUTSIDE_MODEL)
    return found


def stays_inside(lanes: Lanes, motions: GroundMotions) -> bool:
    """Whether no lane can leave Housner's model: boxes that are let go from rest on a still base.

    They have the friction that `housner` asks for, at least tan(alpha), and its restitution, above
    0. With phi the angle from the balance, S = sin(phi), C = cos(phi) and c = cos(phi) where the
    swing began, 1 >= c >= C, Housner's equation and its energy give the force over the weight

        along (3/4) S (3 C - 2 c),    upwards 1 - (3/4) S^2 - (3/2) C (c - C) >= ((3 C - 1) / 2)^2.

    Their ratio falls with c. At c = C it is 3 t / (4 + t^2), t = tan(phi), and that of an impact is
    the same at phi = alpha. At c = 1 it is -3 S (3 C - 2) / (3 C - 1)^2 where it is negative. Both
    stay below t in size up to 55.3 degrees; the restitution is above 0 up to 54.7.
    """
    boxes = lanes.body is None and lanes.hold is None and lanes.release is None
    return boxes and motions.kind == MotionKind.STILL and not lanes.restitution_given


def lanes_to_try(count: int) -> range:
    """Numbers of the lanes that are tried: all, or `LANES_JUDGED` of them at even distances.

    The distance and the number of lanes have no common divisor, so that every value of every axis
    of a sweep occurs.
    """
    step = max(1, -(-count // LANES_JUDGED))
    while math.gcd(step, count) > 1:
        step += 1
    return range(0, count, step)
