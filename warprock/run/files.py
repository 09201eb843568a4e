"""Files that are written whole or not at all, and checks that a folder can be written to.

A file is written under a temporary name next to its place and then moved there.
"""

from __future__ import annotations

import contextlib
import glob
import os
import pathlib
import platform
import re
import secrets
import tempfile
from collections.abc import Iterator

from warprock.errors import InputError
from warprock.reading import reason

RESULTS = (".csv", ".html", ".json", ".md", ".parquet", ".png")
"""How the names of results end."""


def require_writable(folder: pathlib.Path, source: str = "--output") -> None:
    """Refuses a folder that results cannot be written to, leaving nothing behind.

    Raises:
        InputError: It is not a folder, or its nearest existing parent cannot be written to.
    """
    nearest = folder
    allowed = "must be a folder that can be written to"
    try:
        while not _is_there(nearest) and nearest != nearest.parent:
            nearest = nearest.parent
        if not nearest.is_dir():
            raise InputError(source, "", str(folder), f"{allowed}; {nearest} is no folder")
        with tempfile.TemporaryFile(dir=nearest):
            pass
        in_the_way = [each for each in _files_of(folder) if each.is_dir()]
    except OSError as error:
        raise InputError(source, "", str(folder), f"{allowed}; {reason(error)}") from error
    if in_the_way:
        allowed = f"must not hold a folder named {min(in_the_way).name}, which is a file's name"
        raise InputError(source, "", str(folder), allowed)


def require_writable_file(file: pathlib.Path, source: str = "--output") -> None:
    """Refuses a file that results cannot be written to, leaving nothing behind.

    Raises:
        InputError: It is a folder, or in no folder that can be written to.
    """
    try:
        if file.is_dir():
            raise InputError(source, "", str(file), "must be a file to write, not a folder")
    except OSError as error:
        allowed = f"must be a file to write; {reason(error)}"
        raise InputError(source, "", str(file), allowed) from error
    require_writable(file.absolute().parent, source)


def _files_of(folder: pathlib.Path) -> Iterator[pathlib.Path]:
    """Entries of a folder that have the name of a result, files or not."""
    if folder.is_dir():
        yield from (path for path in folder.iterdir() if path.suffix in RESULTS)


def _is_there(path: pathlib.Path) -> bool:
    """Whether something has that name; a broken link counts, too."""
    try:
        path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    return True


@contextlib.contextmanager
def replacing(path: pathlib.Path) -> Iterator[pathlib.Path]:
    """A temporary path that takes the place of `path` if the block succeeds.

    The bytes are on the disk before the file has its name, and the name before the block is left.
    Processes on any machines may write the same file at once: the last one's stays. What a process
    of this machine that was killed left of the same file is taken away.

    Raises:
        OSError: It could not be written; the error names `path`.
    """
    remove_dead_temporaries(path.parent, glob.escape(path.name))
    temporary = path.with_name(f".{path.name}.{writer_name()}.{secrets.token_hex(4)}.tmp")
    try:
        yield temporary
        _to_disk(temporary)
        os.replace(temporary, path)
        if os.name == "posix":
            _to_disk(path.parent)
    except OSError as error:
        if error.errno is None:
            raise
        # Libraries put their own words around those of the system, and name the temporary.
        raise OSError(error.errno, os.strerror(error.errno), str(path)) from error
    finally:
        temporary.unlink(missing_ok=True)


def writer_name() -> str:
    """A name that no other writer to a folder has: the machine and the number of this process."""
    return f"{platform.node()}.{os.getpid()}"


def remove_dead_temporaries(folder: pathlib.Path, pattern: str) -> None:
    """Removes temporary files of processes of this machine that have ended.

    Args:
        folder: Folder of the files.
        pattern: Names of the files, as `glob` matches them.
    """
    ending = re.compile(r".*\.(\d+)\.[0-9a-f]+\.tmp")
    for path in folder.glob(f".{pattern}.{glob.escape(platform.node())}.*.tmp"):
        match = ending.fullmatch(path.name)
        if match and not _runs(int(match[1])):
            path.unlink(missing_ok=True)


def _runs(process: int) -> bool:
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True


def _to_disk(path: pathlib.Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
