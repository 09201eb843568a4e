"""The files of a sweep: its chunks, and the table they make up.

A chunk is a part (see `warprock.running.parts`) whose footer names the plan, the chunk and its
lanes, and counts what became of them.

The merged table has all lanes in order, in row groups that do not depend on the chunks, and nothing
in it but what the plan says: its bytes are a function of the plan's content alone.
"""

from __future__ import annotations

import collections
import dataclasses
import errno
import pathlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from warprock.case.lanes import LaneSet
from warprock.errors import InputError, Said
from warprock.model.response import Response
from warprock.model.undecided import UNDECIDED
from warprock.running.files import replacing
from warprock.running.lane_table import LANE_TABLE, arrow_table, lane_table
from warprock.running.parts import State, find_part, part_writer, read_part, write_part
from warprock.running.provenance import count_words
from warprock.running.refinement import KEY, refinement_counts, rename_counts
from warprock.sweeps.ahead import ahead
from warprock.sweeps.plan import Plan

CHUNKS = "chunks"
"""Folder of the chunks in that of the sweep."""

ROW_GROUP = 2**17
"""Lanes in a row group of the merged table: some 30 MB at a time, whatever the chunks are."""

WORDS = ("status", "outcome")
REFINEMENT = KEY
COUNTED = (*WORDS, REFINEMENT, UNDECIDED)
"""What a footer counts, so that the state of a sweep needs no table read: words of fields, what
`refinement_counts` found, and the lanes that are undecided."""

NAMED = 5
"""Chunks that an error names before it only counts them."""


@dataclasses.dataclass(frozen=True)
class Chunk:
    """A chunk as it was found.

    Attributes:
        number: Its number.
        state: What is in its place.
        why: What is wrong with it; empty where it is done or missing.
        counts: Lanes by word of everything in `COUNTED`, where it is done.
    """

    number: int
    state: State
    why: str = ""
    counts: Mapping[str, Mapping[str, int]] = dataclasses.field(default_factory=dict)


def chunk_path(folder: pathlib.Path, number: int) -> pathlib.Path:
    """Where a chunk of a sweep has its place."""
    return folder / CHUNKS / f"chunk-{number:06d}.parquet"


def find_chunk(plan: Plan, folder: pathlib.Path, number: int) -> Chunk:
    """The state of a chunk, from its file."""
    lanes = plan.lanes_of(number)
    place = {"chunk": number, "first": lanes.start, "end": lanes.stop}
    part = find_part(chunk_path(folder, number), {"plan": plan.id, **place})
    if part.state is State.MISSING:
        return Chunk(number, part.state)
    if part.state is State.BROKEN:
        return Chunk(number, part.state, "it cannot be read: it is cut off or no Parquet")
    footer = rename_counts(part.footer)
    if not {"plan", *place, *COUNTED} <= set(footer):
        return Chunk(number, State.FOREIGN, "it is no chunk of a sweep")
    if part.state is State.FOREIGN:
        why = f"it is of the plan {str(footer['plan'])[:12]}"
        if footer["plan"] == plan.id:
            why = f"it is chunk {footer['chunk']}, lanes {footer['first']} to {footer['end']}"
        return Chunk(number, State.FOREIGN, why)
    if part.rows != len(lanes):
        return Chunk(number, State.BROKEN, f"it has {part.rows} rows for {len(lanes)}")
    return Chunk(number, State.DONE, counts={field: footer[field] for field in COUNTED})


def find_chunks(plan: Plan, folder: pathlib.Path, numbers: Iterable[int]) -> Iterator[Chunk]:
    """The states of some chunks, one at a time: a sweep may have very many."""
    return (find_chunk(plan, folder, number) for number in numbers)


def own_chunks(plan: Plan, folder: pathlib.Path, numbers: Iterable[int]) -> Iterator[Chunk]:
    """The states of chunks; a file of another plan in the place of one must not be overwritten.

    Raises:
        InputError: There is such a file.
    """
    for chunk in find_chunks(plan, folder, numbers):
        if chunk.state is State.FOREIGN:
            path = chunk_path(folder, chunk.number)
            allowed = "must be a chunk of the plan beside it, or not be there: move it away"
            raise InputError(str(path), "", Said(f"another file: {chunk.why}"), allowed)
        yield chunk


