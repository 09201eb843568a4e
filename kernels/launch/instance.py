"""Loads kernel files: each one for one precision, one kind of ground motion, and so on.

A kernel file is plain module code that reads like the equations. What it does not say, this module
gives to it before it runs:

    real                  the scalar type: wp.float64 or wp.float32
    the names of PARAMETERS    numbers and names that are decided before a launch, such as BLOCKS
    all that `kernels/algebra/scalar.py` defines: `larger`, `sine`, HALF, NEVER, `by_precision`, ...
    options of Warp's compiler; a file whose kernels need others sets them itself

In a kernel file `from warprock.kernels.shape.stack import Rows` brings `Rows` from the instance of
that file that has the same parameters. An instance depends only on the parameters that its file, or
a file that it imports, mentions. So `Rows` is the same for every kind of ground motion. Every
instance is a Warp module of its own, compiled and cached on its own.

A thread of a packed kernel has two indices (`pack, _one = wp.tid()`); the second is zero. For a
kernel with one index Warp 1.19 compiles a second variant, for arrays with any strides, which takes
half as long again. If a loop over lanes becomes vector code only when the compiler knows that rows
are contiguous, the kernel makes contiguous arrays of its arguments (`block_of`).
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
from typing import Any, NamedTuple

LANE_WIDTH = 32
"""Lanes in a pack: four interleaved vectors of eight float64 with AVX-512, eight of four else."""


def _processor() -> str:
    """What Linux reports of this processor; empty on other systems."""
    try:
        return pathlib.Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace")
    except OSError:
        return ""


def halves_vectors(report: str) -> bool:
    """Whether a processor works on a vector of 512 bits in two halves: family 25 of AMD (Zen 4).

    Args:
        report: What Linux reports of it.
    """
    facts = (line.partition(":") for line in report.splitlines())
    values = {name.strip(): value.strip() for name, _, value in facts}
    return (
        values.get("vendor_id") == "AuthenticAMD"
        and values.get("cpu family") == "25"
        and "avx512f" in values.get("flags", "").split()
    )


HALVES_VECTORS = halves_vectors(_processor())
"""Whether this processor works on a vector of 512 bits in two halves."""

VECTOR_BYTES, INTERLEAVE = (64, 4) if " avx512f " in _processor() else (32, 2)
"""Length of a vector, and how many of them are worked on side by side, to hide the latency of a
chain of operations: as many as the registers hold (32 with AVX-512, else 16)."""

SAME_CODE = "-discard-value-names -disable-llvm-verifier -fpch-instantiate-templates"
"""Flags that make the same instructions in less time. The compiler forgets the names of its values,
which saves 6 %. It does not check its own intermediate code; such a check finds faults of the
compiler alone. Templates of Warp's headers are instantiated once, where the headers are
precompiled, which saves 65 ms a file."""

CPU_FLAGS = (
    "-march=native -ffp-contract=off -mprefer-vector-width=512 -fno-slp-vectorize"
    " -mllvm=-inline-threshold=9000 -mllvm=-misched-regpressure=0"
    " -mllvm=-enable-interleaved-mem-accesses=false -mstackrealign -mstack-alignment=64"
    f" {SAME_CODE}"
)
"""Flags that let the compiler turn the loop over the lanes of a pack into vector code.

The compiler fuses no product with a sum, neither on the CPU nor on a GPU (`fuse_fp`), unless a
kernel says `fused`. Which product it would fuse depends on the code around it, on the vector length
of the processor, and on loop invariants. The last bits of a lane would then differ between the two
forms of a kernel, between chunks and between machines.

Fields of structs are gathered one by one (`-enable-interleaved-mem-accesses`). A grouped read needs
a scalar last iteration of the loop, so as not to read beyond the end. With packs of four vectors
that iteration is the whole loop.

