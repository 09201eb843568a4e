"""A lane in Newton's viewers: in the browser (viser), rerun, a window, or a USD file."""

from __future__ import annotations

import pathlib
import socket
import tempfile
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from warprock.errors import InputError, Said
from warprock.figures.palette import SERIES
from warprock.running.files import replacing
from warprock.running.scene_motion import SceneMotion
from warprock.scenes.solids import GAP, GONE, Solid, solids

PAUSE = 1.0
"""Seconds for which the end of a lane is shown before it plays again."""
WIDTH_SEEN = 0.6
"""Size of the scene over its width, at least: from 2.2 sizes away a view of 45 degrees is 1.8 sizes
high, and in a window that is no higher than wide the width is seen whole."""
ALIKE = 9
"""Decimals [m] in which the corners of blocks of one shape agree."""
BASE_COLOUR, GROUND_COLOUR = (0.75, 0.75, 0.75), (0.92, 0.92, 0.92)


def open_viewer(kind: str, port: int) -> Any:
    """One of Newton's viewers.

    Args:
        kind: "viser", "rerun" or "window".
        port: Port of a viewer in the browser.

    Raises:
        InputError: The port is taken, or there is no display.
    """
    import newton.viewer

    if kind == "window":
        return _window()
    _require_free(port)
    if kind == "viser":
        return newton.viewer.ViewerViser(host="127.0.0.1", port=port, label="warprock")
    return newton.viewer.ViewerRerun(app_id="warprock", web_port=port)


def _require_free(port: int) -> None:
    """Refuses a port of this machine on which another program listens."""
    with socket.socket() as tried:
        tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            tried.bind(("127.0.0.1", port))
        except OSError as error:
            allowed = f"which cannot be listened on ({error.strerror}): choose another"
            raise InputError("--port", "", port, allowed) from None


def _window() -> Any:
    """A window on a display."""
    import newton.viewer

    try:
        viewer = newton.viewer.ViewerGL()
    except Exception as error:
        # The window's package has an error of its own for each way to have no display.
        if not type(error).__module__.startswith("pyglet"):
            raise
        allowed = f"which needs a display with OpenGL: {error}"
        raise InputError("--viewer", "", Said("window"), allowed) from None
    from imgui_bundle import imgui

    # Else it would leave a file of the places of its panels wherever it is called.
    imgui.get_io().set_ini_filename("")
    return viewer


def write_usd(path: pathlib.Path, motion: SceneMotion, rate: float) -> None:
    """Writes a lane as a USD file with one time code a sample.

    Args:
        path: The file, ending in .usd, .usda or .usdc.
        motion: The lane.
        rate: Samples a second of playing.
    """
    import newton.viewer

    # What writes USD goes by the ending of the name, which a temporary does not have.
    with replacing(path) as temporary, tempfile.TemporaryDirectory(dir=path.parent) as place:
        file = pathlib.Path(place) / path.name
        viewer = newton.viewer.ViewerUSD(str(file), fps=round(rate), num_frames=None)
        shown = _shown(motion)
        for sample in range(len(motion.times)):
            _show(viewer, motion, shown, sample, sample / round(rate))
        viewer.close()
        file.replace(temporary)


def play(viewer: Any, motion: SceneMotion, speed: float, *, rounds: int | None = None) -> None:
    """Plays a lane in a viewer, over and over, until it is closed.

    Args:
        viewer: One of Newton's viewers.
        motion: The lane.
        speed: Seconds of the lane in a second.
        rounds: How often; None until the viewer is closed.
    """
    _look(viewer, motion)
    done, shown = 0, _shown(motion)
    while viewer.is_running() and (rounds is None or done < rounds):
        begun, sample = time.perf_counter(), 0
        while viewer.is_running() and sample < len(motion.times):
            if viewer.is_paused():
                begun += _wait(0.05)
                continue
            due = motion.times[sample] / speed - (time.perf_counter() - begun)
            time.sleep(max(0.0, due))
            _show(viewer, motion, shown, sample, float(motion.times[sample]))
            sample += 1
        _wait(PAUSE if rounds is None else 0.0)
        done += 1


def _wait(seconds: float) -> float:
    time.sleep(seconds)
    return seconds


def _look(viewer: Any, motion: SceneMotion) -> None:
    """Puts the camera where the whole scene is seen."""
    import warp as wp

    low, high = motion.span
    tall = float(motion.tall + motion.sizes[:, :2].max())
    size = max(tall, WIDTH_SEEN * (high - low))
    viewer.set_camera(wp.vec3(0.5 * (low + high), -2.2 * size, 0.9 * size), -12.0, 90.0)


class _Alike(NamedTuple):
    """Blocks of one shape, which viewers show as one shape in many places.

    Attributes:
        blocks: Their numbers, from 0.
        mesh: What is shown of bodies that are no boxes; None of boxes.
    """

    blocks: list[int]
    mesh: Any


