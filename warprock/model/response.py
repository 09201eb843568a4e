"""What an engine answers: every field declared once, with its dimensions, unit and meaning.

The registry drives allocation, the columns of the lane table, axis labels and docs. Arrays are
lane first. A time that never came (a block that never lifted) is NaN, never zero.
"""

from __future__ import annotations

import dataclasses
import enum
import numbers
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.errors import InputError
from warprock.units import ending


class Outcome(enum.IntEnum):
    """Where a lane's blocks are when its run ends.

    A stack is at rest when all of its blocks are; it has overturned once one block has, and slid
    off once a block has left the face of the one below. An assembly has overturned, that is
    collapsed, once one block has: it has turned by a right angle, or its centre has sunk by half of
    its longest joint. It has slid off, which is a collapse, too, once a block has slid along
    another or the ground by more than its longest joint. ROCKING is all that still moves: a block
    that slides without leaving its base, too.

    Example:
        >>> import warprock as wr
        >>> [outcome.name for outcome in wr.Outcome]
        ['AT_REST', 'ROCKING', 'OVERTURNED', 'SLID_OFF']
    """

    AT_REST = 0
    ROCKING = 1
    OVERTURNED = 2
    SLID_OFF = 3


class Status(enum.IntEnum):
    """Whether a lane's numbers may be used.

    Attributes:
        OK: Nothing speaks against them.
        EVENT_LIMIT: The lane took more steps than any motion needs; its run ended there.
        NONFINITE: A number is infinite or NaN.
        ITERATION_LIMIT: A contact solve did not settle; the run of the lane ended there.
        SENSITIVE: The numbers depend on the step: chaos, or close to overturning. No engine says
            so; `warprock.running.tolerance` does, which runs the lane at finer steps.
        OUTSIDE_MODEL: Something happened that the engine leaves out: a contact had to pull, or a
            block would have slid. The numbers are what the engine's equations give.
        UNSTABLE: The lane gained more energy than it held and its base supplied: its step is too
            long, its sweeps are too few, or float32 is too coarse.
        AMBIGUOUS: A block slid, and its friction is above the limit up to which the contact law has
            one solution (`warprock.model.painleve`). Another engine may find another answer.

    Example:
        >>> import warprock as wr
        >>> wr.Status(0)
        <Status.OK: 0>
    """

    OK = 0
    EVENT_LIMIT = 1
    NONFINITE = 2
    ITERATION_LIMIT = 3
    SENSITIVE = 4
    OUTSIDE_MODEL = 5
    UNSTABLE = 6
    AMBIGUOUS = 7


SOUND: tuple[Status, ...] = (Status.OK, Status.AMBIGUOUS)
"""Statuses of lanes whose run is as good as its engine: nothing speaks against its step."""
USABLE: tuple[Status, ...] = (*SOUND, Status.SENSITIVE, Status.OUTSIDE_MODEL)
"""Statuses whose numbers are the engine's answer, if with a reservation; the others have none."""
FALLEN: tuple[Outcome, ...] = (Outcome.OVERTURNED, Outcome.SLID_OFF)
"""Outcomes of a lane that fell: a block that slid off what it stood on has fallen, too."""


def names_of(kind: type[enum.IntEnum], codes: Iterable[int]) -> list[str]:
    """Codes as tables write them.

    >>> names_of(Outcome, [0, 3])
    ['at_rest', 'slid_off']

    Args:
        kind: `Status` or `Outcome`.
        codes: The codes.
    """
    return [kind(int(code)).name.lower() for code in codes]


SOUND_NAMES, USABLE_NAMES = names_of(Status, SOUND), names_of(Status, USABLE)
FALLEN_NAMES = names_of(Outcome, FALLEN)
"""`SOUND`, `USABLE` and `FALLEN` as tables write them."""


class JointState(enum.IntFlag):
    """What a joint of an assembly did in a run."""

    OPENED = 1
    SLID = 2
    BROKEN = 4


