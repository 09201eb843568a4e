"""The programs of others by name: where each is, and a run of lanes in it.

None is imported until it is asked to run. Names are those that `warprock compare` takes beside the
engines; a program that is not installed is one line that says how to install it.
"""

from __future__ import annotations

import dataclasses
import importlib
import importlib.util
from collections.abc import Callable
from typing import Any

from warprock.errors import DeclinedError
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes
from warprock.programs.assembly_scene import assembly_response
from warprock.programs.response import peer_response
from warprock.programs.scene import PeerRun, peer_scenes


@dataclasses.dataclass(frozen=True)
class Program:
    """A program that we did not write.

    Attributes:
        module: Module of its adapter, which has `run`.
        packages: Packages that have to be there.
        install: The command that installs them.
        text: What it is, in one line.
        starts_moving: Whether its adapter starts blocks with velocities.
        bodies: Whether its adapter knows bodies that are no boxes, in space and in stacks.
        holds: Tables of a case by which its adapter lets a block be held.
        assemblies: Whether its adapter knows assemblies of many blocks.
        solids: Whether it knows those in space, too.
    """

    module: str
    packages: tuple[str, ...]
    install: str
    text: str
    starts_moving: bool = False
    bodies: bool = False
    holds: tuple[str, ...] = ()
    assemblies: bool = False
    solids: bool = False

    @property
    def installed(self) -> bool:
        """Whether its packages can be found; none is imported."""
        return all(self.has(package) for package in self.packages)

    def has(self, package: str) -> bool:
        """Whether a package can be found; it is not imported."""
        return importlib.util.find_spec(package) is not None


def _newton(text: str) -> Program:
    return Program(
        "warprock.programs.newton",
        ("newton",),
        'pip install "warprock"',
        text,
        assemblies=True,
    )


PROGRAMS: dict[str, Program] = {
    "mujoco": Program(
        "warprock.programs.mujoco",
        ("mujoco",),
        'pip install "warprock[mujoco]"',
        "MuJoCo: soft convex contacts, Newton's method, elliptic cones.",
        starts_moving=True,
        bodies=True,
        holds=("transverse_wall", "tie", "top_load", "frame"),
        assemblies=True,
        solids=True,
    ),
    "bullet": Program(
        "warprock.programs.bullet",
        ("pybullet",),
        'pip install "warprock[bullet]"',
        "Bullet through pybullet: sequential impulses.",
        starts_moving=True,
        assemblies=True,
        solids=True,
    ),
    "blender": Program(
        "warprock.programs.blender",
        ("bpy",),
        'pip install "warprock[blender]"',
        "Blender's rigid-body world, in a process of its own: Bullet in float32.",
    ),
    "newton-xpbd": _newton("Newton's SolverXPBD: contacts as position constraints."),
    "newton-mujoco": Program(
        "warprock.programs.newton",
        ("newton", "mujoco_warp"),
        'pip install "newton[sim]"',
        "Newton's SolverMuJoCo: MuJoCo's contacts on Warp.",
        assemblies=True,
    ),
    "newton-vbd": _newton("Newton's SolverVBD: vertex block descent with an augmented Lagrangian."),
    "newton-semi-implicit": _newton("Newton's SolverSemiImplicit: springs in contacts, explicit."),
    "newton-featherstone": _newton(
        "Newton's SolverFeatherstone: springs in contacts, explicit, joint coordinates."
    ),
    "newton-kamino": _newton("Newton's SolverKamino: contacts and friction as cones, by ADMM."),
    "newton-steel": _newton("Newton's SolverSteel: projected Gauss-Seidel on contact impulses."),
}
"""Name in `warprock compare` -> program."""


def adapter_of(name: str) -> Any:
    """The module that runs scenes in a program; only this imports the program."""
    return importlib.import_module(PROGRAMS[name].module)


@dataclasses.dataclass(frozen=True)
class PeerAnswer:
    """What a program made of lanes.

    Attributes:
        response: Its response.
        cpu_s: CPU time of its steps alone [s].
        block_time_s: Simulated time of all blocks [s].
        steps_per_s: Steps that a lane took in a simulated second.
    """

    response: Response
    cpu_s: float
    block_time_s: float
    steps_per_s: float

    @property
    def cost(self) -> float:
        """CPU seconds for one simulated second of one block."""
        return self.cpu_s / self.block_time_s


def require_scenes(
    name: str, lanes: Lanes, motions: GroundMotions, times: SampleTimes, settings: Any
) -> None:
    """Declines lanes that a program cannot do, without running them.

    An adapter that declines some scenes says so in its `require_scenes`; the others take all.

    Raises:
        DeclinedError: It cannot do a scene.
    """
    if lanes.moving and not PROGRAMS[name].starts_moving:
        raise DeclinedError(f"it lets blocks go from rest here, and the case {lanes.moving}")
    if lanes.assembly is not None and not PROGRAMS[name].assemblies:
        raise DeclinedError(
            "warprock hands it single blocks and stacks only; the case is an assembly"
        )
    if lanes.assembly is not None and lanes.assembly.spatial and not PROGRAMS[name].solids:
        raise DeclinedError(
            "warprock hands it assemblies in the plane only; the case's lies in space"
        )
    if lanes.assembly is not None and lanes.assembly.bonded:
        raise DeclinedError(
            "warprock hands it dry joints only; the case's are bonded "
            "(assembly.joint_tensile_strength)"
        )
    program = PROGRAMS[name]
    beyond = [table for table in lanes.held if table not in program.holds]
    if beyond:
        given = "blocks in one piece" if program.holds else "free-standing blocks"
        raise DeclinedError(f"warprock hands it {given} only; the case has {' and '.join(beyond)}")
    if lanes.bodies and not (program.bodies and (lanes.spatial or lanes.stacked)):
        where = "; bodies in space and in stacks it can do" if program.bodies else ""
        raise DeclinedError(
            f"warprock hands it boxes only; the case has a body (block.base){where}"
        )
    if lanes.profiles is not None and lanes.rotation_start.any():
        raise DeclinedError("it starts stacks with a body upright here, and the case turns a block")
    adapter = adapter_of(name)
    require = getattr(adapter, "require_scenes", None)
    if require is not None:
        require(peer_scenes(lanes, motions, times), settings)


def run_program(
    name: str,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    settings: Any,
    finished: Callable[[int], None] | None = None,
) -> PeerAnswer:
    """Runs lanes in a program.

    Args:
        name: Name in `PROGRAMS`.
        lanes: The lanes.
        motions: Ground motions of the same lanes.
        times: Length of the run and sampling of its histories.
        settings: Settings of the program, of the type in `PEER_SETTINGS`.
        finished: Called with the number of lanes done so far.

    Raises:
        ImportError: It is not installed; one line that says how to install it.
        DeclinedError: It cannot do a scene.
        ChildProcessError: It runs in a process of its own, which failed; one line that says how.
    """
    scenes = peer_scenes(lanes, motions, times)
    adapter = adapter_of(name)
    runs: list[PeerRun] = adapter.run(scenes, settings, finished)
    answer = peer_response if lanes.assembly is None else assembly_response
    response = answer(name, lanes, scenes, runs, times)
    simulated = sum(s.block_count * s.frame * s.frame_count for s in scenes)
    steps = runs[0].step_count / (scenes[0].frame * scenes[0].frame_count)
    return PeerAnswer(response, sum(run.cpu_s for run in runs), simulated, steps)
