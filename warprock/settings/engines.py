"""Settings of every engine: one frozen dataclass each, every field declared by a `SettingKey`.

They are the keys of the tables [engines.NAME] of a case. `drawn` is the colour (a name in
`warprock/figures/palette.py`) and the marker of the engine in all figures. This file imports no
engine, so that a case can be validated without compiling anything.
"""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self

from warprock.errors import InputError, did_you_mean, list_allowed
from warprock.plugins import Plugged, load
from warprock.settings.setting import SettingKey
from warprock.unmodelled import unmodelled_text

if typing.TYPE_CHECKING:
    import pydantic

FRICTION_IN_SPACE = SettingKey(
    "in space, 0: friction is bound in every direction alike (exact cone); 1: along x and along y "
    "by itself (box), in a stack those of the lower face",
    0,
    1,
)
"""The law of friction of engines whose blocks slide in two directions."""

NEWTON = 0
"""The `restitution_law` of `event` that is Newton's."""


@dataclasses.dataclass(frozen=True)
class FramedSettings:
    """What engines share that take frames, each cut into sub-steps."""

    frames_per_second: Annotated[float, SettingKey("frames a second", 1.0, 1e5, "1/s")] = 240.0
    substeps: Annotated[int, SettingKey("sub-steps a frame", 0, 10000)] = 20

    @property
    def time_step(self) -> float:
        """Time step [s] (Eq. 9 of the paper)."""
        return 1.0 / ((self.substeps + 1) * self.frames_per_second)

    def halved(self) -> Self:
        """The same settings with half of the time step."""
        return dataclasses.replace(self, substeps=2 * self.substeps + 1)

    def with_step_scaled(self, factor: float) -> Self:
        """The same settings with the time step multiplied by a factor."""
        return dataclasses.replace(self, frames_per_second=self.frames_per_second / factor)


@dataclasses.dataclass(frozen=True)
class SteppedSettings:
    """What engines share whose time step is a setting; each declares its meaning and bounds."""

    time_step: float

    def halved(self) -> Self:
        """The same settings with half of the time step."""
        return dataclasses.replace(self, time_step=0.5 * self.time_step)

    def with_step_scaled(self, factor: float) -> Self:
        """The same settings with the time step multiplied by a factor."""
        return dataclasses.replace(self, time_step=factor * self.time_step)


@dataclasses.dataclass(frozen=True)
class HousnerSettings:
    """Settings of `housner`."""

    drawn: ClassVar[tuple[str, str]] = ("black", "s")

    rest_rotation_ratio: Annotated[
        float,
        SettingKey(
            "after an impact the block rests if its next swing would stay below this times the "
            "slenderness angle on either side",
            1e-12,
            1e-2,
        ),
    ] = 1e-9


@dataclasses.dataclass(frozen=True)
class ImpulseSettings(FramedSettings):
    """Settings of `impulse`; the time step is 1 / ((substeps + 1) frames_per_second), Eq. 9."""

    drawn: ClassVar[tuple[str, str]] = ("vermilion", "^")

    iterations: Annotated[
        int,
        SettingKey(
            "sweeps of the contact solver over the contacts; of a single block, more than 15 end "
            "once one changes nothing",
            1,
            1000,
        ),
    ] = 10
    collision_margin: Annotated[
        float,
        SettingKey(
            "a corner closer to the base is a contact that may close its gap in the step; where "
            "it is wider than a corner moves in a step, impacts come late by part of the step",
            0.0,
            0.1,
            "m",
        ),
    ] = 1e-8
    erp: Annotated[float, SettingKey("part of a penetration that a step removes", 0.0, 1.0)] = 0.2
    restitution: Annotated[
        float,
        SettingKey(
            "of single blocks and bodies in space: speed at which a corner that lands leaves the "
            "base again, as a part of that at which it came",
            0.0,
            1.0,
        ),
    ] = 0.0
    friction_box: Annotated[int, FRICTION_IN_SPACE] = 0


@dataclasses.dataclass(frozen=True)
class DirectSettings(FramedSettings):
    """Settings of `direct`; the time step is 1 / ((substeps + 1) frames_per_second), Eq. 9.

    The paper prints neither stiffness nor damping of its compliant contacts. The defaults make
    them rigid: a block sinks by its weight over the stiffness, and its corners, overdamped, do not
    bounce. What matters is the relaxation time damping / stiffness, 5 ms: it is long against the
    step, for a penetration given back in a step would come back as fast as the corner came.
    """

    drawn: ClassVar[tuple[str, str]] = ("green", "v")

    contact_stiffness: Annotated[
        float, SettingKey("stiffness of the spring at a contact point", 1e3, 1e18, "N/m")
    ] = 1e15
    contact_damping: Annotated[
        float, SettingKey("damping of the dashpot at a contact point", 0.0, 1e18, "N s/m")
    ] = 5e12
    friction_box: Annotated[
        int,
        SettingKey(
            "0: friction is bound by the normal impulses of the same step (exact cone); 1: by "
            "those of the last step (box)",
            0,
            1,
        ),
    ] = 0


