"""Collapse loads of assemblies by Siconos and LMGC90, which share no line with warprock.

    apt-get install python3-siconos python3-scipy python3-h5py        # Debian 12: Siconos 4.4.0
    pip install --no-deps --target judges compas_lmgc90               # LMGC90; --path judges
    python -m tools.judges siconos drums
    python -m tools.judges lmgc90 drums wall --path judges --step 2e-3

Neither is needed for anything else. Twelve drums and a wall of 33 blocks are pushed as in `warprock
bench assembly`: the load on every block rises for a second and stays for two, and is halved to a
hundredth. An assembly has collapsed if a block came further than 20 mm. This file runs again for
each load, in the Python that has the program: Siconos has that of Debian, and LMGC90 holds one
scene a process. Both step by the scheme of Moreau and Jean, without restitution, and solve contacts
by nonsmooth Gauss-Seidel; Siconos has contacts of Bullet in the plane, LMGC90 those of polyhedra.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
from typing import Any

GRAVITY = 9.80665
DEBIAN = "/usr/bin/python3"
MARGIN = 0.02
"""Margin of Bullet's boxes inside them, over their smaller side."""
ALERT = 1e-3
"""Distance at which LMGC90 looks for contacts [m]."""

Scene = dict[str, Any]
Told = dict[str, float]


def boxes_of(kind: Any) -> list[dict[str, Any]]:
    """Blocks of an `Assembly` that are upright boxes: centre, sides [m], mass [kg], fixed."""
    found = []
    for corners, mass, fixed in zip(kind.corners, kind.mass, kind.fixed, strict=True):
        low, high = corners.min(axis=0), corners.max(axis=0)
        found.append(
            {
                "centre": (0.5 * (low + high)).tolist(),
                "sides": (high - low).tolist(),
                "mass": float(mass),
                "fixed": bool(fixed),
            }
        )
    return found


def collapse(name: str, scene: Scene, path: pathlib.Path | None) -> tuple[float, float]:
    """The load at which a scene collapses [g], and CPU time of a second of motion [s].

    Args:
        name: siconos or lmgc90.
        scene: boxes, friction, depth [m], step [s], low and high (loads of limit analysis, [g]).
        path: Folder with packages, if not among those of the Python that runs.
    """
    from warprock.measure.assembly_bench import CLOSE, FAR, HIGH, HOLD, LOW, RISE

    middle = 0.5 * (scene["low"] + scene["high"])
    low, high, spent, runs = LOW * middle, HIGH * middle, 0.0, 0
    while high - low > CLOSE * middle:
        load = 0.5 * (low + high)
        asked = {**scene, "load": load, "rise": RISE, "hold": HOLD}
        python = DEBIAN if name == "siconos" else sys.executable
        done = subprocess.run(
            [python, __file__, name, "--inside"],
            input=json.dumps(asked),
            text=True,
            check=True,
            stdout=subprocess.PIPE,
            env=os.environ | ({"PYTHONPATH": str(path.resolve())} if path else {}),
        )
        told: Told = json.loads(done.stdout.splitlines()[-1])
        low, high = (low, load) if told["moved"] > FAR else (load, high)
        spent, runs = spent + told["cpu_s"], runs + 1
    return 0.5 * (low + high), spent / runs / (RISE + HOLD)


def run_siconos(scene: Scene) -> Told:
    """Runs a scene in Siconos: how far a block came [m], and the CPU time of the steps [s]."""
    import h5py
    import siconos.numerics as numerics
    from siconos.io.mechanics_run import MechanicsHdf5Runner
    from siconos.kernel import solver_options_create
    from siconos.mechanics.collision.bullet import SICONOS_BULLET_2D, SiconosBulletOptions
    from siconos.mechanics.collision.tools import Contactor

    file, bodies = "scene.hdf5", []
    with MechanicsHdf5Runner(mode="w", io_filename=file, verbose=False) as made:
        made.add_Newton_impact_friction_nsl("law", mu=scene["friction"], e=0.0)
        for number, box in enumerate(scene["boxes"]):
            width, height = box["sides"]
            inside = MARGIN * min(width, height)
            made.add_primitive_shape(
                f"box {number}", "Box2d", (width, height), insideMargin=inside, outsideMargin=0.0
            )
            inertia = box["mass"] * (width**2 + height**2) / 12.0
            moves = {} if box["fixed"] else {"mass": box["mass"], "inertia": inertia}
            shapes = [Contactor(f"box {number}")]
            made.add_object(f"block {number}", shapes, box["centre"], [0.0], [0.0] * 3, **moves)
    options = SiconosBulletOptions()
    options.dimension = SICONOS_BULLET_2D
    options.perturbationIterations = 0
    options.minimumPointsPerturbationThreshold = 0
    solver = solver_options_create(numerics.SICONOS_FRICTION_2D_NSGS)
    solver.iparam[numerics.SICONOS_IPARAM_MAX_ITER] = scene["sweeps"]
    solver.dparam[numerics.SICONOS_DPARAM_TOL] = scene["settled"]

    def take(body: Any) -> None:
        bodies.append(body)
        body.setFExtPtr([0.0, -GRAVITY * body.scalarMass(), 0.0])

    def push(runner: Any) -> None:
        part = scene["load"] * min(runner.current_time() / scene["rise"], 1.0)
        for body in bodies:
            weight = GRAVITY * body.scalarMass()
            body.setFExtPtr([part * weight, -weight, 0.0])

    begin = time.process_time()
    with MechanicsHdf5Runner(mode="r+", io_filename=file, verbose=False) as runner:
        runner.run(
            bullet_options=options,
            T=scene["rise"] + scene["hold"],
            h=scene["step"],
            Newton_max_iter=1,
            set_external_forces=take,
            solver_options=solver,
            output_frequency=int(0.1 / scene["step"]),
            start_run_iteration_hook=push,
            verbose=False,
            verbose_progress=False,
        )
    spent = time.process_time() - begin
    with h5py.File(file) as kept:
        rows = kept["data"]["dynamic"][:]
    first, last = (rows[rows[:, 0] == rows[at, 0]][:, 2:4] for at in (0, -1))
    return {"moved": float(((last - first) ** 2).sum(axis=1).max() ** 0.5), "cpu_s": spent}


