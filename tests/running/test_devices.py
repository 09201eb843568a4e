"""What Warp is told before the first kernel."""

from __future__ import annotations

import pathlib

import warp as wp
from warp._src import context

from warprock.running.devices import start_warp


def test_what_is_precompiled_is_kept_beside_the_kernels():
    start_warp()
    folder = pathlib.Path(context.runtime.get_clang_pch_dir())
    assert folder.is_dir()
    assert folder.is_relative_to(wp.config.kernel_cache_dir)