@dataclasses.dataclass(frozen=True)
class Field:
    """One array of a response.

    Attributes:
        name: Key in `Response.fields`; with the unit appended it is the column of the lane table.
        dims: Dimensions, lane first.
        unit: SI unit, "-" for a count, a code or a ratio.
        text: Meaning, as printed on axes and in docs.
        enum: Codes of the field, where it holds codes.
        per_block: Whether the lanes of stacks have a value for every block: there the dimension
            "block", lowest first, comes after "lane".
        spatial: Whether only blocks in space have it.
    """

    name: str
    dims: tuple[str, ...]
    unit: str
    text: str
    enum: type[enum.IntEnum] | None = None
    per_block: bool = False
    spatial: bool = False

    @property
    def column(self) -> str:
        """Column name with the unit in it, such as `peak_rotation_rad`."""
        return self.name + self._suffix

    def block_column(self, block: int) -> str:
        """Column name of one block of a stack, such as `peak_rotation_2_rad`; the lowest is 1."""
        return f"{self.name}_{block}{self._suffix}"

    @property
    def _suffix(self) -> str:
        return ending(self.unit)

    @property
    def label(self) -> str:
        """Axis label, such as `Peak rotation [rad]`."""
        return self.text if self.unit == "-" else f"{self.text} [{self.unit}]"


def _in_space(name: str, unit: str, text: str, *dims: str) -> Field:
    """A field that only blocks in space have."""
    return Field(name, ("lane", *dims), unit, text, per_block=True, spatial=True)


