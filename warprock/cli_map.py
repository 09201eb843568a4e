"""The command `map`: in which way a pulse overturns a block, and where that changes."""

from __future__ import annotations

import pathlib

import click


@click.command("map")
@click.argument("case_name", metavar="CASE")
@click.option("-e", "--engine", default="housner", show_default=True, help="Engine.")
@click.option(
    "-s",
    "--set",
    "overrides",
    multiple=True,
    metavar="KEY=VALUE",
    help="Change a key of the case, such as -s contact.angular_restitution=0.8.",
)
@click.option(
    "-o",
    "--output",
    "folder",
    type=click.Path(path_type=pathlib.Path),
    help="Folder for tables and the figure; without, the boundaries are printed only.",
)
@click.option(
    "--tolerance",
    default=1e-4,
    show_default=True,
    help="Width of a boundary over its height at which it is narrow enough.",
)
@click.option("--precision", default="float64", show_default=True, help="Or float32.")
@click.option("--device", default="cpu", show_default=True, help="Warp device.")
@click.option("--workers", type=int, help="Worker threads; the cores at hand without.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def overturning_map(
    case_name: str,
    engine: str,
    overrides: tuple[str, ...],
    folder: pathlib.Path | None,
    tolerance: float,
    precision: str,
    device: str,
    workers: int | None,
    as_json: bool,
) -> None:
    """How pulses overturn a block: without an impact, with impacts, or not at all.

    CASE sweeps motion.frequency and motion.amplitude, the grid of the map; further axes, each with
    a label, make panels. Every change of the mode in a column is halved down to the tolerance.
    """
    from warprock import overturning, overturning_boundaries, store
    from warprock.case import load_case
    from warprock.report import console, plots_map, tables_map

    case = load_case(case_name, overrides)
    overturning_boundaries.require_tolerance(tolerance)
    if folder is not None:
        store.require_writable(folder)
    with console.lane_progress(case.name, None) as progress:
        grid = overturning.run_grid(
            case, engine, precision=precision, device=device, workers=workers
        )
        found = overturning_boundaries.refine(grid, tolerance, progress=progress)
    files: list[pathlib.Path] = []
    if folder is not None:
        files = tables_map.write_map(found, folder)
        files.append(plots_map.draw_map(folder / "map.png", found))
    if as_json:
        rows = found.boundaries.to_dict("records")
        summary = {"case": case.name, **tables_map.map_facts(found), "rows": rows}
        console.print_json(summary | {"files": [str(path) for path in files]})
    else:
        tables_map.print_map(found, files)
