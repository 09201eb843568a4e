"""What the commands of sweeps print, and how far a sweep is while it runs."""

from __future__ import annotations

import contextlib
import dataclasses
import datetime
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import rich.progress

from warprock.findings.refinement import bad_sentences, refinement_sentences
from warprock.model.undecided import UNDECIDED
from warprock.model.words import lane_count_text
from warprock.tables.terminal import plain_console, progress_text

if TYPE_CHECKING:
    import pathlib

SECONDS_BETWEEN_LINES = 10.0
"""Time between two lines of progress where stderr is no terminal."""

NAMED = 20
"""Chunks and files that a list shows before it only counts them."""


@contextlib.contextmanager
def sweep_progress(total: int, chunks: int, kept: int) -> Iterator[Callable[[int], None]]:
    """Lanes done, lanes a second and time left on stderr: a bar, or lines without a terminal.

    Args:
        total: Lanes that this run has to do.
        chunks: Chunks that this run has to do.
        kept: Chunks that were done before.

    Yields:
        A function to call with the number of lanes finished so far.
    """
    before = f"{kept} chunks done before, " * (kept > 0)
    print(
        f"sweep: {before}{chunks} chunks, {lane_count_text(total)} to run",
        file=sys.stderr,
        flush=True,
    )
    console = plain_console(stderr=True)
    if not console.is_terminal:
        yield _lines(total)
        return
    columns = (
        rich.progress.TextColumn("sweep, lanes"),
        rich.progress.BarColumn(),
        rich.progress.MofNCompleteColumn(),
        progress_text("{task.fields[rate]}"),
    )
    with rich.progress.Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=total, rate="")
        begin = time.perf_counter()

        def show(done: int) -> None:
            bar.update(task, completed=done, rate=_rate(done, total, time.perf_counter() - begin))

        yield show


def _lines(total: int) -> Callable[[int], None]:
    begin = last = time.perf_counter()
    said = 0

    def say(done: int) -> None:
        nonlocal last, said
        now = time.perf_counter()
        if done > said and (now - last >= SECONDS_BETWEEN_LINES or done == total):
            last, said = now, done
            rate = _rate(done, total, now - begin)
            print(f"sweep: {done} of {lane_count_text(total)}, {rate}", file=sys.stderr, flush=True)

    return say


def _rate(done: int, total: int, seconds: float) -> str:
    if done == 0 or seconds <= 0.0:
        return ""
    left = datetime.timedelta(seconds=round((total - done) * seconds / done))
    return f"{done / seconds:.0f} lanes/s, {left} left"


def print_plan(found: Mapping[str, Any]) -> None:
    """Prints what `sweeps.plan.plan_facts` found, and what to do next."""
    written = "written" if found["written"] else "there already"
    folder, settings = found["folder"], found["settings"]
    _print(f"plan {found['plan'][:12]} of {found['case']}: {written}, in {folder}")
    _print(f"  lanes: {found['lanes']}, in {found['chunks']} chunks of {found['chunk_lanes']}")
    values = ", ".join(f"{name} = {value}" for name, value in settings.items())
    _print(f"  engine: {found['engine']} in {found['precision']} on {found['device']}; {values}")
    wanted = f"estimated, and refined until it is within {found['tolerance']} of the slenderness"
    _print(f"  error of every lane: {f'{wanted} angle' if found['estimate'] else 'not estimated'}")
    for record in found["records"]:
        _print(f"  record: {record['name']}, SHA-256 {record['sha256'][:12]}")
    _print(f"next: warprock sweep run {folder}; warprock sweep merge {folder}")


def print_counts(found: Mapping[str, Any], engine: str, settings: Any) -> None:
    """Prints what `sweeps.run.shard_counts` found of an engine with its settings."""
    whole = found["lanes"] == found["lanes_of_sweep"]
    of = "" if whole else f" of shard {found['shard']}, of {found['lanes_of_sweep']} in all,"
    _print(
        f"{found['lanes_done']} of {lane_count_text(found['lanes'])}{of} done in {found['folder']}"
    )
    _print_words(found)
    _print(f"  lanes whose numbers may not be used: {found['unusable']}")
    facts = {
        **found,
        "lanes": found["lanes_done"],
        "engine": {"name": engine, "settings": dataclasses.asdict(settings)},
    }
    for line in [*refinement_sentences(facts, mend="plan anew with"), *bad_sentences(facts)]:
        _print(f"  {line}")
    left = found["chunks_left"]
    if left:
        _print(f"  chunks of the sweep that are still to be done: {left}")
    _print(f"next: warprock sweep {'status' if left else 'merge'} {found['folder']}")


def print_state(found: Mapping[str, Any], folder: pathlib.Path) -> None:
    """Prints what `sweeps.chunks.sweep_state` found."""
    _print(f"plan {found['plan'][:12]} of {found['case']}, {found['engine']}, in {folder}")
    _print(f"  chunks: {found['chunks_done']} of {found['chunks']} done")
    for state in ("missing", "broken", "foreign"):
        if found[state]:
            _print(f"  {state}: {len(found[state])}: {_first(found[state])}")
    for path, why in found["wrong"].items():
        _print(f"  {path}: {why}")
    if found["strangers"]:
        _print(f"  other files beside the chunks: {_first(found['strangers'])}")
    _print(f"  lanes: {found['lanes_done']} of {found['lanes']} done")
    _print_words(found)
    done = found["chunks_done"] == found["chunks"]
    _print(f"next: warprock sweep {'merge' if done else 'run'} {folder}")


def print_sweep_bench(rows: Sequence[Mapping[str, Any]]) -> None:
    """Prints what `measure.sweep_bench.run_sweep_bench` measured."""
    from warprock.tables.terminal import print_rows

    print_rows("Sweeps from plan to merged table, measured here and now", rows)


def _print_words(found: Mapping[str, Any]) -> None:
    for name in ("outcome", "status", "refinement"):
        if name == "refinement" and not found[name]:
            continue
        words = ", ".join(f"{word} {count}" for word, count in found[name].items() if count)
        _print(f"  {name}: {words or '-'}")
    lanes = found[UNDECIDED].get("lanes", 0)
    if lanes:
        _print(
            f"  undecided: {lanes} lanes had not fallen when their run ended, but still moved or "
            "were still shaken"
        )


def _first(items: Sequence[object]) -> str:
    more = f" and {len(items) - NAMED} more" if len(items) > NAMED else ""
    return ", ".join(str(item) for item in items[:NAMED]) + more


def _print(text: str) -> None:
    sys.stdout.write(text + "\n")
