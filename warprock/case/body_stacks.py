"""Bodies in stacks from the values of a case: what they are, lane by lane, and their columns."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from warprock.case.block import Stack
from warprock.case.body import StackedBody
from warprock.case.body_lanes import DIRECTION, SIDES, seen_in_plane
from warprock.case.input_columns import computed, key_column, lane_columns
from warprock.case.values import LaneValues
from warprock.errors import InputError, Said
from warprock.model.bodies import Bodies
from warprock.model.lanes import Lanes
from warprock.model.profiles import Profiles
from warprock.model.stacking import box_profiles

Array = npt.NDArray[np.float64]

_BOX = tuple(f"block.N.{name}" for name in ("width", "height", "depth"))
_PLACE = tuple(f"block.N.{name}" for name in ("offset", "friction", "rotation"))


def stacked_tables(values: LaneValues) -> dict[int, StackedBody]:
    """The tables of the bodies among a stack's blocks, by number; none of single blocks."""
    stack = values.case.tables.block
    blocks = stack.numbered.items() if isinstance(stack, Stack) else ()
    return {int(number): block for number, block in blocks if isinstance(block, StackedBody)}


def stacked_bodies(values: LaneValues, *, in_space: bool) -> dict[int, Bodies]:
    """The bodies among the blocks, by number.

    Raises:
        InputError: The blocks are to move in space.
    """
    found = {}
    for number, table in stacked_tables(values).items():
        key = f"block.{number}"
        if in_space:
            of = 'without model = "planar"' if table.spatial else "in a stack in space"
            said = "points [x, y, z]" if table.spatial else "points [x, z]"
            allowed = f"must not be given {of}: stacks in space are of boxes alone"
            source = values.case.source_of(f"{key}.base")
            raise InputError(source, f"{key}.base", Said(said), allowed)
        mass = values.numbers(f"{key}.mass")
        points, count, inertia = seen_in_plane(values, table)
        points[..., 0] *= values.numbers(f"{key}.base_scale")[:, None]
        found[number] = Bodies(
            mass=mass,
            gyration=inertia / mass,
            points=points,
            count=count,
            corner_radius=np.zeros_like(mass),
            axes=np.tile((0.0, 0.0, 0.0, 1.0), (len(mass), 1)),
        )
    return found


def stacked_body_sizes(values: LaneValues, number: int, body: Bodies) -> dict[str, Array]:
    """Width, height and depth of the box around a body, up to its top, and density; [lane]."""
    table, key = stacked_tables(values)[number], f"block.{number}.height"
    width = np.ptp(body.points[..., 0], axis=1)
    height = 2.0 * body.centre_height
    if table.top is not None:
        height = body.centre_height + _top(table)[2]
    elif values.given(key):
        height = values.numbers(key)
    depth = np.ones_like(width)
    density = body.mass / (width * height * depth)
    return {"width": width, "height": height, "depth": depth, "density": density}


def _top(table: StackedBody) -> Array:
    """Where the top of a body begins and ends, and how high it is, from the centre of mass [m]."""
    (left, level), (right, _) = table.top
    x, z = table.centre
    return np.array([left - x, right - x, level - z])


def profiles_of(values: LaneValues, lanes: Lanes, bodies: Mapping[int, Bodies]) -> Profiles:
    """What the blocks of stacks are, boxes among them."""
    boxes, tables = box_profiles(lanes), stacked_tables(values)
    most = max(2, *(body.most_points for body in bodies.values()))
    shape = (*lanes.width.shape, most, 2)
    rows = np.minimum(np.arange(most), 1)
    points, count = boxes.points[:, :, rows], boxes.count.copy()
    mass, gyration, top = boxes.mass.copy(), boxes.gyration.copy(), boxes.top.copy()
    assert points.shape == shape
    for number, body in bodies.items():
        at = number - 1
        points[:, at] = body.points[:, np.minimum(np.arange(most), body.most_points - 1)]
        count[:, at], mass[:, at], gyration[:, at] = body.count, body.mass, body.gyration
        top[:, at, :2] = body.points[:, [0, -1], 0]
        top[:, at, 2] = lanes.height[:, at] - body.centre_height
        if tables[number].top is not None:
            top[:, at] = _top(tables[number])
    is_body = tuple(number in bodies for number in range(1, lanes.block_count + 1))
    return Profiles(mass, gyration, points, count, top, is_body)


def stacked_body_columns(values: LaneValues, lanes: Lanes, block: int) -> dict[str, object]:
    """Input columns of a body in a stack, by the place of its block from 0."""
    profiles, number = lanes.profiles, f"_{block + 1}"
    assert profiles is not None
    columns: dict[str, object] = {**key_column("block.N.mass", profiles.mass[:, block], number)}
    key = f"block.{block + 1}.base_scale"
    # Whatever an ensemble or a sweep moves is given in the table of its first lane, too.
    table = stacked_tables(values)[block + 1]
    if "base_scale" in table.model_fields_set:
        columns |= key_column("block.N.base_scale", values.numbers(key), number)
    columns |= lane_columns(_BOX, lanes, block)
    columns |= computed("slenderness_angle", lanes.slenderness_angle[:, block], number)
    for side, angle in zip(SIDES, profiles.slenderness_angles[:, block].T, strict=True):
        columns |= computed(f"slenderness_angle_{side}", angle, number)
    if table.spatial and values.given(DIRECTION):
        columns |= key_column(DIRECTION, values.numbers(DIRECTION))
    return columns | lane_columns(_PLACE, lanes, block)