FIELDS: dict[str, Field] = {
    field.name: field
    for field in (
        Field("peak_rotation", ("lane",), "rad", "Largest rotation to either side", per_block=True),
        Field("peak_time", ("lane",), "s", "Time of the largest rotation", per_block=True),
        Field("outcome", ("lane",), "-", "Where the block is at the end", Outcome),
        Field("status", ("lane",), "-", "Whether the lane's numbers may be used", Status),
        Field("impact_count", ("lane",), "-", "Landings of ends that had parted"),
        Field("uplift_time", ("lane",), "s", "Time at which the block first leaves its flat state"),
        Field("rest_time", ("lane",), "s", "Time from which the block neither rocks nor slides"),
        Field(
            "residual_slide",
            ("lane",),
            "m",
            "Slide along what the block stands on, at the end",
            per_block=True,
        ),
        Field(
            "peak_slide",
            ("lane",),
            "m",
            "Largest slide along what the block stands on",
            per_block=True,
        ),
        Field(
            "peak_penetration",
            ("lane",),
            "m",
            "Deepest penetration of a corner into what it stands on",
        ),
        Field(
            "energy_lost",
            ("lane",),
            "J",
            "Energy lost in impacts and friction, and to ties",
        ),
        Field("step_count", ("lane",), "-", "Time steps taken"),
        Field(
            "friction_needed",
            ("lane",),
            "-",
            "Friction without which the block would slide; infinite where its base would have to "
            "pull",
        ),
        Field("peak_tie_force", ("lane",), "N", "Largest force of a tie"),
        Field(
            "peak_tie_elongation",
            ("lane",),
            "m",
            "Largest elongation of a tie from the state in which the block rests",
        ),
        Field("broken_ties", ("lane",), "-", "Ties that broke"),
        Field("tie_break_time", ("lane",), "s", "Time at which the first of them broke"),
        Field(
            "peak_displacement", ("lane",), "m", "Largest displacement of a block of an assembly"
        ),
        Field(
            "residual_displacement", ("lane",), "m", "Largest displacement of a block at the end"
        ),
        Field("peak_opening", ("lane",), "m", "Widest gap of a joint between the ends it shares"),
        Field("opened_joints", ("lane",), "-", "Joints that opened"),
        Field("slid_joints", ("lane",), "-", "Joints that slid"),
        Field("broken_joints", ("lane",), "-", "Bonded joints that broke"),
        Field("joint_break_time", ("lane",), "s", "Time at which the first of them broke"),
        Field(
            "collapse_time",
            ("lane",),
            "s",
            "Time at which a block of an assembly had fallen or slid off",
        ),
        Field(
            "collapse_load",
            ("lane",),
            "-",
            "Acceleration of the base / g when the motion began that ended in collapse",
        ),
        Field("joint_state", ("lane", "joint"), "-", "What a joint did, a `JointState`"),
        Field(
            "solver_residual",
            ("lane",),
            "m/s",
            "The most that the contact solver left of a velocity in a step",
        ),
        Field(
            "tie_energy_lost",
            ("lane",),
            "J",
            "Energy that ties took by yielding and breaking, a part of the energy lost",
        ),
        Field("peak_rotation_left", ("lane",), "rad", "Largest rotation of a body towards -x"),
        Field("peak_rotation_right", ("lane",), "rad", "Largest rotation of a body towards +x"),
        Field(
            "peak_rotation_error",
            ("lane",),
            "rad",
            "Estimated error of the largest rotation",
            per_block=True,
        ),
        Field(
            "rotation_error",
            ("lane",),
            "rad",
            "Estimated largest error of the rotation over the run",
            per_block=True,
        ),
        Field(
            "peak_slide_error",
            ("lane",),
            "m",
            "Estimated error of the slide, the largest and the one at the end",
            per_block=True,
        ),
        Field(
            "uplift_time_error",
            ("lane",),
            "s",
            "Estimated error of the time at which the block first leaves its flat state",
        ),
        Field("time_step", ("lane",), "s", "Setting of the time step that the numbers are from"),
        Field("first_step_count", ("lane",), "-", "Time steps of one run at the step asked for"),
        Field("total_step_count", ("lane",), "-", "Time steps of all runs of the lane"),
        Field("rotation", ("lane", "sample"), "rad", "Rotation", per_block=True),
        Field(
            "turn", ("lane", "sample"), "rad", "Rotation of a block of an assembly", per_block=True
        ),
        Field(
            "slide",
            ("lane", "sample"),
            "m",
            "Slide along what the block stands on",
            per_block=True,
        ),
        Field(
            "x",
            ("lane", "sample"),
            "m",
            "Centre of the block along x, from where the lowest block stood on its base",
            per_block=True,
        ),
        Field(
            "z",
            ("lane", "sample"),
            "m",
            "Height of the centre of the block above the base",
            per_block=True,
        ),
        _in_space("peak_tilt", "rad", "Largest angle between the block's axis and the vertical"),
        _in_space("peak_rotation_across", "rad", "Largest rotation across the plane of rocking"),
        _in_space("peak_yaw", "rad", "Largest turn about the vertical since the start"),
        _in_space("residual_yaw", "rad", "Turn about the vertical since the start, at the end"),
        _in_space("residual_slide_across", "m", "Slide across the plane of rocking, at the end"),
        _in_space("rotation_across", "rad", "Rotation across the plane of rocking", "sample"),
        _in_space("yaw", "rad", "Turn about the vertical", "sample"),
        _in_space("slide_across", "m", "Slide across the plane of rocking", "sample"),
        _in_space("y", "m", "Centre of the block along y, as x", "sample"),
        *(
            _in_space(f"attitude_{part}", "-", f"Quaternion of the attitude, {part}", "sample")
            for part in "xyzw"
        ),
    )
}
"""Every field by name.

In space the rotation is that of the block's axis in the plane of rocking, atan2(x, z) of the axis
(x, y, z), the rotation across atan2(y, z), each until the block falls: from z = 1/2 on, a lean of
60 degrees, both go over to the angles of an axis that lies on the ground, atan2(x, |y|) and
atan2(y, |x|). A block that fell along x has a rotation of 90 degrees and none across, one that
fell across has the opposite, one that fell over a corner in the direction (cos a, sin a) has
90 degrees - a and a (see `pose.rotations`). Peaks are the largest of these over the run, the fall
included; a lane's run ends with its fall, and its histories stay where they are then.

The yaw is the twist of the attitude about the vertical; the slide is that of the corner which
touches, from where it stood at the start: `residual_slide` along x, `residual_slide_across` along
y, `peak_slide` the length of both.

Histories of places (`x`, `y`, `z`: of the middle of the block's box; `slide`, `attitude_x` to
`attitude_w`) are seen from the base, which moves: x is along the base, in the plane of rocking, y
across it, z upwards. The slide is that of the lowest corner, one in the air too.
"""