def write_chunk(
    plan: Plan, folder: pathlib.Path, number: int, lane_set: LaneSet, response: Response
) -> dict[str, dict[str, int]]:
    """Writes a chunk to its place.

    Args:
        plan: The plan.
        folder: Folder of the sweep.
        number: Number of the chunk.
        lane_set: Its lanes.
        response: The engine's answer for them.

    Returns:
        Lanes by word of everything in `COUNTED`.

    Raises:
        OSError: The file could not be written; there is none, or the one that was there before.
    """
    lanes = plan.lanes_of(number)
    counts = {field: count_words(response, field) for field in WORDS}
    settings = plan.case.engine_settings(plan.engine)
    counts[REFINEMENT] = refinement_counts(response, lane_set, settings, plan.tolerance)
    rows = lane_table(lane_set, response)
    counts[UNDECIDED] = {"lanes": int(rows[UNDECIDED].sum())}
    footer = {"plan": plan.id, "chunk": number, "first": lanes.start, "end": lanes.stop, **counts}
    table = arrow_table(rows).replace_schema_metadata(None)
    path = chunk_path(folder, number)
    try:
        write_part(path, table, footer)
    except OSError as error:
        raise _unwritten(error, f"chunk {number} ({path})") from error
    return counts


def _unwritten(error: OSError, what: str) -> OSError:
    why = error.strerror or error
    mend = "make room" if error.errno in (errno.ENOSPC, errno.EDQUOT) else "mend that"
    return OSError(
        f"{what} could not be written: {why}; nothing else is lost: {mend}, then run the same "
        "command again"
    )


def sweep_state(plan: Plan, folder: pathlib.Path) -> dict[str, Any]:
    """How far a sweep is, ready for JSON.

    Args:
        plan: The plan.
        folder: Folder of the sweep.

    Returns:
        plan, engine, case, lanes (total and done), chunks (total, how many of them are done, and
        the numbers of those missing, broken and foreign, with what is wrong), status and outcome
        (lanes done by word), refinement (see `refinement_counts`) and the tolerance, and strangers:
        other files among the chunks.
    """
    found = tally(plan, folder, range(plan.chunk_count))
    done = found.numbers[State.DONE]
    there = (folder / CHUNKS).iterdir() if (folder / CHUNKS).is_dir() else ()
    return {
        "plan": plan.id,
        "case": plan.content["case"]["name"],
        "engine": plan.engine,
        "lanes": plan.lane_count,
        "lanes_done": sum(len(plan.lanes_of(number)) for number in done),
        "chunks": plan.chunk_count,
        "chunks_done": len(done),
        **{
            state.value: found.numbers[state]
            for state in (State.MISSING, State.BROKEN, State.FOREIGN)
        },
        "wrong": found.wrong,
        "strangers": sorted(str(path) for path in there if not _is_place(plan, folder, path)),
        **found.counts,
        "tolerance": plan.tolerance,
    }


def _is_place(plan: Plan, folder: pathlib.Path, path: pathlib.Path) -> bool:
    """Whether a file has the name of one of the chunks."""
    digits = path.stem.removeprefix("chunk-")
    if not (digits.isascii() and digits.isdecimal()):
        return False
    number = int(digits)
    return number < plan.chunk_count and path.name == chunk_path(folder, number).name


@dataclasses.dataclass(frozen=True)
class Tally:
    """What some chunks are, together.

    Attributes:
        numbers: Their numbers by their state.
        wrong: What is wrong with files that are broken or foreign, by their paths.
        counts: Lanes of those that are done by word of everything in `COUNTED`.
    """

    numbers: Mapping[State, list[int]]
    wrong: Mapping[str, str]
    counts: Mapping[str, Mapping[str, int]]


def tally(plan: Plan, folder: pathlib.Path, numbers: Iterable[int]) -> Tally:
    """Looks at some chunks, one at a time."""
    by_state: dict[State, list[int]] = {state: [] for state in State}
    wrong = {}
    totals: dict[str, collections.Counter[str]] = {name: collections.Counter() for name in COUNTED}
    for chunk in find_chunks(plan, folder, numbers):
        by_state[chunk.state].append(chunk.number)
        if chunk.state in (State.BROKEN, State.FOREIGN):
            wrong[str(chunk_path(folder, chunk.number))] = chunk.why
        for name, words in chunk.counts.items():
            totals[name].update(words)
    return Tally(by_state, wrong, {name: dict(total) for name, total in totals.items()})