@dataclasses.dataclass(frozen=True)
class EventSettings(SteppedSettings):
    """Settings of `event`."""

    drawn: ClassVar[tuple[str, str]] = ("blue", "o")

    time_step: Annotated[
        float,
        SettingKey(
            "longest step, never more than 0.25 / frequency parameter; a single box in the plane "
            "that rests, rocks about a corner that sticks or slides flat follows polynomials in "
            "steps up to 4 times as long, never longer than 1 / angular frequency of its motion, "
            "and takes half as long ones while it slides on a corner or flies; one that ties, a "
            "load or a wall hold follows polynomials in all it does; steps are shortened to end at "
            "impacts and at knots of the motion",
            1e-6,
            0.1,
            "s",
        ),
    ] = 5e-3
    rest_rotation_ratio: Annotated[
        float,
        SettingKey(
            "after an impact the block rests if its next swing would stay below this times the "
            "slenderness angle on either side; in a stack in the plane, and in one that bounces, "
            "a hundredth of it counts, for what rests decides which ends take part in an impact "
            "elsewhere",
            1e-9,
            1e-2,
        ),
    ] = 1e-6
    restitution: Annotated[
        float,
        SettingKey(
            "of single blocks and bodies, and of stacks: speed at which a corner that "
            "lands leaves again, as a part of that at which it came; a bounce that would last less "
            "than a sixteenth of the longest step is left out",
            0.0,
            1.0,
        ),
    ] = 0.0
    restitution_law: Annotated[
        int,
        SettingKey(
            "0: Newton's, restitution is a ratio of normal velocities; 1: Poisson's, not of "
            "stacks, it is one of normal impulses; they differ where friction stops a corner that "
            "slides",
            0,
            1,
        ),
    ] = NEWTON
    friction_box: Annotated[int, FRICTION_IN_SPACE] = 0


@dataclasses.dataclass(frozen=True)
class XpbdSettings(FramedSettings):
    """Settings of `xpbd`; the time step is 1 / ((substeps + 1) frames_per_second), Eq. 9."""

    drawn: ClassVar[tuple[str, str]] = ("orange", "P")

    iterations: Annotated[
        int, SettingKey("sweeps of the position solver in a sub-step", 1, 1000)
    ] = 8
    compliance: Annotated[
        float,
        SettingKey(
            "how far a newton presses an end of an interface in, whatever the sizes of its "
            "blocks: one contact's, not a pressure's; 0 is rigid",
            0.0,
            1e-3,
            "m/N",
        ),
    ] = 0.0


@dataclasses.dataclass(frozen=True)
class TwoBlockSettings:
    """Settings of `two-block`."""

    drawn: ClassVar[tuple[str, str]] = ("black", "D")

    rest_rotation_ratio: Annotated[
        float,
        SettingKey(
            "after an impact a contact that opens closes again if its next swing would stay below "
            "this times the slenderness angle of the block on it",
            1e-12,
            1e-2,
        ),
    ] = 1e-9


@dataclasses.dataclass(frozen=True)
class DemSettings(SteppedSettings):
    """Settings of `dem`; the defaults are those of Table 5 of the paper.

    The paper's 0.2 sqrt(m / k) is a tenth of the stability limit 2 sqrt(m / k) of an undamped
    spring: `step_safety` = 0.1.
    """

    drawn: ClassVar[tuple[str, str]] = ("purple", "X")
    springs: ClassVar[bool] = True

    time_step: Annotated[
        float, SettingKey("longest step, where stability allows it", 1e-8, 0.1, "s")
    ] = 1e-3
    normal_stiffness: Annotated[
        float, SettingKey("normal stiffness of an interface per area", 1e5, 1e14, "N/m^3")
    ] = 1e9
    shear_stiffness: Annotated[
        float, SettingKey("shear stiffness of an interface per area", 1e5, 1e14, "N/m^3")
    ] = 1e9
    subcontacts: Annotated[
        int,
        SettingKey(
            "springs along an interface, evenly from end to end; the two at the ends stand for "
            "half of the area of the others",
            2,
            64,
        ),
    ] = 5
    subcontacts_across: Annotated[
        int,
        SettingKey(
            "for blocks in space: rows of springs along the depth, spread as those along an "
            "interface",
            2,
            16,
        ),
    ] = 5
    stiffness_damping: Annotated[
        float,
        SettingKey(
            "stiffness-proportional damping: a dashpot of this times the stiffness beside every "
            "spring",
            0.0,
            1.0,
            "s",
        ),
    ] = 2.25e-4
    mass_damping: Annotated[
        float,
        SettingKey("mass-proportional damping of the motion relative to the base", 0.0, 1e3, "1/s"),
    ] = 0.0
    cohesion: Annotated[
        float, SettingKey("shear strength without load, until it fails", 0.0, 1e12, "N/m^2")
    ] = 0.0
    tensile_strength: Annotated[
        float, SettingKey("tensile strength, until it fails", 0.0, 1e12, "N/m^2")
    ] = 0.0
    dilatancy: Annotated[
        float,
        SettingKey(
            "angle at which slip opens an interface; beyond the friction angle slip wins energy",
            0.0,
            1.0,
            "rad",
        ),
    ] = 0.0
    friction_box: Annotated[int, FRICTION_IN_SPACE] = 0
    step_safety: Annotated[
        float,
        SettingKey(
            "longest step over the largest stable one, from the stiffest mode and its damping",
            1e-3,
            2.0,
        ),
    ] = 0.2

    def with_step_scaled(self, factor: float) -> Self:
        """The same settings with every lane's step multiplied by a factor, whatever limits it."""
        return dataclasses.replace(
            self, time_step=factor * self.time_step, step_safety=factor * self.step_safety
        )


