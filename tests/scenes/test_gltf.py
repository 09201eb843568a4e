"""Lanes as glTF."""

from __future__ import annotations

import json
import pathlib
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.shared.moving import swinging, tumbling
from warprock.running.scene_motion import SceneMotion
from warprock.scenes.gltf import write_gltf


def written(
    path: pathlib.Path, motion: SceneMotion
) -> tuple[dict[str, Any], Callable[[int], np.ndarray]]:
    """A lane as a file: its JSON, and what reads one of its arrays of numbers."""
    write_gltf(path, motion)
    data = path.read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    scene = json.loads(data[20 : 20 + size])
    binary = data[28 + size :]
    assert len(binary) >= scene["buffers"][0]["byteLength"]

    def read(accessor: int) -> np.ndarray:
        part = scene["accessors"][accessor]
        view = scene["bufferViews"][part["bufferView"]]
        raw = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        return np.frombuffer(raw, dtype="<f4").reshape(part["count"], -1)

    return scene, read


def test_a_glb_holds_the_motion_of_every_body(tmp_path: pathlib.Path) -> None:
    motion = swinging(5)
    scene, read = written(tmp_path / "a.glb", motion)
    (animation,) = scene["animations"]
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        values, name = read(sampler["output"]), scene["nodes"][channel["target"]["node"]]["name"]
        np.testing.assert_allclose(read(sampler["input"])[:, 0], motion.times, atol=1e-6)
        if name == "block 2":
            way = channel["target"]["path"]
            expected = motion.position[1] if way == "translation" else motion.attitude[1]
            np.testing.assert_allclose(values, expected, atol=1e-6)
    assert [node["name"] for node in scene["nodes"][:3]] == ["base", "block 1", "block 2"]
    assert scene["nodes"][1]["scale"] == [0.4, 0.5, 1.0]


def test_a_body_is_the_hull_of_its_corners_seen_from_outside(tmp_path: pathlib.Path) -> None:
    motion = tumbling()
    scene, read = written(tmp_path / "a.glb", motion)
    attributes = scene["meshes"][1]["primitives"][0]["attributes"]
    corners = read(attributes["POSITION"]).reshape(-1, 3, 3)
    first, second, third = np.moveaxis(corners, 1, 0)
    across = np.cross(second - first, third - first)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    np.testing.assert_allclose(np.repeat(across, 3, axis=0), read(attributes["NORMAL"]), atol=1e-6)
    # By the divergence theorem the wedge: 0.3 m long, and half of 0.4 m x 0.4 m.
    volume = np.sum(np.cross(first, second) * third) / 6.0
    assert volume == pytest.approx(0.3 * 0.5 * 0.4 * 0.4, rel=1e-6)
    assert "scale" not in scene["nodes"][1]
    # It goes 2 m along x, and the base lies below.
    assert 0.5 * scene["nodes"][0]["scale"][0] > 2.0
