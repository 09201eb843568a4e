"""Frames of moving pictures."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.moving import swinging
from warprock.figures.moving import frames


@pytest.mark.parametrize("spatial", [False, True])
def test_every_sample_is_a_picture_in_which_blocks_move(spatial: bool) -> None:
    motion = swinging(4, spatial=spatial)
    pictures = list(frames(motion))
    assert len(pictures) == 4
    assert all(picture.shape == (640, 720, 3) for picture in pictures)
    blue = np.array([0x00, 0x72, 0xB2]) if not spatial else None
    if blue is not None:
        shown = [np.argwhere(np.all(picture[:400] == blue, axis=-1)) for picture in pictures]
        # The lower block fills a good part of the scene, and leans to the right.
        assert all(len(part) > 5000 for part in shown)
        assert shown[2][:, 1].max() > shown[0][:, 1].max() + 5
    assert np.any(pictures[0][:400] != pictures[2][:400])


def test_the_view_goes_with_a_base_that_drifts_far() -> None:
    first, *_, last = frames(swinging(3, drift=100.0))
    dark = [np.argwhere(np.all(picture[:420] == [0xDD] * 3, axis=-1)) for picture in (first, last)]
    assert all(len(part) > 1000 for part in dark)
    np.testing.assert_allclose(dark[0].mean(axis=0), dark[1].mean(axis=0), rtol=0.0, atol=3.0)