ERROR_FIELDS: tuple[str, ...] = (
    "peak_rotation_error",
    "rotation_error",
    "peak_slide_error",
    "uplift_time_error",
)
"""Estimated errors, which no engine answers: `warprock.running.estimate` adds them."""
ESTIMATE_FIELDS: tuple[str, ...] = (
    *ERROR_FIELDS,
    "time_step",
    "first_step_count",
    "total_step_count",
)
"""Errors, and what runs they took: `warprock.running.tolerance` adds these."""
MODEL_FIELDS: tuple[str, ...] = ("friction_needed",)
"""Fields that `housner`, its reference, and `event` of prescribed restitutions answer besides."""
BODY_FIELDS: tuple[str, ...] = ("peak_rotation_left", "peak_rotation_right")
"""Fields that engines answer besides for bodies in the plane, whose sides may differ."""
TIE_FIELDS: tuple[str, ...] = (
    "peak_tie_force",
    "peak_tie_elongation",
    "broken_ties",
    "tie_break_time",
    "tie_energy_lost",
)
"""Fields that engines answer besides for blocks with ties."""
ASSEMBLY_FIELDS: tuple[str, ...] = (
    "peak_displacement",
    "residual_displacement",
    "peak_opening",
    "opened_joints",
    "slid_joints",
    "broken_joints",
    "joint_break_time",
    "collapse_time",
    "collapse_load",
    "solver_residual",
)
"""Fields that the engine of assemblies answers besides."""
LANE_FIELDS: tuple[str, ...] = tuple(
    n
    for n, f in FIELDS.items()
    if f.dims == ("lane",)
    and n not in (*ESTIMATE_FIELDS, *MODEL_FIELDS, *BODY_FIELDS, *TIE_FIELDS, *ASSEMBLY_FIELDS)
    and not f.spatial
)
"""Fields that every engine answers."""
SPATIAL_FIELDS: tuple[str, ...] = tuple(
    n for n, f in FIELDS.items() if f.dims == ("lane",) and f.spatial
)
"""Fields that an engine answers besides for blocks in space."""
HISTORIES: tuple[str, ...] = tuple(n for n, f in FIELDS.items() if f.dims == ("lane", "sample"))
"""Fields with the dimension sample: those in space only for blocks in space, and but for the
rotations and the yaw only where places were asked for, too."""
INTEGER_FIELDS: tuple[str, ...] = (
    *("outcome", "status", "impact_count", "step_count"),
    "broken_ties",
    *("opened_joints", "slid_joints", "joint_state"),
)


MOST_SAMPLES = 2**27
"""Samples of one history: 1 GB."""


