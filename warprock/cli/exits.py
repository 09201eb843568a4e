"""How commands end: every error in one line and with its exit code."""

from __future__ import annotations

import functools
from typing import Any

import click

from warprock.errors import InputError, one_line, shortened
from warprock.run.compiling import saying_when_compiling

EXIT_FAILED, EXIT_INPUT, EXIT_CHECK, EXIT_INTERRUPTED = 1, 2, 3, 130

ASKED = "warprock.asked"
"""What a context keeps the arguments of the whole command under."""


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
            with saying_when_compiling(functools.partial(click.echo, err=True)):
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
