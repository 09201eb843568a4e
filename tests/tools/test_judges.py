"""What is handed to programs that judge assemblies from outside; none of them runs."""

from __future__ import annotations

import numpy as np
import pytest

from tools.judges import SIDES, boxes_of
from warprock.measure.assembly_bench import bench_scenes


@pytest.mark.parametrize("name", ["drums", "wall"])
def test_boxes_are_the_blocks(name: str):
    (kind,) = (each.kind for each in bench_scenes() if each.name == name)
    boxes = boxes_of(kind)
    for box, mass, area, centre in zip(boxes, kind.mass, kind.area, kind.centre, strict=True):
        assert np.prod(box["sides"]) == pytest.approx(area)
        assert box["mass"] == mass
        assert box["centre"] == pytest.approx(centre.tolist())


def test_sides_of_a_box_look_outwards():
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    for side in SIDES:
        at = corners[list(side)]
        normal = np.cross(at[1] - at[0], at[2] - at[1])
        assert normal @ at.mean(axis=0) > 0.0
        assert np.abs(at.sum(axis=0)).max() == 4
