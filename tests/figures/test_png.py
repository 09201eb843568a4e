"""PNG files: Pillow reads what was written."""

from __future__ import annotations

import io

import numpy as np
import PIL.Image
import pytest

from warprock.figures.png import png_file


def test_pixels_and_words_come_back():
    pixels = np.random.default_rng(1).integers(256, size=(7, 5, 3), dtype=np.uint8)
    words = {"Title": "µ = 0.4", "Description": "5 of 12 lanes\nfell"}
    with PIL.Image.open(io.BytesIO(png_file(pixels, 160, words))) as image:
        assert (image.format, image.mode) == ("PNG", "RGB")
        assert (np.asarray(image) == pixels).all()
        assert {name: image.info[name] for name in words} == words
        # Whole dots a metre.
        assert image.info["dpi"] == pytest.approx((160.0, 160.0), abs=0.0254)
