"""Where a step of an engine spends its time: kernels from which parts are cut, in alternation.

    python -m tools.step_parts                # impulse, direct, xpbd and dem
    python -m tools.step_parts dem --keep     # and the table of docs/explanation/history.md

A copy of the tree is made for each cut. In its kernel, assignments to what a part keeps get another
target, so that the compiler drops all that only served them: of the account of energy `account`, of
the observation (peaks, impacts, uplift, rest, overturning) `peaks`, `seen`, `parting` and `seat`.
Blocks move as before. Processes of all copies run in turn, ROUNDS times, on one core; the table has
the fastest run of each, since what else runs on a machine only makes runs slower. Blocks must
neither overturn nor slide off, which only a whole kernel would see.
"""

from __future__ import annotations

import argparse
import ast
import datetime
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
from typing import Any

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "explanation" / "history.md"
BEGIN, END = "% python -m tools.step_parts: begin", "% python -m tools.step_parts: end"

KERNELS = {
    "impulse": "impulse/block_run.py",
    "direct": "direct/block_run.py",
    "xpbd": "xpbd/stack_run.py",
    "dem": "dem/stack_run.py",
}
"""The loop over lanes of a single block in the plane, by engine."""
KEPT = {"account": {"account"}, "observation": {"peaks", "seen", "parting", "seat"}}
"""What kernels keep of a part, by the names of their rows."""
CUTS: dict[str, tuple[str, ...]] = {
    "all of it": (),
    "without the account of energy": ("account",),
    "without observation": ("observation",),
    "without both": ("account", "observation"),
}
CASE, LANES = "single-sine-pulse", 1024
SECONDS = {"impulse": 1.0, "direct": 1.0, "xpbd": 0.5, "dem": 1.0}
"""How long lanes run [s]."""
ROUNDS, REPEATS = 3, 8
"""Processes of each copy, and runs in each."""


def root_name(target: ast.expr) -> str:
    """The name that a target begins with: `account` of `account[i].loss`."""
    while isinstance(target, ast.Attribute | ast.Subscript):
        target = target.value
    return target.id if isinstance(target, ast.Name) else ""


class _Cut(ast.NodeTransformer):
    """Takes a part of a step out of statements; the part is a key of `KEPT`."""

    def __init__(self, part: str) -> None:
        self.part, self.count = part, 0

    def visit_Assign(self, node: ast.Assign) -> ast.stmt:
        """The value may be a call that does more, so it is kept."""
        (target,) = node.targets
        if not isinstance(target, ast.Name) and root_name(target) in KEPT[self.part]:
            self.count += 1
            node.targets = [ast.Name(f"{self.part}_{self.count}", ast.Store())]
        return node

    def visit_Expr(self, node: ast.Expr) -> ast.stmt:
        """A call for its effect on what is observed."""
        called = ast.unparse(node.value.func) if isinstance(node.value, ast.Call) else ""
        if self.part == "observation" and called.startswith("observe"):
            self.count += 1
            return ast.Pass()
        return node


def without(text: str, parts: tuple[str, ...]) -> str:
    """A kernel file without some parts.

    Args:
        text: The file.
        parts: "account", "observation".

    Raises:
        SystemExit: The kernel has nothing of a part.
    """
    tree = ast.parse(text)
    (kernel,) = (
        each for each in tree.body if isinstance(each, ast.FunctionDef) and each.name == "run_lanes"
    )
    samples = next(
        each
        for each in kernel.body
        if isinstance(each, ast.For) and "sample_times" in ast.unparse(each.iter)
    )
    # What takes steps up to a sample is the last loop; what is seen at the start stays.
    steps = [each for each in samples.body if isinstance(each, ast.While | ast.For)][-1]
    for part in parts:
        cut = _Cut(part)
        cut.visit(kernel if part == "account" else steps)
        if not cut.count:
            raise SystemExit(f"run_lanes: has nothing of the {part}")
    return ast.unparse(tree) + "\n"


