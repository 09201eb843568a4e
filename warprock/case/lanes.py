"""From a case to its lanes: blocks, starts, ground motions and the table of inputs.

Lane i is a pure function of the case and i: its digits in mixed radix over the sweep's axes pick
one value of each. All work is done on whole arrays; what can be wrong with one value alone was
refused when the case was read, and what can be wrong with a combination is refused here.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from warprock.arguments import at_the_door
from warprock.case.assembly_lanes import assembly_columns, assembly_lanes
from warprock.case.axes import LABEL
from warprock.case.body_lanes import body_columns, body_lanes, body_of
from warprock.case.case import Case
from warprock.case.check import PeaksCheck
from warprock.case.columns import Columns
from warprock.case.ensemble import CELL_COLUMNS
from warprock.case.ground_motions import lane_motions
from warprock.case.hold_lanes import held, refuse_elsewhere
from warprock.case.input_columns import computed, key_column, lane_columns
from warprock.case.keys import general_key
from warprock.case.release import release_blocks, release_columns
from warprock.case.round_base import refuse_in_space, round_keys
from warprock.case.run import DURATION
from warprock.case.space import optional, spatial_because, spatial_columns, spatial_lanes
from warprock.case.stacks import stack_columns, stack_lanes
from warprock.case.values import LaneValues
from warprock.errors import InputError, Said
from warprock.model import rocking
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import GroundMotions
from warprock.model.response import FIELDS, SampleTimes
from warprock.model.scene import SceneKind, scene_kind
from warprock.model.undecided import UNDECIDED

if TYPE_CHECKING:
    import pandas as pd

Array = npt.NDArray[np.float64]

_KEYS = (
    *(f"block.{name}" for name in ("width", "height", "depth", "density")),
    *(f"contact.{name}" for name in ("friction", "angular_restitution")),
)
"""Keys of a single block in the order of their columns; what follows from them comes behind."""

MOST_BLOCKS_AT_ONCE = 5_000_000
"""Blocks of all lanes of a case together that are held in memory at once."""
BYTES_OF_A_BLOCK = 1000
"""Memory that a run takes for each, measured over a million lanes, the table it writes included."""
LANES_A_SECOND = 5000.0
"""Lanes of 20 s of a record that `event` runs in a second on two cores."""


@dataclasses.dataclass(frozen=True)
class LaneSet:
    """A case as lanes.

    Attributes:
        lanes: Blocks and starts, shape [lane].
        motions: Ground motions of the same lanes.
        longest: Length of the longest run and sampling of its histories.
        scene: What the case requires of an engine.
        table: Inputs, one row a lane: labels, then physical inputs with their units in the column
            names.
        labels: Names of the label columns.
        shape: Lengths of the case's axes, first one slowest.
        members: Lanes in a cell of the sweep, 1 without an ensemble; cells are slower.
        cell_table: Inputs of every cell without their spread; None without an ensemble, or where
            only some lanes were asked for.
        step_factors: Factor on the engine's time step, shape [lane]; None is 1 for all.
        first: Number of the first lane, where only some were asked for.
        durations: Length of every lane's run [s], shape [lane]; None where all are the longest.
        ground: Motions of the ground below the supports of the lanes; None without supports, where
            `motions` are those of the ground.

    Example:
        >>> import warprock as wr
        >>> lanes = wr.expand_lanes(wr.load_case("free-b1-b3"))
        >>> lanes.shape, lanes.select({"block": "B2"}).tolist()
        ((3, 3), [3, 4, 5])
    """

    lanes: Lanes
    motions: GroundMotions
    longest: SampleTimes
    scene: SceneKind
    table: Columns
    labels: tuple[str, ...]
    shape: tuple[int, ...]
    members: int = 1
    cell_table: Columns | None = None
    step_factors: Array | None = None
    first: int = 0
    durations: Array | None = None
    ground: GroundMotions | None = None

    @property
    def inputs(self) -> pd.DataFrame:
        """The table of inputs as a DataFrame."""
        return self.table.frame

    @property
    def cells(self) -> pd.DataFrame | None:
        """Inputs of every cell without their spread as a DataFrame, where there are any."""
        return None if self.cell_table is None else self.cell_table.frame

    @property
    def times(self) -> SampleTimes:
        """Length of the run and sampling of its histories, the same for all lanes.

        Raises:
            InputError: They differ, so whoever asks cannot run these lanes together.
        """
        if self.durations is not None:
            got = Said(self.duration_text)
            raise InputError("run_lanes", DURATION, got, "must be the same for all lanes here")
        return self.longest

    @property
    def ends(self) -> Array | float:
        """When lanes end [s]: shape [lane], or one time for all."""
        return self.longest.duration if self.durations is None else self.durations

    @property
    def duration_text(self) -> str:
        """Length of the runs in words."""
        least, most = np.min(self.ends), np.max(self.ends)
        return f"{most:g} s" if least == most else f"{least:g} s to {most:g} s"

    def take(self, chosen: npt.NDArray[np.intp]) -> LaneSet:
        """Some lanes, in any order and as often as they are named; `first` stays what it was.

        Args:
            chosen: Places of the lanes in this set, from 0.
        """
        steps, durations = self.step_factors, self.durations
        return dataclasses.replace(
            self,
            lanes=self.lanes.take(chosen),
            motions=self.motions.take(chosen),
            table=self.table.take(chosen),
            step_factors=None if steps is None else steps[chosen],
            durations=None if durations is None else durations[chosen],
            ground=None if self.ground is None else self.ground.take(chosen),
        )

    def alone(self, lane: int) -> LaneSet:
        """One lane, by its place from 0, with its number."""
        return dataclasses.replace(self.take(np.array([lane])), first=self.first + lane)

    @at_the_door
    def select(self, where: Mapping[str, str]) -> npt.NDArray[np.intp]:
        """Lanes with certain labels, in lane order.

        Args:
            where: Label -> value; empty selects every lane.

        Raises:
            InputError: No such label, or no lane has that value.
        """
        chosen = np.ones(self.lanes.lane_count, dtype=bool)
        for label, value in where.items():
            if label not in self.labels:
                known = ", ".join(self.labels) or "none"
                raise InputError("where", label, value, f"must be a label of the case ({known})")
            chosen &= self.table.among(label, [value])
            if not chosen.any():
                raise InputError("where", label, value, "must select at least one lane")
        return np.flatnonzero(chosen)


@at_the_door
def expand_lanes(case: Case, lanes: range | None = None) -> LaneSet:
    """The lanes of a case, their motions and sampling, the kind of scene and the table of inputs.

    Args:
        case: The case.
        lanes: Numbers of the lanes wanted; None is all of them.

    Raises:
        InputError: A combination of values that no engine could use.

    Example:
        >>> import warprock as wr
        >>> wr.expand_lanes(wr.load_case("free-b0")).lanes.height.tolist()
        [5.0, 5.5]
    """
    _require_lanes(case, lanes)
    values = LaneValues(case, range(case.lane_count) if lanes is None else lanes)
    durations = _durations(values)
    if not values.lanes:
        raise InputError(case.file, "sweep", Said("0 lanes"), "must make at least 1 lane")
    why = spatial_because(values)
    if why:
        refuse_in_space(values, why)
    blocks, (motions, ground), columns = _scene(values, in_space=bool(why))
    scene = scene_kind(
        blocks,
        motions,
        restitution_given=values.given("contact.angular_restitution"),
        spatial_because=why,
    )
    step_factors, cells = None, None
    if case.ensemble is not None:
        step_factors = case.ensemble.step_factors(values.members)
        columns |= {"member": values.members}
        if step_factors is not None:
            columns |= {"time_step_factor": step_factors}
        if lanes is None:
            firsts = LaneValues(case, range(0, case.lane_count, case.members), spread=False)
            cells = Columns(firsts.labels() | _scene(firsts, in_space=bool(why))[2])
    _refuse_labels(case, columns)
    lane_set = LaneSet(
        lanes=blocks,
        motions=motions,
        longest=dataclasses.replace(case.sample_times, duration=float(durations.max())),
        scene=scene,
        table=Columns(values.labels() | columns),
        labels=case.labels,
        shape=case.shape,
        members=case.members,
        cell_table=cells,
        step_factors=step_factors,
        first=values.lanes.start,
        durations=durations if durations.min() < durations.max() else None,
        ground=ground,
    )
    if lanes is None and not case.overridden:
        _refuse_checks(case, lane_set)
    return lane_set


def _durations(values: LaneValues) -> Array:
    """Length of every lane's run [s], shape [lane]; each has a sample besides the first."""
    durations, interval = values.numbers(DURATION), values.case.sample_times.interval
    if interval is not None:
        allowed = f"must be at least run.sample_interval, {interval:g} s"
        values.refuse(durations < interval, DURATION, allowed)
    return durations


