"""What an analysis has to show: JSON, files and a print-out, for the one driver of the commands."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import pandas as pd


@dataclasses.dataclass(frozen=True)
class Report:
    """What an analysis has to show.

    Attributes:
        json: What `--json` prints, but for the files that were written.
        tables: Tables to write; see `running.results.write_results`.
        facts: What `run.json` holds; None writes none.
        show: Prints the analysis on the terminal.
        beside: Whether it was made from the results in a folder, which stay when it is written.
        came_out: What came out, in one sentence.
        then: The command to try next, once the results are in a folder.
        texts: Texts to write, by the name of their file.
    """

    json: Mapping[str, Any]
    tables: Mapping[str, pd.DataFrame]
    facts: Mapping[str, Any] | None
    show: Callable[[], None]
    beside: bool = False
    came_out: str = ""
    then: str = ""
    texts: Mapping[str, str] = dataclasses.field(default_factory=dict)
