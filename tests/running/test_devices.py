"""What Warp is told before the first kernel."""

from __future__ import annotations

import pathlib

import warp as wp
from warp._src import codegen, context

from warprock.running.devices import start_warp


def test_what_is_precompiled_is_kept_beside_the_kernels():
    start_warp()
    folder = pathlib.Path(context.runtime.get_clang_pch_dir())
    assert folder.is_dir()
    assert folder.is_relative_to(wp.config.kernel_cache_dir)


def test_functions_of_structs_that_nobody_calls_are_left_to_the_compiler():
    start_warp()
    heads = [
        line for line in codegen.struct_template.splitlines() if "CUDA_CALLABLE {name} add" in line
    ]
    assert heads
    assert all(line.startswith("static ") for line in heads)