def _require_lanes(case: Case, lanes: range | None) -> None:
    """Refuses lanes that the case does not have, and all of a case that are too many."""
    if lanes is None:
        require_room_for_lanes(case)
    elif lanes and not 0 <= min(lanes) <= max(lanes) < case.lane_count:
        raise InputError("lanes", "", lanes, f"must lie in 0 to {case.lane_count - 1}")


def require_room_for_lanes(case: Case) -> None:
    """Refuses more lanes than are held in memory at once.

    Raises:
        InputError: There are more.
    """
    count, blocks = case.lane_count, case.tables.block_count
    if count * blocks <= MOST_BLOCKS_AT_ONCE:
        return
    of_blocks = "" if blocks == 1 else f" of {blocks} blocks"
    need, hours = BYTES_OF_A_BLOCK * blocks * count / 1e9, count / LANES_A_SECOND / 3600.0
    allowed = (
        f"must make at most {MOST_BLOCKS_AT_ONCE // blocks:,} lanes{of_blocks} in one run, which "
        f"holds them all in memory (these: some {need:,.0f} GB, {hours:,.1f} h): warprock sweep "
        "plan runs any number in chunks"
    )
    raise InputError(case.file, "sweep", Said(f"{count:,} lanes"), allowed)


def _scene(
    values: LaneValues, *, in_space: bool
) -> tuple[Lanes, tuple[GroundMotions, GroundMotions | None], dict[str, object]]:
    """Blocks, motions of bases and of the ground below supports, and columns of the input table."""
    stacked = values.case.tables.stacked
    body = body_of(values)
    assembly = values.case.tables.assembly is not None
    beyond = (
        assembly and "is an assembly ([assembly])",
        in_space and not assembly and "has blocks in space",
        stacked and "has a stack",
        body is not None and "has a body (block.base)",
        values.case.tables.constant("motion.z") and "moves its base upwards (motion.z)",
    )
    for place in filter(None, beyond):
        refuse_elsewhere(values, str(place))
    if assembly:
        blocks = assembly_lanes(values, in_space=in_space)
        motions, ground, more = lane_motions(values, blocks)
        columns = assembly_columns(values, blocks) | more | _own_duration(values)
        return blocks, (motions, ground), columns
    if body is not None:
        blocks = body_lanes(values, body, in_space=in_space)
    else:
        blocks = (
            stack_lanes(values, in_space=in_space)
            if stacked
            else _blocks(values, in_space=in_space)
        )
    if in_space:
        blocks = spatial_lanes(values, blocks)
    if body is not None:
        columns = body_columns(values, body, blocks)
    else:
        columns = stack_columns(values, blocks) if stacked else _block_columns(blocks)
    for number, key in round_keys(values).items():
        columns |= key_column(general_key(key), values.numbers(key), number)
    if isinstance(blocks, SpatialLanes):
        columns |= spatial_columns(blocks)
    if not blocks.stacked:
        blocks = release_blocks(values, blocks)
        columns |= release_columns(values)
        blocks, of_hold = held(values, blocks)
        columns |= of_hold
    motions, ground, more = lane_motions(values, blocks)
    return blocks, (motions, ground), columns | more | _own_duration(values)