SIDES = ((0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5))
"""Corners of the six sides of a box, outwards and counterclockwise, of signs that count -, +."""


def run_lmgc90(scene: Scene) -> Told:
    """Runs a scene in LMGC90: how far a block came [m], and the CPU time of the steps [s]."""
    import numpy as np
    from compas_lmgc90 import _lmgc90

    solver, depth = _lmgc90.LMGC90Solver(), scene["depth"]
    solver.initialize(scene["step"], 0.5, False)
    solver.add_one_tact_behav("iqsc0", "IQS_CLB", [scene["friction"]])
    box = scene["boxes"][-1]
    solver.set_materials(np.array([box["mass"] / (np.prod(box["sides"]) * depth)]))
    solver.set_see_tables(ALERT)
    solver.set_nb_bodies(len(scene["boxes"]))
    corners_of = [a + 1 for b in SIDES for a in (b[0], b[1], b[2], b[0], b[2], b[3])]
    # F(t) = (f0 + f1 cos(f2 t + f3)) min(1, f4 + f5 t)
    held, rises = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0], 1.0 / scene["rise"]
    for number, box in enumerate(scene["boxes"], start=1):
        halves = (0.5 * box["sides"][0], 0.5 * depth, 0.5 * box["sides"][1])
        corners = [sign * half for signs in itertools.product((-1, 1), repeat=3)
                   for sign, half in zip(signs, halves, strict=True)]  # fmt: skip
        centre = [box["centre"][0], 0.0, box["centre"][1]]
        fixed, load = box["fixed"], scene["load"] * GRAVITY * box["mass"]
        driven = (6, 0) if fixed else (0, 1)
        solver.set_one_polyr("s0001", centre, corners_of, corners, *driven)
        for axis in range(1, 7) if fixed else ():
            solver.set_drvdof(number, axis, held, True, False)
        if not fixed:
            solver.set_drvdof(number, 1, [load, 0.0, 0.0, 0.0, 0.0, rises], False, False)
    solver.close_before_computing()
    first, begin = np.array(solver.get_initial_state().init_bodies), time.process_time()
    for _ in range(round((scene["rise"] + scene["hold"]) / scene["step"])):
        last = solver.compute_one_step().bodies
    spent = time.process_time() - begin
    return {"moved": float(np.linalg.norm(last - first, axis=1).max()), "cpu_s": spent}


PROGRAMS = {"siconos": run_siconos, "lmgc90": run_lmgc90}


def main() -> None:
    """Reads the command line."""
    parser = argparse.ArgumentParser(description=str(__doc__).partition("\n")[0])
    parser.add_argument("program", choices=PROGRAMS)
    parser.add_argument("scenes", nargs="*", default=["drums", "wall"], help="drums, wall")
    parser.add_argument("--step", type=float, default=2e-3, help="time step [s]")
    parser.add_argument("--sweeps", type=int, default=1000, help="of Siconos, at most")
    parser.add_argument("--settled", type=float, default=1e-8, help="error at which they end")
    parser.add_argument("--path", type=pathlib.Path, help="folder with the packages of the program")
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.inside:
        scene = json.load(sys.stdin)
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            print("\n" + json.dumps(PROGRAMS[asked.program](scene)))
        return
    from warprock.measure.assembly_bench import bench_scenes

    for each in bench_scenes():
        if each.name in asked.scenes:
            scene = {
                "boxes": boxes_of(each.kind),
                "friction": float(each.kind.joints.friction.max()),
                "depth": each.kind.depth,
                "step": asked.step,
                "sweeps": asked.sweeps,
                "settled": asked.settled,
                "low": each.low,
                "high": each.high,
            }
            load, cost = collapse(asked.program, scene, asked.path)
            print(
                f"{each.name}: {load:.4f} g; limit analysis {each.low:.4f} to {each.high:.4f} g; "
                f"{cost:.2f} CPU seconds for a second of motion at {1e3 * asked.step:g} ms a step",
                flush=True,
            )


if __name__ == "__main__":
    main()
