"""The command `stability`: the atlas of extremes."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.arguments import require_within
from warprock.cli.options import json_option, output_to, workers_option
from warprock.cli.pages import add_page
from warprock.errors import InputError

MOST_POINTS, MOST_STEPS = 256, 1_000_000_000
"""Values along an axis of a map, some hundred thousand lanes, and time steps of a launch."""


@click.command()
@click.option("-e", "--engine", "engines", multiple=True, help="Repeat for each; all without.")
@click.option("--map", "maps", multiple=True, help="Repeat for each; all without.")
@click.option("--points", default=16, show_default=True, help="Values along an axis, at least 2.")
@click.option("--steps", default=26_000, show_default=True, help="Most time steps of a launch.")
@output_to(
    "Folder for the results; what it holds already is not run again.",
    default="results/stability",
    show_default=True,
)
@workers_option
@json_option
def stability(
    engines: tuple[str, ...],
    maps: tuple[str, ...],
    points: int,
    steps: int,
    folder: pathlib.Path,
    workers: int | None,
    as_json: bool,
) -> None:
    """Where each engine stays finite, keeps its energy and is right, at the extremes.

    Blocks of 5 cm to 50 m, steps of 1e-6 to 0.1 s, 5 g, 50 Hz, friction 0 to 10: maps as Parquet
    files and figures, and a summary made from them. A run that was stopped goes on where it was.
    """
    from warprock.figures.atlas import draw_maps
    from warprock.figures.drawing import write_drawings
    from warprock.measure import atlas
    from warprock.measure.atlas_lanes import AtlasSize
    from warprock.measure.atlas_maps import LABELS, MAPS
    from warprock.measure.atlas_summary import explain_words, summarise
    from warprock.running.case_run import require_choice
    from warprock.running.devices import start_warp
    from warprock.running.options import RunOptions
    from warprock.settings.engines import SETTINGS
    from warprock.tables.atlas import print_atlas, write_summary
    from warprock.tables.terminal import lane_progress, print_json

    for engine in engines:
        require_choice("--engine", engine, tuple(SETTINGS))
    known = {each.name: each for each in MAPS}
    for name in maps:
        require_choice("--map", name, tuple(known))
    require_within("--points", points, 2, MOST_POINTS)
    require_within("--steps", steps, 1, MOST_STEPS)
    start_warp()
    chosen = [known[name] for name in maps or known]
    with lane_progress("stability", len(atlas.all_parts(engines or None, chosen))) as done:
        table = atlas.run_atlas(
            folder,
            AtlasSize(points=points, steps=steps),
            engines=engines or None,
            maps=chosen,
            options=RunOptions(workers=workers, progress=done),
        )
    if not len(table):
        raise InputError("--map", "", list(maps), "no engine that was asked for runs it")
    found: dict[str, Any] = {"explained": explain_words(), **summarise(table)}
    drawn = [(m.name, m.title, m.x, up) for m in chosen for up in (m.y, m.other_y) if up]
    drawings = draw_maps(table, drawn, LABELS)
    files = [*write_drawings(drawings, folder), write_summary(found, folder)]
    files.append(add_page(folder, drawings=drawings))
    if as_json:
        print_json(found | {"files": files})
    else:
        print_atlas(found, files)


COMMANDS = (stability,)
