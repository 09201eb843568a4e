"""Parts of a long piece of work that are kept as files, so that it goes on where it was stopped.

A part is a Parquet file that is there whole or not at all. Its footer, JSON in the metadata of the
file, says what the part is of: a plan, a number, a fingerprint of what decides its numbers. A part
is done if the file can be read and its footer says what is asked for. Nothing is locked; two
processes that write the same part write the same bytes.
"""

from __future__ import annotations

import dataclasses
import enum
import json
import pathlib
from collections.abc import Mapping
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from warprock.reading import require_plain
from warprock.running.files import replacing

FOOTER = b"warprock"
"""Key of the footer in the metadata of a file."""

COMPRESSION = "zstd"


class State(enum.StrEnum):
    """What is found in the place of a part."""

    DONE = "done"
    MISSING = "missing"
    BROKEN = "broken"
    FOREIGN = "foreign"


@dataclasses.dataclass(frozen=True)
class Part:
    """What is found in the place of a part.

    Attributes:
        state: Whether it is what was asked for.
        footer: What the file says of itself; empty where it says nothing.
        rows: Rows of its table.
    """

    state: State
    footer: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    rows: int = 0


def find_part(path: pathlib.Path, of: Mapping[str, Any]) -> Part:
    """What is in the place of a part, without reading its table.

    Args:
        path: Where the part has its place.
        of: What its footer must say.

    Returns:
        The part: missing; broken, where the file is cut off or no Parquet; foreign, where its
        footer says something else; or done.
    """
    try:
        require_plain(path)
        found = pq.read_metadata(path)
    except FileNotFoundError:
        return Part(State.MISSING)
    except (OSError, pa.ArrowException):
        return Part(State.BROKEN)
    try:
        footer = json.loads((found.metadata or {}).get(FOOTER, b"{}"))
    except ValueError:
        footer = {}
    footer = footer if isinstance(footer, dict) else {}
    mine = all(key in footer and footer[key] == value for key, value in of.items())
    return Part(State.DONE if mine else State.FOREIGN, footer, found.num_rows)


def read_part(path: pathlib.Path) -> pa.Table:
    """The table of a part.

    Raises:
        OSError: It cannot be read, or is not as it was written.
    """
    try:
        with pq.ParquetFile(path, page_checksum_verification=True) as file:
            return file.read()
    except pa.ArrowException as error:
        raise OSError(str(error)) from None


def write_part(path: pathlib.Path, table: pa.Table, footer: Mapping[str, Any]) -> None:
    """Writes a part to its place, in a folder that is made if it does not exist.

    Args:
        path: Where the part has its place.
        table: Its table, which becomes one row group.
        footer: What it is of, ready for JSON.

    Raises:
        OSError: It could not be written; there is none, or the one that was there before.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as temporary, part_writer(temporary, table.schema, footer) as writer:
        writer.write_table(table, row_group_size=max(1, len(table)))


def part_writer(
    path: pathlib.Path, schema: pa.Schema, footer: Mapping[str, Any]
) -> pq.ParquetWriter:
    """A writer of a file with a footer; numbers are written as they are, words by number."""
    text = json.dumps(footer, ensure_ascii=False, separators=(",", ":"))
    return pq.ParquetWriter(
        path,
        schema.with_metadata({**(schema.metadata or {}), FOOTER: text}),
        compression=COMPRESSION,
        use_dictionary=[field.name for field in schema if pa.types.is_dictionary(field.type)],
        write_page_checksum=True,
    )
