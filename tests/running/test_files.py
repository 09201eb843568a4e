"""Files that are there whole or not at all, what a killed process leaves, folders to write to."""

from __future__ import annotations

import errno
import os
import pathlib
import platform
import stat
import subprocess
import sys

import pytest

from warprock.errors import InputError
from warprock.running import files


def test_a_file_appears_whole_or_not_at_all(tmp_path: pathlib.Path):
    path = tmp_path / "table"
    path.write_text("before", encoding="utf-8")

    def write_half() -> None:
        with files.replacing(path) as temporary:
            temporary.write_text("half", encoding="utf-8")
            raise RuntimeError("the disk is full")

    with pytest.raises(RuntimeError, match="disk"):
        write_half()
    assert path.read_text(encoding="utf-8") == "before"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.name != "posix", reason="folders are brought to the disk on POSIX systems")
def test_bytes_are_on_the_disk_before_the_name_and_the_name_before_the_end(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    done: list[str] = []
    sync, move = os.fsync, os.replace

    def watched_sync(handle: int) -> None:
        folder = stat.S_ISDIR(os.fstat(handle).st_mode)
        done.append("folder" if folder else "bytes")
        sync(handle)

    def watched_move(*paths: pathlib.Path) -> None:
        done.append("name")
        move(*paths)

    monkeypatch.setattr(files.os, "fsync", watched_sync)
    monkeypatch.setattr(files.os, "replace", watched_move)
    with files.replacing(tmp_path / "table") as temporary:
        temporary.write_text("whole", encoding="utf-8")
    assert done == ["bytes", "name", "folder"]


def test_an_error_names_the_file_and_what_the_system_said(tmp_path: pathlib.Path):
    path = tmp_path / "table"

    def write_to_a_full_disk() -> None:
        with files.replacing(path) as temporary:
            temporary.write_text("half", encoding="utf-8")
            raise OSError(errno.ENOSPC, f"Error writing bytes to file {temporary}")

    with pytest.raises(OSError, match=f"No space left on device: '{path}'$"):
        write_to_a_full_disk()
    assert list(tmp_path.iterdir()) == []


def test_a_folder_under_a_file_is_refused(tmp_path: pathlib.Path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="must be a folder that can be written to"):
        files.require_writable(tmp_path / "file" / "results")
    with pytest.raises(InputError):
        files.require_writable(tmp_path / "file")
    files.require_writable(tmp_path / "new" / "results")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_folder_that_cannot_be_written_to_is_refused():
    with pytest.raises(InputError, match="must be a folder that can be written to"):
        files.require_writable(pathlib.Path("/proc/warprock"))


def test_a_name_that_no_folder_can_have_is_refused(tmp_path: pathlib.Path):
    with pytest.raises(InputError, match="file name too long"):
        files.require_writable(tmp_path / ("a" * 300) / "results")


def test_a_link_to_nothing_is_refused(tmp_path: pathlib.Path):
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "gone")
    for folder in (link, link / "results"):
        with pytest.raises(InputError, match="link is no folder"):
            files.require_writable(folder)
    assert not (tmp_path / "gone").exists()


@pytest.mark.skipif(os.name != "posix", reason="asks a POSIX system which processes run")
def test_what_a_killed_process_left_is_taken_away_when_the_file_is_written_again(
    tmp_path: pathlib.Path,
):
    kill = "import os, pathlib, signal, sys; from warprock.running.files import replacing\n"
    kill += "with replacing(pathlib.Path(sys.argv[1])) as temporary:\n"
    kill += "    temporary.write_text('half'); os.kill(os.getpid(), signal.SIGKILL)"
    path, other = tmp_path / "table.csv", tmp_path / "table"
    for each in (path, other):
        subprocess.run([sys.executable, "-c", kill, str(each)], check=False, timeout=60)
    ours = tmp_path / f".table.csv.{platform.node()}.{os.getpid()}.0a1b2c3d.tmp"
    theirs = tmp_path / ".table.csv.elsewhere.1.0a1b2c3d.tmp"
    for kept in (ours, theirs):
        kept.write_text("half of a process that still writes", encoding="utf-8")
    assert len(list(tmp_path.iterdir())) == 4
    with files.replacing(path) as temporary:
        temporary.write_text("whole", encoding="utf-8")
    left = {found.name for found in tmp_path.iterdir()}
    assert left > {path.name, ours.name, theirs.name}
    # Of the other file, which nobody has written again.
    (dead,) = left - {path.name, ours.name, theirs.name}
    assert dead.startswith(f".table.{platform.node()}.")
