"""Loads kernel files: each one for one precision, one kind of ground motion, and so on.

A kernel file is plain module code that reads like the equations. What it does not say, this module
gives to it before it runs:

    real                  the scalar type: wp.float64 or wp.float32
    the names of PARAMETERS    numbers and names that are decided before a launch, such as BLOCKS
    all that `kernels/scalar.py` defines: `larger`, `sine`, HALF, NEVER, `by_precision`, ...
    options of Warp's compiler; a file whose kernels need others sets them itself

In a kernel file `from warprock.kernels.shape.stack import Rows` brings `Rows` from the instance of
that file that has the same parameters. An instance has those parameters alone that its file, or
one that it imports, names: so `Rows` is the same for every kind of ground motion. Every instance is
a Warp module of its own, compiled and cached on its own.

A thread of a packed kernel has two numbers (`pack, _one = wp.tid()`), of which the second is zero.
Of a kernel with one number Warp 1.19 compiles two variants, one of them for arrays whose rows lie
anyhow, which takes half as long again. Where a loop over lanes is vector code only if the compiler
knows that rows lie side by side, the kernel makes such arrays of what it is given (`block_of`).
"""

from __future__ import annotations

import builtins
import functools
import pathlib
import sys
import threading
from collections.abc import Callable
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from types import CodeType, ModuleType

LANE_WIDTH = 32
"""Lanes in a pack: four interleaved vectors of eight float64 with AVX-512, eight of four else."""


def _has_avx512() -> bool:
    """Whether this processor has 512-bit vectors, as far as Linux tells."""
    try:
        return " avx512f " in pathlib.Path("/proc/cpuinfo").read_text(encoding="ascii")
    except OSError:
        return False


VECTOR_BYTES, INTERLEAVE = (64, 4) if _has_avx512() else (32, 2)
"""Length of a vector, and how many of them are worked on side by side, to hide the latency of a
chain of operations: as many as the registers hold (32 with AVX-512, else 16)."""

CPU_FLAGS = (
    "-march=native -ffp-contract=off -mprefer-vector-width=512 -fno-slp-vectorize"
    " -mllvm=-inline-threshold=9000 -mllvm=-misched-regpressure=0"
    " -mllvm=-enable-interleaved-mem-accesses=false -mstackrealign -mstack-alignment=64"
)
"""Flags that let the compiler turn the loop over the lanes of a pack into vector code.

No product is fused with a sum, neither here nor on a GPU (`fuse_fp`), but where a kernel says
`fused`: which one the compiler takes depends on what stands around it, on the vectors of the
processor, and on what does not change from step to step; a lane would have other last bits in a
kernel's other form, in another chunk, on another machine.

Fields of structs are gathered one by one (`-enable-interleaved-mem-accesses`). Read side by side as
a group, they would need a last turn of the loop in scalar code, so as not to read beyond their end,
and with packs of four vectors that turn is the whole loop.

The matrices that keep lanes begin at multiples of 64 bytes (`-mstackrealign`,
`-mstack-alignment`). The stack comes at multiples of 16, and a vector of 64 bytes that does not lie
in one line of the cache takes two reads, which costs up to a third of the speed."""

MAX_UNROLL = 15
"""Longest loop that Warp writes out; must stay below LANE_WIDTH, whose loop is vectorised."""

BYTES = {"float64": 8, "float32": 4}
"""Length of a number by its precision, which is the name of Warp's scalar type, too."""

FOLDER = pathlib.Path(__file__).resolve().parent
"""Folder of the kernel files, which is read and never written to."""

PARAMETERS = (
    "PRECISION",
    "MOTION",
    "ITERATIONS",
    "BLOCKS",
    "LANES",
    "FRICTION",
    "POINTS",
    "VERTICAL",
    "CHAINS",
    "PRESCRIBED",
    "THROWN",
)
"""Names that the loader sets in a kernel file: the arguments of `kernel_module`, in capitals."""

HOST_FILES = ("instance", "modes", "rows")
"""Files of this folder that are the same for all parameters: Python imports them as any other."""

SCALAR = "scalar"
"""File whose names every other file is given."""

_PREFIX = f"{__package__}."
_LOCK = threading.RLock()


CAPTURES = "-mllvm=-capture-tracking-max-uses-to-explore=10000"
"""Lets the compiler look at all uses of the matrices that keep lanes: where it has not seen that no
pointer to them is handed on, it must think that arrays of the launch overlap them, and makes no
vector code."""


def module_options(interleave: int = INTERLEAVE, more_flags: str = "") -> dict[str, object]:
    """Warp module options of every kernel file, unless it sets others.

    Args:
        interleave: Vectors that a loop over lanes works on side by side.
        more_flags: Of the compiler, besides those of every file.
    """
    flags = f"{CPU_FLAGS} -mllvm=-force-vector-interleave={interleave} {more_flags}".rstrip()
    return {
        "enable_backward": False,
        "fuse_fp": False,
        "cpu_compiler_flags": flags,
        "max_unroll": MAX_UNROLL,
    }