The matrices that keep lanes are aligned to 64 bytes (`-mstackrealign`, `-mstack-alignment`). The
stack is aligned to 16 bytes only, and a vector of 64 bytes across two cache lines takes two reads,
which costs up to a third of the speed."""

MAX_UNROLL = 15
"""Longest loop that Warp unrolls. It must stay below LANE_WIDTH, whose loop is vectorised."""

BYTES = {"float64": 8, "float32": 4}
"""Bytes of a number by its precision, which is the name of Warp's scalar type, too."""

FOLDER = pathlib.Path(__file__).resolve().parents[1]
"""`kernels/`; never written to."""


class Variant(NamedTuple):
    """What is decided before a kernel file runs, and may differ between its instances.

    Attributes:
        precision: Key of `BYTES`.
        motion: Kind of ground motion: still, harmonic, ricker, modulated or record.
        iterations: Sweeps of an iterative contact solver. The compiler unrolls a constant number;
            otherwise a loop over lanes is not vectorised.
        blocks: Blocks in a stack.
        lanes: Lanes that a thread of a stack's kernel runs side by side.
        friction: Law of friction where a block slides in two directions: cone or box.
        points: Contact points of a body that is no box.
        vertical: Whether the base of a body in the plane moves upwards, too.
        chains: Whether blocks of a stack in the plane stand on chains of corners.
        prescribed: Whether the lanes prescribe their angular restitution.
        thrown: Whether blocks in space start in motion, or bounce.
        bounces: Whether what strikes its base in `event` leaves it with a part of its speed.
        springs: Whether the contacts of an assembly are springs.
        bonds: Whether joints of an assembly have cohesion and tensile strength until they break.
        trees: Whether joints of some assemblies form trees.
    """

    precision: str
    motion: str = "still"
    iterations: int = 0
    blocks: int = 1
    lanes: int = LANE_WIDTH
    friction: str = "cone"
    points: int = 0
    vertical: bool = False
    chains: bool = False
    prescribed: bool = False
    thrown: bool = False
    bounces: bool = False
    springs: bool = False
    bonds: bool = False
    trees: bool = False


PARAMETERS = tuple(name.upper() for name in Variant._fields)
"""Names that the loader sets in a kernel file: the fields of its `Variant`, in capitals."""

HOST_FILES = ("lane/modes", "launch/instance", "launch/rows")
"""Kernel files that are the same for all parameters: Python imports them as any other."""

SCALAR = "algebra/scalar"
"""File whose names every other file is given."""

_PREFIX = "warprock.kernels."
_LOCK = threading.RLock()


