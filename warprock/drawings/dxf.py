"""Drawings in DXF files: closed polylines, each a block.

The package ezdxf reads them, an extra of ours. Its layer is the group of a block. A text inside an
outline is its name. Blocks of the drawing (INSERT) are taken apart; layers that are off or frozen,
and all that is no polyline, are left out.
"""

from __future__ import annotations

import collections
import importlib.util
import io
from collections.abc import Iterator
from typing import Any

import numpy as np

from warprock.drawings.outline import (
    Array,
    Drawing,
    Outline,
    named_apart,
    require_few,
    require_outlines,
)
from warprock.errors import InputError, Said

EXTRA = "dxf"
"""The extra of ours that brings what reads drawings."""

HOLDS = "closed polylines, a block each"


def read(content: bytes, source: str) -> Drawing:
    """The blocks of a file.

    Args:
        content: Its bytes.
        source: Its path, as errors name it.

    Raises:
        InputError: ezdxf is not installed or cannot read the file, or a polyline is open or bent.
    """
    if importlib.util.find_spec("ezdxf") is None:
        allowed = f"must be installed to read drawings: pip install 'warprock[{EXTRA}]'"
        raise InputError(source, "", Said("no package ezdxf"), allowed)
    import ezdxf
    import ezdxf.disassemble
    import ezdxf.recover
    import ezdxf.units

    try:
        document, _ = ezdxf.recover.read(io.BytesIO(content))
    except (ezdxf.DXFError, OSError, ValueError) as error:
        why = str(error).partition("\n")[0] or type(error).__name__
        raise InputError(source, "", Said(why), "must be a DXF file that ezdxf can read") from None
    hidden = {
        layer.dxf.name.lower() for layer in document.layers if layer.is_off() or layer.is_frozen()
    }
    outlines: list[Outline] = []
    names: list[tuple[str, Array]] = []
    others: collections.Counter[str] = collections.Counter()
    for entity in ezdxf.disassemble.recursive_decompose(document.modelspace()):
        layer, kind = str(entity.dxf.get("layer", "0")), entity.dxftype()
        if layer.lower() in hidden:
            others["on layers that are off"] += 1
        elif kind in ("LWPOLYLINE", "POLYLINE"):
            require_few(source, len(outlines))
            outlines += _outline(source, entity, layer, kind)
        elif kind in ("TEXT", "MTEXT"):
            text = entity.plain_text() if kind == "TEXT" else entity.plain_text(split=False)
            at = entity.dxf.insert
            names.append((" ".join(text.split()), np.array([at.x, at.y])))
        else:
            others[kind] += 1
    require_outlines(source, outlines, HOLDS)
    factor = ezdxf.units.conversion_factor
    unit = document.units
    length = float(factor(unit, ezdxf.units.M)) if unit else None
    left_out = ", ".join(f"{count:,} {kind}" for kind, count in sorted(others.items()))
    found = named_apart(_named(outlines, names))
    return Drawing(found, length, left_out)


def _outline(source: str, entity: Any, layer: str, kind: str) -> Iterator[Outline]:
    """The polygon of a polyline."""
    if kind == "POLYLINE":
        if not (entity.is_2d_polyline or entity.is_3d_polyline):
            return
        corners = np.array([[at.x, at.y] for at in entity.points_in_wcs()])
        bent = entity.is_2d_polyline and entity.has_arc
    else:
        corners = np.array([[at.x, at.y] for at in entity.vertices_in_wcs()])
        bent = entity.has_arc
    where = f"layer {layer}, entity {entity.dxf.get('handle') or kind}"
    if bent:
        allowed = "must have straight edges: blocks are polygons"
        raise InputError(source, where, Said("a polyline with an arc"), allowed)
    closed = entity.is_closed
    if len(corners) > 1 and np.allclose(corners[0], corners[-1], rtol=0.0, atol=_same(corners)):
        corners, closed = corners[:-1], True
    if not closed:
        allowed = "must be closed: a block is a polygon; switch off layers of other lines"
        raise InputError(source, where, Said("an open polyline"), allowed)
    yield Outline("", layer, corners)


def _same(corners: Array) -> float:
    return 1e-9 * float(np.abs(corners).max())


def _named(outlines: list[Outline], names: list[tuple[str, Array]]) -> Iterator[Outline]:
    """Outlines with the first text that begins inside each."""
    places = np.array([at for _, at in names]).reshape(-1, 2)
    for each in outlines:
        low, high = each.corners.min(axis=0), each.corners.max(axis=0)
        near = np.flatnonzero(((places >= low) & (places <= high)).all(axis=1))
        inside = (names[k][0] for k in near if _inside(each.corners, places[k]))
        yield each._replace(name=next(filter(None, inside), ""))


def _inside(corners: Array, at: Array) -> bool:
    """Whether a point lies in a polygon: a ray to +x crosses its edges an odd number of times."""
    here, after = corners, np.roll(corners, -1, axis=0)
    over = (here[:, 1] > at[1]) != (after[:, 1] > at[1])
    rise = np.where(over, after[:, 1] - here[:, 1], 1.0)
    x = here[:, 0] + (at[1] - here[:, 1]) / rise * (after[:, 0] - here[:, 0])
    return bool((over & (x > at[0])).sum() % 2)