@dataclasses.dataclass(frozen=True)
class SampleTimes:
    """How long a run lasts and when its histories are sampled.

    Attributes:
        duration: Length of the run [s], > 0.
        interval: Time between samples of the histories [s]; None asks for no histories.
        places: Whether histories tell where the blocks are, too, besides how they are turned.

    Example:
        >>> import warprock as wr
        >>> wr.SampleTimes(1.0, 0.25).times.tolist()
        [0.0, 0.25, 0.5, 0.75, 1.0]

    Raises:
        InputError: The duration or the interval is out of bounds.
    """

    duration: float
    interval: float | None = None
    places: bool = False

    def __post_init__(self) -> None:
        for name, given in (("duration", self.duration), ("interval", self.interval)):
            number = isinstance(given, numbers.Real) and not isinstance(given, bool)
            if not number and (name == "duration" or given is not None):
                raise InputError(name, "", given, "must be a number of seconds")
        if not (np.isfinite(self.duration) and self.duration > 0.0):
            raise InputError("duration", "", self.duration, "must be > 0 s")
        if self.interval is not None and not 0.0 < self.interval <= self.duration:
            allowed = f"must be > 0 s and at most the duration, {self.duration} s"
            raise InputError("interval", "", self.interval, allowed)
        if self.count > MOST_SAMPLES:
            allowed = (
                f"must make at most {MOST_SAMPLES:,} samples, not {self.count:,}, "
                f"{8 * self.count / 1e9:,.1f} GB a history"
            )
            raise InputError("interval", "", self.interval, allowed)

    @property
    def count(self) -> int:
        """Number of samples."""
        if self.interval is None:
            return 1
        return 1 + int(np.floor(self.duration / self.interval * (1.0 + 1e-12)))

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """Sample times [s], shape [sample]; the last one is at most the duration.

        Without histories it is the end of the run alone.
        """
        if self.interval is None:
            return np.array([self.duration])
        samples = self.interval * np.arange(self.count, dtype=np.float64)
        # 140 x 0.005 s is more than 0.7 s by round-off: a time that a run would not come to.
        return np.minimum(samples, self.duration)


@dataclasses.dataclass(frozen=True)
class Response:
    """The answer of one engine for a batch of lanes.

    Attributes:
        engine: Name of the engine.
        fields: Arrays by field name, lane first, then the block in fields of stacks that are per
            block, then the sample; `rotation` only where histories were asked for, `rotation_error`
            and `peak_rotation_error` only where the errors were estimated.
        times: Sample times of the histories [s], shape [sample]; empty without histories.

    Example:
        >>> import warprock as wr
        >>> response = wr.run("free-b0", "housner", progress=False).response
        >>> response.count(wr.Status.OK), response["peak_rotation"].round(4).tolist()
        (2, [0.0987, 0.0899])
    """

    engine: str
    fields: Mapping[str, npt.NDArray[Any]]
    times: npt.NDArray[np.float64]

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self.fields[name]

    @property
    def lane_count(self) -> int:
        """Number of lanes."""
        return len(self.fields["status"])

    def count(self, status: Status, lanes: npt.NDArray[np.intp] | None = None) -> int:
        """Lanes with a status, of all or of some by number."""
        found = self.fields["status"] == status
        return int(np.count_nonzero(found if lanes is None else found[lanes]))


def join_responses(parts: Sequence[Response]) -> Response:
    """Joins the responses of several lots of lanes, in their order.

    Histories of runs that end earlier go on as NaN.
    """
    longest = max(parts, key=lambda part: len(part.times))
    count = len(longest.times)
    fields = {
        name: np.concatenate([_lengthen(name, part, count) for part in parts])
        for name in longest.fields
    }
    return Response(engine=longest.engine, fields=fields, times=longest.times)


def _lengthen(name: str, part: Response, count: int) -> npt.NDArray[Any]:
    """A field, with NaN up to a count of samples where it is a history."""
    values, missing = part.fields[name], count - len(part.times)
    if missing == 0 or FIELDS[name].dims[-1] != "sample":
        return values
    ends = [(0, 0)] * (values.ndim - 1)
    return np.pad(values, [*ends, (0, missing)], constant_values=np.nan)


def take_lanes(response: Response, lanes: npt.NDArray[np.intp]) -> Response:
    """Some of the lanes of a response, by number, in the order given."""
    fields = {name: values[lanes] for name, values in response.fields.items()}
    return dataclasses.replace(response, fields=fields)
