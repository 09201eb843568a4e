"""Kills a sweep at random moments with SIGKILL.

Run it as `python -m tests.shared.sweep_killer DIR KILLS SEED`.

A fork of this process goes on with the sweep, as a process of its own would, but without the
seconds that imports take. Every third one is killed where it hurts most: its chunk is written, and
does not have its name yet. Prints what was found after each kill, as JSON.
"""

from __future__ import annotations

import json
import os
import pathlib
import random
import shutil
import signal
import sys
import time

from warprock.running import files
from warprock.sweeps.chunks import CHUNKS
from warprock.sweeps.plan import PLAN, Plan, read_plan
from warprock.sweeps.run import Shard, chunks_to_run, run_chunk, run_here


def end_here(*_paths: object) -> None:
    """In place of a move: the end of the process."""
    os.kill(os.getpid(), signal.SIGKILL)


def chunks_done(folder: pathlib.Path) -> int:
    """Chunks that are in their places."""
    return len(list((folder / CHUNKS).glob("chunk-*")))


def seconds_of_a_chunk(plan: Plan, folder: pathlib.Path) -> float:
    """Wall time of a chunk whose kernel is there already [s]."""
    for number in (0, 1):
        begin = time.perf_counter()
        run_chunk(plan, folder, number, workers=1)
    return time.perf_counter() - begin


def killed(plan: Plan, folder: pathlib.Path, more: int, after: float | None) -> bool:
    """Whether a run of the sweep was killed.

    Args:
        plan: The plan.
        folder: Folder of the sweep.
        more: Chunks that it does first.
        after: Time from then to the kill [s]; None is amid the next write.
    """
    left, end = chunks_to_run(plan, folder, Shard()), chunks_done(folder) + more
    child = os.fork()
    if child == 0:
        run_here(plan, folder, 1)(left[:more], lambda done: None)
        if after is None:
            files.os.replace = end_here  # type: ignore[assignment]
        run_here(plan, folder, 1)(left[more:], lambda done: None)
        os._exit(0)
    if after is not None:
        while chunks_done(folder) < end:
            time.sleep(1e-3)
        time.sleep(after)
        os.kill(child, signal.SIGKILL)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


def main(folder: pathlib.Path, kills: int, seed: int) -> None:
    """Kills and reports."""
    plan, chance = read_plan(folder), random.Random(seed)
    aside = folder / "aside"
    aside.mkdir()
    shutil.copy(folder / PLAN, aside / PLAN)
    once = seconds_of_a_chunk(plan, aside)
    shutil.rmtree(aside)
    rows = []
    for number in range(kills):
        after = None if number % 3 == 2 else chance.uniform(0.0, once)
        hit = killed(plan, folder, chance.randrange(3), after)
        temporaries = len(list((folder / CHUNKS).glob(".*.tmp")))
        rows.append({"hit": hit, "done": chunks_done(folder), "half": temporaries})
    print(json.dumps(rows))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
