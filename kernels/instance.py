"""Kernel files compiled for one precision and one kind of ground motion.

A scheme's file is plain module code in which `real` is the scalar type and `MOTION` the kind of
ground motion. `kernel_module` runs such a file once for each pair that a scene asks for, so that
both are decided before launch and the code reads like the equations. Every instance is a Warp
module of its own, compiled and cached on its own.
"""

from __future__ import annotations

import importlib.util
import pathlib
import sys
import threading
from types import ModuleType

import warp as wp

LANE_WIDTH = 16
"""Lanes in a pack: two interleaved 512-bit or four 256-bit vectors of float64."""

CPU_FLAGS = (
    "-march=native -ffp-contract=fast -mprefer-vector-width=512 -fno-slp-vectorize"
    " -mllvm=-inline-threshold=9000 -mllvm=-misched-regpressure=0"
    " -mllvm=-force-vector-interleave=1"
)
"""Flags that let the compiler turn the loop over the lanes of a pack into vector code."""

REALS = {"float64": wp.float64, "float32": wp.float32}
"""Scalar type by the name of the precision."""

_LOCK = threading.Lock()


def kernel_module(
    file: str, *, precision: str, motion: str = "still", iterations: int = 0
) -> ModuleType:
    """The instance of a kernel file for a precision and a kind of ground motion.

    Args:
        file: Stem of the file in this folder, such as `housner`.
        precision: Key of `REALS`.
        motion: Kind of ground motion: still, harmonic, ricker or record.
        iterations: Sweeps of an iterative contact solver; as a constant the compiler unrolls
            them, without which a loop over lanes is not vectorised.
    """
    name = f"{__package__}.{file}__{precision}__{motion}__{iterations}"
    with _LOCK:
        if name in sys.modules:
            return sys.modules[name]
    path = pathlib.Path(__file__).with_name(f"{file}.py")
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    module.__dict__.update(
        real=REALS[precision], PRECISION=precision, MOTION=motion, ITERATIONS=iterations
    )
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def module_options(interleave: int = 1) -> dict[str, object]:
    """Warp module options of every kernel file."""
    flags = CPU_FLAGS.replace("interleave=1", f"interleave={interleave}")
    return {"enable_backward": False, "cpu_compiler_flags": flags, "max_unroll": LANE_WIDTH - 1}
