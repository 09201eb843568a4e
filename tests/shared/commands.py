"""Commands as a user gives them, run in this process."""

from __future__ import annotations

from click.testing import CliRunner, Result

from warprock.cli.main import main


def invoke(*arguments: object) -> Result:
    """Runs a command, however it ends."""
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def succeed(*arguments: object) -> Result:
    """Runs a command that has to end well."""
    result = invoke(*arguments)
    assert result.exit_code == 0, result.output
    return result
