"""The tables [motion] (along x), [motion.y] and [motion.z]: how the base moves."""

from __future__ import annotations

from typing import Annotated, ClassVar, Self

import pydantic

from warprock.case.validation import KeyedError, Table
from warprock.case.waveforms import FAMILY_OF
from warprock.errors import GIVEN, NOTHING
from warprock.model.motion import Control, Waveform
from warprock.quantity import AMPLITUDE, Column, NumberKey, TextKey
from warprock.units import Quantity


class Direction(Table):
    """How the base moves along one axis: a waveform under a control, or a record times a scale."""

    place: ClassVar[str] = "motion"

    waveform: Annotated[
        Waveform,
        TextKey(
            "a waveform",
            tuple(Waveform),
            swept=True,
            column=Column("waveform", text="Shape of the controlled quantity in time"),
        ),
    ]
    control: Annotated[
        Control | None,
        TextKey(
            "the controlled quantity of the base",
            tuple(Control),
            swept=True,
            column=Column("control", text="Quantity of the base that follows the waveform"),
        ),
    ] = None
    frequency: Annotated[
        float | None,
        NumberKey(
            "the frequency of the waveform",
            "1e-4 Hz to 1e4 Hz",
            swept=True,
            column=Column("frequency"),
        ),
    ] = None
    amplitude: Annotated[Quantity | None, AMPLITUDE] = None
    start: Annotated[
        float,
        NumberKey(
            "the time at which the motion starts",
            "0 s to 1e5 s",
            swept=True,
            column=Column("start"),
        ),
    ] = 0.0
    cycles: Annotated[
        float | None,
        NumberKey(
            "the number of cycles",
            "0 to 1e7",
            low_open=True,
            swept=True,
            column=Column("cycles", text="Periods of its frequency in a pulse"),
        ),
    ] = None
    duration: Annotated[
        float | None,
        NumberKey(
            "the time from start to stop",
            "0 s to 1e5 s",
            low_open=True,
            swept=True,
            instead_of="cycles",
        ),
    ] = None
    phase: Annotated[
        float,
        NumberKey(
            "the phase of a pulse in its middle",
            "-360 deg to 360 deg",
            swept=True,
            column=Column("phase"),
        ),
    ] = 0.0
    tilt_rate: Annotated[
        float | None,
        NumberKey(
            "the angular velocity of a table that tilts, positive where its side at +x sinks",
            "-90 deg/s to 90 deg/s",
            swept=True,
            column=Column("tilt_rate", "deg/s"),
        ),
    ] = None
    tilt_step: Annotated[
        float | None,
        NumberKey(
            "the angle by which a table that tilts in steps tilts before each pause",
            "0.01 deg to 75 deg",
            swept=True,
            column=Column("tilt_step", "deg"),
        ),
    ] = None
    pause: Annotated[
        float | None,
        NumberKey(
            "how long a table that tilts in steps pauses after each",
            "0 s to 1e5 s",
            swept=True,
            column=Column("tilt_pause"),
        ),
    ] = None
    tilt_to: Annotated[
        float | None,
        NumberKey(
            "the tilt at which a table that tilts stays; without it it tilts until the run ends",
            "0.01 deg to 75 deg",
            swept=True,
            column=Column("tilt_to", "deg"),
        ),
    ] = None
    rise: Annotated[
        float,
        NumberKey(
            "the time in which a push, a sideways load that then stays, rises to its amplitude",
            "0 s to 1e5 s",
            low_open=True,
            swept=True,
            column=Column("rise"),
        ),
    ] = 1.0
    record: Annotated[
        str | None,
        TextKey(
            "the name of a record or the path of a file",
            most=4096,
            swept=True,
            column=Column("record", text="Name of the record"),
        ),
    ] = None
    scale: Annotated[
        float,
        NumberKey("the factor on the record", "-1000 to 1000", swept=True, column=Column("scale")),
    ] = 1.0
    target_pga: Annotated[
        float | None,
        NumberKey(
            "the peak acceleration that the record is scaled to",
            "0 g to 100 g",
            low_open=True,
            swept=True,
            instead_of="scale",
            column=Column("target_pga"),
        ),
    ] = None
    target_sa: Annotated[
        float | None,
        NumberKey(
            "the spectral acceleration, of 5 % damping at sa_period, that the record is scaled to",
            "0 g to 100 g",
            low_open=True,
            swept=True,
            instead_of="scale target_pga",
            column=Column("target_sa"),
        ),
    ] = None
    sa_period: Annotated[
        float | None,
        NumberKey(
            "the period of the spectral acceleration, a column of every lane that follows a record",
            "1e-3 s to 100 s",
            column=Column("sa_period"),
        ),
    ] = None

    def takes(self, name: str) -> bool:
        """Whether the waveform has a use for a key of this table."""
        return name == "direction" or name in FAMILY_OF[self.waveform].keys

    @pydantic.model_validator(mode="after")
    def _keys_of_the_waveform(self) -> Self:
        family, declared = FAMILY_OF[self.waveform], self.declared()
        given = self.model_fields_set - {"waveform", "direction", "y", "z"}
        for name in declared:
            if name in given and name not in family.keys:
                allowed = f"must not be given with waveform {self.waveform}"
                raise KeyedError(name, GIVEN, allowed)
        for name in family.needs:
            if name not in given:
                raise KeyedError(name, NOTHING, declared[name].allowed)
        if ("tilt_step" in given) != ("pause" in given):
            name = "pause" if "tilt_step" in given else "tilt_step"
            raise KeyedError(name, NOTHING, f"{declared[name].allowed}, with the other of the two")
        if "target_sa" in given and "sa_period" not in given:
            raise KeyedError("sa_period", NOTHING, "must be given with motion.target_sa")
        if "duration" in family.may and not {"cycles", "duration"} & given:
            raise KeyedError("cycles", NOTHING, "must be given, or motion.duration")
        return self


class Motion(Direction):
    """How the base moves: along x; in space also along y and z, in the plane upwards where asked.

    A box whose base moves upwards runs in space unless the case says `model = "planar"`; a profile
    runs in the plane.
    """

    direction: Annotated[
        float | None,
        NumberKey(
            "the angle from the block's x axis to the axis that [motion] moves along, about the "
            "vertical; of a body run in the plane it turns the plane of rocking",
            "-360 deg to 360 deg",
            swept=True,
            column=Column("direction", "deg"),
        ),
    ] = None
    y: Direction | None = None
    z: Direction | None = None

    @pydantic.model_validator(mode="after")
    def _one_direction(self) -> Self:
        if self.direction is not None and self.y is not None:
            allowed = "must not be given beside motion.y, which says how the base moves across"
            raise KeyedError("direction", self.direction, allowed)
        return self
