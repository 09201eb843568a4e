"""Files that are written whole or not at all, and checks that a folder can be written to.

A file is written under a temporary name next to its place and then moved there.
"""

from __future__ import annotations

import contextlib
import errno
import glob
import os
import pathlib
import platform
import re
import secrets
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator

from warprock.errors import InputError
from warprock.reading import kind_of, reason

RESULTS = (".csv", ".html", ".json", ".md", ".parquet", ".png")
"""How the names of results end."""


def require_writable(folder: pathlib.Path, source: str = "--output") -> None:
    """Refuses a folder that results cannot be written to, leaving nothing behind.

    Raises:
        InputError: It is not a folder, or its nearest existing parent cannot be written to.
    """
    _require_room(folder, source)
    allowed = "must be a folder that can be written to"
    try:
        in_the_way = [each for each in _files_of(folder) if _no_plain_file(each)]
    except OSError as error:
        raise InputError(source, "", str(folder), f"{allowed}; {reason(error)}") from error
    if in_the_way:
        first = min(in_the_way)
        kind = _no_plain_file(first)
        allowed = f"must not hold {kind} named {first.name}, which is a file's name"
        raise InputError(source, "", str(folder), allowed)


def require_writable_file(file: pathlib.Path, source: str = "--output") -> None:
    """Refuses a file that results cannot be written to, leaving nothing behind.

    What is replaced is a plain file: a device, a pipe or a link with that name would be lost.

    Raises:
        InputError: It is there and no plain file, or in no folder that can be written to.
    """
    try:
        kind = _no_plain_file(file)
    except OSError as error:
        allowed = f"must be a file to write; {reason(error)}"
        raise InputError(source, "", str(file), allowed) from error
    if kind:
        raise InputError(source, "", str(file), f"must be a file to write, not {kind}")
    _require_room(file.absolute().parent, source)


def _require_room(folder: pathlib.Path, source: str) -> None:
    """Refuses a folder in which no file can be made, whatever it holds.

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
    except OSError as error:
        raise InputError(source, "", str(folder), f"{allowed}; {reason(error)}") from error


def _files_of(folder: pathlib.Path) -> Iterator[pathlib.Path]:
    """Entries of a folder that have the name of a result, files or not."""
    if folder.is_dir():
        yield from (path for path in folder.iterdir() if path.suffix in RESULTS)


def _no_plain_file(path: pathlib.Path) -> str:
    """What has a name that is to be a file's: a link, a folder, a pipe, a device.

    Empty where that is a plain file, or nothing.
    """
    try:
        found = path.lstat()
    except (FileNotFoundError, NotADirectoryError):
        return ""
    except ValueError:
        raise OSError(errno.EINVAL, "a path with a null character", str(path)) from None
    return kind_of(found.st_mode)


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
        OSError: It could not be written, or what has its name is no plain file; the error names
            `path`.
    """
    with replacing_together() as writing, writing(path) as temporary:
        yield temporary


Writing = Callable[[pathlib.Path], contextlib.AbstractContextManager[pathlib.Path]]


@contextlib.contextmanager
def replacing_together() -> Iterator[Writing]:
    """Files that take their places together if the block succeeds, and else none of them.

    Yields:
        A function of a path: the context in which its temporary is written, see `replacing`.

    Raises:
        OSError: One could not be written; the error names it.
    """
    temporaries: dict[pathlib.Path, pathlib.Path] = {}

    @contextlib.contextmanager
    def writing(path: pathlib.Path) -> Iterator[pathlib.Path]:
        if kind := _no_plain_file(path):
            raise OSError(errno.EEXIST, f"must be a file to write, not {kind}", str(path))
        remove_dead_temporaries(path.parent, glob.escape(path.name))
        name = f".{path.name}.{writer_name()}.{secrets.token_hex(4)}.tmp"
        temporaries[path] = path.with_name(name)
        with _naming(path):
            yield temporaries[path]
            _to_disk(temporaries[path])

    try:
        yield writing
        with _delay_signals():
            for path, temporary in temporaries.items():
                with _naming(path):
                    os.replace(temporary, path)
        for folder in {path.parent for path in temporaries} if os.name == "posix" else ():
            with _naming(folder):
                _to_disk(folder)
    finally:
        for temporary in temporaries.values():
            temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def _naming(path: pathlib.Path) -> Iterator[None]:
    """Lets what the system says of a temporary name the file that it is of."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        # Libraries put their own words around those of the system, and name the temporary.
        raise OSError(error.errno, os.strerror(error.errno), str(path)) from error


@contextlib.contextmanager
def _delay_signals() -> Iterator[None]:
    """Delays Ctrl-C and SIGTERM to the end of the block, which is short."""
    if threading.current_thread() is not threading.main_thread():
        # Only the main thread is interrupted.
        yield
        return
    came: list[int] = []
    kept = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    for each, handler in kept.items():
        if callable(handler):
            signal.signal(each, lambda number, _frame: came.append(number))
    try:
        yield
    finally:
        for each, handler in kept.items():
            if callable(handler):
                signal.signal(each, handler)
    for number in came:
        signal.raise_signal(number)


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
    # Windows brings only what is open for writing to the disk.
    handle = os.open(path, os.O_RDONLY if os.name == "posix" else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