def _own_duration(values: LaneValues) -> dict[str, Array]:
    """The column of the duration, where lanes differ by it."""
    return key_column(DURATION, values.numbers(DURATION)) if values.swept(DURATION) else {}


def _blocks(values: LaneValues, *, in_space: bool) -> Lanes:
    """Blocks and their starts."""
    width, height = values.numbers("block.width"), values.numbers("block.height")
    angle = np.arctan2(width, height)
    rotation_start = np.zeros_like(width)
    if values.given("start.rotation_ratio"):
        aside = optional(values, "block.centre_offset_x") if in_space else 0.0
        nearer = np.arctan2(width - 2.0 * np.abs(aside), height)
        rotation_start = nearer * values.numbers("start.rotation_ratio")
    elif values.given("start.rotation"):
        rotation_start = values.numbers("start.rotation")
        # A strip of wall has another balance, which is judged where it is known.
        in_one_piece = values.case.tables.strip is None
        beyond = (np.abs(rotation_start) >= angle) & (not in_space) & in_one_piece
        if beyond.any():
            limit = np.rad2deg(angle[int(np.argmax(beyond))])
            allowed = f"must be less than the block's slenderness angle, {limit:.6g} deg"
            values.refuse(beyond, "start.rotation", allowed)
    if values.given("contact.angular_restitution"):
        restitution = values.numbers("contact.angular_restitution")
    else:
        restitution = rocking.angular_restitution(angle)
    return Lanes(
        width=width,
        height=height,
        depth=values.numbers("block.depth"),
        density=values.numbers("block.density"),
        friction=values.numbers("contact.friction"),
        chamfer=np.zeros_like(width),
        offset=np.zeros_like(width),
        rotation_start=rotation_start,
        angular_restitution=restitution,
        restitution_given=values.given("contact.angular_restitution"),
    )


