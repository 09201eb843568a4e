"""The commands of analyses of a case: each is made of its function in `warprock.api.analyses`.

A file there, `NAME.py`, has the public function `NAME`, which its command calls. An analysis whose
command does more has a file of its own in this room.
"""

from __future__ import annotations

import importlib
import pathlib
import pkgutil
from typing import TYPE_CHECKING, Any

import click

import warprock.api.analyses
import warprock.cli
from warprock.cli.analysis import call, finish, run_of
from warprock.cli.options import case_options, estimate_options
from warprock.cli.pages import on_case
from warprock.cli.signatures import own_options, read_function

if TYPE_CHECKING:
    from warprock.api.found import Found


def analysis_command(name: str) -> click.Command:
    """The command of an analysis of a case.

    Args:
        name: That of its function, and of its file in `warprock.api.analyses`.
    """
    module = f"analyses/{name}"
    function = read_function(module, name)

    def run(case_name: str, folder: pathlib.Path | None, as_json: bool, **asked: Any) -> None:
        api = importlib.import_module(f"warprock.api.analyses.{name}")
        found, engine = call(getattr(api, name), case_name, **asked)
        then = _then(name, found, engine, folder, case_name, asked["overrides"])
        finish(found, folder, as_json=as_json, then=then)

    command = own_options(module, name)(run)
    if function.held:
        command = estimate_options(command)
    text = function.text.replace("`case`", "CASE")
    return click.command(name, help=text)(case_options(command))


def _then(
    name: str,
    found: Found,
    engine: str,
    folder: pathlib.Path | None,
    case_name: str,
    overrides: tuple[str, ...],
) -> str:
    """The command to try next: the same for longer where lanes are undecided, or that of a run."""
    longer = found.facts.get("decided_after_s")
    if longer is None:
        return run_of(engine, folder, case_name, overrides)
    kept = [text for text in overrides if not text.startswith("run.duration")]
    kept.append(f'run.duration="{longer:g} s"')
    return on_case(name, case_name, kept, "-e", engine, "-o", str(folder))


def _names() -> list[str]:
    """The analyses that have no command of their own."""
    own = {module.name for module in pkgutil.iter_modules(warprock.cli.__path__)}
    found = [module.name for module in pkgutil.iter_modules(warprock.api.analyses.__path__)]
    return [name for name in found if name not in own]


COMMANDS = tuple(map(analysis_command, _names()))
