"""How lanes are run: what a user asks for once, and every room hands down to the batch."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from warprock.engines.launching import Form

Progress = Callable[[int], None]
"""Called with the number of lanes finished so far."""

TOLERANCE = 0.01
"""Largest error of a rotation over the slenderness angle where none is asked for."""


@dataclasses.dataclass(frozen=True)
class RunOptions:
    """How lanes are run; no result depends on `workers` or `progress`.

    Attributes:
        precision: "float64" or "float32".
        device: Warp device, such as "cpu" or "cuda:0".
        workers: Worker threads; None uses the cores at hand.
        tolerance: Largest error of a rotation over the slenderness angle, > 0 and < 1: a lane that
            misses it by its estimate runs again at finer steps. None estimates no error, and runs
            every lane once.
        progress: Called with the number of lanes finished so far.
        form: Form of the kernels; None is the fast one for many lanes.
    """

    precision: str = "float64"
    device: str = "cpu"
    workers: int | None = None
    tolerance: float | None = TOLERANCE
    progress: Progress | None = None
    form: Form | None = None

    @property
    def of_batch(self) -> dict[str, Any]:
        """These options as arguments of `run_batch`."""
        return {
            "precision": self.precision,
            "device": self.device,
            "workers": self.workers,
            "progress": self.progress,
            "form": self.form,
        }

    @property
    def on_cpu(self) -> bool:
        """Whether the device is the CPU."""
        return self.device.startswith("cpu")

    def watched_by(self, watch: Progress) -> RunOptions:
        """The options with one more function that takes the number of lanes finished so far."""
        told = self.progress

        def tell(done: int) -> None:
            watch(done)
            if told is not None:
                told(done)

        return dataclasses.replace(self, progress=tell)

    def counting_from(self, before: int) -> RunOptions:
        """The options for the next of several batches.

        Args:
            before: Lanes of the batches before it, which are finished.
        """
        return dataclasses.replace(self, progress=count_from(self.progress, before))

    def without_progress(self) -> RunOptions:
        """The options without progress, for a batch whose lanes are counted elsewhere."""
        return dataclasses.replace(self, progress=None)


def count_from(progress: Progress | None, before: int) -> Progress | None:
    """A progress that counts on from lanes that are finished already; None stays None."""
    if progress is None or before == 0:
        return progress
    return lambda done: progress(before + done)


class Counted:
    """Lanes finished of several batches that run side by side."""

    def __init__(self, progress: Progress | None) -> None:
        """Starts at none.

        Args:
            progress: Takes their sum; None counts nothing.
        """
        self._progress, self._lock = progress, threading.Lock()
        self._done: dict[int, int] = {}

    def of(self, number: int) -> Progress | None:
        """The progress of one batch."""
        if self._progress is None:
            return None

        def report(done: int) -> None:
            assert self._progress is not None
            with self._lock:
                self._done[number] = done
                self._progress(sum(self._done.values()))

        return report


DEFAULT_OPTIONS = RunOptions()
"""What holds where nothing is asked for."""
