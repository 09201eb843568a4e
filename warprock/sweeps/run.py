"""Runs the chunks of a sweep that are not there yet: case -> lanes -> engine -> response -> file.

Which chunks are done is known from the files alone. So a sweep that was stopped, killed or spread
over machines is continued by running it again.
"""

from __future__ import annotations

import concurrent.futures
import contextlib
import dataclasses
import pathlib
import re
import signal
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

from warprock.case.lanes import LaneSet, expand_lanes
from warprock.errors import InputError
from warprock.model.response import Response, SampleTimes
from warprock.running.case_run import run_lane_set
from warprock.running.devices import start_warp
from warprock.running.files import remove_dead_temporaries
from warprock.running.options import Progress, count_from
from warprock.running.parts import State
from warprock.running.refinement import count_bad, unusable_lanes
from warprock.sweeps.ahead import ahead
from warprock.sweeps.chunks import (
    CHUNKS,
    REFINEMENT,
    find_chunk,
    own_chunks,
    tally,
    write_chunk,
)
from warprock.sweeps.plan import Plan, require_same_software

RunChunks = Callable[[list[int], Progress], None]
"""Runs chunks, and says how many of their lanes are finished."""

_SHARD = re.compile(r"\s*(\d{1,9})\s*/\s*(\d{1,9})\s*", re.ASCII)

STOPPING_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGTERM", "SIGUSR1") if hasattr(signal, name)
)
"""What a batch system sends before it ends a job."""


class Stopped(BaseException):
    """A signal asked the sweep to stop; like KeyboardInterrupt, no error to be handled on the way.

    The chunk in hand is dropped; what has been done stays.
    """


@contextlib.contextmanager
def stopping() -> Iterator[None]:
    """Lets the signals of a batch system end the block with `Stopped`."""

    def stop(number: int, _frame: FrameType | None) -> None:
        raise Stopped(signal.Signals(number).name)

    before = {each: signal.signal(each, stop) for each in STOPPING_SIGNALS}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


@dataclasses.dataclass(frozen=True)
class Shard:
    """A part of a sweep's chunks: every `count`-th one.

    Attributes:
        number: From 1 to `count`.
        count: Parts of the sweep.
    """

    number: int = 1
    count: int = 1

    def chunks(self, plan: Plan) -> range:
        """Numbers of the chunks of a plan that are in the part."""
        return range(self.number - 1, plan.chunk_count, self.count)


def read_shard(text: str) -> Shard:
    """A shard from what a user writes, such as 2/7.

    Raises:
        InputError: It is not i/n with i from 1 to n.
    """
    match = _SHARD.fullmatch(text)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise InputError("--shard", "", text, "must be i/n, such as 2/7, with i from 1 to n")
    return Shard(int(match[1]), int(match[2]))


def run_chunk(
    plan: Plan,
    folder: pathlib.Path,
    number: int,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
) -> None:
    """Runs one chunk and writes it to its place, unless it is there.

    Args:
        plan: The plan.
        folder: Folder of the sweep.
        number: Number of the chunk.
        workers: Worker threads; None uses the cores at hand.
        progress: Called with the number of its lanes finished so far.

    Raises:
        OSError: It could not be written.
    """
    if find_chunk(plan, folder, number).state is State.DONE:
        return
    lane_set = expand_lanes(plan.case, plan.lanes_of(number))
    response = _response_of_chunk(plan, lane_set, workers, progress)
    write_chunk(plan, folder, number, lane_set, response)


def _response_of_chunk(
    plan: Plan, lane_set: LaneSet, workers: int | None, progress: Progress | None
) -> Response:
    """What became of the lanes of a chunk."""
    start_warp()
    return run_lane_set(
        plan.engine,
        lane_set,
        SampleTimes(lane_set.longest.duration),
        plan.options(workers, progress),
        settings=plan.case.engine_settings(plan.engine),
    )


def chunks_to_run(plan: Plan, folder: pathlib.Path, shard: Shard) -> list[int]:
    """Numbers of the chunks of a shard that are not complete.

    Raises:
        InputError: A file in the place of a chunk is of another plan, or something here differs
            from what the plan was made with.
    """
    require_same_software(plan)
    found = own_chunks(plan, folder, shard.chunks(plan))
    return [chunk.number for chunk in found if chunk.state is not State.DONE]


def run_here(plan: Plan, folder: pathlib.Path, workers: int | None = None) -> RunChunks:
    """A way to run chunks: one after the other in this process, each on all of its threads.

    While a chunk runs, the one before it is written and the lanes of the next are made.
    """

    def lanes_of(number: int) -> LaneSet | None:
        """The lanes of a chunk, unless it is there."""
        if find_chunk(plan, folder, number).state is State.DONE:
            return None
        return expand_lanes(plan.case, plan.lanes_of(number))

    def run(numbers: list[int], progress: Progress) -> None:
        remove_dead_temporaries(folder / CHUNKS, "chunk-*")
        before = 0
        # Whoever stops a run waits for the file in hand.
        with concurrent.futures.ThreadPoolExecutor(1) as writer:
            writing: list[concurrent.futures.Future[Any]] = []
            for number, lanes in zip(numbers, ahead(map(lanes_of, numbers)), strict=True):
                if lanes is not None:
                    counted = count_from(progress, before)
                    found = _response_of_chunk(plan, lanes, workers, counted)
                    for each in writing:
                        each.result()
                    writing = [writer.submit(write_chunk, plan, folder, number, lanes, found)]
                before += len(plan.lanes_of(number))
                progress(before)
            for each in writing:
                each.result()

    return run


def shard_counts(plan: Plan, folder: pathlib.Path, shard: Shard) -> dict[str, Any]:
    """What became of the lanes of a shard, ready for JSON.

    Returns:
        shard (such as 2/7), lanes and lanes_done of the shard, lanes_of_sweep, chunks_left (of the
        whole sweep: those that are not done), status and outcome (lanes done by word), refinement
        (see `refinement_counts`) and the tolerance, unusable (lanes done whose numbers may not be
        used) and bad (these, and those that missed the tolerance).
    """
    chunks = shard.chunks(plan)
    found = tally(plan, folder, chunks)
    others = [number for number in range(plan.chunk_count) if number not in chunks]
    left = len(chunks) - len(found.numbers[State.DONE])
    left += len(others) - len(tally(plan, folder, others).numbers[State.DONE])
    return {
        "shard": f"{shard.number}/{shard.count}",
        "lanes_of_sweep": plan.lane_count,
        "chunks_left": left,
        "lanes": sum(len(plan.lanes_of(number)) for number in chunks),
        "lanes_done": sum(len(plan.lanes_of(number)) for number in found.numbers[State.DONE]),
        **found.counts,
        "tolerance": plan.tolerance,
        "unusable": unusable_lanes(found.counts["status"]),
        "bad": count_bad(found.counts["status"], found.counts[REFINEMENT]),
    }
