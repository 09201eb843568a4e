"""The commands: where each is found, and in which order `warprock --help` shows them."""

from __future__ import annotations

import importlib
import pkgutil

import click

import warprock.api.analyses
import warprock.cli
from warprock.cli.exits import ExitCodes

SECTIONS: dict[str, dict[str, str]] = {
    "Start": {
        "list": "the shipped cases, the engines, programs of others",
        "init": "write a case of your own: a body, a record, a sweep",
        "body": "a case of a statue, a machine or a rock, from its mesh",
        "identify": "what a block keeps at an impact, from a test of free rocking",
        "explain": "what a case asks for, and which engine runs it",
        "keys": "every key of a case file, with bounds and units",
        "records": "strong-motion records: shipped ones, and files of your own",
    },
    "Run": {
        "run": "every lane of a case, with an error estimate of each",
        "report": "a page of the results in a folder",
        "animate": "a moving picture of a lane",
        "view": "a lane in a viewer",
    },
    "Compare": {
        "compare": "engines and programs of others side by side on one case",
        "validate": "engines held to what tests showed",
        "check": "what the shipped cases expect, checked",
        "reproduce": "the tables and figures of the benchmark paper",
    },
    "Analyse": {
        "verdict": "does it stand under this motion, and by how much",
        "brief": "one page for a decision: chance, what it takes, what helps",
        "capacity": "what a block bears by statics: multiplier, displacement, work",
        "fragility": "fragility functions from the lanes of a run or a sweep",
        "predictors": "which intensity measures predict best, alone and two together",
        "risk": "how often a year blocks fall, under a hazard curve of yours",
        "measures": "what lowers that rate most: wider, lower, tied, isolated",
        "ida": "the factor on a motion at which each lane first falls",
        "map": "which pulses overturn a block, with an impact or without",
        "spectrum": "rocking spectra: peaks of blocks of many sizes",
        "limit": "the sideways load at which an assembly collapses",
        "sensitivity": "which inputs explain the variance of a result",
    },
    "Sweep": {
        "sweep": "millions of lanes in chunks: resumed, shared out, merged",
    },
    "Examine": {
        "doctor": "this machine, and what is missing on it",
        "bench": "what steps and accuracy cost on this machine",
        "trade": "error and cost of every engine over its settings",
        "stability": "where each engine may be trusted, at the extremes",
        "completion": "make the shell complete commands, cases and keys",
    },
}
"""Heading -> command -> what it does, in one line of a terminal of 80 columns."""

_OTHER = "Other"
LONGEST = 240
"""Letters of a first sentence that are written."""


class Main(ExitCodes):
    """The group of all commands, whose help has sections.

    A file in this folder adds the commands that it names in `COMMANDS`. It is imported when one of
    them is asked for: a command lies in the file of its name, or in any other.
    """

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of a name; None if there is none."""
        own = cmd_name.replace("-", "_")
        files = [each.name for each in pkgutil.iter_modules(warprock.cli.__path__)]
        for file in sorted(files, key=lambda name: name != own):
            if cmd_name in self.commands:
                break
            self._add(file)
        return super().get_command(ctx, cmd_name)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of all commands: of `SECTIONS` and of analyses. No file is imported for them."""
        analyses = (each.name for each in pkgutil.iter_modules(warprock.api.analyses.__path__))
        return sorted({*analyses, *(name for texts in SECTIONS.values() for name in texts)})

    def _add(self, file: str) -> None:
        """Adds the commands of a file."""
        for command in getattr(importlib.import_module(f"warprock.cli.{file}"), "COMMANDS", ()):
            self.add_command(command)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Writes the commands section by section, and analyses that have none under "Other"."""
        left = set(self.list_commands(ctx))
        for heading, texts in SECTIONS.items():
            _write(formatter, heading, list(texts.items()))
            left -= texts.keys()
        found = ((name, self.get_command(ctx, name)) for name in sorted(left))
        _write(formatter, _OTHER, [(n, c.get_short_help_str(64)) for n, c in found if c])


class Several(click.Group):
    """A command that has commands; its help says the first sentence of each, whole."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Writes its commands."""
        found = ((name, self.get_command(ctx, name)) for name in self.list_commands(ctx))
        _write(formatter, "Commands", [(n, c.get_short_help_str(LONGEST)) for n, c in found if c])


def _write(formatter: click.HelpFormatter, heading: str, rows: list[tuple[str, str]]) -> None:
    if rows:
        with formatter.section(heading):
            formatter.write_dl([(f"{name:<11}", text) for name, text in rows])
