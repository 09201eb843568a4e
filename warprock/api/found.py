"""What a command found, as an object: its tables, its figures, its files."""

from __future__ import annotations

import base64
import functools
import html
import os
import pathlib
import tempfile
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from warprock.api.names import python_names
from warprock.arguments import at_the_door
from warprock.errors import InputError
from warprock.findings.finding import Finding
from warprock.findings.numbers import three

if TYPE_CHECKING:
    import pandas as pd

    from warprock.figures.axes import Axes
    from warprock.figures.drawing import Drawing

Panel = tuple[int, Callable[..., None]]
"""Groups of lanes, and what draws one, `group`, on axes."""

ROWS_SHOWN = 8
"""Rows of a table that a notebook shows."""


def untitled(draw: Callable[..., Sequence[Drawing]], *args: Any) -> Sequence[Drawing]:
    """Draws figures that have titles of their own: without that of the finding, the last one."""
    return draw(*args[:-1])


class Found:
    """What a command found.

    Attributes:
        title: What was run, in one line.
        found: The object that the rooms below handed over, with all that was computed.

    Example:
        >>> import warprock as wr
        >>> found = wr.compare("free-b0", ["housner"], progress=False)
        >>> found, list(found.tables)
        (Comparison(free-b0: housner: 2 rows), ['comparison'])
    """

    _saves_page: ClassVar[bool] = True
    """Whether `save` leaves a page."""

    def __init__(
        self,
        title: str,
        found: Any,
        find: Callable[[], Finding],
        draw: Callable[[str], Sequence[Drawing]],
        panel: Panel | None = None,
        play: Callable[[], Mapping[str, Any] | None] | None = None,
    ) -> None:
        self.title, self.found = title, found
        self._find, self._draw, self._panel, self._play = find, draw, panel, play
        self._saved: pathlib.Path | None = None

    def __getstate__(self) -> dict[str, Any]:
        """What a pickle keeps: what was found; tables and figures are made of it again."""
        made = ("finding", "_drawings")
        return {name: value for name, value in self.__dict__.items() if name not in made}

    @functools.cached_property
    def finding(self) -> Finding:
        """What came out: its sentences tell it, the first in short."""
        return self._find()

    @property
    def table(self) -> pd.DataFrame:
        """The table that matters most.

        Units are in the names of its columns; `table.attrs["columns"]`, where it is there, has the
        unit and the meaning of every column.
        """
        return next(iter(self.tables.values()))

    @property
    def tables(self) -> Mapping[str, pd.DataFrame]:
        """All tables, by the name of their file."""
        return self.finding.frames

    @property
    def facts(self) -> Mapping[str, Any]:
        """What ran and what came of it, ready for JSON: the content of `run.json`."""
        return self.finding.facts or self.finding.json

    def figures(self) -> list[Drawing]:
        """Its figures.

        Returns:
            Drawings; each has a Matplotlib figure, `figure`, its `title`, and what a blind reader
            is told of it, `alt`. A notebook shows one that is the last line of a cell.
        """
        return list(self._drawings)

    @functools.cached_property
    def _drawings(self) -> Sequence[Drawing]:
        return self._draw(self.finding.headline)

    @at_the_door
    def plot(self, *, ax: Any = None, group: int = 0) -> Any:
        """Its first figure, as Matplotlib has it; or one group of lanes on axes of one's own.

        Args:
            ax: Matplotlib axes to draw on; None gives the figure, whose `.axes` are its panels.
            group: Number of the group of lanes that is drawn on these axes, from 0.

        Returns:
            A `matplotlib.figure.Figure`, which a notebook shows; the axes where some are given.

        Raises:
            InputError: There is no such group, or no figure that fits on one pair of axes.
            ValueError: It has no figure.

        Example:
            >>> import matplotlib.pyplot as plt
            >>> import warprock as wr
            >>> curve = {"spectrum.period": ["2 s", "4 s"], "spectrum.slenderness": ["10 deg"]}
            >>> found = wr.spectrum("rocking-spectrum", overrides=curve, progress=False)
            >>> _, axes = plt.subplots()
            >>> found.plot(ax=axes) is axes
            True
        """
        from warprock.figures.axes import require_axes

        require_axes(ax)
        if ax is not None:
            return self._plot_on(ax, group)
        drawings = self.figures()
        if not drawings:
            raise ValueError(f"{self.title}: has no figure")
        return drawings[0].figure

    def _plot_on(self, ax: Axes, group: int) -> Axes:
        """Draws a group of lanes on some axes."""
        if self._panel is None:
            allowed = f"must be left out: {self.title} has no figure for one pair of axes"
            raise InputError("ax", "", ax, allowed)
        count, draw = self._panel
        if not 0 <= group < count:
            raise InputError("group", "", group, f"must be a group of lanes from 0 to {count - 1}")
        draw(ax, group=group)
        return ax

    def show(self) -> None:
        """Prints it as the command does."""
        from warprock.tables.finding import print_finding

        print_finding(self.finding)

    @at_the_door
    def save(self, folder: str | os.PathLike[str]) -> list[pathlib.Path]:
        """Writes all of it to a folder, as the command does with `-o`: tables, figures, a page.

        Args:
            folder: Where to; made if it does not exist. What a command left there before goes.

        Returns:
            The files; the page, report.html, comes last where there is one.

        Raises:
            InputError: The folder cannot be written to.
        """
        from warprock.figures.drawing import write_drawings
        from warprock.running.results import list_results

        place = pathlib.Path(folder)
        with python_names():
            files = self.write(place)
            files += write_drawings(self.figures(), place)
        if not self.finding.stays:
            list_results(place, files, beside=self.finding.beside)
        self._saved = place
        return [*files, self._write_page(place)] if self._saves_page else files

    @at_the_door
    def report(self, folder: str | os.PathLike[str] | None = None) -> pathlib.Path:
        """The page of it: one HTML file that a browser opens and a mail can carry.

        Args:
            folder: Where to write it, and all that `save` writes; where None, the folder that it
                was saved to, or one for temporary files.

        Returns:
            The file.

        Raises:
            InputError: The folder cannot be written to.
        """
        if folder is not None or self._saved is None:
            return self.save(folder or tempfile.mkdtemp(prefix="warprock-"))[-1]
        return self._write_page(self._saved)

    def _write_page(self, folder: pathlib.Path) -> pathlib.Path:
        """Writes the page of a folder that it was saved to."""
        from warprock.report.writing import write_report
        from warprock.running.results import list_results

        page = write_report(folder, scenes=self.scenes(), drawings=self.figures())
        if not self.finding.stays:
            list_results(folder, [page], beside=True)
        return page

    def scenes(self) -> Mapping[str, Any] | None:
        """Lanes to play on the page; None where there are none."""
        return None if self._play is None else self._play()

    def write(self, folder: pathlib.Path) -> list[pathlib.Path]:
        """Writes all but the figures and the page."""
        from warprock.running.results import write_results

        finding = self.finding
        return write_results(folder, self.tables, finding.facts or None, finding.texts)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.title}: {len(self.table):,} rows)"

    def _repr_html_(self) -> str:
        """What a notebook shows: what was run, what came out, the first rows, and a picture."""
        drawings = self.figures()
        pictures = "".join(_picture(drawing) for drawing in drawings[:1])
        head = f"<p><b>{html.escape(repr(self))}</b></p>"
        if self.finding.headline:
            head += f"<p>{html.escape(self.finding.sentences[0])}</p>"
        return head + _rows_html(self._shown()) + pictures

    def _shown(self) -> pd.DataFrame:
        """The table as a notebook shows it."""
        return self.table


def _rows_html(table: pd.DataFrame) -> str:
    """The first rows of a table as HTML, three digits a number."""
    rows = table.head(ROWS_SHOWN)
    text = rows.to_html(index=False, border=0, float_format=three, na_rep="")
    left = len(table) - len(rows)
    more = f"<p>and {left:,} more rows in .table</p>" if left else ""
    return f'<div style="overflow-x: auto">{text}</div>{more}'


def _picture(drawing: Drawing) -> str:
    """A drawing as an image that stands in a page."""
    text = base64.b64encode(drawing.png()).decode()
    alt = html.escape(drawing.alt, quote=True)
    return f'<img alt="{alt}" style="max-width: 100%" src="data:image/png;base64,{text}">'
