"""Moving pictures as files."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest
from PIL import Image

from warprock.scenes.pictures import WRITERS


def pictures(count: int) -> list[np.ndarray]:
    """A white square that goes to the right on black."""
    found = np.zeros((count, 32, 64, 3), dtype=np.uint8)
    for k in range(count):
        found[k, 8:24, 8 * k : 8 * k + 16] = 255
    return list(found)


def test_a_gif_holds_every_picture_and_repeats(tmp_path: pathlib.Path) -> None:
    WRITERS[".gif"](tmp_path / "a.gif", iter(pictures(5)), 25.0)
    with Image.open(tmp_path / "a.gif") as image:
        assert (image.n_frames, image.size, image.info["duration"]) == (5, (64, 32), 40)
        assert image.info["loop"] == 0
        image.seek(4)
        last = np.asarray(image.convert("L"))
    assert last[16, 40] == 255
    assert last[16, 8] == 0


def test_an_mp4_holds_every_picture(tmp_path: pathlib.Path) -> None:
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg", reason="the extra movie is missing")
    WRITERS[".mp4"](tmp_path / "a.mp4", iter(pictures(5)), 25.0)
    count, seconds = imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "a.mp4"))
    assert (count, round(seconds, 2)) == (5, 0.2)
