"""What the loader gives to kernel files."""

import pathlib
import tomllib

import pytest

from warprock.kernels.instance import FOLDER, PARAMETERS, SCALAR, kernel_module, public

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_the_linter_knows_the_names_that_kernel_files_are_given():
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["ruff"]
    given = public(kernel_module(SCALAR, precision="float64"))
    assert set(linter["builtins"]) == {"real", *PARAMETERS, *given}


@pytest.mark.parametrize("name", ["sine", "larger", "HALF"])
def test_a_file_is_given_the_scalar_names_of_its_precision(name: str):
    for precision in ("float64", "float32"):
        scalar = kernel_module(SCALAR, precision=precision)
        file = kernel_module("cone", precision=precision)
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


def test_an_import_brings_the_instance_with_the_same_parameters():
    for blocks in (2, 3):
        rows = kernel_module("shape/stack", precision="float64", blocks=blocks).Rows
        contact = kernel_module("direct/stack", precision="float64", blocks=blocks)
        assert contact.Rows is rows


def test_a_file_that_fails_is_not_kept():
    for _ in range(2):
        with pytest.raises(FileNotFoundError, match="no_such_kernel"):
            kernel_module("no_such_kernel", precision="float64")
    assert not (FOLDER / "no_such_kernel.py").exists()
