"""What `-o` may replace: plain files alone; a device, a pipe or a link stays what it is."""

from __future__ import annotations

import os
import pathlib
import stat
from collections.abc import Iterator

import click
import pytest

from tests.shared.commands import invoke, succeed
from warprock.cli.main import main
from warprock.errors import InputError
from warprock.running.files import replacing, require_writable

pytestmark = pytest.mark.skipif(os.name != "posix", reason="pipes and devices that are files")


def _with_output(
    command: click.Command, context: click.Context, path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    """All commands that have `-o`, and their names."""
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            inner = command.get_command(context, name)
            assert inner is not None
            yield from _with_output(inner, context, (*path, name))
    elif any("--output" in each.opts for each in command.params):
        yield path, command


COMMANDS = dict(_with_output(main, click.Context(main)))


def _pipe(path: pathlib.Path) -> None:
    os.mkfifo(path)


def _device(path: pathlib.Path) -> None:
    if os.geteuid():
        pytest.skip("only root makes devices, and only root may replace one")
    # That of /dev/full.
    os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 7))


def _link_to_a_file(path: pathlib.Path) -> None:
    target = path.with_name("target")
    target.write_text("kept")
    path.symlink_to(target)


def _link_to_nothing(path: pathlib.Path) -> None:
    path.symlink_to(path.with_name("nothing"))


def _link_to_a_device(path: pathlib.Path) -> None:
    path.symlink_to("/dev/null")


MAKERS = (_pipe, _device, _link_to_a_file, _link_to_nothing, _link_to_a_device)


def test_there_are_commands_that_write():
    assert {("run",), ("animate",), ("records", "import"), ("sweep", "merge")} <= set(COMMANDS)


@pytest.mark.parametrize("make", MAKERS)
@pytest.mark.parametrize("names", COMMANDS, ids=" ".join)
def test_every_command_leaves_what_is_no_plain_file(names, make, tmp_path: pathlib.Path):
    out = tmp_path / "out.csv"
    make(out)
    before = {path.name: path.lstat()[:3] for path in tmp_path.iterdir()}
    needed = [
        text
        for each in COMMANDS[names].params
        if each.required and "--output" not in each.opts
        for text in ([] if isinstance(each, click.Argument) else [each.opts[-1]]) + ["1"]
    ]
    result = invoke(*names, *needed, "-o", out)
    assert result.exit_code == 2, result.output
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: --output: got ")
    assert "out.csv" in line
    assert {path.name: path.lstat()[:3] for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize("make", MAKERS)
def test_nothing_in_a_folder_of_results_is_replaced_but_plain_files(make, tmp_path: pathlib.Path):
    make(tmp_path / "lanes.csv")
    with pytest.raises(InputError, match=r"must not hold a (link|pipe|device) named lanes\.csv"):
        require_writable(tmp_path)
    # What came there since: the file in hand is given up.
    with pytest.raises(OSError, match="must be a file to write"), replacing(tmp_path / "lanes.csv"):
        pytest.fail("nothing is written")


def test_a_link_to_a_folder_is_a_folder(tmp_path: pathlib.Path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "folder")
    succeed("run", "free-b0", "-o", tmp_path / "out")
    assert (tmp_path / "folder" / "run.json").is_file()
