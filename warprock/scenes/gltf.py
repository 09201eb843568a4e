"""A lane as a glTF file (GLB): blocks that move, for browsers, Blender and slides.

glTF has y upwards: a node turns the scene, in which z is up.

Khronos Group (2021), glTF 2.0 Specification.
"""

from __future__ import annotations

import json
import pathlib
import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.figures.palette import SERIES
from warprock.running.files import replacing
from warprock.running.scene_motion import SceneMotion
from warprock.scenes.solids import solids

BASE_COLOUR = "#BFBFBF"
FLOAT, SHORT = 5126, 5123
"""Codes of glTF for the type of numbers."""
UPRIGHT = [-float(np.sqrt(0.5)), 0.0, 0.0, float(np.sqrt(0.5))]
"""The turn that brings z to y."""


class _File:
    """The parts of a glTF file, and the bytes that they point at."""

    def __init__(self) -> None:
        self.bytes = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: npt.NDArray[Any], *, bounds: bool = False) -> int:
        """Adds an array, shape [count] or [count, part]; returns the number of its accessor."""
        short = np.issubdtype(values.dtype, np.integer)
        data = values.astype("<u2" if short else "<f4")
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": data.nbytes})
        self.bytes += data.tobytes()
        kind = "SCALAR" if data.ndim == 1 else f"VEC{data.shape[1]}"
        accessor: dict[str, Any] = {
            "bufferView": len(self.views) - 1,
            "componentType": SHORT if short else FLOAT,
            "count": len(data),
            "type": kind,
        }
        if bounds:
            accessor["min"] = np.atleast_1d(data.min(axis=0)).tolist()
            accessor["max"] = np.atleast_1d(data.max(axis=0)).tolist()
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def write_gltf(path: pathlib.Path, motion: SceneMotion) -> None:
    """Writes a lane as one GLB file with an animation in real time.

    Args:
        path: The file.
        motion: The lane.
    """
    file = _File()
    cube = _primitive(file, *_cube())
    times = file.add(motion.times, bounds=True)
    tall = motion.tall
    side = 2.0 * motion.reach
    low, high = motion.span
    size = np.array([high - low, side, 0.06 * tall])
    shown = np.array([0.5 * (low + high), 0.0, -0.03 * tall])
    bodies = [("base", BASE_COLOUR, size, motion.base + shown)]
    bodies += [
        (f"block {k + 1}", SERIES[k % len(SERIES)], size, motion.position[k])
        for k, size in enumerate(motion.sizes)
    ]
    held = list(solids(motion, 0.06 * tall))
    bodies += [(each.name, each.colour, each.sizes[0], each.places) for each in held]
    nodes: list[dict[str, Any]] = []
    channels, samplers, meshes, materials = [], [], [], []
    last = len(motion.sizes)
    for k, (name, shade, size, places) in enumerate(bodies):
        moved = [("translation", places)]
        if 0 < k <= last:
            moved.append(("rotation", _unbroken(motion.attitude[k - 1])))
        elif k > last:
            of_held = held[k - 1 - last]
            moved += [("rotation", _unbroken(of_held.turns)), ("scale", of_held.sizes)]
        for way, values in moved:
            samplers.append({"input": times, "output": file.add(values)})
            target = {"node": k, "path": way}
            channels.append({"sampler": len(samplers) - 1, "target": target})
        surface = motion.surface(k - 1) if 0 < k <= last else None
        shape = cube if surface is None else _primitive(file, *_facets(*surface))
        meshes.append({"primitives": [shape | {"material": k}]})
        colour = _rgb(shade)
        look = {"baseColorFactor": [*colour, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9}
        materials.append({"name": name, "pbrMetallicRoughness": look})
        node = {"name": name, "mesh": k, "translation": places[0].tolist()}
        nodes.append(node | ({"scale": size.tolist()} if surface is None else {}))
    nodes.append({"name": motion.name, "rotation": UPRIGHT, "children": list(range(len(bodies)))})
    scene = {
        "asset": {"version": "2.0", "generator": "warprock"},
        "scene": 0,
        "scenes": [{"nodes": [len(bodies)]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "animations": [{"name": motion.name, "channels": channels, "samplers": samplers}],
        "buffers": [{"byteLength": len(file.bytes)}],
        "bufferViews": file.views,
        "accessors": file.accessors,
    }
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    data = bytes(file.bytes) + b"\0" * (-len(file.bytes) % 4)
    length = 12 + 8 + len(text) + 8 + len(data)
    with replacing(path) as temporary:
        temporary.write_bytes(
            struct.pack("<4sII", b"glTF", 2, length)
            + struct.pack("<I4s", len(text), b"JSON")
            + text
            + struct.pack("<I4s", len(data), b"BIN\0")
            + data
        )


def _primitive(
    file: _File, corners: npt.NDArray[Any], normals: npt.NDArray[Any], triangles: npt.NDArray[Any]
) -> dict[str, Any]:
    """A part of a mesh: its arrays in the file."""
    attributes = {"POSITION": file.add(corners, bounds=True), "NORMAL": file.add(normals)}
    return {"attributes": attributes, "indices": file.add(triangles)}


def _facets(
    corners: npt.NDArray[Any], normals: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]]:
    """Corners, normals and triangles of a surface with flat faces: each has corners of its own."""
    flat = np.repeat(normals, 3, axis=0)
    return corners.reshape(-1, 3), flat, np.arange(len(flat), dtype=np.int64)


def _cube() -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]]:
    """Corners, normals and triangles of a cube of size 1: four corners a face."""
    corners: list[npt.NDArray[Any]] = []
    normals: list[npt.NDArray[Any]] = []
    triangles: list[int] = []
    for axis in range(3):
        for side in (-0.5, 0.5):
            first, second = (axis + 1) % 3, (axis + 2) % 3
            start = len(corners)
            for u, v in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
                corner, normal = np.zeros(3), np.zeros(3)
                corner[axis], corner[first], corner[second] = side, u, v
                normal[axis] = 2.0 * side
                corners.append(corner)
                normals.append(normal)
            turn = (0, 1, 2, 0, 2, 3) if side > 0.0 else (0, 2, 1, 0, 3, 2)
            triangles += [start + k for k in turn]
    return np.array(corners), np.array(normals), np.array(triangles, dtype=np.int64)


def _unbroken(attitude: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Quaternions with signs such that each lies near the one before it."""
    turns = np.sum(attitude[1:] * attitude[:-1], axis=1) < 0.0
    signs = np.concatenate([[1.0], np.where(np.cumsum(turns) % 2 == 1, -1.0, 1.0)])
    return np.asarray(attitude * signs[:, None])


def _rgb(colour: str) -> list[float]:
    """A colour `#RRGGBB` as parts of one."""
    return [int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