def _alike(motion: SceneMotion) -> list[_Alike]:
    """Blocks by shape: those of an assembly together, of all other lanes each alone."""
    import newton

    groups: dict[bytes | int, list[int]] = {}
    for block in range(len(motion.sizes)):
        same: bytes | int = block
        if motion.fixed and motion.outline is not None:
            # Zeros of both signs are one number.
            same = (motion.outline[block].round(ALIKE) + 0.0).tobytes()
        groups.setdefault(same, []).append(block)
    found = []
    for blocks in groups.values():
        surface, mesh = motion.surface(blocks[0]), None
        if surface is not None:
            corners, normals = surface
            # Flat faces: each triangle has corners of its own.
            flat, order = np.repeat(normals, 3, axis=0), np.arange(3 * len(corners))
            points = corners.reshape(-1, 3)
            mesh = newton.Mesh(points, order, normals=flat, compute_inertia=False)
        found.append(_Alike(blocks, mesh))
    return found


class _Shown(NamedTuple):
    """What is shown of a lane besides its blocks.

    Attributes:
        alike: Its blocks by shape.
        rigid: What holds them and keeps its size.
        lines: What holds them and becomes longer.
    """

    alike: Sequence[_Alike]
    rigid: Sequence[Solid]
    lines: Sequence[Solid]


def _shown(motion: SceneMotion) -> _Shown:
    held = list(solids(motion, _thickness(motion)))
    rigid = [each for each in held if each.rigid]
    return _Shown(_alike(motion), rigid, [each for each in held if not each.rigid])


def _thickness(motion: SceneMotion) -> float:
    """Thickness of the base as it is shown [m]."""
    return 0.06 * motion.tall


def _show(viewer: Any, motion: SceneMotion, shown: _Shown, sample: int, at: float) -> None:
    """Shows a sample of a lane, at a time of the viewer [s]."""
    import newton
    import warp as wp

    viewer.begin_frame(at)
    reach, thick = motion.reach, 0.5 * _thickness(motion)
    base, (low, high) = motion.base[sample], motion.span
    down = (3.0 if motion.ground is None else 5.0 + 2.0 * GAP) * thick
    still = np.array([0.0, 0.0, 0.0, 1.0])
    shapes = [
        (
            "base",
            (0.5 * (high - low), reach, thick),
            base + np.array([0.5 * (low + high), 0.0, -thick]),
            still,
            BASE_COLOUR,
        ),
        (
            "ground",
            (3.0 * reach, 3.0 * reach, 0.2 * thick),
            np.array([0.0, 0.0, -down - max(0.0, -float(motion.base[:, 2].min()))]),
            still,
            GROUND_COLOUR,
        ),
    ]
    for each in shown.rigid:
        name, half = each.name.replace(" ", "_"), tuple(0.5 * each.sizes[0])
        place, turn = each.places[sample], each.turns[sample]
        shapes.append((f"held_{name}", half, place, turn, _rgb(each.colour)))
    for name, scale, place, turn, colour in shapes:
        viewer.log_shapes(
            f"/{name}",
            newton.GeoType.BOX,
            tuple(float(part) for part in scale),
            wp.array([wp.transform(place, turn)], dtype=wp.transform),
            wp.array([wp.vec3(*colour)], dtype=wp.vec3),
        )
    for blocks, mesh in shown.alike:
        size = motion.sizes[blocks[0]] if mesh is None else np.full(3, 2.0)
        places = np.concatenate(
            [motion.position[blocks, sample], motion.attitude[blocks, sample]], axis=-1
        )
        colours = [_rgb(SERIES[block % len(SERIES)]) for block in blocks]
        viewer.log_shapes(
            f"/block_{blocks[0] + 1}",
            newton.GeoType.BOX if mesh is None else newton.GeoType.MESH,
            tuple(0.5 * float(part) for part in size),
            wp.array(places, dtype=wp.transform),
            wp.array(colours, dtype=wp.vec3),
            geo_src=mesh,
        )
    for each in shown.lines:
        start, end = (wp.array([wp.vec3(*place)], dtype=wp.vec3) for place in each.ends(sample))
        width = float(each.sizes[sample, 0])
        hidden = width <= GONE * float(each.sizes[:, 0].max())
        name = f"/held_{each.name.replace(' ', '_')}"
        viewer.log_lines(name, start, end, _rgb(each.colour), width=width, hidden=hidden)
    # Viewers take such names as paths: no blank, slash or bracket.
    viewer.log_scalar("time_s", float(motion.times[sample]))
    viewer.log_scalar("base_acceleration_m_per_s2", float(motion.acceleration[sample, 0]))
    if motion.fixed:
        viewer.log_scalar("largest_rotation_deg", float(np.abs(motion.ratio[:, sample]).max()))
    else:
        for block, ratio in enumerate(motion.ratio[:, sample]):
            viewer.log_scalar(f"rotation_ratio_{block + 1}", float(ratio))
    viewer.end_frame()


def _rgb(colour: str) -> tuple[float, float, float]:
    """A colour `#RRGGBB` as parts of one."""
    red, green, blue = (int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue
