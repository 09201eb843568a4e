"""What engines, starts and memory cost, in ratios to a fixed loop; one revision beside another.

    python -m tools.speed                        # this tree
    python -m tools.speed --against HEAD~20      # beside another revision, in one run
    python -m tools.speed --keep 0.1.0           # a column of docs/explanation/history.md

Each scene runs on one core, after a run that compiles or loads its kernels. Its CPU time for a lane
and a second is divided by that of a fixed loop of NumPy and Python, which runs before and after it
in the same process: figures of two machines of one kind can be compared. A start is divided by that
of Python. Of two revisions processes alternate, and the rounds say what is noise: a scene is slower
where each round says so, and the median by more than the rounds of one revision differ.
"""

from __future__ import annotations

import argparse
import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[1]
TABLE = ROOT / "docs" / "explanation" / "history.md"

ROUNDS, REPEATS = 3, 5
"""Processes of each revision, and runs of a scene in each."""
LEAST = 0.03
"""Changes that are noise whatever the rounds say: the place of code in memory makes as much."""


class Scene(NamedTuple):
    """Lanes that an engine runs: those of a shipped case, several times over.

    Attributes:
        case: Name of the case.
        engine: Name of the engine.
        lanes: How many lanes.
        seconds: How long each runs [s].
    """

    case: str
    engine: str
    lanes: int
    seconds: float


SCENES = {
    f"{engine}, {what}": Scene(case, engine, lanes, seconds)
    for what, case, engines in (
        (
            "a block",
            "single-sine-pulse",
            {
                "housner": (20000, 1.0),
                "event": (8000, 1.0),
                "impulse": (1024, 0.2),
                "direct": (1024, 0.2),
                "xpbd": (512, 0.2),
                "dem": (1024, 0.2),
            },
        ),
        (
            "a stack",
            "stack-sine-pulse",
            {
                "two-block": (2000, 0.5),
                "event": (256, 0.5),
                "impulse": (256, 0.1),
                "dem": (256, 0.1),
            },
        ),
        ("space", "space-free", {"event": (512, 0.5), "impulse": (256, 0.1), "dem": (64, 0.05)}),
    )
    for engine, (lanes, seconds) in engines.items()
}
STARTS = {
    "--help": ("--help",),
    "list": ("list",),
    "keys": ("keys",),
    "explain, space": ("explain", "space-free"),
    "explain, a block": ("explain", "free-b0"),
    "run, two lanes": ("run", "free-b0", "-e", "housner", "--no-estimate"),
}
MEMORY = "memory of that run"


def fixed_loop() -> float:
    """CPU time of the fixed loop [s]: some work of NumPy, some of Python."""
    import numpy as np

    begin, numbers, total = time.process_time(), np.linspace(0.0, 1.0, 200_000), 0.0
    for _ in range(12):
        total += float(np.sin(numbers).sum())
    for number in range(200_000):
        total += number * 0.5
    return time.process_time() - begin


def probe(names: list[str]) -> dict[str, list[float]]:
    """CPU time of scenes over that of the fixed loop, for 1,000 lanes and a second of motion."""
    import numpy as np

    import warprock as wr

    found: dict[str, list[float]] = {}
    for name in names:
        scene = SCENES[name]
        whole = wr.expand_lanes(wr.load_case(scene.case))
        some = np.arange(scene.lanes) % whole.lanes.lane_count
        batch = whole.lanes.take(some), whole.motions.take(some), wr.SampleTimes(scene.seconds)
        wr.run_batch(scene.engine, *batch, workers=1)
        found[name] = []
        for _ in range(REPEATS):
            before, begin = fixed_loop(), time.process_time()
            wr.run_batch(scene.engine, *batch, workers=1)
            spent = time.process_time() - begin
            unit = 0.5 * (before + fixed_loop())
            found[name].append(1e3 * spent / (scene.lanes * scene.seconds) / unit)
    return found


def start(command: list[str], tree: pathlib.Path) -> tuple[float, float]:
    """CPU time of a process [s], and the most memory of any so far [byte]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                   cwd=tree, env={**os.environ, "PYTHONPATH": str(tree)})  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return spent, 1024.0 * after.ru_maxrss


def starts(tree: pathlib.Path, names: list[str]) -> dict[str, list[float]]:
    """CPU time of commands over that of Python's start, and the memory of the last one [MB]."""
    found: dict[str, list[float]] = {}
    asked = {name: words for name, words in STARTS.items() if name in names}
    if MEMORY in names:
        asked["run, two lanes"] = STARTS["run, two lanes"]
    for name, words in asked.items():
        command, found[name] = [sys.executable, "-m", "warprock", *words], []
        start(command, tree)
        for _ in range(REPEATS):
            python = start([sys.executable, "-c", "pass"], tree)[0]
            spent, most = start(command, tree)
            found[name].append(spent / python)
        if name == "run, two lanes":
            found[MEMORY] = [1e-6 * most]
    return found


def measure(tree: pathlib.Path, names: list[str]) -> dict[str, float]:
    """Medians of scenes and starts in a tree, in processes of their own."""
    scenes = [name for name in names if name in SCENES]
    found: dict[str, list[float]] = {}
    if scenes:
        command = [sys.executable, str(ROOT / "tools" / "speed.py"), "--probe", *scenes]
        told = subprocess.run(
            command, check=False, capture_output=True, text=True, cwd=tree,
            env={**os.environ, "PYTHONPATH": str(tree)},
        )  # fmt: skip
        if told.returncode:
            last = (told.stderr.splitlines() or ["nothing"])[-1]
            raise SystemExit(f"{tree}: cannot run {', '.join(scenes)}: {last}")
        found |= json.loads(told.stdout.splitlines()[-1])
    if len(scenes) < len(names):
        found |= starts(tree, names)
    return {name: statistics.median(found[name]) for name in names}


def judged(ours: list[float], others: list[float]) -> tuple[float, float, str]:
    """Ratio of ours to the other revision's, what is noise, and what that says."""
    ratios = [a / b for a, b in zip(ours, others, strict=True)]
    noise = max(LEAST, *(max(each) / min(each) - 1.0 for each in (ours, others)))
    ratio = statistics.median(ratios)
    if min(ratios) > 1.0 and ratio > 1.0 + noise:
        return ratio, noise, "slower"
    if max(ratios) < 1.0 and ratio < 1.0 / (1.0 + noise):
        return ratio, noise, "faster"
    return ratio, noise, ""


def compare(revision: str, names: list[str]) -> int:
    """Prints this tree beside another revision; gives how many scenes are slower."""
    with tempfile.TemporaryDirectory(prefix="warprock-speed-") as folder:
        other = pathlib.Path(folder) / "tree"
        git: Callable[..., object] = lambda *words: subprocess.run(  # noqa: E731
            ["git", *words], cwd=ROOT, check=True, stdout=subprocess.DEVNULL
        )
        git("worktree", "add", "--quiet", "--detach", str(other), revision)
        try:
            pairs = [(measure(ROOT, names), measure(other, names)) for _ in range(ROUNDS)]
        finally:
            git("worktree", "remove", "--force", str(other))
    slower = 0
    print(f"{'':<24}{'here':>9}{revision[:12]:>14}{'ratio':>8}{'noise':>8}")
    for name in names:
        ours, others = [pair[0][name] for pair in pairs], [pair[1][name] for pair in pairs]
        ratio, noise, word = judged(ours, others)
        slower += word == "slower"
        here, there = statistics.median(ours), statistics.median(others)
        print(f"{name:<24}{here:>9.3g}{there:>14.3g}{ratio:>8.2f}{noise:>8.2f}  {word}")
    return slower


def keep(version: str, found: dict[str, float]) -> None:
    """Adds the column of a version to the table of the manual, or replaces it."""
    head, _, tail = TABLE.read_text(encoding="utf-8").partition("| scene |")
    lines = [line for line in ("| scene |" + tail).splitlines() if line.startswith("|")]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    rows[0][1:] = [version if name == version else name for name in rows[0][1:]]
    columns = {name: {} for name in rows[0][1:]}
    for row in rows[2:]:
        for name, cell in zip(rows[0][1:], row[1:], strict=True):
            columns[name][row[0]] = cell
    columns[version] = {name: f"{value:.3g}" for name, value in found.items()}
    text = ["| " + " | ".join(("scene", *columns)) + " |", "| --- " * (len(columns) + 1) + "|"]
    text += [
        "| " + " | ".join((name, *(each.get(name, "") for each in columns.values()))) + " |"
        for name in found
    ]
    TABLE.write_text(head + "\n".join(text) + "\n", encoding="utf-8")


def main() -> int:
    """Measures what was asked for."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    everything = [*SCENES, *STARTS, MEMORY]
    ask.add_argument("scenes", nargs="*", help=f"parts of their names: {', '.join(everything)}")
    ask.add_argument("--against", metavar="REVISION", help="another revision to run beside")
    ask.add_argument("--keep", metavar="VERSION", help="keep the figures in the manual")
    ask.add_argument("--probe", action="store_true", help=argparse.SUPPRESS)
    asked = ask.parse_args()
    if asked.probe:
        print(json.dumps(probe(asked.scenes)))
        return 0
    names = [n for n in everything if not asked.scenes or any(s in n for s in asked.scenes)]
    if asked.against:
        return 1 if compare(asked.against, names) else 0
    found = measure(ROOT, names)
    for name, value in found.items():
        print(f"{name:<24}{value:>9.3g}")
    if asked.keep:
        keep(asked.keep, found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
