"""What becomes of lanes of soft-spring blocks, in the plane and in space, for one precision."""

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module, module_options

real: Any
PRECISION: str

wp.set_module_options(module_options())
scalar = kernel_module("scalar", precision=PRECISION)
larger = scalar.larger

NEVER = real(1.0e30)
ROCKING = 1
OVERTURNED = 2
BROKEN = 3
SLID_OFF = 4


@wp.func
def passes_left(until: real, steps: int, dt: real, mode: int) -> int:
    """Steps that a lane has to take to a time, and at most one more."""
    left = (until - real(steps) * dt) / dt
    running = mode == ROCKING and left > real(0.0)
    return wp.where(running, int(wp.ceil(wp.where(running, left, real(0.0)))) + 1, 0)


@wp.func
def time_past(until: real, steps: int, dt: real, mode: int) -> real:
    """Time by which a lane that still runs has passed a sample [s]."""
    return wp.where(mode == ROCKING, larger(real(steps) * dt - until, real(0.0)), real(0.0))


@wp.func
def witness(
    live: bool, time: real, overlap: real, end: real, shared: real, old: wp.ref[real],
    uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int],
    mode: wp.ref[int],
):  # fmt: skip
    """Whether an interface rocks, whether it has closed again, and whether it is still there.

    `overlap` is that in the middle of what the faces share, `old` what it was in the last step;
    `end` that at the end, or corner, where it is deepest; `shared` how much they share.
    """
    zero = real(0.0)
    parted = live and overlap <= zero
    uplift_time = wp.where(parted and uplift_time >= NEVER, time, uplift_time)
    moved = wp.where(parted, time, moved)
    impacts = impacts + wp.where(live and old <= zero and overlap > zero, 1, 0)
    old = wp.where(live, overlap, old)
    deepest = wp.where(live and shared > zero, larger(end, deepest), deepest)
    mode = wp.where(live and shared <= zero, SLID_OFF, mode)