CAPTURES = "-mllvm=-capture-tracking-max-uses-to-explore=10000"
"""Lets the compiler look at all uses of the matrices that keep lanes. Otherwise it cannot prove
that no pointer to them escapes, must assume that they overlap the arrays of the launch, and makes
no vector code."""


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
    """Vectors that a loop over lanes works on side by side: at most as many as a pack has.

    If it is asked for more, the compiler takes shorter vectors. In float32 and packs of two that
    costs up to two fifths of the speed.
    """
    return min(INTERLEAVE, LANE_WIDTH * BYTES[precision] // VECTOR_BYTES)


TWO_VECTORS = module_options(interleave=2)
"""For steps of medium length: more vectors would not fit into the registers.

How much that costs depends on the processor. On an Intel Xeon four vectors are 3 to 18 % slower
than two in float64. On an AMD EPYC that works on 512 bits in two halves (`HALVES_VECTORS`) they are
3 to 10 % slower for bodies of housner and event and for blocks under a record; but bodies of
housner under a record along x take 7 % less time with four."""

FOUR_VECTORS = module_options(interleave=4, more_flags="-mllvm=-licm-mssa-optimization-cap=10000")
"""For blocks of housner under analytic motions in float64, if `HALVES_VECTORS`: they take 4 to 11 %
less time than with two vectors.

The flag lets the compiler read what stays the same once, before the loop over steps. It looks at
100 reads otherwise, and with four vectors those beyond that take a further tenth of the time. Other
kernels gain nothing by it."""

ONE_VECTOR = module_options(interleave=1, more_flags=CAPTURES)
"""For long steps: one vector fills the registers, and the processor overlaps the vectors of a pack
by itself."""

LOOPS_STAY = {"max_unroll": 0}
"""For one lane a thread: loops over blocks are not unrolled, since their bodies are long."""

SHORT_COPIES = module_options(more_flags="-mprefer-vector-width=128")
"""For one lane a thread and structs of matrices that are set number by number, then copied: a copy
by 64 bytes waits until the processor is done with each of the eight numbers that it reads. Copies
by 16 bytes save stacks of `direct` 4 to 10 % in float64, and cost them 4 % in float32."""


def short_loops_go(blocks: int) -> dict[str, object]:
    """Module options for one lane a thread and stacks of so many blocks.

    Loops over the rows of a matrix and over the blocks are unrolled, which takes a quarter to two
    fifths less time; longer loops are not. Six blocks take 16 s to compile, 12 with loops
    that stay.
    """
    return {"max_unroll": max(3, blocks)}


BRANCHES = {
    "cpu_compiler_flags": f"-march=native -ffp-contract=off {SAME_CODE}",
    "max_unroll": 0,
}
"""For one lane a thread and steps with many branches: loops are not unrolled, and the compiler may
leave calls. No vector code."""

VECTORS_INSIDE = {
    "cpu_compiler_flags": (
        "-march=native -ffp-contract=off -mprefer-vector-width=512 -fno-slp-vectorize"
        " -mllvm=-enable-interleaved-mem-accesses=false -mstackrealign -mstack-alignment=64"
        f" {SAME_CODE} -mllvm=-force-vector-interleave=1 {CAPTURES}"
    ),
    "max_unroll": 0,
}
"""For steps with many branches in which one loop becomes vector code, over what a lane has side by
side."""


def kernel_module(file: str, **decided: Any) -> ModuleType:
    """The instance of a kernel file for a precision, a kind of ground motion and a stack.

    Args:
        file: Path of the file in `kernels/` without its ending, such as `housner/block`.
        **decided: Fields of its `Variant`.

    Raises:
        OSError: A kernel file cannot be read.
    """
    with _LOCK:
        return _instance(file, dict(zip(PARAMETERS, Variant(**decided), strict=True)))


def _instance(file: str, given: dict[str, object]) -> ModuleType:
    """The instance of a file for those of the given parameters that it mentions."""
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
        for value in vars(module).values():
            if isinstance(value, wp.Function):
                value.adj.skip_reverse_codegen = True  # no kernel runs backwards
    except BaseException:
        del sys.modules[module_name]
        raise
    return module


def public(module: ModuleType) -> dict[str, object]:
    """The names that a kernel file defines itself, without those that begin with an underscore."""
    given = {"wp", "real", *PARAMETERS}
    return {k: v for k, v in vars(module).items() if not (k.startswith("_") or k in given)}


def _importer(given: dict[str, object]) -> Callable[..., ModuleType]:
    """An `import` function that gives the instances of kernel files for given parameters."""

    def load(name: str, *args: object, **kwargs: object) -> ModuleType:
        file = _kernel_file(name)
        return _instance(file, given) if file else builtins.__import__(name, *args, **kwargs)

    return load


def _kernel_file(module: str) -> str:
    """The kernel file behind the name of a module; empty for an ordinary Python module."""
    file = module.removeprefix(_PREFIX).replace(".", "/") if module.startswith(_PREFIX) else ""
    return "" if file in HOST_FILES else file


@functools.cache
def _needed(file: str) -> frozenset[str]:
    """Names of the parameters that a file, or a file that it imports, mentions."""
    names = _names(_code(file))
    found = {"PRECISION"} | names.intersection(PARAMETERS)
    imported = {_kernel_file(name) for name in names} - {""}
    return frozenset(found.union(*(_needed(each) for each in imported)))


def _names(code: CodeType) -> set[str]:
    """All global names in compiled code, and the names of the modules that it imports."""
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
