"""Fingerprints of all that warprock answers, to prove that a move changed nothing.

Run it before and after a change that should leave every result as it is, and compare:

    python -m tools.freeze > before.txt
    ... move things ...
    python -m tools.freeze > after.txt
    diff before.txt after.txt

A line is what was asked and the start of the SHA-256 of its answer:

    lanes CASE ENGINE PRECISION FORM FIELD    one response field, every bit of it
    inputs CASE                               the lanes' inputs
    json COMMAND                              what the command prints with --json
    help COMMAND                              its --help

Lanes are at most `--lanes` of each case, evenly taken, over the first `--seconds` of its run, on
one worker. Of JSON what names the moment or the machine is left out: times, versions, processor,
the hash of the kernel files (which a move of these files changes). All of it takes about ten
minutes on two cores with warm kernels; name cases or engines to hash these alone.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import pathlib
from collections.abc import Iterator
from typing import Any

import click
import numpy as np
from click.testing import CliRunner

import warprock as package
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.case.text import case_names
from warprock.cli.main import main as warprock
from warprock.engines import ENGINES, engine_class
from warprock.engines.launching import Form
from warprock.errors import InputError
from warprock.model.response import SampleTimes
from warprock.running.batch import run_batch
from warprock.running.devices import start_warp

ROOT = pathlib.Path(__file__).resolve().parents[1]
SAMPLES = 40
"""Samples of each history."""

MOMENT = {"finished", "wall_time_s", "seconds", "machine", "versions", "kernel_sha256"}
"""Keys of JSON whose values belong to the moment or the machine."""

RUN_CASES = ("free-b1-b3", "single-sine-pulse", "stack-sine-pulse", "space-free")
COMMANDS = (
    "list",
    *(f"explain {case}" for case in RUN_CASES),
    *(f"run {case}" for case in RUN_CASES),
    "reproduce table6",
)
"""Commands whose JSON is kept."""


def digest(content: bytes) -> str:
    """The start of the SHA-256 of a content."""
    return hashlib.sha256(content).hexdigest()[:16]


def lane_lines(name: str, whole: LaneSet, asked: argparse.Namespace) -> Iterator[str]:
    """Lines of one case: its inputs, and every response field of every engine that can run it."""
    count = whole.lanes.lane_count
    some = np.unique(np.linspace(0, count - 1, asked.lanes).astype(np.intp))
    lanes, motions = whole.lanes.take(some), whole.motions.take(some)
    duration = min(asked.seconds, whole.times.duration)
    times = SampleTimes(duration, duration / SAMPLES)
    yield f"inputs {name} {digest(whole.inputs.to_csv().encode())}"
    for engine in asked.engines:
        if engine_class(engine).supports(whole.scene) is not None:
            continue
        for precision in asked.precisions:
            for form in Form:
                found = run_batch(
                    engine, lanes, motions, times, precision=precision, form=form, workers=1
                )
                for field in sorted(found.fields):
                    content = np.ascontiguousarray(found[field]).tobytes()
                    yield f"lanes {name} {engine} {precision} {form} {field} {digest(content)}"


def without_moment(answer: Any) -> Any:
    """An answer without what belongs to the moment or the machine."""
    if isinstance(answer, dict):
        return {key: without_moment(value) for key, value in answer.items() if key not in MOMENT}
    if isinstance(answer, list):
        return [without_moment(value) for value in answer]
    return answer


def json_lines() -> Iterator[str]:
    """Lines of the commands that answer with JSON."""
    for command in COMMANDS:
        result = CliRunner().invoke(warprock, [*command.split(), "--json"])
        if result.exit_code != 0:
            raise SystemExit(f"warprock {command} --json: {result.output}")
        content = json.dumps(without_moment(json.loads(result.stdout)), sort_keys=True)
        yield f"json {command} {digest(content.encode())}"


def help_lines(command: click.Command, path: tuple[str, ...] = ()) -> Iterator[str]:
    """Lines of the help of a command and of all commands below it."""
    text = CliRunner().invoke(warprock, [*path, "--help"]).output
    yield f"help {' '.join(('warprock', *path))} {digest(text.encode())}"
    if isinstance(command, click.Group):
        for name in command.list_commands(click.Context(command)):
            below = command.get_command(click.Context(command), name)
            assert below is not None
            yield from help_lines(below, (*path, name))


def lines(asked: argparse.Namespace) -> Iterator[str]:
    """All lines that were asked for."""
    for name in asked.cases or case_names():
        try:
            whole = expand_lanes(load_case(name))
        except InputError as error:
            if asked.cases:
                raise
            yield f"lanes {name} left out: {error}"
            continue
        yield from lane_lines(name, whole, asked)
    if not asked.cases:
        yield from json_lines()
        yield from help_lines(warprock)


def main() -> None:
    """Prints the lines that were asked for."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    ask.add_argument("cases", nargs="*", help="shipped cases; none is all of them, JSON and help")
    ask.add_argument("--lanes", type=int, default=48, help="lanes of each case (48)")
    ask.add_argument("--seconds", type=float, default=0.6, help="length of each run (0.6)")
    ask.add_argument("--engines", nargs="+", default=list(ENGINES), choices=list(ENGINES))
    ask.add_argument("--precisions", nargs="+", default=["float64", "float32"])
    asked = ask.parse_args()
    if pathlib.Path(package.__file__).resolve().parents[1] != ROOT:
        raise SystemExit(
            f"this would hash {package.__file__}: run python -m tools.freeze in {ROOT}"
        )
    start_warp()
    try:
        for line in lines(asked):
            print(line, flush=True)
    except InputError as error:
        raise SystemExit(str(error)) from None


if __name__ == "__main__":
    main()
