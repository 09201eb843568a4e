"""Addresses of the parts of an array of numbers.

A kernel makes contiguous arrays of parts of known length, so that its loops over lanes become
vector code, see instance.py. It makes them itself: where a func makes the array and reads a contact
from it, a wall of 2,000 blocks takes 1.35 times as long.
"""

import warp as wp

from warprock.kernels.launch.instance import BYTES

REAL_BYTES = BYTES[PRECISION]
"""Bytes of a number of a kernel."""


@wp.func
def address_of(start: wp.uint64, part: int, length: int) -> wp.uint64:
    """Address of a part of an array of numbers that begins at `start`, all parts of a length."""
    return start + wp.uint64(part) * wp.uint64(length * REAL_BYTES)
