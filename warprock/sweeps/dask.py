"""Runs the chunks of a sweep on a Dask cluster.

The cluster only hands out numbers of chunks: its workers read the plan from the folder of the
sweep, which all of them must see, and write the chunks there.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import logging
import pathlib
import threading
from collections.abc import Iterator
from typing import Any

from warprock.errors import InputError, Said
from warprock.running import machine
from warprock.running.options import Progress
from warprock.sweeps.plan import Plan, read_plan, require_same_software
from warprock.sweeps.run import RunChunks, run_chunk

_ONE_CHUNK = threading.Lock()

LOCAL = "local"
"""What asks for a cluster of processes on this machine."""


def require_dask() -> None:
    """Refuses a cluster where Dask is not installed.

    Raises:
        InputError: It is not.
    """
    if importlib.util.find_spec("distributed") is None:
        allowed = 'needs the extra [dask]: python -m pip install "warprock[dask]"'
        raise InputError("--scheduler", "", Said("dask is not installed"), allowed)


def run_on_dask(
    plan: Plan, folder: pathlib.Path, address: str, workers: int | None = None
) -> RunChunks:
    """A way to run chunks: on a cluster, each worker one at a time.

    Args:
        plan: The plan.
        folder: Folder of the sweep; the workers must see it under the same path.
        address: Address of a scheduler, or `LOCAL`.
        workers: Processes of a local cluster, the cores at hand where None; threads of a chunk on
            any other, those that each of its workers has where None.

    Raises:
        InputError: Dask is not installed.
    """
    require_dask()
    place = str(folder.resolve())

    def run(numbers: list[int], progress: Progress) -> None:
        import distributed

        before = 0
        with _client(address, workers) as client:
            tasks = {
                client.submit(
                    _run_task,
                    place,
                    plan.id,
                    number,
                    1 if address == LOCAL else workers,
                    key=f"warprock-{plan.id[:12]}-{number}",
                    pure=False,
                ): number
                for number in numbers
            }
            for task in distributed.as_completed(tasks):
                try:
                    task.result()
                except distributed.KilledWorker as error:
                    chunk = f"chunk {tasks[task]}: its workers died, out of memory perhaps"
                    raise OSError(f"{chunk}; what is done is kept: {error}") from error
                before += len(plan.lanes_of(tasks[task]))
                progress(before)

    return run


@contextlib.contextmanager
def _client(address: str, workers: int | None) -> Iterator[Any]:
    """A client of a scheduler; a local cluster ends with the block."""
    import distributed

    if address != LOCAL:
        try:
            client = distributed.Client(address)
        except (OSError, ValueError) as error:
            allowed = f"must be the address of a Dask scheduler, or {LOCAL}: {error}"
            raise InputError("--scheduler", "", address, allowed) from None
        with client:
            yield client
        return
    count = workers or machine.core_count()
    with (
        distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            silence_logs=logging.ERROR,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def _run_task(folder: str, plan_id: str, number: int, workers: int | None) -> None:
    """One chunk, on a worker of the cluster, which does one at a time on all of its threads."""
    import distributed

    threads = workers or int(distributed.get_worker().state.nthreads)
    with _ONE_CHUNK:
        run_chunk(_plan(folder, plan_id), pathlib.Path(folder), number, workers=threads)


@functools.lru_cache(maxsize=4)
def _plan(folder: str, plan_id: str) -> Plan:
    """The plan as the worker reads it, held against the one that was asked for."""
    plan = read_plan(pathlib.Path(folder))
    if plan.id != plan_id:
        raise InputError(plan.file, "id", plan.id, f"must be {plan_id}, that of the plan to run")
    require_same_software(plan)
    return plan