def probe(engine: str) -> dict[str, Any]:
    """What an engine does in this tree.

    Returns:
        `spent`, CPU times of runs [s]; `steps` of all lanes in one; `outcomes` that lanes have; and
        `moved`, a fingerprint of their rotations over time.
    """
    import numpy as np

    import warprock as wr

    whole = wr.expand_lanes(wr.load_case(CASE))
    some = np.arange(LANES) % whole.lanes.lane_count
    batch, end = (whole.lanes.take(some), whole.motions.take(some)), SECONDS[engine]
    sampled = wr.run_batch(engine, *batch, wr.SampleTimes(end, 0.05), workers=1)
    spent = []
    for _ in range(REPEATS):
        begin = time.process_time()
        response = wr.run_batch(engine, *batch, wr.SampleTimes(end), workers=1)
        spent.append(time.process_time() - begin)
    return {
        "spent": spent,
        "steps": int(response["step_count"].sum()),
        "outcomes": sorted({wr.Outcome(int(each)).name.lower() for each in response["outcome"]}),
        "moved": hashlib.sha256(np.ascontiguousarray(sampled["rotation"]).tobytes()).hexdigest(),
    }


def copy(tree: pathlib.Path, engine: str, parts: tuple[str, ...]) -> None:
    """Makes a copy of this tree whose kernel of an engine has no such parts."""
    for name in ("warprock", "kernels", "cases", "tools"):
        shutil.copytree(
            ROOT / name,
            tree / name,
            ignore=shutil.ignore_patterns("__pycache__"),
            dirs_exist_ok=True,
        )
    file = tree / "kernels" / KERNELS[engine]
    if parts:
        file.write_text(without(file.read_text(encoding="utf-8"), parts), encoding="utf-8")


def run_probe(tree: pathlib.Path, engine: str) -> dict[str, Any]:
    """What `probe` finds in a tree, in a process of its own."""
    told = subprocess.run(
        [sys.executable, str(tree / "tools" / "step_parts.py"), "--probe", engine],
        check=True, stdout=subprocess.PIPE, text=True, cwd=tree,
        env={**os.environ, "PYTHONPATH": str(tree)},
    )  # fmt: skip
    found: dict[str, Any] = json.loads(told.stdout.splitlines()[-1])
    return found


def measure(engine: str) -> dict[str, float]:
    """Steps in a CPU second of each cut of an engine, in its fastest run.

    Raises:
        SystemExit: A cut changes how blocks move, or a block falls.
    """
    with tempfile.TemporaryDirectory(prefix="warprock-parts-") as folder:
        trees = {name: pathlib.Path(folder) / str(n) for n, name in enumerate(CUTS)}
        for name, tree in trees.items():
            copy(tree, engine, CUTS[name])
        rounds = [
            {name: run_probe(tree, engine) for name, tree in trees.items()} for _ in range(ROUNDS)
        ]
    (whole, *_), names = CUTS, list(CUTS)
    first = rounds[0]
    if not {"rocking", "at_rest"}.issuperset(first[whole]["outcomes"]):
        raise SystemExit(f"{engine}: lanes of {CASE} are {', '.join(first[whole]['outcomes'])}")
    for name in names:
        if first[name]["moved"] != first[whole]["moved"]:
            raise SystemExit(f"{engine} {name}: blocks move otherwise")
    steps = first[whole]["steps"]
    return {
        name: max(steps / spent for each in rounds for spent in each[name]["spent"])
        for name in names
    }


def table(found: dict[str, dict[str, float]], day: datetime.date) -> str:
    """The rates as a table in Markdown: million steps a second, and their ratio to the whole."""
    rows = [f"| million steps a second, {day:%B %Y} | {' | '.join(found)} |"]
    rows += ["| --- " * (len(found) + 1) + "|"]
    for name in CUTS:
        cells = []
        for rates in found.values():
            ratio = rates[name] / next(iter(rates.values()))
            times = f" ({ratio:.2f} times)" if CUTS[name] else ""
            cells.append(f"{1e-6 * rates[name]:.1f}{times}")
        rows.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(rows)


def main() -> None:
    """Measures, prints, and keeps the table where that is asked for."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    ask.add_argument("engines", nargs="*", help=f"of {', '.join(KERNELS)}")
    ask.add_argument("--keep", action="store_true", help="write the table to the manual")
    ask.add_argument("--probe", action="store_true", help=argparse.SUPPRESS)
    asked = ask.parse_args()
    unknown = [name for name in asked.engines if name not in KERNELS]
    if unknown:
        ask.error(f"engine: got {unknown[0]}, allowed: {', '.join(KERNELS)}")
    if asked.probe:
        print(json.dumps(probe(asked.engines[0])))
        return
    found = {engine: measure(engine) for engine in asked.engines or KERNELS}
    text = table(found, datetime.datetime.now(datetime.UTC).date())
    print(text)
    if asked.keep:
        page = PAGE.read_text(encoding="utf-8")
        before, after = page.split(BEGIN)[0], page.split(END)[1]
        PAGE.write_text(f"{before}{BEGIN}\n\n{text}\n\n{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
