"""Frames of a moving picture of one lane: its blocks, its base, the ground, and time.

The view stands still while the base stays within it; where the base drifts far, the view goes with
the base and the marks of the ground pass by.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.figures.held import HeldView
from warprock.figures.palette import DARK, FALLEN, GREY, PALE, SERIES
from warprock.figures.sheet import style
from warprock.figures.solid_view import SolidView
from warprock.model.hull import lower_hull
from warprock.model.tie_states import TieState
from warprock.model.words import ASSEMBLY, BLOCK
from warprock.running.scene_motion import SceneMotion
from warprock.running.scene_parts import TIE_WORDS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]
Frame = npt.NDArray[np.uint8]

SIZE = (7.2, 6.4)
"""Inches."""
DPI = 100
AZIMUTH, ELEVATION = np.deg2rad(-55.0), np.deg2rad(18.0)
"""From where blocks in space are seen: turned about the vertical, and from above."""
AXES = "xyz"
"""Axes of the places and accelerations of a base."""
FAR = 1.0
"""Drift of the base over the size of the scene from which the view goes with it."""
GAP = 1.2
"""Height between a support and the ground below it over that of their slabs."""
MOST_CURVES = 200
"""Blocks whose rotations are drawn over time: those that turn furthest."""
EDGE = 0.06
"""Width of the edges of an assembly's blocks over the median length of these, at most 1 point."""
FAINT = 0.3
"""Opacity of blocks that stay where they were when their model ended."""
FACES = np.array(
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
)
"""Corners of the faces of a block, as `SceneMotion.corners_in_space` numbers them, seen from
outside against the clock."""


