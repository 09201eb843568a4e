"""The bench of assemblies by their number of blocks."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.shared.commands import invoke, succeed
from warprock.measure import blocks_bench


@pytest.mark.thorough
@pytest.mark.usefixtures("two_rooms")
def test_a_small_wall_is_measured(monkeypatch: pytest.MonkeyPatch):
    """Three courses of three blocks, two of the middle one halves at its ends.

    Three joints with the ground, six between one course and the next, and two, three and two
    upright ones.
    """
    monkeypatch.setattr(blocks_bench, "TRIES", 1)
    (row,) = json.loads(succeed("bench", "blocks", "--blocks", "10", "--json").stdout)["rows"]
    assert (row["blocks"], row["joints"], row["status"]) == (10, 22, "ok")
    assert row["cpu_us_per_step"] == pytest.approx(1e3 * row["cpu_per_motion"])


def test_walls_in_space_are_the_same_walls_of_bricks():
    plane, space = (blocks_bench._wall(10, space=each) for each in (False, True))
    assert (plane.spatial, space.spatial) == (False, True)
    assert plane.joints.count == space.joints.count == 22
    # So deep as THICK, where those of the plane are 1 m deep.
    np.testing.assert_allclose(space.mass, blocks_bench.THICK * plane.mass, rtol=1e-12)


def test_numbers_of_blocks_have_bounds():
    result = invoke("bench", "blocks", "--blocks", "10", "--blocks", "1")
    assert result.exit_code == 2
    assert "--blocks: got 1, must be a number of blocks from 2 to 20,000" in result.output
