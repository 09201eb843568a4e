"""How commands end: every error in one line and with its exit code."""

from __future__ import annotations

import functools
import os
import re
import time
from collections.abc import Callable
from typing import Any, TypeVar

import click

from warprock.errors import InputError, one_line, shorten
from warprock.running.waiting import saying_what_takes_long

EXIT_FAILED, EXIT_INPUT, EXIT_CHECK, EXIT_BAD_LANES = 1, 2, 3, 4
EXIT_RESUMABLE, EXIT_INTERRUPTED = 75, 130
"""Something failed; bad input; a check that does not hold; more bad lanes than `--max-bad` allows;
a sweep that goes on where it stopped; Ctrl-C."""

ASKED = "warprock.asked"
"""What a context keeps the arguments of the whole command under."""


_THREADS = ("OMP_NUM_THREADS", "NUMEXPR_NUM_THREADS", "NUMEXPR_MAX_THREADS")
"""What libraries read of the environment when they are loaded, and fail at."""

PATIENCE = 5.0
"""Seconds between two lines that say that a command is still at work."""

Found = TypeVar("Found")


def require_threads() -> None:
    """Refuses numbers of threads in the environment that are none.

    OpenMP takes a number for each level, such as 4,2; of these libraries get the first.

    Raises:
        InputError: One is no whole number above 0.
    """
    for name in _THREADS:
        text = os.environ.get(name, "").strip()
        first, *levels = (part.strip() for part in text.split(","))
        if not text:
            continue
        if not all(part.isascii() and part.isdecimal() and int(part) for part in (first, *levels)):
            raise InputError(name, "", text, "must be a whole number of threads, at least 1")
        os.environ[name] = first


def waited_for(work: Callable[[], Found], text: str) -> Found:
    """What some work gives that may be long, done in a thread: Ctrl-C ends the wait at once.

    Args:
        work: The work, which reports nothing itself.
        text: What is said on stderr of it while it lasts.
    """
    import concurrent.futures

    pool, begin = concurrent.futures.ThreadPoolExecutor(1), time.perf_counter()
    try:
        done = pool.submit(work)
        while True:
            concurrent.futures.wait([done], PATIENCE)
            if done.done():
                return done.result()
            click.echo(one_line(f"{text}, {time.perf_counter() - begin:.0f} s so far"), err=True)
    finally:
        pool.shutdown(wait=False)


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
            click.echo(f"error: {_usage(error, ctx)}", err=True)
            ctx.exit(EXIT_INPUT)

    def invoke(self, ctx: click.Context) -> Any:
        """Runs a command; bad input exits with 2, Ctrl-C with 130, a full disk with 1."""
        try:
            require_threads()
            with saying_what_takes_long(functools.partial(click.echo, err=True)):
                return super().invoke(ctx)
        except InputError as error:
            click.echo(f"error: {error}", err=True)
            ctx.exit(EXIT_INPUT)
        except click.exceptions.NoArgsIsHelpError:
            # A group of commands by its name alone: Click prints what there is.
            raise
        except click.UsageError as error:
            click.echo(f"error: {_usage(error, ctx)}", err=True)
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


def _usage(error: click.UsageError, ctx: click.Context) -> str:
    """What Click says of options and arguments, in one line, and where to read more."""
    wrong = _NOT_A_NUMBER.match(error.message)
    if isinstance(error, click.BadParameter) and error.param is not None and wrong:
        bound = f"must be {_numbers(error.param.type)}"
        return str(InputError(error.param.opts[-1], "", wrong["got"], bound))
    said = shorten(" ".join(error.format_message().split()))
    said += "" if said.endswith((".", "?")) else "."
    path = f"{ctx.command_path} {ctx.invoked_subcommand or ''}".strip()
    if error.ctx is not None:
        path = error.ctx.command_path
    return f"{said} See {path} --help"


_NOT_A_NUMBER = re.compile(r"'?(?P<got>.+?)'? is not (?:a valid (?:integer|float)|in the range)")
"""What Click says of a number that is none, or out of bounds."""


def _numbers(kind: Any) -> str:
    """The numbers that an option takes, in words."""
    if isinstance(kind, click.IntRange):
        return f"a whole number, at least {kind.min} and at most {kind.max}"
    return "a whole number" if isinstance(kind, click.types.IntParamType) else "a number"
