"""What a kernel takes of a GPU, read from the machine code that Warp compiles it to.

The file is ELF; its section `.nv.info` lists numbers of each function, of which the CUDA driver
tells the same (`cuFuncGetAttribute`) where there is a device.
"""

from __future__ import annotations

import dataclasses
import struct

REGISTER_COUNT, FRAME_SIZE, STACK_SIZE = 0x2F, 0x11, 0x12
"""Attributes of a function: registers, its own frame, and the frames of all that it calls."""
PAIR = 4
"""Format of an attribute that is followed by its size and as many bytes: a function, a number."""


@dataclasses.dataclass(frozen=True)
class Resources:
    """What a thread of a kernel takes.

    Attributes:
        registers: Registers of 32 bits.
        local_memory: Stack of the kernel and what it calls, in the device's memory [bytes].
    """

    registers: int
    local_memory: int


def resources_of(code: bytes) -> Resources:
    """What the hungriest kernel of a file takes.

    Raises:
        ValueError: The file does not tell.
    """
    begin, size = _section(code, b".nv.info")
    found: dict[int, list[int]] = {}
    place = begin
    while place < begin + size:
        layout, attribute, length = struct.unpack_from("<BBH", code, place)
        place += 4
        if layout == PAIR:
            if length == 2 * PAIR:
                found.setdefault(attribute, []).append(struct.unpack_from("<II", code, place)[1])
            place += length
    try:
        return Resources(max(found[REGISTER_COUNT]), max(found[STACK_SIZE]))
    except KeyError:
        raise ValueError("the machine code does not tell what its kernels take") from None


def _section(code: bytes, name: bytes) -> tuple[int, int]:
    """Place and size of a section of an ELF file of 64 bits."""
    (table,) = struct.unpack_from("<Q", code, 0x28)
    length, count, names = struct.unpack_from("<HHH", code, 0x3A)
    rows = [struct.unpack_from("<IIQQQQ", code, table + k * length) for k in range(count)]
    for row in rows:
        start = rows[names][4] + row[0]
        if code[start : code.index(b"\0", start)] == name:
            return row[4], row[5]
    raise ValueError(f"the machine code has no section {name.decode()}")
