"""Blender's rigid-body world, run by this file as a process of its own: `python THIS_FILE`.

It imports nothing but the standard library and bpy. On stdin it takes one JSON object, on the last
line of stdout it answers another: `warprock.programs.blender` says what is in them.

The base is an animated passive body, with a key of its place at every frame and straight lines
between them. Since Blender 4.4 a curve moves nothing unless its object is bound to the slot of the
action that holds it. Damping and deactivation, on by default, are off. Results exist at frames.
"""

from __future__ import annotations

import json
import os
import sys
import time
from typing import Any

FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""Faces of a box by its corners, which are numbered by the signs of x, y and z."""
BASE_HALF = (20.0, 20.0, 1.0)
"""Half dimensions of the base [m]."""
FIRST = 1
"""Number of the frame at the start."""


def main() -> None:
    """Answers what is asked on stdin."""
    asked = json.load(sys.stdin)
    bpy = import_bpy()
    answers = [run_scene(bpy, scene, asked["settings"]) for scene in asked["scenes"]]
    print()
    print(json.dumps(answers))


def import_bpy() -> Any:
    """Blender with one worker thread, where the system lets a process choose its processors.

    With more, an animated base and the bodies on it are not always moved in the same order: the
    first peaks of the paper's pulses were seen to differ by 1 % from one run to the next. Blender
    counts the processors that it may use while it is imported.
    """
    # bpy would look for the NumPy that it was built with, which nothing here needs.
    sys.modules["numpy"] = None  # type: ignore[assignment]
    allowed = os.sched_getaffinity(0) if sys.platform == "linux" else None
    if allowed:
        os.sched_setaffinity(0, {min(allowed)})
    import bpy

    if allowed:
        os.sched_setaffinity(0, allowed)
    return bpy


def run_scene(bpy: Any, scene: dict[str, Any], settings: dict[str, Any]) -> dict[str, Any]:
    """Runs one scene; `poses` at the frames, [place, quaternion (w, x, y, z)] of each block."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage = bpy.context.scene
    stage.render.fps = max(1, round(1.0 / scene["frame"]))
    stage.render.fps_base = stage.render.fps * scene["frame"]
    stage.gravity = (0.0, 0.0, -scene["gravity"])
    bpy.ops.rigidbody.world_add()
    world = stage.rigidbody_world
    world.collection = bpy.data.collections.new("bodies")
    world.substeps_per_frame = settings["substeps"]
    world.solver_iterations = settings["iterations"]
    last = FIRST + scene["frame_count"]
    stage.frame_start = world.point_cache.frame_start = FIRST
    stage.frame_end = world.point_cache.frame_end = last
    base = add_body(bpy, stage, "base", BASE_HALF, (0.0, 0.0, 0.0))
    base.rigid_body.type = "PASSIVE"
    base.rigid_body.collision_shape = "BOX"
    base.rigid_body.friction = scene["frictions"][0]
    base.location = (0.0, 0.0, -BASE_HALF[2])
    if scene["base"]:
        base.rigid_body.kinematic = True
        animate(bpy, base, scene["base"])
    blocks = []
    for number, asked in enumerate(scene["blocks"]):
        block = add_body(bpy, stage, f"block {number}", asked["half"], asked["middle"])
        block.location = asked["position"]
        block.rotation_mode = "QUATERNION"
        block.rotation_quaternion = asked["attitude"]
        body = block.rigid_body
        body.mass = asked["mass"]
        body.friction = scene["frictions"][1 + number]
        body.collision_shape = settings["shape"]
        body.mesh_source = "BASE"
        body.use_margin = True
        body.collision_margin = settings["margin"]
        blocks.append(block)
    return follow(stage, blocks, range(FIRST, last + 1), scene["frames_per_result"])


def add_body(bpy: Any, stage: Any, name: str, half: Any, middle: Any) -> Any:
    """A box as a rigid body whose origin is its centre of mass."""
    signs = (-1.0, 1.0)
    corners = [
        tuple(middle[axis] + (a, b, c)[axis] * half[axis] for axis in range(3))
        for a in signs
        for b in signs
        for c in signs
    ]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], FACES)
    mesh.update()
    body = bpy.data.objects.new(name, mesh)
    stage.collection.objects.link(body)
    stage.rigidbody_world.collection.objects.link(body)
    rigid = body.rigid_body
    rigid.restitution = rigid.linear_damping = rigid.angular_damping = 0.0
    rigid.use_deactivation = False
    return body


def animate(bpy: Any, base: Any, places: list[list[float]]) -> None:
    """Curves of the base's place: one key a frame, straight lines between them."""
    action = bpy.data.actions.new("base")
    slot = action.slots.new(id_type="OBJECT", name="base")
    strip = action.layers.new("base").strips.new(type="KEYFRAME")
    curves = strip.channelbag(slot, ensure=True).fcurves
    height = base.location[2]
    for axis in range(3):
        curve = curves.new("location", index=axis)
        points = curve.keyframe_points
        points.add(len(places))
        above = height if axis == 2 else 0.0
        keys = [(FIRST + number, place[axis] + above) for number, place in enumerate(places)]
        points.foreach_set("co", [part for key in keys for part in key])
        for point in points:
            point.interpolation = "LINEAR"
        curve.update()
    base.animation_data_create()
    base.animation_data.action = action
    base.animation_data.action_slot = slot


def follow(stage: Any, blocks: list[Any], frames: range, every: int) -> dict[str, Any]:
    """Plays the frames in order, as the simulation needs it, and collects the poses."""
    poses = []
    begin = time.process_time()
    for number, frame in enumerate(frames):
        stage.frame_set(frame)
        if number % every == 0:
            matrices = [block.matrix_world for block in blocks]
            poses.append([[*matrix.translation, *matrix.to_quaternion()] for matrix in matrices])
    return {"poses": poses, "cpu_s": time.process_time() - begin}


if __name__ == "__main__":
    main()
