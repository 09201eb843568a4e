"""The atlas of extremes: the function, and what the command of its name calls, too."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Sequence
from typing import Any

import pandas as pd

from warprock.api.found import Found, untitled
from warprock.api.names import python_names
from warprock.api.progress import Shown, shown
from warprock.arguments import at_the_door, require_within, several
from warprock.errors import InputError
from warprock.figures import atlas as figures
from warprock.findings.stability import find_stability
from warprock.measure import atlas
from warprock.measure.atlas_lanes import AtlasSize
from warprock.measure.atlas_maps import LABELS, MAPS, AtlasMap
from warprock.running.case_run import require_choice
from warprock.running.devices import start_warp
from warprock.running.machine import require_workers
from warprock.running.options import RunOptions
from warprock.settings.engines import SETTINGS

MOST_POINTS, MOST_STEPS = 256, 1_000_000_000
"""Values along an axis of a map, some hundred thousand lanes, and time steps of a launch."""


@at_the_door
def stability(
    engine: str | Sequence[str] = (),
    *,
    map: str | Sequence[str] = (),
    points: int = 16,
    steps: int = 26_000,
    folder: str | os.PathLike[str] = "results/stability",
    workers: int | None = None,
    progress: Shown = True,
) -> Found:
    """Where each engine stays finite, keeps its energy and is right, at the extremes.

    Blocks of 5 cm to 50 m, steps of 1e-6 to 0.1 s, 5 g, 50 Hz, friction 0 to 10: maps as Parquet
    files and figures, and a summary made from them. A run that was stopped goes on where it was.

    Args:
        engine: Names, one or several, of engines; all without.
        map: Name of a map, all without; or several.
        points: Values along an axis, at least 2.
        steps: Most time steps of a launch.
        folder: Folder for the results; what it holds already is not run again.
        workers: As in `run`.
        progress: As in `run`.

    Returns:
        A `Found` whose facts count the lanes of every engine and say what they tell.

    Raises:
        InputError: An unknown engine or map, or a number out of bounds.

    Example:
        >>> import tempfile
        >>> import warprock as wr
        >>> small = {"map": "step", "points": 2, "steps": 50, "progress": False}
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     found = wr.stability("housner", folder=folder, **small)
        >>> [entry["absurd"] for entry in found.facts["engines"]]
        [0, 0]
    """
    with python_names():
        require_workers(workers)
        given = several(engine), several(map), AtlasSize(points=points, steps=steps)
        asked = Atlas(*given, pathlib.Path(folder))
        with shown(progress, "stability", asked.parts) as report:
            return asked.run(RunOptions(workers=workers, progress=report))


class Atlas:
    """Maps of some engines, judged before anything runs.

    Attributes:
        parts: How many parts they have.
    """

    def __init__(
        self, engines: Sequence[str], maps: Sequence[str], size: AtlasSize, folder: pathlib.Path
    ) -> None:
        known = {each.name: each for each in MAPS}
        for engine in engines:
            require_choice("--engine", engine, tuple(SETTINGS))
        for name in maps:
            require_choice("--map", name, tuple(known))
        require_within("--points", size.points, 2, MOST_POINTS)
        require_within("--steps", size.steps, 1, MOST_STEPS)
        self.engines, self.size, self.folder = engines or None, size, folder
        self.maps = [known[name] for name in maps or known]
        self.parts = len(atlas.all_parts(self.engines, self.maps))

    def run(self, options: RunOptions) -> Found:
        """Runs the parts that the folder has not."""
        start_warp()
        given: dict[str, Any] = {"engines": self.engines, "maps": self.maps, "options": options}
        table = atlas.run_atlas(self.folder, self.size, **given)
        if not len(table):
            names = [each.name for each in self.maps]
            raise InputError("--map", "", names, "no engine that was asked for runs it")
        draw = functools.partial(untitled, _draw, table, self.maps)
        return Found("stability", table, functools.partial(find_stability, table), draw)


def _draw(table: pd.DataFrame, maps: Sequence[AtlasMap]) -> Any:
    drawn = [(m.name, m.title, m.x, up) for m in maps for up in (m.y, m.other_y) if up]
    return figures.draw_maps(table, drawn, LABELS)