def frames(motion: SceneMotion, samples: Sequence[int] | None = None) -> Iterator[Frame]:
    """One picture a sample, each [row, column, 3] of red, green and blue, 0 to 255.

    Args:
        motion: The lane.
        samples: Numbers of the samples; None is all.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=SIZE, dpi=DPI)
        canvas = FigureCanvasAgg(figure)
        grid = figure.add_gridspec(
            3, 1, height_ratios=(6.0, 1.0, 1.0), left=0.11, right=0.97, top=0.9, bottom=0.08
        )
        scene, turn, pull = (figure.add_subplot(grid[row]) for row in range(3))
        view = _View(scene, motion)
        lines = [_curves(turn, motion), _shaking(pull, motion)]
        figure.text(0.02, 0.965, motion.name, fontsize=11, fontweight="bold", va="center")
        said = figure.text(0.02, 0.925, "", fontsize=9.5, color=DARK, va="center")
        moving = [*view.artists, *lines, said]
        for artist in moving:
            artist.set_animated(True)
        # What stands still is drawn once.
        drawn: Any = canvas
        drawn.draw()
        background = drawn.copy_from_bbox(figure.bbox)
        for sample in range(len(motion.times)) if samples is None else samples:
            time = motion.times[sample]
            view.show(sample)
            for line in lines:
                line.set_xdata([time, time])
            said.set_text(_said(motion, sample))
            drawn.restore_region(background)
            for artist in sorted(moving, key=lambda each: each.get_zorder()):
                figure.draw_artist(artist)
            yield np.asarray(drawn.buffer_rgba())[..., :3].copy()


def _said(motion: SceneMotion, sample: int) -> str:
    """What stands above the scene at a sample."""
    parts = [f"time {motion.times[sample]:.2f} s"]
    outcome = motion.outcome
    if motion.fixed:
        outcome = outcome.replace(BLOCK.fallen, ASSEMBLY.fallen)
    if np.any(motion.acceleration) or np.any(motion.base):
        moved = ", ".join(
            f"{name} {round(1e3 * float(motion.base[sample, AXES.index(name)]), 1) + 0.0:.1f} mm"
            for name in motion.axes
        )
        parts.append(f"{'base' if motion.ground is None else 'support'} moved by {moved}")
    if motion.ground is not None:
        parts.append(f"ground by {1e3 * float(motion.ground[sample, 0]) + 0.0:.1f} mm")
    ties = [part.states[sample] for part in motion.parts if part.states is not None]
    if ties:
        said = ", ".join(TIE_WORDS[TieState(state)] for state in ties)
        parts.append(f"{'tie' if len(ties) == 1 else 'ties:'} {said}")
    if motion.end is not None and motion.times[sample] >= motion.end:
        what = f"{motion.outcome} at {motion.end:.2f} s; what follows is not modelled"
        if motion.fixed:
            what = f"{outcome}; followed until {motion.end:.2f} s"
        parts.append(what)
    elif sample == len(motion.times) - 1:
        parts.append(f"end: {outcome}")
    return "     ".join(parts)


def _curves(axes: Axes, motion: SceneMotion) -> Any:
    """Rotations over time; returns the line that marks the time."""
    from matplotlib.collections import LineCollection

    ratios = np.asarray(motion.ratio)[: len(motion.ratio) - motion.fixed]
    if len(ratios) > MOST_CURVES:
        far = np.argsort(np.nanmax(np.abs(ratios), axis=1), kind="stable")[-MOST_CURVES:]
        ratios = ratios[np.sort(far)]
    curves = np.stack([np.broadcast_to(motion.times, ratios.shape), ratios], axis=-1)
    axes.add_collection(LineCollection([*curves], colors=SERIES, linewidths=1.0))
    axes.autoscale_view()
    label = "rotations\n[deg]" if motion.fixed else "rotation /\nslenderness"
    axes.set_ylabel(label, fontsize=8)
    axes.set_xlim(motion.times[0], max(motion.times[-1], 1e-9))
    axes.tick_params(labelbottom=False, labelsize=8)
    return axes.axvline(0.0, color=FALLEN, linewidth=1.2)


def _shaking(axes: Axes, motion: SceneMotion) -> Any:
    """The acceleration of the base over time; returns the line that marks the time."""
    for name in motion.axes:
        axis = AXES.index(name)
        look = (DARK, GREY, PALE)[axis] if motion.spatial else (DARK, "", GREY)[axis]
        axes.plot(motion.times, motion.acceleration[:, axis], color=look, linewidth=1.0, label=name)
    if len(motion.axes) > 1 and np.any(motion.acceleration):
        axes.legend(loc="upper right", fontsize=7, ncols=3)
    axes.set_ylabel("base accel.\n[m/s²]", fontsize=8)
    axes.set_xlabel("time [s]", fontsize=8)
    axes.set_xlim(motion.times[0], max(motion.times[-1], 1e-9))
    axes.tick_params(labelsize=8)
    return axes.axvline(0.0, color=FALLEN, linewidth=1.2)


class _View:
    """The scene: what stands still is drawn once, what moves is put in place a sample."""

    def __init__(self, axes: Axes, motion: SceneMotion) -> None:
        """Draws the ground, and makes the base and the blocks."""
        from matplotlib.patches import Polygon

        self.axes, self.motion = axes, motion
        corners = motion.corners_in_space() if motion.spatial else motion.corners()
        self.reach = motion.reach
        self.slab = 0.06 * motion.tall
        # Corners as seen from the base, where the view goes with it.
        drift = float(np.ptp(motion.base, axis=0).max())
        self.follows = drift > FAR * 2.0 * self.reach
        self.off = motion.base if self.follows else np.zeros_like(motion.base)
        self.corners = corners - (
            self.off[None, :, None] if motion.spatial else self.off[None, :, None, [0, 2]]
        )
        self.base = motion.base - self.off
        self.ground_below = None if motion.ground is None else motion.ground - self.off
        self.depth = self.slab * (1.0 if motion.ground is None else 2.0 + GAP)
        pieces = len(FACES) if motion.spatial and motion.outline is None else 1
        self.ground: list[Any] = []
        self.slabs = [
            Polygon(np.zeros((4, 2)), facecolor=PALE, edgecolor=DARK, linewidth=0.8, zorder=order)
            for order in ((1.0,) if motion.ground is None else (1.0, 0.8))
        ]
        self.blocks: list[Any] = [
            Polygon(np.zeros((4, 2)), edgecolor="black", linewidth=1.0, alpha=1.0)
            for _ in range(0 if motion.fixed else pieces * len(motion.sizes))
        ]
        for patch in (*self.slabs, *self.blocks):
            axes.add_patch(patch)
        if motion.faces:
            self.blocks = [_solids(axes)]
        elif motion.fixed:
            self.blocks = [_assembled(axes, motion, self.corners)]
        self.marks = axes.plot([], [], color=GREY, linewidth=0.8, zorder=0.5)[0]
        self.pin = axes.plot([], [], color=FALLEN, linewidth=1.6, zorder=1.5)[0]
        self.links = axes.plot([], [], color=DARK, linewidth=2.0, zorder=0.9)[0]
        self.names = [axes.text(0.0, 0.0, "", fontsize=8, va="center", zorder=1.6) for _ in "12"]
        self.held = HeldView(axes, motion, self.off)
        self.artists = [self.marks, *self.slabs, *self.blocks, self.pin, self.links, *self.names]
        self.artists += self.held.artists
        axes.set_aspect("equal", adjustable="box")
        axes.set_xticks([])
        axes.set_yticks([])
        for side in axes.spines.values():
            side.set_visible(False)
        self._frame()
        if motion.fixed:
            across = float(np.ptp(axes.get_xlim()))
            points = 72.0 * SIZE[0] * axes.get_position().width
            length = float(np.median(motion.sizes[:, [0, 2]].max(axis=1)))
            self.blocks[0].set_linewidth(min(1.0, EDGE * length / across * points))

    def _seen(self, points: Array) -> Array:
        """Where points in space lie in the picture, to the right and up."""
        c, s = np.cos(AZIMUTH), np.sin(AZIMUTH)
        x, y, z = points[..., 0], points[..., 1], points[..., 2]
        across, away = -s * x + c * y, -(c * x + s * y)
        up = z * np.cos(ELEVATION) + away * np.sin(ELEVATION)
        return np.stack([across, up], axis=-1)

    def _depth(self, points: Array) -> Array:
        """How near to the reader points in space lie."""
        c, s = np.cos(AZIMUTH), np.sin(AZIMUTH)
        near = c * points[..., 0] + s * points[..., 1]
        return np.asarray(near * np.cos(ELEVATION) + points[..., 2] * np.sin(ELEVATION))

    def _slab(self, base: Array, below: float = 0.0) -> Array:
        """Outline of the base in the picture, or of the ground a height below it."""
        if not self.motion.spatial:
            left, right = self.motion.span
            high = self.motion.floor - below
            low = high - self.slab
            return np.array([(left, low), (right, low), (right, high), (left, high)]) + base[[0, 2]]
        flat = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)])
        level = np.array([0.0, 0.0, self.motion.floor - below])
        return self._seen(flat * self.reach + base + level)

    def _show_support(self, sample: int) -> None:
        """Puts the ground below a support in place, and what is between them."""
        if self.ground_below is None:
            return
        floor = self._slab(self.base[sample])
        ground = self._slab(self.ground_below[sample], self.depth - self.slab)
        self.slabs[1].set_xy(ground)
        if self.motion.spatial:
            feet, heads = ground, floor
        else:
            # From the upper side of the ground to the lower side of the support.
            left, right = 0.85, 0.15
            feet = np.stack([s * ground[3] + (1.0 - s) * ground[2] for s in (left, right)])
            heads = np.stack([s * floor[0] + (1.0 - s) * floor[1] for s in (left, right)])
            said = zip(self.names, (floor, ground), ("support", "ground"), strict=True)
            for name, slab, text in said:
                name.set_text(f"  {text}")
                name.set_position((slab[0, 0], 0.5 * (slab[0, 1] + slab[3, 1])))
        gaps = np.full_like(feet, np.nan)
        self.links.set_data(*np.stack([feet, heads, gaps], axis=1).reshape(-1, 2).T)

    def _frame(self) -> None:
        """Sets the limits so that nothing leaves the picture."""
        seen = self._seen(self.corners) if self.motion.spatial else self.corners
        slabs = [self._slab(self.base[k]) for k in _extremes(self.base)]
        if self.ground_below is not None:
            below = self.depth - self.slab
            moved = self.ground_below
            slabs += [self._slab(moved[k], below) for k in _extremes(moved)]
        ends = np.concatenate([seen.reshape(-1, 2), *slabs, self.held.ends])
        low, high = ends.min(axis=0), ends.max(axis=0)
        margin = 0.04 * float((high - low).max())
        self.axes.set_xlim(low[0] - margin, high[0] + margin)
        self.axes.set_ylim(low[1] - 3.0 * margin, high[1] + margin)

    def show(self, sample: int) -> None:
        """Puts everything where it is at a sample."""
        base, end = self.base[sample], self.motion.end
        faint = end is not None and self.motion.times[sample] >= end
        for patch in self.blocks:
            patch.set_alpha(FAINT if faint else 1.0)
        self.slabs[0].set_xy(self._slab(base))
        self._show_support(sample)
        self.held.show(sample)
        self._show_ground(sample)
        if self.motion.faces:
            self._show_solids(sample)
            return
        if self.motion.fixed:
            self.blocks[0].set_verts([*self.corners[:, sample]])
            return
        if not self.motion.spatial:
            for block, patch in enumerate(self.blocks):
                patch.set_xy(self.corners[block, sample])
                patch.set_facecolor(SERIES[block % len(SERIES)])
                patch.set_zorder(2)
            return
        if self.motion.outline is not None:
            self.blocks[0].set_xy(_hull(self._seen(self.corners[0, sample])))
            self.blocks[0].set_facecolor(SERIES[0])
            self.blocks[0].set_zorder(2.0)
            return
        for block in range(len(self.motion.sizes)):
            corners = self.corners[block, sample]
            for face, which in enumerate(FACES):
                points = corners[which]
                normal = np.cross(points[1] - points[0], points[2] - points[1])
                normal = normal / max(float(np.linalg.norm(normal)), 1e-12)
                near = float(self._depth(normal))
                patch = self.blocks[6 * block + face]
                patch.set_visible(near > 0.0)
                patch.set_xy(self._seen(points))
                patch.set_facecolor(_shaded(SERIES[block % len(SERIES)], 0.55 + 0.45 * near))
                patch.set_zorder(2.0 + 0.001 * float(self._depth(points.mean(axis=0))) + block)

    def _show_solids(self, sample: int) -> None:
        """Puts the blocks of an assembly in space in place, but for what lies below its ground."""
        motion, here = self.motion, self.corners[:, sample]
        level = float(self.base[sample, 2]) + motion.floor + 1e-6 * motion.tall
        moving = np.arange(len(here)) < len(here) - motion.fixed
        shown = np.flatnonzero(moving | (here[..., 2].max(axis=1) > level))
        colours = [SERIES[0] if moving[block] else PALE for block in shown]
        faces = [motion.faces[block] for block in shown]
        view = SolidView(AZIMUTH, ELEVATION)
        polygons, shades = view.faces(here[shown], faces, colours)
        self.blocks[0].set_verts(polygons)
        self.blocks[0].set_facecolor(shades)

    def _show_ground(self, sample: int) -> None:
        """Marks of the ground, every tenth or so of the picture, and how far the base has gone."""
        half = max(self.reach, *np.abs(self.motion.span))
        step = 10.0 ** np.floor(np.log10(half))
        off = self.off[sample]
        first = np.ceil((off[0] - 2.0 * half) / step)
        places = step * (first + np.arange(int(4.0 * half / step) + 1)) - off[0]
        base, down = self.base[sample], self.slab
        if not self.motion.spatial:
            level = min(self.motion.floor, 0.0) - self.depth - 0.6 * down
            xs = np.column_stack([places, places, np.full(len(places), np.nan)]).ravel()
            zs = np.tile([level, level - 0.6 * down, np.nan], len(places))
            ends = self.axes.get_xlim()
            self.marks.set_data(
                np.concatenate([[*ends, np.nan], xs]), np.concatenate([[level, level, np.nan], zs])
            )
            self.pin.set_data([base[0], base[0]], [base[2] + self.motion.floor, level])
            return
        far = np.stack([np.full_like(places, -self.reach), np.full_like(places, self.reach)])
        deep = np.full_like(far, self.motion.floor - self.depth)
        lines = self._seen(np.stack([np.tile(places, (2, 1)), far, deep], axis=-1))
        gaps = np.full((1, len(places), 2), np.nan)
        drawn = np.concatenate([lines, gaps]).transpose(1, 0, 2).reshape(-1, 2)
        self.marks.set_data(drawn[:, 0], drawn[:, 1])
        origin = self._seen(np.stack([-off, base]))
        self.pin.set_data(origin[:, 0], origin[:, 1])


def _assembled(axes: Axes, motion: SceneMotion, corners: Array) -> Any:
    """The blocks of an assembly, thousands of them, as one; those that can move have one colour."""
    from matplotlib.collections import PolyCollection

    colours = [SERIES[0]] * (len(corners) - motion.fixed) + [PALE] * motion.fixed
    blocks = PolyCollection([*corners[:, 0]], facecolors=colours, edgecolors="black", zorder=2.0)
    return axes.add_collection(blocks, autolim=False)


def _solids(axes: Axes) -> Any:
    """The faces of the blocks of an assembly in space, put in place a sample."""
    from matplotlib.collections import PolyCollection

    blocks = PolyCollection([], edgecolors="black", zorder=2.0)
    return axes.add_collection(blocks, autolim=False)


def _hull(points: Array) -> Array:
    """The points of a picture that all others lie between, going round: the convex hull."""
    return np.concatenate([lower_hull(points), -lower_hull(-points)])


def _extremes(base: Array) -> list[int]:
    """Samples at which the base is farthest along each axis."""
    return sorted({int(k) for axis in base.T for k in (axis.argmin(), axis.argmax())})


def _shaded(colour: str, light: float) -> tuple[float, float, float]:
    """A colour in less light."""
    from matplotlib.colors import to_rgb

    red, green, blue = to_rgb(colour)
    return red * light, green * light, blue * light
