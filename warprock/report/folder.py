"""A folder of results as a page reads it: facts, tables, figures, and which files belong to it."""

from __future__ import annotations

import base64
import dataclasses
import functools
import hashlib
import pathlib
import re
import urllib.parse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from warprock.errors import InputError, Said
from warprock.findings.kinds import shapes
from warprock.reading import read_bytes, reason, require_plain
from warprock.report.columns import require_columns
from warprock.report.content import Picture
from warprock.report.earlier import earlier_sources
from warprock.running.results import PROVENANCE
from warprock.running.run_file import read_facts, read_object

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow.parquet as pq

MOST_ROWS = 1_000_000
"""Rows of a table that a page is made from; of a longer one the first are read."""


class Drawn(Protocol):
    """A figure at hand, as `warprock.figures` makes it."""

    @property
    def name(self) -> str:
        """Name of its file without the ending."""

    @property
    def title(self) -> str:
        """What it says, in one line."""

    @property
    def alt(self) -> str:
        """What a reader who cannot see it is told."""

    def svg(self) -> str:
        """The figure as SVG."""

    def png(self) -> bytes:
        """The figure as PNG."""


@dataclasses.dataclass(frozen=True)
class ResultFolder:
    """A folder of results.

    Attributes:
        path: Where it is.
        drawings: Figures that are at hand as they were drawn.
    """

    path: pathlib.Path
    drawings: Sequence[Drawn] = ()

    def has(self, *names: str) -> bool:
        """Whether files of these names are all there."""
        return all((self.path / name).is_file() for name in names)

    @functools.cached_property
    def facts(self) -> dict[str, Any]:
        """What `run.json` holds; empty where there is none."""
        return read_facts(self.path / PROVENANCE, shapes()) if self.has(PROVENANCE) else {}

    def json(self, name: str) -> dict[str, Any]:
        """What a JSON file holds.

        Raises:
            InputError: It cannot be read, or holds no object.
        """
        return read_object(self.path / name)

    def table(self, name: str, wanted: str = "") -> pd.DataFrame:
        """A table; `attrs["columns"]` holds unit and meaning of columns where its file does.

        Args:
            name: Name of a file that ends in .parquet or .csv.
            wanted: Pattern of the columns to read, of a Parquet file; empty reads all.

        Raises:
            InputError: It cannot be read, or lacks columns that a page needs.
        """
        import pandas as pd
        import pyarrow as pa
        import pyarrow.parquet as pq

        path = self.path / name
        try:
            require_plain(path)
            if name.endswith(".csv"):
                found = pd.read_csv(path, nrows=MOST_ROWS, keep_default_na=True)
                require_columns(found, name, str(path))
                return found
            with pq.ParquetFile(path) as file:
                names = [each for each in file.schema_arrow.names if re.search(wanted, each)]
                arrow = file.read_row_groups(_first_groups(file), columns=names)
        except InputError:
            raise
        except (OSError, ValueError, pa.ArrowException) as error:
            why = reason(error) if isinstance(error, OSError) else str(error)
            raise InputError(str(path), "", Said("the file"), f"must be a table ({why})") from None
        schema = arrow.schema
        # Column by column, each let go once it is there: no two tables at a time.
        table: pd.DataFrame = arrow.to_pandas(split_blocks=True, self_destruct=True)
        del arrow
        table.attrs["columns"] = {
            field.name: {key.decode(): value.decode() for key, value in field.metadata.items()}
            for field in schema
            if field.metadata
        }
        require_columns(table, name, str(path))
        return table

    def rows(self, name: str) -> int:
        """Rows of a Parquet file."""
        import pyarrow.parquet as pq

        return int(pq.read_metadata(self.path / name).num_rows)

    def digest(self, name: str) -> str:
        """SHA-256 of a plain file."""
        require_plain(self.path / name)
        with (self.path / name).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()

    def pictures(self, *patterns: str) -> list[Picture]:
        """Figures whose files are there, as drawn where they are at hand, else as they lie there.

        Args:
            patterns: Names of files, as `glob` matches them, in the order of the page.
        """
        names = [path.name for pattern in patterns for path in sorted(self.path.glob(pattern))]
        return [self._picture(name) for name in dict.fromkeys(names)]

    def _picture(self, name: str) -> Picture:
        digest = self.digest(name)
        for drawn in self.drawings:
            if name == f"{drawn.name}.png":
                return Picture(name, drawn.title, drawn.alt, _address(drawn), digest)
        path = self.path / name
        title, alt = _png_words(path)
        title = title or name.removesuffix(".png").replace("-", " ")
        source = self._earlier.get(digest) or _png(read_bytes(path))
        return Picture(name, title, alt or f"Figure: {title}", source, digest)

    @functools.cached_property
    def _earlier(self) -> dict[str, str]:
        return earlier_sources(self.path)


MOST_SVG = 1_500_000
"""Characters of a drawing as SVG; a longer one stands in the page as PNG."""


def _address(drawn: Drawn) -> str:
    """A drawing as a `data:` address."""
    text = drawn.svg()
    if len(text) > MOST_SVG:
        return _png(drawn.png())
    return "data:image/svg+xml," + urllib.parse.quote(text, safe=" =:/;,.()'<>[]{}!?*+-_~@&|^")


def _png(content: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(content).decode('ascii')}"


def _png_words(path: pathlib.Path) -> tuple[str, str]:
    """Title and alternative text that a figure of ours has in its metadata; empty without."""
    import PIL.Image

    try:
        with PIL.Image.open(path) as image:
            words = image.info
    except OSError as error:
        raise InputError(str(path), "", Said("the file"), f"must be a figure: {error}") from None
    return str(words.get("Title", "")), str(words.get("Description", ""))


def _first_groups(file: pq.ParquetFile) -> list[int]:
    """The first row groups of a file, as many as a page is made from."""
    groups, rows = [], 0
    for group in range(file.metadata.num_row_groups):
        if rows < MOST_ROWS:
            groups.append(group)
        rows += file.metadata.row_group(group).num_rows
    return groups