@dataclasses.dataclass(frozen=True)
class AssemblySettings(SteppedSettings):
    """Settings of `assembly`."""

    drawn: ClassVar[tuple[str, str]] = ("sky", "p")

    time_step: Annotated[float, SettingKey("time step", 1e-6, 0.1, "s")] = 1e-3
    settled: Annotated[
        float,
        SettingKey(
            "a step is solved once a sweep over its contacts changes no velocity there by more "
            "than this times gravity x time step, in space than a tenth of that where all stands",
            1e-12,
            1.0,
        ),
    ] = 1e-3
    iterations: Annotated[
        int,
        SettingKey(
            "most sweeps of a step, eight times as many where a lane has more than 1,200 joints; a "
            "lane that needs more ends there, with status iteration_limit",
            1,
            1_000_000,
        ),
    ] = 10_000
    after_collapse: Annotated[
        float,
        SettingKey(
            "how long a lane goes on after its collapse, so that its blocks fall, lie on one "
            "another and come to rest; 0 ends it there",
            0.0,
            1e6,
            "s",
        ),
    ] = 0.0


_OWN: dict[str, type[Any]] = {
    "housner": HousnerSettings,
    "impulse": ImpulseSettings,
    "event": EventSettings,
    "direct": DirectSettings,
    "xpbd": XpbdSettings,
    "dem": DemSettings,
    "two-block": TwoBlockSettings,
    "assembly": AssemblySettings,
}


def _brought_settings(name: str) -> type[Any]:
    """The settings of an engine that another package brings."""
    found: type[Any] = load(name).settings_type
    return found


SETTINGS: Mapping[str, type[Any]] = Plugged(_OWN, _brought_settings)
"""Engine name -> settings dataclass, of engines that other packages bring, too."""


def has_time_step(settings: Any) -> bool:
    """Whether an engine with these settings has a time step that an ensemble can spread."""
    return hasattr(settings, "with_step_scaled")


EXACT = tuple(name for name, settings in SETTINGS.items() if not has_time_step(settings))
"""Engines without a time step: no step adds an error, and their blocks do not slide."""


def on_springs(engine: str) -> bool:
    """Whether the blocks of an engine, or of a program beside it, stand on springs that lift."""
    return bool(getattr(SETTINGS.get(engine), "springs", False))


def declared_settings(settings_type: type[Any]) -> dict[str, SettingKey]:
    """What each field of a dataclass of settings may hold, by its name."""
    hints = typing.get_type_hints(settings_type, include_extras=True)
    return {
        field.name: hints[field.name].__metadata__[0] for field in dataclasses.fields(settings_type)
    }


def build_settings(engine: str, table: Mapping[str, object], source: str) -> Any:
    """Validated settings of an engine from a table of a case file or of the command line.

    Args:
        engine: Name of the engine.
        table: Values by field name; missing fields keep their defaults.
        source: File or option, for the error text.

    Raises:
        InputError: Unknown key, wrong type or value outside its bounds.
    """
    return judged_settings(SETTINGS[engine], f"engines.{engine}", table, source)


def judged_settings(
    settings_type: type[Any], place: str, table: Mapping[str, object], source: str
) -> Any:
    """Validated settings, as `build_settings` does it, of any dataclass of settings.

    Args:
        settings_type: The dataclass, each of whose fields has a `SettingKey` in its annotation, and
            a default, which is not judged.
        place: Dotted key of the table, for the error text.
        table: Values by field name.
        source: File or option, for the error text.
    """
    if not table:
        return settings_type()
    import pydantic

    known = declared_settings(settings_type)
    for name, got in table.items():
        if name not in known:
            near = unmodelled_text(name) or did_you_mean(name, known)
            allowed = f"unknown key (allowed: {list_allowed(name, known)}){near}"
            raise InputError(source, f"{place}.{name}", got, allowed)
    if settings_type not in _ADAPTERS:
        _ADAPTERS[settings_type] = pydantic.TypeAdapter(settings_type)
    try:
        return _ADAPTERS[settings_type].validate_python(table)
    except pydantic.ValidationError as error:
        fault = error.errors(include_url=False)[0]
        key, why = f"{place}.{fault['loc'][0]}", str(fault["ctx"]["error"])
        raise InputError(source, key, fault["input"], why) from None


_ADAPTERS: dict[type[Any], pydantic.TypeAdapter[Any]] = {}
"""Readers of the settings that were asked for: each takes some milliseconds to make."""
