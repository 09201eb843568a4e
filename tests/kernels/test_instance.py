"""What the loader gives to kernel files."""

import ast
import pathlib
import re
import tomllib

import pytest
import warp as wp

from warprock.kernels.launch.instance import (
    BYTES,
    FOLDER,
    LANE_WIDTH,
    PARAMETERS,
    SCALAR,
    VECTOR_BYTES,
    halves_vectors,
    kernel_module,
    public,
)

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_the_linter_knows_the_names_that_kernel_files_are_given():
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["ruff"]
    given = public(kernel_module(SCALAR, precision="float64"))
    assert set(linter["builtins"]) == {"real", *PARAMETERS, *given}


@pytest.mark.parametrize("name", ["sine", "larger", "HALF"])
def test_a_file_is_given_the_scalar_names_of_its_precision(name: str):
    for precision in ("float64", "float32"):
        scalar = kernel_module(SCALAR, precision=precision)
        file = kernel_module("contact/cone", precision=precision)
        assert getattr(file, name) is getattr(scalar, name)


def test_an_instance_has_only_the_parameters_that_matter_to_it():
    still = kernel_module("impulse/block_run", precision="float64", motion="still", iterations=3)
    moved = kernel_module("impulse/block_run", precision="float64", motion="record", iterations=3)
    more = kernel_module("impulse/block_run", precision="float64", motion="record", iterations=4)
    assert still.Motion is not moved.Motion
    assert moved.Motion is more.Motion
    assert still.Block is moved.Block
    assert still.step is not more.step
    same = kernel_module("impulse/block_run", precision="float64", iterations=3, blocks=2)
    assert same is still


def test_no_function_has_a_derivative_that_would_be_compiled():
    file = kernel_module("impulse/block_run", precision="float64", motion="still", iterations=3)
    functions = [value for value in vars(file).values() if isinstance(value, wp.Function)]
    assert functions
    assert all(function.adj.skip_reverse_codegen for function in functions)


def test_an_import_brings_the_instance_with_the_same_parameters():
    for blocks in (2, 3):
        rows = kernel_module("shape/stack", precision="float64", blocks=blocks).Rows
        contact = kernel_module("direct/stack", precision="float64", blocks=blocks)
        assert contact.Rows is rows


@pytest.mark.parametrize("precision", BYTES)
@pytest.mark.parametrize("file", ["impulse/block_run", "direct/block_run", "housner/block_run"])
def test_a_pack_has_all_vectors_that_are_worked_on_side_by_side(file: str, precision: str):
    module = kernel_module(file, precision=precision, iterations=3)
    flags = wp.get_module_options(module)["cpu_compiler_flags"]
    (count,) = map(int, re.findall(r"-force-vector-interleave=(\d+)", flags))
    assert count * VECTOR_BYTES <= LANE_WIDTH * BYTES[precision]


@pytest.mark.parametrize(
    ("vendor", "family", "flags", "halves"),
    [
        ("AuthenticAMD", "25", "fpu avx2 avx512f avx512dq", True),  # Zen 4
        ("AuthenticAMD", "25", "fpu avx2", False),  # Zen 3: no such vectors
        ("AuthenticAMD", "26", "fpu avx2 avx512f", False),  # Zen 5
        ("GenuineIntel", "6", "fpu avx2 avx512f", False),
    ],
)
def test_family_25_of_amd_works_on_512_bits_in_two_halves(
    vendor: str, family: str, flags: str, halves: bool
):
    report = f"processor\t: 0\nvendor_id\t: {vendor}\ncpu family\t: {family}\nflags\t\t: {flags}\n"
    assert halves_vectors(report + "\n" + report) is halves
    assert not halves_vectors("")


def test_a_file_that_fails_is_not_kept():
    for _ in range(2):
        with pytest.raises(FileNotFoundError, match="no_such_kernel"):
            kernel_module("no_such_kernel", precision="float64")
    assert not (FOLDER / "no_such_kernel.py").exists()


def hidden(text: str, given: set[str]) -> set[str]:
    """Names of a kernel file that its functions give to variables of their own, too.

    Of a name with a part (`e.odd`) Warp asks its own numbers, too: `wp.e`, `wp.tau`.
    """
    tree, found = ast.parse(text), set[str]()
    outer = {*given, *(name.asname or name.name for name in _of(tree, ast.alias))}
    functions = list(_of(tree, ast.FunctionDef))
    outer |= {each.name for each in functions}
    numbers = {name for name, value in vars(wp).items() if isinstance(value, float)}
    for function in functions:
        own = {each.arg for each in function.args.args}
        own |= {each.id for each in _of(function, ast.Name) if isinstance(each.ctx, ast.Store)}
        parted = {ast.unparse(each.value) for each in _of(function, ast.Attribute)}
        found |= own & (outer | (numbers & parted))
    return found


def _of(tree, kind):
    return (node for node in ast.walk(tree) if isinstance(node, kind))


def test_what_a_kernel_is_cached_under_does_not_depend_on_what_was_built_before():
    """Warp's hash takes a variable of such a name for what it hides until it has built it once."""
    given = set(public(kernel_module(SCALAR, precision="float64")))
    for file in FOLDER.rglob("*.py"):
        found = hidden(file.read_text(encoding="utf-8"), given)
        assert not found, f"{file.relative_to(FOLDER)}: {found}"
    assert hidden("def step(x: real):\n    e = pair(x)\n    return e.odd", given) == {"e"}
    assert hidden("def step(x: real):\n    e = x * x\n    return e", given) == set()
    assert hidden("def step(x: real):\n    sine = x\n    return sized(sine)", given) == {"sine"}
    assert hidden("def size(x: real): ...\ndef step(size: real): ...", given) == {"size"}
