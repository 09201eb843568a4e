"""Newton beside ours: the same lanes with each of its solvers of rigid bodies, on the CPU.

All lanes run at once, as worlds of one model; a launch costs so much more than the arithmetic in it
that thousands of lanes take hardly longer than one. Newton works in float32.

Settings are the best of those tried on blocks B1 to B3; what is not set is Newton's default. Its
solvers differ in how they are told of friction at a face, so the blocks of a lane must have one
coefficient in common.

The Newton Developers (2025), Newton: a GPU-accelerated physics simulation engine.
"""

from __future__ import annotations

import contextlib
import dataclasses
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.errors import DeclinedError
from warprock.programs.assembly_scene import one_friction
from warprock.programs.scene import PeerRun, PeerScene, missing
from warprock.settings.programs import (
    NewtonFeatherstoneSettings,
    NewtonKaminoSettings,
    NewtonMujocoSettings,
    NewtonSemiImplicitSettings,
    NewtonSteelSettings,
    NewtonVbdSettings,
    NewtonXpbdSettings,
)

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class _Solver:
    """How one of Newton's solvers is set up.

    Attributes:
        make: Makes the solver from Newton's solvers, a model and our settings.
        plane: Whether it knows planes that move; boxes serve it otherwise.
        collides: Whether it takes Newton's contacts; it finds its own otherwise.
        register: Name of its class, if that registers attributes with the builder.
    """

    make: Callable[[Any, Any, Any], Any]
    plane: bool = True
    collides: bool = True
    register: str | None = None


SOLVERS: dict[type[Any], _Solver] = {
    NewtonXpbdSettings: _Solver(
        lambda solvers, model, s: solvers.SolverXPBD(model, iterations=s.iterations)
    ),
    NewtonMujocoSettings: _Solver(
        lambda solvers, model, s: solvers.SolverMuJoCo(
            model, solver="newton", cone="elliptic", iterations=s.iterations
        ),
        plane=False,
        collides=False,
    ),
    NewtonVbdSettings: _Solver(
        lambda solvers, model, s: solvers.SolverVBD(model, iterations=s.iterations)
    ),
    NewtonSemiImplicitSettings: _Solver(
        lambda solvers, model, s: solvers.SolverSemiImplicit(model, angular_damping=0.0)
    ),
    NewtonFeatherstoneSettings: _Solver(
        lambda solvers, model, s: solvers.SolverFeatherstone(model, angular_damping=0.0)
    ),
    NewtonKaminoSettings: _Solver(
        lambda solvers, model, s: solvers.SolverKamino(model), register="SolverKamino"
    ),
    NewtonSteelSettings: _Solver(
        lambda solvers, model, s: solvers.SolverSteel(model, iterations=s.iterations)
    ),
}
"""Settings of one of Newton's solvers -> how it is set up."""


def run(
    scenes: Sequence[PeerScene],
    settings: Any,
    finished: Callable[[int], None] | None = None,
) -> list[PeerRun]:
    """Runs scenes, all at once.

    Args:
        scenes: The scenes, of one kind and length.
        settings: Settings of one of Newton's solvers, which choose it.
        finished: Called with the number of scenes that are done: in proportion to the time run.

    Returns:
        Poses at the frames of each scene, and its part of the CPU time of the steps.

    Raises:
        ImportError: Newton or what the solver needs is not installed; one line that says how.
        DeclinedError: It cannot do a scene.
    """
    require_scenes(scenes, settings)
    with _without_adjoints():
        return _run(scenes, settings, finished)


@contextlib.contextmanager
def _without_adjoints() -> Iterator[None]:
    """Newton's kernels, if this defines them, have no adjoints.

    Nothing here asks for a gradient, and with adjoints its kernels take twice as long to compile.
    """
    import warp as wp

    before = wp.config.enable_backward
    wp.config.enable_backward = False
    try:
        yield
    finally:
        wp.config.enable_backward = before


def _run(
    scenes: Sequence[PeerScene], settings: Any, finished: Callable[[int], None] | None
) -> list[PeerRun]:
    try:
        import newton
        import warp as wp

        from warprock.programs.newton_scene import NewtonScene
    except ImportError as error:
        raise missing("newton", 'pip install "warprock"', error) from None
    wp.config.log_level = max(wp.config.log_level, wp.LOG_WARNING)
    solver_kind = SOLVERS[type(settings)]
    steps = scenes[0].steps_per_frame(settings.steps_per_second)
    step = scenes[0].frame / steps
    register = solver_kind.register and getattr(newton.solvers, solver_kind.register)
    built = NewtonScene(
        scenes,
        step=step,
        plane=solver_kind.plane,
        register=register and register.register_custom_attributes,
    )
    try:
        solver = solver_kind.make(newton.solvers, built.model, settings)
    except ImportError as error:
        raise missing("newton", 'pip install "newton[sim]"', error) from None
    seen, cpu_s = _march(newton, wp, built, solver, solver_kind, scenes, steps, finished)
    count = scenes[0].frame_count * steps
    return [
        PeerRun(poses[..., :3], poses[..., 3:], cpu_s / len(scenes), count)
        for poses in np.moveaxis(seen, 1, 0)
    ]


def require_scenes(scenes: Sequence[PeerScene], _settings: Any) -> None:
    """Declines what no solver of Newton's is set up for here.

    Raises:
        DeclinedError: Blocks of a lane with frictions of their own.
    """
    for scene in scenes:
        if scene.assembly is not None:
            one_friction(scene.assembly)
        if len({block.friction for block in scene.blocks}) > 1:
            raise DeclinedError("it needs one friction coefficient for all blocks of a lane")


def _march(
    newton: Any,
    wp: Any,
    built: Any,
    solver: Any,
    kind: _Solver,
    scenes: Sequence[PeerScene],
    steps: int,
    finished: Callable[[int], None] | None,
) -> tuple[Array, float]:
    """Poses at the frames, shape [frame, world, block, 7], and the CPU time of the steps [s]."""
    model, step = built.model, scenes[0].frame / steps
    state, after, control = model.state(), model.state(), model.control()
    newton.eval_fk(model, model.joint_q, model.joint_qd, state)
    pipeline = contacts = None
    if kind.collides:
        pipeline = newton.CollisionPipeline(model, broad_phase="explicit")
        contacts = pipeline.contacts()
    paths = [scene.base_steps(steps) for scene in scenes]
    frame_count = scenes[0].frame_count
    seen = [built.poses(state)]
    cpu_s = 0.0
    for frame in range(frame_count):
        now = slice(frame * steps, (frame + 1) * steps)
        places, velocities = (
            wp.array(np.stack([path[part][now] for path in paths], axis=1), dtype=wp.vec3)
            for part in (0, 1)
        )
        begin = time.process_time()
        for number in range(steps):
            built.drive(state, number, places, velocities)
            state.clear_forces()
            if pipeline is not None:
                pipeline.collide(state, contacts)
            solver.step(state, after, control, contacts, step)
            state, after = after, state
        # The first steps compile Newton's kernels where they are not in Warp's cache.
        if frame > 0 or frame_count == 1:
            cpu_s += time.process_time() - begin
        seen.append(built.poses(state))
        if finished is not None:
            finished(len(scenes) * (frame + 1) // frame_count)
    return np.array(seen), cpu_s * frame_count / max(1, frame_count - 1)
