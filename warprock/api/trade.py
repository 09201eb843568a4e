"""What accuracy costs: the function, and what the command of its name calls, too."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Sequence

import pandas as pd

from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.progress import Shown, shown
from warprock.arguments import at_the_door, several
from warprock.figures.trade import draw_trade
from warprock.findings.trade import find_trade
from warprock.measure.trade import TABLE, Entry, all_entries, run_trade, write_csv
from warprock.measure.trade_scenes import TRADE_SCENES
from warprock.running.devices import start_warp
from warprock.running.options import Progress


@at_the_door
def trade(
    engine: str | Sequence[str] = (),
    *,
    scene: str | Sequence[str] = (),
    folder: str | os.PathLike[str] = "results",
    progress: Shown = True,
) -> Found:
    """What accuracy costs: every engine over its own knobs, on fixed scenes.

    Writes trade.parquet row by row, so that a run that was stopped goes on where it was; then
    trade.csv, in the form that `run --cheapest` reads, and the figure trade.png.

    Args:
        engine: Names, one or several, of engines; all without.
        scene: Only free, pulse, sine, record or stack; or several.
        folder: Folder of the table; rows that it has from this machine are kept.
        progress: As in `run`.

    Returns:
        A `Found` whose table has one row a scene, engine, settings and precision.

    Raises:
        InputError: An unknown engine or scene, or a table in the folder that cannot be read.

    Example:
        >>> import tempfile
        >>> import warprock as wr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     found = wr.trade("housner", scene="free", folder=folder, progress=False)
        >>> found.table["precision"].tolist()
        ['float64', 'float32']
    """
    with python_names():
        entries = trade_entries(several(engine), several(scene))
        with shown(progress, "trade, rows", len(entries)) as report:
            return trade_of(entries, pathlib.Path(folder), report)


def trade_entries(engines: Sequence[str], scenes: Sequence[str]) -> list[Entry]:
    """The rows that are asked for."""
    start_warp()
    return all_entries(scenes or tuple(TRADE_SCENES), engines or None)


def trade_of(entries: Sequence[Entry], folder: pathlib.Path, progress: Progress) -> Trade:
    """Measures the rows that a folder has not; progress is called with those that are there."""
    return Trade(run_trade(entries, folder, progress), folder)


class Trade(Found):
    """What accuracy costs; its table is kept in a folder of its own."""

    def __init__(self, table: pd.DataFrame, folder: pathlib.Path) -> None:
        texts = {name: scene.text for name, scene in TRADE_SCENES.items()}
        find = functools.partial(find_trade, table)
        super().__init__("trade", table, find, functools.partial(draw_trade, table, texts))
        self.folder = folder

    def write(self, folder: pathlib.Path) -> list[pathlib.Path]:
        """Writes the table in the form in which one is shipped, beside that which is kept."""
        return [self.folder / TABLE, write_csv(self.table, folder)]
