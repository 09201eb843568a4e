"""The command line: each command calls the functions of its module and prints what they return.

Heavy modules are imported inside the commands, so that `warprock --help` answers at once.
Results go to stdout, progress and errors to stderr.
"""

from __future__ import annotations

import gc
import os
import signal
import sys

import click

import warprock
from warprock.cli.exits import EXIT_INTERRUPTED, EXIT_RESUMABLE
from warprock.cli.sections import Main


def _say_version(ctx: click.Context, _option: click.Parameter, asked: bool) -> None:
    """Prints the version, which is looked up only here."""
    if asked and not ctx.resilient_parsing:
        click.echo(f"warprock, version {warprock.__version__}")
        ctx.exit()


@click.group(cls=Main, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_say_version,
    help="Show the version and exit.",
)
def main() -> None:
    """Rocking of rigid blocks under ground motion, many inputs at once.

    A case (a folder with a case.toml, or the name of a shipped one) becomes lanes, one for each
    set of inputs; an engine answers for all lanes at once.

    First steps: warprock run free-b0 -o results; warprock init record mine/case.toml; warprock
    run mine -o results/mine.
    """


def entry() -> None:
    """The command line as a process: on Ctrl-C it ends at once, and on SIGTERM as on Ctrl-C.

    A launch in a worker thread cannot be stopped, and Python would wait for it.
    """
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    # Else pydantic looks for plug-ins of its own in every package that is installed.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Else NumPy starts a thread of OpenBLAS for each core, at every start. Lanes have threads of
    # their own, and what a product of matrices sums first must not depend on the machine.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Else a tenth of the start of a command goes into looks for garbage among what it imports; Warp
    # alone makes more than 100,000 objects that stay.
    gc.set_threshold(200_000)
    for name in ("stdout", "stderr"):
        # Closed by whoever started us; a result's file must not take its number.
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
    try:
        main()
    except SystemExit as end:
        try:
            sys.stdout.flush()
        except BrokenPipeError:
            # Nobody reads: what is left goes nowhere, or Python would say so at its end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise SystemExit(1) from None
        if end.code not in (EXIT_INTERRUPTED, EXIT_RESUMABLE):
            raise
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        sys.stdout.flush()
        os._exit(int(end.code))
    finally:
        # Else Python looks for garbage among all that was imported before it ends: a third of a
        # short run.
        gc.freeze()
