"""The palette as readers with any colour vision see it."""

from __future__ import annotations

import itertools
import re

import matplotlib
import numpy as np
import pytest

from warprock.figures.atlas import CLASS_COLORS
from warprock.figures.overturning import COLORS as MODES
from warprock.figures.palette import ENGINE_MARKS, SCALE, SERIES
from warprock.figures.sheet import SHEET

# Machado, Oliveira and Fernandes (2009), severity 1, on linear sRGB.
VISION = {
    "all cones": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "tritanopia": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
}
TO_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
NOTICED = 10.0
"""Distance in CIELAB from which colours of lines and marks are told apart at a glance; 2.3 is the
least that an eye notices side by side."""


def lab(colors: list[str], vision: str) -> np.ndarray:
    """CIELAB (D65) of colours as that vision sees them, shape [colour, 3]."""
    rgb = np.array([matplotlib.colors.to_rgb(each) for each in colors])
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ VISION[vision].T, 0.0, 1.0)
    xyz = seen @ TO_XYZ.T / TO_XYZ.sum(axis=1)
    root = np.where(xyz > 216.0 / 24389.0, np.cbrt(xyz), (24389.0 / 27.0 * xyz + 16.0) / 116.0)
    x, y, z = root.T
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=1)


def nearest(colors: list[str], vision: str) -> tuple[float, str, str]:
    """The two colours that are most alike, and their distance."""
    places = lab(colors, vision)
    return min(
        (float(np.linalg.norm(places[i] - places[j])), colors[i], colors[j])
        for i, j in itertools.combinations(range(len(colors)), 2)
    )


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize(
    "colors",
    [
        list(SERIES),
        list(dict.fromkeys(color for color, _ in ENGINE_MARKS.values())),
        list(CLASS_COLORS),
        list(MODES.values()),
    ],
    ids=["series", "engines", "atlas", "map"],
)
def test_every_reader_tells_all_colours_apart(colors: list[str], vision: str):
    distance, one, other = nearest(colors, vision)
    assert distance > NOTICED, (one, other)


@pytest.mark.parametrize("vision", VISION)
def test_colours_of_a_scale_only_get_lighter(vision: str):
    shades = [
        matplotlib.colors.to_hex(matplotlib.colormaps[SCALE](x)) for x in np.linspace(0, 1, 33)
    ]
    assert np.all(np.diff(lab(shades, vision)[:, 0]) > 0.0)


def test_the_sheet_has_the_colours_of_the_palette():
    cycle = re.search(r"cycler\('color', \[(.*)\]\)", SHEET.read_text(encoding="utf-8"))
    assert cycle is not None
    assert re.findall(r"'(\w+)'", cycle[1]) == [color.lstrip("#") for color in SERIES]


def test_engines_that_share_a_colour_have_marks_of_their_own():
    assert len(set(ENGINE_MARKS.values())) == len(ENGINE_MARKS)
