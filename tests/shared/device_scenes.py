"""Every scene that chooses a kernel, for tests of devices that no other test runs on.

`python -m tests.shared.device_scenes` compiles the kernels of all engines, scenes, kinds of motion
and precisions for a GPU, which needs none, and prints what each takes.
"""

from __future__ import annotations

import argparse
import dataclasses
import functools
import itertools
import pathlib
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import warp as wp

from tests.shared import planar_bodies, space_bodies, stack_bodies
from tests.shared.cubin import Resources, resources_of
from tests.shared.kinds import lanes_of, motions_of, planar_motions
from warprock.engines import ENGINES, engine_class
from warprock.engines.launching import Form, Target
from warprock.kernels.launch.instance import BYTES
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, MotionKind, UprightMotions
from warprock.model.pose import quaternion
from warprock.model.release import Release
from warprock.model.scene import SceneKind, scene_kind
from warprock.running.devices import start_warp
from warprock.settings.engines import SETTINGS

STARTS = np.array([0.0, 0.05, 0.0, -0.08])
"""Rotations from which bodies are let go [rad]; two of them stand."""

ARCHITECTURE = 80
"""Compute capability that kernels are compiled for: 8.0, and every later one runs its PTX."""


def _restitution_given() -> Lanes:
    lanes = lanes_of("block")
    return dataclasses.replace(
        lanes, restitution_given=True, angular_restitution=np.full(lanes.lane_count, 0.9)
    )


def _body_in_space() -> Lanes:
    return space_bodies.body_lanes(
        space_bodies.ROCK_POINTS, space_bodies.ROCK_TENSOR, 4, rotation_start=STARTS, friction=0.8
    )


def _thrown(lanes: Lanes) -> Lanes:
    """The lanes, thrown with a spin in some attitude from twice their height."""
    count = lanes.lane_count
    turn = np.linspace(0.2, 0.8, count)
    release = Release(
        velocity=np.tile((0.4, 0.1, 0.0), (count, 1)),
        angular_velocity=np.tile((1.0, 3.0, 0.5), (count, 1)),
        attitude=quaternion(np.stack([0.3 * turn, turn, 0.5 * turn], axis=-1)),
        height=2.0 * lanes.height,
    )
    return dataclasses.replace(lanes, release=release)


LANES: dict[str, Callable[[], Lanes]] = {
    "block": lambda: lanes_of("block"),
    "block, restitution prescribed": _restitution_given,
    "block, base upwards": lambda: lanes_of("block"),
    "body": lambda: planar_bodies.body_lanes(planar_bodies.STEPPED, STARTS, friction=0.8),
    "body, base upwards": lambda: planar_bodies.body_lanes(
        planar_bodies.STEPPED, STARTS, friction=0.8
    ),
    "stack": lambda: lanes_of("stack"),
    "stack, base upwards": lambda: lanes_of("stack"),
    "stack with a body, base upwards": lambda: stack_bodies.with_body(lanes_of("stack"), 1),
    "stack with a body": lambda: stack_bodies.with_body(lanes_of("stack"), 1),
    "block in space": lambda: lanes_of("block in space"),
    "thrown block in space": lambda: _thrown(lanes_of("block in space")),
    "body in space": _body_in_space,
    "stack in space": lambda: lanes_of("stack in space"),
}
"""Lanes by the name of a scene, four of each."""

MOTIONS = tuple(MotionKind)


@dataclasses.dataclass(frozen=True)
class Run:
    """What chooses a kernel: an engine and its settings, lanes and their motions."""

    engine: str
    scene: str
    kind: MotionKind
    settings: Any = None

    @property
    def name(self) -> str:
        """What it is, in words."""
        box = ", box friction" if self.settings is not None else ""
        return f"{self.engine}: {self.scene}{box}, {self.kind.value}"

    def batch(self) -> tuple[Lanes, GroundMotions]:
        """Its lanes and their motions."""
        lanes = LANES[self.scene]()
        if "upwards" not in self.scene:
            return lanes, motions_of(self.kind, lanes)
        along = planar_motions(self.kind, lanes.lane_count)
        return lanes, UprightMotions(along, along)

    @property
    def supported(self) -> bool:
        """Whether the engine runs the scene."""
        return engine_class(self.engine).supports(_kind_of(self.scene, self.kind)) is None

    def module(
        self, device: str = "cuda:0", precision: str = "float64", form: Form | None = None
    ) -> str:
        """Name of the Warp module that holds its kernel, which need not be built."""
        lanes, motions = self.batch()
        engine = engine_class(self.engine)(self.settings, Target(precision, device, form))
        return engine.module_of(engine.kernel_lanes(lanes, motions), motions).__name__


@functools.cache
def _kind_of(scene: str, kind: MotionKind) -> SceneKind:
    """What a scene under a kind of motion asks of an engine."""
    lanes, motions = Run("", scene, kind).batch()
    return scene_kind(lanes, motions, restitution_given="restitution" in scene)


def runs(kinds: tuple[MotionKind, ...] = MOTIONS) -> Iterator[Run]:
    """All runs that engines do not decline, with friction as a box where that is a kernel too."""
    for name in ENGINES:
        for scene in LANES:
            for kind in kinds:
                if not (found := Run(name, scene, kind)).supported:
                    continue
                yield found
                if "in space" in scene and hasattr(SETTINGS[name], "friction_box"):
                    yield dataclasses.replace(found, settings=SETTINGS[name](friction_box=True))


def compiled(module: str, folder: pathlib.Path, *, to_ptx: bool = True) -> pathlib.Path:
    """The file that Warp makes of a module for a GPU: PTX, or machine code, which takes longer."""
    start_warp()
    return wp.compile_aot_module(
        module, arch=ARCHITECTURE, module_dir=folder, use_ptx=to_ptx, strip_hash=False
    )[0]


def measured(module: str) -> tuple[float, Resources]:
    """Seconds that Warp takes to build a module for a GPU, and what its kernel takes of one."""
    with tempfile.TemporaryDirectory() as folder:
        begin = time.process_time()
        code = compiled(module, pathlib.Path(folder), to_ptx=False).read_bytes()
        return time.process_time() - begin, resources_of(code)


def main() -> None:
    """Prints one line a kernel: CPU seconds, registers and bytes of local memory a thread."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("words", nargs="*", help="only runs whose names have all of these words")
    parser.add_argument("--precisions", nargs="+", default=list(BYTES), choices=list(BYTES))
    asked = parser.parse_args()
    seen, total = set[str](), 0.0
    asked_runs = (run for run in runs() if all(word in run.name for word in asked.words))
    for run, precision in itertools.product(asked_runs, asked.precisions):
        if (module := run.module(precision=precision)) in seen:
            continue
        seen.add(module)
        took, found = measured(module)
        total += took
        print(
            f"{run.name}, {precision}: {took:.1f} s, {found.registers} registers, "
            f"{found.local_memory} bytes of local memory",
            flush=True,
        )
    print(f"{len(seen)} kernels, {total:.0f} s")


if __name__ == "__main__":
    main()
