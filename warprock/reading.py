"""Files as they are read: plain files of a bounded size, so that no reader waits without end."""

from __future__ import annotations

import errno
import os
import stat

MOST_BYTES = 2**30
"""Bytes of a file that is read whole, unless its reader says otherwise."""

_KINDS = (
    (stat.S_ISDIR, errno.EISDIR, "a folder"),
    (stat.S_ISFIFO, errno.EINVAL, "a pipe, which need not end: write it to a file first"),
    (stat.S_ISCHR, errno.ENODEV, "a device"),
    (stat.S_ISBLK, errno.ENODEV, "a device"),
    (stat.S_ISSOCK, errno.ENODEV, "a socket"),
    (stat.S_ISLNK, errno.ELOOP, "a link"),
)
"""Kinds of entries that are no plain file: test, error number, and name."""


def kind_of(mode: int) -> str:
    """The name of an entry that is no plain file; empty for a plain file.

    Args:
        mode: Its `st_mode`.
    """
    return next((text for is_kind, _, text in _KINDS if is_kind(mode)), "").partition(",")[0]


def require_plain(path: str | os.PathLike[str]) -> int:
    """Refuses what is no plain file, without opening it.

    Args:
        path: The file, or a link to it.

    Returns:
        Its size in bytes.

    Raises:
        OSError: It is not there or no plain file; `strerror` says which.
    """
    try:
        found = os.stat(path)
    except ValueError:
        raise OSError(errno.EINVAL, "a path with a null character", str(path)) from None
    for is_kind, number, text in _KINDS:
        if is_kind(found.st_mode):
            raise OSError(number, text, str(path))
    return found.st_size


def read_bytes(path: str | os.PathLike[str], most: int = MOST_BYTES) -> bytes:
    """The bytes of a plain file.

    Args:
        path: The file.
        most: Bytes that it may have.

    Raises:
        OSError: It cannot be read, is no plain file, or is too large; `strerror` says which.
    """
    size = require_plain(path)
    if size > most:
        raise OSError(errno.EFBIG, f"a file of {size:,} bytes, more than {most:,}", str(path))
    with open(path, "rb") as file:
        return file.read(most)


def reason(error: OSError) -> str:
    """What the system says of an error, without its number and the path."""
    return (error.strerror or str(error) or type(error).__name__).lower()
