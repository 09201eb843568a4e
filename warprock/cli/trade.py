"""The command `trade`, and what `run --cheapest` makes of its table."""

from __future__ import annotations

import pathlib
from typing import TYPE_CHECKING

import click

from warprock.cli.options import json_option, output_to
from warprock.cli.pages import add_page
from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.case.case import Case
    from warprock.measure.trade_choice import Choice
    from warprock.running.options import RunOptions


@click.command()
@click.option("-e", "--engine", "engines", multiple=True, help="Only this engine; repeat for more.")
@click.option("--scene", "scenes", multiple=True, help="Only free, pulse, sine, record or stack.")
@output_to(
    "Folder of the table; rows that it has from this machine are kept.",
    default="results",
    show_default=True,
)
@json_option
def trade(
    engines: tuple[str, ...], scenes: tuple[str, ...], folder: pathlib.Path, as_json: bool
) -> None:
    """What accuracy costs: every engine over its own knobs, on fixed scenes.

    Writes trade.parquet row by row, so that a run that was stopped goes on where it was; then
    trade.csv, in the form that `run --cheapest` reads, and the figure trade.png.
    """
    from warprock.figures.drawing import write_drawings
    from warprock.figures.trade import draw_trade
    from warprock.measure.trade import TABLE, all_entries, level_rows, run_trade, write_csv
    from warprock.measure.trade_scenes import TRADE_SCENES
    from warprock.running.devices import start_warp
    from warprock.tables.terminal import lane_progress, print_json
    from warprock.tables.trade import print_trade

    start_warp()
    entries = all_entries(scenes or tuple(TRADE_SCENES), engines or None)
    with lane_progress("trade, rows", len(entries)) as progress:
        table = run_trade(entries, folder, progress)
    files = [folder / TABLE, write_csv(table, folder)]
    texts = {name: scene.text for name, scene in TRADE_SCENES.items()}
    drawings = draw_trade(table, texts)
    files += write_drawings(drawings, folder)
    files.append(add_page(folder, drawings=drawings))
    levels = level_rows(table)
    if as_json:
        print_json({"levels": levels, "rows": table.to_dict("records"), "files": files})
    else:
        print_trade(levels, texts, files)


def choose_for(
    case_name: str,
    overrides: tuple[str, ...],
    tolerance: float | None,
    *,
    engine: str | None,
    precision: str | None,
    options: RunOptions,
) -> tuple[Case, Choice]:
    """A case with the cheapest settings within a tolerance, and the choice.

    Args:
        case_name: The case asked for.
        overrides: The overrides asked for.
        tolerance: The tolerance asked for; None where no estimate is wanted.
        engine: The engine asked for; None if none was.
        precision: The precision asked for; None if none was.
        options: How the tests of the choice are run, but for their precision.

    Raises:
        InputError: Settings, or no estimates, were asked for as well, or nothing met the tolerance.
    """
    from warprock.case.load import load_case
    from warprock.measure.trade_choice import OPTION, choose

    if tolerance is None:
        raise InputError("--no-estimate", "", "given", f"must be left out with {OPTION}")
    for override in overrides:
        if override.startswith("engines."):
            allowed = f"chooses the settings itself, without {override}"
            raise InputError(OPTION, "", "given", allowed)
    case = load_case(case_name, overrides)
    choice = choose(case, tolerance, engine=engine, precision=precision, options=options)
    return load_case(case_name, (*overrides, *choice.overrides)), choice


COMMANDS = (trade,)