def _interleave_of(precision: str) -> int:
    """Vectors that a loop over lanes works on side by side: no more than a pack has.

    Asked for more, the compiler takes shorter vectors, which in float32 and packs of two costs up
    to two fifths of the speed.
    """
    return min(INTERLEAVE, LANE_WIDTH * BYTES[precision] // VECTOR_BYTES)


TWO_VECTORS = module_options(interleave=2)
"""For steps of middling length: more vectors would not find room in the registers."""

ONE_VECTOR = module_options(interleave=1, more_flags=CAPTURES)
"""For long steps: the values of a step fill the registers, and the processor overlaps the vectors
of a pack by itself."""

LOOPS_STAY = {"max_unroll": 0}
"""For a lane a thread: loops over blocks stay loops, since their bodies are long."""

SHORT_LOOPS_GO = {"max_unroll": 3}
"""For a lane a thread: loops over the rows of a matrix and over three blocks are written out, which
is a quarter faster than loops and takes no longer to compile; longer ones stay."""

BRANCHES = {"cpu_compiler_flags": "-march=native -ffp-contract=off", "max_unroll": 0}
"""For a lane a thread whose steps take many ways: loops stay loops, and calls stay calls where the
compiler sees fit. No vector code."""


def kernel_module(
    file: str,
    *,
    precision: str,
    motion: str = "still",
    iterations: int = 0,
    blocks: int = 1,
    lanes: int = LANE_WIDTH,
    friction: str = "cone",
    points: int = 0,
    vertical: bool = False,
    chains: bool = False,
    prescribed: bool = False,
    thrown: bool = False,
) -> ModuleType:
    """The instance of a kernel file for a precision, a kind of ground motion and a stack.

    Args:
        file: Path of the file in this folder without its ending, such as `housner/block`.
        precision: Key of `BYTES`.
        motion: Kind of ground motion: still, harmonic, ricker, modulated or record.
        iterations: Sweeps of an iterative contact solver; as a constant the compiler unrolls
            them, without which a loop over lanes is not vectorised.
        blocks: Blocks in a stack.
        lanes: Lanes that a thread of a stack's kernel runs side by side.
        friction: Law of friction where a block slides in two directions: cone or box.
        points: Contact points of a body that is no box.
        vertical: Whether the base of a body in the plane moves upwards, too.
        chains: Whether blocks of a stack in the plane stand on chains of corners.
        prescribed: Whether the lanes prescribe their angular restitution.
        thrown: Whether blocks in space start in motion, or bounce.

    Raises:
        OSError: A kernel file cannot be read.
    """
    values = (
        precision, motion, iterations, blocks, lanes, friction, points, vertical, chains,
        prescribed, thrown,
    )  # fmt: skip
    with _LOCK:
        return _instance(file, dict(zip(PARAMETERS, values, strict=True)))


def _instance(file: str, given: dict[str, object]) -> ModuleType:
    """The instance of a file for parameters, of which it takes those that matter to it."""
    used = {name: value for name, value in given.items() if name in _needed(file)}
    module_name = "__".join((_PREFIX + file.replace("/", "."), *map(str, used.values())))
    if module_name in sys.modules:
        return sys.modules[module_name]
    spec = spec_from_loader(module_name, SourceFileLoader(module_name, str(_path(file))))
    assert spec is not None
    module = module_from_spec(spec)
    import warp as wp  # it takes most of a second, and a list of engines needs no kernel

    scalar = {} if file == SCALAR else public(_instance(SCALAR, given))
    module.__dict__.update(scalar, real=getattr(wp, str(given["PRECISION"])), **used)
    module.__dict__["__builtins__"] = {**vars(builtins), "__import__": _importer(given)}
    sys.modules[module_name] = module
    try:
        options = module_options(_interleave_of(str(given["PRECISION"])))
        wp.set_module_options(options, module=module)
        exec(_code(file), module.__dict__)
    except BaseException:
        del sys.modules[module_name]
        raise
    return module


def public(module: ModuleType) -> dict[str, object]:
    """What a kernel file defines itself, but for names that begin with an underscore."""
    given = {"wp", "real", *PARAMETERS}
    return {k: v for k, v in vars(module).items() if not (k.startswith("_") or k in given)}


def _importer(given: dict[str, object]) -> Callable[..., ModuleType]:
    """An `import` statement that takes kernel files as they are for parameters."""

    def load(name: str, *args: object, **kwargs: object) -> ModuleType:
        file = _kernel_file(name)
        return _instance(file, given) if file else builtins.__import__(name, *args, **kwargs)

    return load


def _kernel_file(module: str) -> str:
    """The kernel file that a file imports by this name; empty where Python does it."""
    file = module.removeprefix(_PREFIX).replace(".", "/") if module.startswith(_PREFIX) else ""
    return "" if file in HOST_FILES else file


@functools.cache
def _needed(file: str) -> frozenset[str]:
    """Names of the parameters that a file names, or one that it imports."""
    names = _names(_code(file))
    found = {"PRECISION"} | names.intersection(PARAMETERS)
    imported = {_kernel_file(name) for name in names} - {""}
    return frozenset(found.union(*(_needed(each) for each in imported)))


def _names(code: CodeType) -> set[str]:
    """All names in compiled code that are not local ones, those of imported modules included."""
    inner = (_names(each) for each in code.co_consts if isinstance(each, CodeType))
    return set(code.co_names).union(*inner)


@functools.cache
def _code(file: str) -> CodeType:
    """The compiled code of a kernel file."""
    code = SourceFileLoader(file, str(_path(file))).get_code(file)
    assert code is not None
    return code


def _path(file: str) -> pathlib.Path:
    return FOLDER / f"{file}.py"
