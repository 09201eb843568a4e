"""What the commands of analyses share: the case and its options, the wait, and what comes of it.

A command calls the Python function of the same name, which gives a `Found`; here it is shown and
saved.
"""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from warprock.cli.options import asked_options, say_engine
from warprock.cli.pages import asked_command, leave, on_case

if TYPE_CHECKING:
    from warprock.api.found import Found


def call(function: Callable[..., Found], /, *given: Any, **asked: Any) -> tuple[Found, str]:
    """What the function of a command finds, and the engine that ran; "" where none did.

    Says which engine that is where a block was not run by the one that it has as a rule.

    Args:
        function: The public function of the same name.
        *given: The case, or the table.
        **asked: The options of the command, by the names of the arguments.

    Raises:
        InputError: Something cannot be used.
    """
    from warprock.api.names import called_by_command

    held = {name: asked.pop(name) for name in ("tolerance", "estimate") if name in asked}
    if held:
        asked["tolerance"] = asked_options(**held).tolerance
    with called_by_command() as done:
        found = function(*given, **asked)
    if done.choice is None:
        return found, ""
    say_engine(done.choice)
    return found, done.choice.engine


def finish(
    found: Found,
    folder: pathlib.Path | None,
    *,
    as_json: bool,
    then: str = "",
    always: bool = False,
    output: str = "results",
    first: Sequence[pathlib.Path] = (),
    plays: bool = True,
) -> None:
    """Writes what a command found where a folder is given, and prints it.

    Args:
        found: What the command found.
        folder: Where to write; None writes nothing.
        as_json: Whether to print one JSON object.
        then: The command to try next, once the results are in the folder.
        always: Whether to try that next where there is no folder, too.
        output: The folder that a command to try next writes to where there is none.
        first: What the command has written before, which stays whatever comes after it.
        plays: Whether the page plays its lanes; that of a folder with a run plays those already.
    """
    from warprock.tables.finding import print_finding
    from warprock.tables.terminal import print_end, print_json, print_written

    finding, files = found.finding, list(first)
    if folder is not None:
        written, drawings = found.write(folder), found.figures()
        files += leave(
            folder,
            written,
            drawings=drawings,
            scenes=found.scenes() if plays else None,
            beside=finding.beside,
            stays=finding.stays,
        )
    if as_json:
        print_json({**finding.json, "files": files})
    else:
        print_finding(finding)
        print_written(files)
        typed = then if folder is not None or always else f"{asked_command()} -o {output}"
        if finding.sentences[0]:
            print_end(finding.sentences[0], typed)


def show(found: Found, then: str = "", *, as_json: bool) -> None:
    """Prints what a command found that writes nothing.

    Args:
        found: What the command found.
        then: The command to try next; that of the finding without.
        as_json: Whether to print one JSON object.
    """
    from warprock.tables.finding import print_finding
    from warprock.tables.terminal import print_end, print_json

    finding = found.finding
    if as_json:
        print_json(finding.json)
    else:
        print_finding(finding)
        print_end(finding.sentences[0], then or finding.then)


def run_of(
    engine: str, folder: pathlib.Path | None, case_name: str, overrides: tuple[str, ...]
) -> str:
    """The command that runs the lanes of the case of an analysis, beside its folder.

    Args:
        engine: Name of the engine.
        folder: That of the analysis.
        case_name: The case asked for.
        overrides: Of `-s`.
    """
    return on_case("run", case_name, overrides, "-e", engine, "-o", f"{folder}-run")
