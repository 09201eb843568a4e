"""What Warp is told before the first kernel."""

from __future__ import annotations

import pathlib

import warp as wp
from warp._src import build, codegen, context

from warprock.kernels.launch.instance import FOUR_VECTORS, TWO_VECTORS
from warprock.running.devices import start_warp


def test_what_is_precompiled_is_kept_beside_the_kernels():
    start_warp()
    folder = pathlib.Path(context.runtime.get_clang_pch_dir())
    assert folder.is_dir()
    assert folder.is_relative_to(wp.config.kernel_cache_dir)


def test_kernels_whose_flags_differ_in_the_optimiser_share_a_header(tmp_path: pathlib.Path):
    start_warp()
    source = tmp_path / "nothing.cpp"
    source.write_text('#define WP_TILE_BLOCK_DIM 1\n#define WP_NO_CRT\n#include "builtin.h"\n')
    for number, options in enumerate((TWO_VECTORS, FOUR_VECTORS)):
        build.build_cpu(
            str(tmp_path / f"{number}.o"), str(source), extra_flags=options["cpu_compiler_flags"],
            use_precompiled_headers=True, pch_dir=str(tmp_path), block_dim=1,
        )  # fmt: skip
    two, four = tmp_path.rglob("*.pch")
    assert two.samefile(four)


def test_functions_of_structs_that_nobody_calls_are_left_to_the_compiler():
    start_warp()
    heads = [
        line for line in codegen.struct_template.splitlines() if "CUDA_CALLABLE {name} add" in line
    ]
    assert heads
    assert all(line.startswith("static ") for line in heads)


def test_a_kernel_is_simplified_once():
    start_warp()
    heads = [
        line
        for line in codegen.cpu_kernel_template_forward.splitlines()
        if "_cpu_kernel_forward(" in line
    ]
    assert heads
    assert all("noinline" in line for line in heads)