def merge(
    plan: Plan,
    folder: pathlib.Path,
    output: pathlib.Path | None = None,
    progress: Callable[[int], None] | None = None,
) -> pathlib.Path:
    """Joins the chunks of a sweep in one file, chunk by chunk.

    Args:
        plan: The plan.
        folder: Folder of the sweep.
        output: File to write, Parquet, or CSV where its name ends in .csv; `lanes.parquet` in the
            folder of the sweep where None.
        progress: Called with the number of lanes written so far.

    Returns:
        The file.

    Raises:
        InputError: A chunk is missing, broken or foreign.
        OSError: The file could not be written; there is none, or the one that was there before.
    """
    path = output or folder / LANE_TABLE
    found: dict[State, list[int]] = {State.BROKEN: [], State.MISSING: [], State.DONE: []}
    for chunk in own_chunks(plan, folder, range(plan.chunk_count)):
        found[chunk.state].append(chunk.number)
    for state in (State.BROKEN, State.MISSING):
        numbers = found[state]
        if numbers:
            more = f" and {len(numbers) - NAMED} more" if len(numbers) > NAMED else ""
            names = ", ".join(chunk_path(folder, number).name for number in numbers[:NAMED])
            allowed = f"must all be complete: warprock sweep run {folder}"
            raise InputError(str(folder), "chunks", Said(f"{state} {names}{more}"), allowed)
    try:
        with replacing(path) as temporary:
            write = _write_csv if path.suffix == ".csv" else _write_merged
            write(plan, folder, temporary, progress)
    except OSError as error:
        raise _unwritten(error, str(path)) from error
    # What Arrow keeps for later, for the page of the sweep to have.
    pa.default_memory_pool().release_unused()
    return path


def _write_merged(
    plan: Plan,
    folder: pathlib.Path,
    path: pathlib.Path,
    progress: Callable[[int], None] | None,
) -> None:
    written = 0
    writer: pq.ParquetWriter | None = None
    try:
        for group in ahead(_row_groups(_chunk_tables(plan, folder))):
            writer = writer or part_writer(path, group.schema, plan.content)
            writer.write_table(group, row_group_size=ROW_GROUP)
            written += len(group)
            if progress is not None:
                progress(written)
    finally:
        if writer is not None:
            writer.close()


def _write_csv(
    plan: Plan,
    folder: pathlib.Path,
    path: pathlib.Path,
    progress: Callable[[int], None] | None,
) -> None:
    """Joins the chunks of a sweep as text, in the form of the CSV table of a run."""
    written = 0
    for table in _chunk_tables(plan, folder):
        rows = table.to_pandas()
        rows.to_csv(path, mode="a" if written else "w", header=not written, index=False)
        written += len(rows)
        if progress is not None:
            progress(written)


def _chunk_tables(plan: Plan, folder: pathlib.Path) -> Iterator[pa.Table]:
    for number in range(plan.chunk_count):
        path = chunk_path(folder, number)
        try:
            table = read_part(path)
        except OSError as error:
            allowed = "must be as it was written: delete it and run the sweep again"
            raise InputError(str(path), "", Said(f"damaged data: {error}"), allowed) from None
        yield table


def _row_groups(tables: Iterable[pa.Table]) -> Iterator[pa.Table]:
    """The rows of some tables in groups of `ROW_GROUP`, the last one smaller."""
    waiting: pa.Table | None = None
    for table in tables:
        waiting = table if waiting is None else pa.concat_tables([waiting, table])
        while len(waiting) >= ROW_GROUP:
            yield _number_words(waiting.slice(0, ROW_GROUP))
            waiting = waiting.slice(ROW_GROUP)
    if waiting is not None and len(waiting):
        yield _number_words(waiting)


def _number_words(table: pa.Table) -> pa.Table:
    """Columns of words numbered in the order in which these rows have them.

    Each chunk has numbered its words in its own way; no word is written out for each lane.
    """
    columns = [_number(column.combine_chunks()) for column in table.columns]
    fields = [
        field.with_type(column.type) for field, column in zip(table.schema, columns, strict=True)
    ]
    return pa.Table.from_arrays(columns, schema=pa.schema(fields))


def _number(column: pa.Array) -> pa.Array:
    """A column as it is, but for words: the first of them has the number 0, and so on."""
    if pa.types.is_string(column.type):
        return column.dictionary_encode()
    if not pa.types.is_dictionary(column.type):
        return column
    numbers = column.indices.dictionary_encode()
    words = column.dictionary.cast(pa.string()).take(numbers.dictionary)
    return pa.DictionaryArray.from_arrays(numbers.indices, words)
