"""Prints the CPU time that each kernel takes to compile for this processor.

    python -m tests.shared.compile_times > before.txt
    ... change kernels ...
    python -m tests.shared.compile_times --before before.txt
    python -m tests.shared.compile_times --forms packed --precisions float64 event stack

A line is a kernel and its seconds, with `--before` also those of the other file and their ratio.
Every kernel is compiled afresh, one after the other in one process. Words choose kernels by engine,
scene and kind of motion (`tests/shared/device_scenes.py`); all of them take hours.
"""

from __future__ import annotations

import argparse
import itertools
import pathlib
import tempfile
import time
from collections.abc import Iterator

import warp as wp

from tests.shared.device_scenes import Run, runs
from warprock.engines.launching import Form
from warprock.kernels.launch.instance import BYTES
from warprock.running.devices import start_warp


def compile_time(module: str, repeats: int) -> float:
    """Shortest CPU time that Warp takes to write and compile a module [s]."""
    found = []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            begin = time.process_time()
            wp.compile_aot_module(module, device="cpu", module_dir=folder)
            found.append(time.process_time() - begin)
    return min(found)


def modules(asked: argparse.Namespace) -> Iterator[tuple[str, str]]:
    """The name of every kernel that was asked for and its module, once each."""
    seen = set[str]()
    wanted: list[Run] = [run for run in runs() if all(word in run.name for word in asked.words)]
    for run, precision, form in itertools.product(wanted, asked.precisions, asked.forms):
        module = run.module("cpu", precision, Form(form))
        if module not in seen:
            seen.add(module)
            yield f"{run.name}, {precision}, {form}", module


def read_times(file: pathlib.Path) -> dict[str, float]:
    """Seconds by the name of a kernel, from what this tool printed."""
    rows = (line.rsplit(": ", 1) for line in file.read_text(encoding="utf-8").splitlines())
    return {name: float(rest.split()[0]) for name, rest in rows}


def main() -> None:
    """Compiles the kernels that were asked for."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    ask.add_argument("words", nargs="*", help="only kernels whose names have all of these words")
    ask.add_argument("--precisions", nargs="+", default=list(BYTES), choices=list(BYTES))
    ask.add_argument("--forms", nargs="+", default=list(Form), choices=list(Form))
    ask.add_argument("--repeats", type=int, default=1, help="the shortest of so many counts (1)")
    ask.add_argument("--before", type=pathlib.Path, help="what this printed before a change")
    asked = ask.parse_args()
    before = read_times(asked.before) if asked.before else {}
    start_warp()
    # Warp compiles its own header before the first kernel.
    compile_time(next(runs()).module("cpu"), 1)
    for name, module in modules(asked):
        took = compile_time(module, asked.repeats)
        there = before.get(name)
        compared = "" if there is None else f", {there:.2f} s before, {took / there:.2f} times that"
        print(f"{name}: {took:.2f} s{compared}", flush=True)


if __name__ == "__main__":
    main()
