"""Assemblies of COMPAS: JSON files of `compas_assembly`, `compas_cra` and `compas_dem`.

Three forms are read: an `Assembly`, whose nodes hold blocks; a `BlockModel`, whose elements do; and
a list of meshes. In the plane blocks are prisms side by side, in space convex bodies. What the file
calls a support (`is_support`) is fixed.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from warprock.drawings.outline import (
    Drawing,
    Outline,
    Solid,
    named_apart,
    require_few,
    require_outlines,
)
from warprock.drawings.sections import Surface, convex_corners, plane_sections
from warprock.errors import InputError, Said

HOLDS = "an Assembly or a BlockModel of COMPAS, or a list of its meshes"


class _Block(NamedTuple):
    name: str
    mesh: Mapping[str, Any]
    support: bool
    placed: Any


def read(content: bytes, source: str) -> Drawing:
    """The blocks of a file as their sections in the plane.

    Args:
        content: Its bytes.
        source: Its path, as errors name it.

    Raises:
        InputError: It is no JSON of COMPAS, or its blocks are no prisms in one plane.
    """
    blocks, surfaces = _read(content, source)
    found = plane_sections(source, surfaces)
    outlines = named_apart(
        Outline(each.name, "", found[str(place)], each.support) for place, each in enumerate(blocks)
    )
    require_outlines(source, outlines, HOLDS)
    return Drawing(outlines)


def read_solids(content: bytes, source: str) -> Drawing:
    """The blocks of a file in space.

    Args:
        content: Its bytes.
        source: Its path, as errors name it.

    Raises:
        InputError: It is no JSON of COMPAS, or a block is not closed or not convex.
    """
    blocks, surfaces = _read(content, source)
    solids = named_apart(
        Solid(each.name, "", convex_corners(source, surface), each.support)
        for each, surface in zip(blocks, surfaces.values(), strict=True)
    )
    return Drawing((), solids=solids)


def _read(content: bytes, source: str) -> tuple[list[_Block], dict[str, Surface]]:
    """The blocks and their surfaces by number.

    Raises:
        InputError: It is no JSON of COMPAS, or holds no blocks.
    """
    try:
        text = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise InputError(source, "", Said(error), f"must be JSON: {HOLDS}") from None
    try:
        blocks = list(_blocks(text))
        surfaces = {str(place): _surface(each) for place, each in enumerate(blocks)}
    except (KeyError, TypeError, ValueError, AttributeError, IndexError):
        raise InputError(source, "", Said("another structure"), f"must hold {HOLDS}") from None
    require_few(source, len(surfaces))
    if not surfaces:
        require_outlines(source, [], HOLDS)
    return blocks, surfaces


def _inner(table: Any) -> Any:
    """What an object of COMPAS holds: its data, which early versions call its value."""
    while isinstance(table, Mapping) and ("data" in table or "value" in table):
        table = table["data"] if "data" in table else table["value"]
    return table


def _blocks(text: Any) -> Iterator[_Block]:
    """Blocks of any of the three forms."""
    top = _inner(text)
    if isinstance(top, list):
        for place, each in enumerate(top, 1):
            yield _Block(str(place), _inner(each), False, None)
    elif "elements" in top:
        elements = top["elements"]
        for element in elements.values() if isinstance(elements, Mapping) else elements:
            own = _inner(element)
            mesh = own["geometry"] if "geometry" in own else own["shape"]
            placed = _inner(own.get("transformation"))
            yield _Block(str(own.get("name") or ""), _inner(mesh), _support(own), placed)
    else:
        graph = _inner(top.get("graph", top))
        for key, node in graph["node"].items():
            yield _Block(str(key), _inner(node["block"]), _support(node), None)


def _support(own: Mapping[str, Any]) -> bool:
    return bool(own.get("is_support", False))


def _surface(block: _Block) -> Surface:
    vertices = block.mesh["vertex"]
    place = {str(key): number for number, key in enumerate(vertices)}
    corners = np.array([[float(at[axis]) for axis in "xyz"] for at in vertices.values()])
    if block.placed is not None:
        matrix = np.asarray(block.placed["matrix"], dtype=np.float64)
        corners = corners @ matrix[:3, :3].T + matrix[:3, 3]
    faces = [np.array([place[str(key)] for key in face]) for face in block.mesh["face"].values()]
    return Surface(block.name, corners, faces)