def _block_columns(lanes: Lanes) -> dict[str, object]:
    angle, size = lanes.slenderness_angle, (lanes.width, lanes.height)
    columns: dict[str, object] = {**lane_columns(_KEYS, lanes)}
    columns |= computed("slenderness_angle", angle)
    columns |= computed("half_diagonal", rocking.half_diagonal(*size))
    columns |= computed("frequency_parameter", rocking.frequency_parameter(*size))
    columns |= lane_columns(["start.rotation"], lanes)
    return columns | key_column("start.rotation_ratio", lanes.rotation_start / angle)


def _refuse_labels(case: Case, columns: Mapping[str, object]) -> None:
    """Refuses a label that would hide an input or a result in the lane table."""
    results = (FIELDS.keys() | {field.column for field in FIELDS.values()}) | {
        field.block_column(block)
        for field in FIELDS.values()
        for block in range(1, case.tables.block_count + 1)
    }
    for label in case.labels:
        if label in {"lane", UNDECIDED, *CELL_COLUMNS, *columns} | results:
            allowed = "must not be the name of an input or of a result"
            raise InputError(case.file, f"sweep.{LABEL}{label}", label, allowed)


def _refuse_checks(case: Case, lane_set: LaneSet) -> None:
    """Refuses a check that has another number of values than lanes to compare them with."""
    for number, check in enumerate(case.checks):
        if isinstance(check, PeaksCheck):
            count = len(lane_set.select(check.where))
            if len(check.values) != count:
                got = "1 value" if len(check.values) == 1 else f"{len(check.values)} values"
                raise InputError(
                    case.file,
                    f"check[{number}].values",
                    Said(got),
                    f"must be {count}, one for each lane selected",
                )
