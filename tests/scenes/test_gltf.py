"""Lanes as glTF."""

from __future__ import annotations

import json
import pathlib
import struct

import numpy as np

from tests.shared.moving import swinging
from warprock.scenes.gltf import write_gltf


def test_a_glb_holds_the_motion_of_every_body(tmp_path: pathlib.Path) -> None:
    motion = swinging(5)
    write_gltf(tmp_path / "a.glb", motion)
    data = (tmp_path / "a.glb").read_bytes()
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
