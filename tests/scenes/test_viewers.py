"""Lanes in Newton's viewers."""

from __future__ import annotations

import dataclasses
import pathlib
import socket

import numpy as np
import pytest

from tests.shared.moving import swinging, tumbling
from warprock.errors import InputError
from warprock.scenes.viewers import open_viewer, play, write_usd

pytestmark = pytest.mark.thorough
"""Newton's viewers take 4 s to import."""


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


def test_a_usd_file_holds_the_hull_of_a_body(tmp_path: pathlib.Path) -> None:
    usd = pytest.importorskip("pxr.Usd", reason="the extra usd is missing")
    from pxr import UsdGeom

    motion = tumbling()
    write_usd(tmp_path / "a.usda", motion, 10.0)
    stage = usd.Stage.Open(str(tmp_path / "a.usda"))
    box = UsdGeom.BBoxCache(4, [UsdGeom.Tokens.default_])
    prim = stage.GetPrimAtPath("/root/block_1")
    found = box.ComputeWorldBound(prim).ComputeAlignedRange()
    corners = motion.corners_in_space()[0, 4]
    # It is turned about x, and its faces along x lie square to it.
    np.testing.assert_allclose(found.GetMin()[0], corners[:, 0].min(), atol=1e-5)
    np.testing.assert_allclose(found.GetMax()[0], corners[:, 0].max(), atol=1e-5)
    wedge = UsdGeom.Mesh(stage.GetPrimAtPath("/root/block_1/instance_0"))
    # Two ends of a triangle each, and three sides of two.
    assert len(wedge.GetPointsAttr().Get(0)) == 3 * 8


def test_a_viewer_is_shown_every_sample() -> None:
    import newton.viewer

    class Counted(newton.viewer.ViewerNull):
        def __init__(self) -> None:
            super().__init__()
            self.shown, self.curves, self.eye = 0, set[str](), np.zeros(3)

        def set_camera(self, pos: object, pitch: float, yaw: float) -> None:
            self.eye = np.array(pos)

        def log_scalar(self, name: str, value: float, **options: object) -> None:
            self.curves.add(name)

        def end_frame(self) -> None:
            self.shown += 1

    viewer = Counted()
    motion = swinging(5)
    play(viewer, motion, 100.0, rounds=2)
    assert viewer.shown == 10
    before = viewer.eye
    # An assembly a hundred metres long that begins at x = 0 is seen from before its middle, and
    # whole: half of it is within the 22.5 degrees to each side of a view of 45 degrees.
    shift = np.array([50.0, 0.0, 0.0])
    long = np.array([100.0, *motion.sizes[0, 1:]])
    wide = dataclasses.replace(
        motion,
        sizes=np.broadcast_to(long, motion.sizes.shape),
        position=motion.position - motion.position[..., :1] * [1.0, 0.0, 0.0] + shift,
        base=0.0 * motion.base,
        fixed=1,
    )
    play(viewer, wide, 100.0, rounds=1)
    assert viewer.eye[0] == pytest.approx(50.0, abs=1.0)
    assert before[0] == pytest.approx(0.0, abs=0.1)
    assert -np.tan(np.deg2rad(22.5)) * viewer.eye[1] >= 50.0
    # A viewer that reads a name as a path would show its last part alone.
    assert len(viewer.curves) == 4
    assert all(name.replace("_", "").isalnum() for name in viewer.curves), viewer.curves


@pytest.mark.parametrize("kind", ["viser", "rerun"])
def test_a_port_that_is_taken_is_refused(kind: str) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(InputError, match=r"--port: got [0-9]+, which cannot be listened on"):
            open_viewer(kind, taken.getsockname()[1])


def test_a_window_needs_a_display(monkeypatch: pytest.MonkeyPatch) -> None:
    import newton.viewer

    class NoSuchDisplayError(Exception):
        __module__ = "pyglet.display.xlib"

    def fail() -> None:
        raise NoSuchDisplayError('Cannot connect to "None"')

    monkeypatch.setattr(newton.viewer, "ViewerGL", fail)
    with pytest.raises(InputError, match=r'which needs a display .*Cannot connect to "None"'):
        open_viewer("window", 8080)
