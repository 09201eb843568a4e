"""What steps and accuracy cost: the function, which the command of its name calls."""

from __future__ import annotations

import functools
from collections.abc import Sequence

from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.arguments import at_the_door, require_within
from warprock.figures.drawing import Drawing
from warprock.findings.bench import find_bench, find_device_bench
from warprock.measure import peers
from warprock.measure.bench import rocking_engines, run_bench
from warprock.measure.device_bench import run_device_bench
from warprock.running.devices import require_device, start_warp
from warprock.running.machine import require_workers


@at_the_door
def bench(*, seconds: float = 2.0, device: str | None = None, workers: int | None = None) -> Found:
    """What every engine's steps and accuracy cost on this machine, beside others where installed.

    One block, from nine starts, runs in all of them; the extras [mujoco] and [bullet] install two,
    and numba a plain loop. It takes some 100 times as long as a measurement, and a minute.

    Args:
        seconds: Time a measurement takes, about [s].
        device: Lanes a second on this Warp device instead, such as cuda:0.
        workers: As in `run`.

    Returns:
        A `Found` whose table has one row an engine, precision and form of the kernel; on a device
        one an engine, scene, precision and number of lanes.

    Raises:
        InputError: A time out of bounds, no such device, or no such number of workers.

    Example:
        >>> import warprock as wr
        >>> found = wr.bench(seconds=0.1)  # doctest: +SKIP
        >>> found.table[["engine", "precision", "block_steps_per_s"]]  # doctest: +SKIP
    """
    with python_names():
        require_within("--seconds", seconds, 0.0, 3600.0)
        require_workers(workers)
        start_warp()
        if device is not None:
            require_device(device)
            found = run_device_bench(device, seconds, workers)
            return Found("bench", found, functools.partial(find_device_bench, found), _undrawn)
        found = run_bench(seconds=seconds, workers=workers)
        found["prices"] = peers.compare(rocking_engines(), seconds)
        return Found("bench", found, functools.partial(find_bench, found), _undrawn)


def _undrawn(_said: str) -> Sequence[Drawing]:
    return ()
