"""Lanes in Newton's viewers."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

from tests.shared.moving import swinging
from warprock.scenes.viewers import play, write_usd


def test_a_usd_file_holds_the_blocks_over_time(tmp_path: pathlib.Path) -> None:
    usd = pytest.importorskip("pxr.Usd", reason="the extra usd is missing")
    from pxr import UsdGeom

    motion = swinging(5)
    write_usd(tmp_path / "a.usda", motion, 10.0)
    stage = usd.Stage.Open(str(tmp_path / "a.usda"))
    assert stage.GetEndTimeCode() == 4
    cache = UsdGeom.BBoxCache(4, [UsdGeom.Tokens.default_])
    boxes = {
        prim.GetName(): cache.ComputeWorldBound(prim).ComputeAlignedRange().GetMidpoint()
        for prim in stage.Traverse()
        if "block_2" in prim.GetName()
    }
    assert boxes
    np.testing.assert_allclose(next(iter(boxes.values())), motion.position[1, 4], atol=1e-5)


def test_a_viewer_is_shown_every_sample() -> None:
    import newton.viewer

    class Counted(newton.viewer.ViewerNull):
        def __init__(self) -> None:
            super().__init__()
            self.shown, self.curves = 0, set[str]()

        def log_scalar(self, name: str, value: float, **options: object) -> None:
            self.curves.add(name)

        def end_frame(self) -> None:
            self.shown += 1

    viewer = Counted()
    play(viewer, swinging(5), 100.0, rounds=2)
    assert viewer.shown == 10
    # A viewer that reads a name as a path would show its last part alone.
    assert len(viewer.curves) == 4
    assert all(name.replace("_", "").isalnum() for name in viewer.curves), viewer.curves
