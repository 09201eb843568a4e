"""What a step in space costs: blocks, bodies and stacks in `impulse` and `dem`, a lane and step.

    python -m tools.space_steps              # the table of docs/explanation/cost.md
    python -m tools.space_steps --rounds 9

Boxes of 0.2 x 0.4 x 0.6 m under a cycle of 4 Hz, a little turned and out of place; bodies are the
same box on points around its base. Scenes run in turn on one thread; medians of all rounds.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import tempfile
import time

import numpy as np

from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.model.response import SampleTimes
from warprock.running.batch import run_batch

WIDTH, DEPTH, HEIGHT, DENSITY = 0.2, 0.4, 0.6, 2000.0
LANES, SECONDS = 128, 0.5
"""Lanes at once, and how long each runs [s]."""

SCENES = (
    "block",
    "body, 4 points",
    "body, 8 points",
    "body, 12 points",
    "two blocks",
    "three blocks",
)
ENGINES = ("impulse", "dem")


def lane_set(scene: str) -> LaneSet:
    """The lanes of a scene."""
    draw = np.random.default_rng(1)
    swept = {
        "motion.amplitude": [f"{each:.4f} g" for each in np.linspace(0.35, 0.6, LANES)],
        "motion.y.amplitude": [f"{0.3 * each:.4f} g" for each in np.linspace(0.35, 0.6, LANES)],
    }
    blocks = {"two blocks": 2, "three blocks": 3}.get(scene, 1)
    tables = []
    for number in range(1, blocks + 1):
        name = "block" if blocks == 1 else f"block.{number}"
        table = f'[{name}]\nwidth = "{WIDTH} m"\ndepth = "{DEPTH} m"\nheight = "{HEIGHT} m"\n'
        tables.append(f'{table}density = "{DENSITY} kg/m^3"\n')
        turned = "start.yaw" if blocks == 1 else f"{name}.yaw"
        swept[turned] = [f"{each:.3f} deg" for each in draw.uniform(-0.5, 0.5, LANES)]
        if number > 1:
            for key in ("offset", "offset_across"):
                swept[f"{name}.{key}"] = [
                    f"{each:.3f} mm" for each in draw.uniform(-0.8, 0.8, LANES)
                ]
    if scene.startswith("body"):
        tables = [_body(int(scene.split()[1]))]
    axes = "".join(f"{key} = {json.dumps(values)}\n" for key, values in swept.items())
    wave = 'waveform = "sine"\ncontrol = "acceleration"\nfrequency = "4 Hz"\namplitude = "0.1 g"\n'
    text = (
        f'title = "{scene}"\nsource = "tools/space_steps.py"\nmodel = "spatial"\n\n'
        f"{''.join(tables)}\n[contact]\nfriction = 0.7\n\n[motion]\n{wave}cycles = 1\n\n"
        f'[motion.y]\n{wave}cycles = 1\n\n[run]\nduration = "{SECONDS} s"\n\n[[sweep]]\n{axes}'
    )
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "case.toml")
        file.write_text(text, encoding="utf-8")
        return expand_lanes(load_case(file))


def _body(points: int) -> str:
    """The box as a body on so many points around its base: its corners, and more between them."""
    per_side = points // 4
    part = np.arange(per_side) / per_side
    corner = 0.5 * np.array([(-WIDTH, -DEPTH), (WIDTH, -DEPTH), (WIDTH, DEPTH), (-WIDTH, DEPTH)])
    sides = zip(corner, np.roll(corner, -1, axis=0), strict=True)
    around = np.concatenate([one + part[:, None] * (next_ - one) for one, next_ in sides])
    mass = DENSITY * WIDTH * DEPTH * HEIGHT
    squares = np.array([DEPTH**2 + HEIGHT**2, WIDTH**2 + HEIGHT**2, WIDTH**2 + DEPTH**2])
    inertia = [f"{each:.9g} kg m^2" for each in mass * squares / 12.0] + ["0 kg m^2"] * 3
    base = [[float(x), float(y), 0.0] for x, y in around]
    return (
        f'[block]\nmass = "{mass:.9g} kg"\ncentre = [0.0, 0.0, {0.5 * HEIGHT}]\n'
        f"inertia = {json.dumps(inertia)}\nbase = {json.dumps(base)}\n"
    )


def microseconds(engine: str, lanes: LaneSet) -> float:
    """CPU time of a lane and step [us]."""
    begin = time.process_time()
    found = run_batch(engine, lanes.lanes, lanes.motions, SampleTimes(SECONDS), workers=1)
    return 1e6 * (time.process_time() - begin) / float(found["step_count"].sum())


def main() -> None:
    """Prints the table."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    ask.add_argument("--rounds", type=int, default=5, help="runs of each scene (5)")
    rounds = ask.parse_args().rounds
    sets = {scene: lane_set(scene) for scene in SCENES}
    pairs = [(scene, engine) for scene in sets for engine in ENGINES]
    for scene, engine in pairs:
        # Compiles the kernel, or loads it.
        microseconds(engine, sets[scene])
    runs = [[microseconds(engine, sets[scene]) for scene, engine in pairs] for _ in range(rounds)]
    took = dict(zip(pairs, np.median(runs, axis=0), strict=True))
    print("| scene | `impulse` | times | `dem` | times |\n| --- | --- | --- | --- | --- |")
    for scene in sets:
        cells = [
            f"{took[scene, engine]:.3g} | {took[scene, engine] / took[SCENES[0], engine]:.2g}"
            for engine in ENGINES
        ]
        print(f"| {scene} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
