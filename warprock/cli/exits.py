"""How commands end: every error in one line and with its exit code, and what a long wait is for."""

from __future__ import annotations

import contextlib
import os
import pathlib
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import click

from warprock.errors import InputError, one_line, shortened

EXIT_FAILED, EXIT_INPUT, EXIT_CHECK, EXIT_INTERRUPTED = 1, 2, 3, 130

ASKED = "warprock.asked"
"""What a context keeps the arguments of the whole command under."""

PATIENCE = 2.0
"""Seconds of compiling after which a command says so."""
_GLANCE = 0.25
"""Seconds between two looks at the folder of the kernels."""


class ExitCodes(click.Group):
    """A group of commands that turns errors into the exit codes of the command line."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Reads the options before the command; an unknown one exits with 2."""
        ctx.meta[ASKED] = list(args)
        try:
            return super().parse_args(ctx, args)
        except click.exceptions.NoArgsIsHelpError:
            raise
        except click.UsageError as error:
            click.echo(f"error: {_usage(error)}", err=True)
            ctx.exit(EXIT_INPUT)

    def invoke(self, ctx: click.Context) -> Any:
        """Runs a command; bad input exits with 2, Ctrl-C with 130, a full disk with 1."""
        try:
            with saying_when_compiling():
                return super().invoke(ctx)
        except InputError as error:
            click.echo(f"error: {error}", err=True)
            ctx.exit(EXIT_INPUT)
        except click.exceptions.NoArgsIsHelpError:
            # A group of commands by its name alone: Click prints what there is.
            raise
        except click.UsageError as error:
            click.echo(f"error: {_usage(error)}", err=True)
            ctx.exit(EXIT_INPUT)
        except KeyboardInterrupt:
            click.echo("interrupted", err=True)
            ctx.exit(EXIT_INTERRUPTED)
        except BrokenPipeError:
            # Whoever read the output has enough of it: Click ends quietly.
            raise
        except OSError as error:
            place = "" if error.filename is None else f"{error.filename}: "
            why = error.strerror or str(error)
            click.echo(one_line(f"error: {place}{why}"), err=True)
            ctx.exit(EXIT_FAILED)
        except MemoryError as error:
            mend = "fewer lanes or samples at once need less: warprock sweep runs lanes in chunks"
            click.echo(one_line(f"error: not enough memory ({error}); {mend}"), err=True)
            ctx.exit(EXIT_FAILED)


def _usage(error: click.UsageError) -> str:
    """What Click says of options and arguments, in one line, and where to read more."""
    said = shortened(" ".join(error.format_message().split()))
    path = error.ctx.command_path if error.ctx is not None else "warprock"
    return f"{said} See {path} --help"


@contextlib.contextmanager
def saying_when_compiling() -> Iterator[None]:
    """Says on stderr, once, that kernels are compiled, where that takes long in the block.

    A command that runs a kernel for the first time compiles it, which may take a minute, and is
    silent meanwhile. Warp compiles in a folder beside the kernels that bears the number of the
    process; whether there is one tells a compiler at work from a kernel that is only loaded.
    """
    done = threading.Event()
    watcher = threading.Thread(target=_watch, args=(done,), daemon=True)
    watcher.start()
    try:
        yield
    finally:
        done.set()


def _watch(done: threading.Event) -> None:
    since: float | None = None
    while not done.wait(_GLANCE):
        if not _compiling():
            since = None
            continue
        since = time.monotonic() if since is None else since
        if time.monotonic() - since >= PATIENCE:
            text = "compiling kernels: this takes a while the first time, and is kept for the next"
            click.echo(text, err=True)
            return


def _compiling() -> bool:
    """Whether this process is compiling a kernel now."""
    warp = sys.modules.get("warp")
    folder = getattr(getattr(warp, "config", None), "kernel_cache_dir", None)
    if not folder:
        return False
    with contextlib.suppress(OSError):
        return any(pathlib.Path(folder).glob(f"*_p{os.getpid()}_t*"))
    return False
