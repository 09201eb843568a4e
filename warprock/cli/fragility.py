"""The command `fragility`: fragility functions from a lane table."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import call, finish
from warprock.cli.completion import files
from warprock.cli.options import json_option, output_option
from warprock.cli.pages import on_case
from warprock.cli.signatures import own_options
from warprock.errors import InputError


@click.command()
@click.argument("table", type=click.Path(path_type=pathlib.Path))
@own_options("analyses/fragility", "fragility", weights=files)
@output_option
@json_option
def fragility(
    table: pathlib.Path, folder: pathlib.Path | None, as_json: bool, **asked: Any
) -> None:
    """Fragility functions from TABLE, the lane table of a run or of a merged sweep, or its folder.

    For each group of lanes and limit state: the lognormal function of greatest likelihood, with a
    band over records, or why there is none.

    A lane without usable numbers (nonfinite, unstable, a limit reached in its engine) is left out
    and counted by its status. A lane is in doubt where its estimated error reaches over the limit,
    where its status says outside_model or ambiguous, or where its run ended before it had decided:
    it counts by its finest run, and bands reach around those in which all such lanes reached the
    limit, or none.
    """
    from warprock.api.analyses import fragility as api

    found, _engine = call(api.fragility, table, **asked)
    source = table if table.is_dir() else table.parent
    beside = folder is not None and folder.resolve() == source.resolve()
    finish(found, folder, as_json=as_json, then=_then(source, folder), plays=not beside)


def _then(source: pathlib.Path, folder: pathlib.Path | None) -> str:
    """The command to try next: the factors at which lanes fall, of the case of the table.

    Nothing where the folder of the table does not tell the case, or other values than its file.
    """
    from warprock.case.load import load_case
    from warprock.case.text import case_names
    from warprock.running.results import PROVENANCE
    from warprock.running.run_file import read_facts

    try:
        facts = read_facts(source / PROVENANCE)
        asked, engine = facts["case"], facts["engine"]["name"]
        name = asked["name"] if asked["name"] in case_names() else asked["file"]
        case = load_case(name)
    except (OSError, ValueError, KeyError, TypeError, InputError):
        return ""
    if case.tables.motion is None or case.raw != asked["resolved"]:
        return ""
    return on_case("ida", name, (), "-e", engine, "-o", f"{folder}-ida")


COMMANDS = (fragility,)
