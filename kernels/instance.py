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

LANE_WIDTH = 32
"""Lanes in a pack: four interleaved vectors of eight float64 with AVX-512, eight of four else."""


def _has_avx512() -> bool:
    """Whether this processor has 512-bit vectors, as far as Linux tells."""
    try:
        return " avx512f " in pathlib.Path("/proc/cpuinfo").read_text(encoding="ascii")
    except OSError:
        return False


INTERLEAVE = 4 if _has_avx512() else 2
"""Vectors worked on side by side, to hide the latency of a chain of operations: as many as the
registers hold (32 with AVX-512, else 16)."""

CPU_FLAGS = (
    "-march=native -ffp-contract=fast -mprefer-vector-width=512 -fno-slp-vectorize"
    " -mllvm=-inline-threshold=9000 -mllvm=-misched-regpressure=0"
    " -mllvm=-enable-interleaved-mem-accesses=false"
)
"""Flags that let the compiler turn the loop over the lanes of a pack into vector code.

The last one gathers the fields of structs one by one. Read side by side as a group, they would
need a last turn of the loop in scalar code, so as not to read beyond their end, and with packs of
four vectors that turn is the whole loop."""

MAX_UNROLL = 15
"""Longest loop that Warp writes out; must stay below LANE_WIDTH, whose loop is vectorised."""

REALS = {"float64": wp.float64, "float32": wp.float32}
"""Scalar type by the name of the precision."""

FOLDER = pathlib.Path(__file__).resolve().parent
"""Folder of the kernel files, which is read and never written to."""

_LOCK = threading.Lock()


def kernel_module(
    file: str,
    *,
    precision: str,
    motion: str = "still",
    iterations: int = 0,
    blocks: int = 1,
    lanes: int = LANE_WIDTH,
    friction: str = "cone",
) -> ModuleType:
    """The instance of a kernel file for a precision, a kind of ground motion and a stack.

    Args:
        file: Path of the file in this folder without its ending, such as `housner/block`.
        precision: Key of `REALS`.
        motion: Kind of ground motion: still, harmonic, ricker, modulated or record.
        iterations: Sweeps of an iterative contact solver; as a constant the compiler unrolls
            them, without which a loop over lanes is not vectorised.
        blocks: Blocks in a stack.
        lanes: Lanes that a thread of a stack's kernel runs side by side.
        friction: Law of friction where a block slides in two directions: cone or box.
    """
    name = f"{__package__}.{file.replace('/', '.')}__{precision}__{motion}"
    name += f"__{iterations}__{blocks}__{lanes}"
    name += "" if friction == "cone" else f"__{friction}"
    with _LOCK:
        if name in sys.modules:
            return sys.modules[name]
    path = FOLDER / f"{file}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    module.__dict__.update(
        real=REALS[precision],
        PRECISION=precision,
        MOTION=motion,
        ITERATIONS=iterations,
        BLOCKS=blocks,
        LANES=lanes,
        FRICTION=friction,
    )
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def module_options(interleave: int = INTERLEAVE) -> dict[str, object]:
    """Warp module options of every kernel file.

    Args:
        interleave: Vectors that a loop over lanes works on side by side.
    """
    return {
        "enable_backward": False,
        "cpu_compiler_flags": f"{CPU_FLAGS} -mllvm=-force-vector-interleave={interleave}",
        "max_unroll": MAX_UNROLL,
    }
