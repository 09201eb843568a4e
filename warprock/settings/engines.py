"""Settings of every engine: one frozen dataclass each, every field with unit, bound and meaning.

This file imports no engine, so that a case can be validated without compiling anything.
"""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping
from typing import Any, Self

from warprock.errors import InputError, listed


def setting(default: float | int, *, unit: str, low: float, high: float, text: str) -> Any:
    """A settings field: its default, unit, inclusive bounds and meaning."""
    return dataclasses.field(
        default=default, metadata={"unit": unit, "low": low, "high": high, "text": text}
    )


def friction_in_space() -> Any:
    """The settings field of engines whose blocks slide in two directions: the law of friction."""
    return setting(
        0,
        unit="-",
        low=0,
        high=1,
        text="in space, 0: friction is bound in every direction alike (exact cone); 1: along x and "
        "along y by itself (box), in a stack those of the lower face",
    )


@dataclasses.dataclass(frozen=True)
class HousnerSettings:
    """Settings of `housner`."""

    rest_rotation_ratio: float = setting(
        1e-9,
        unit="-",
        low=1e-12,
        high=1e-2,
        text="after an impact the block rests if its next swing would stay below this times the "
        "slenderness angle on either side",
    )


@dataclasses.dataclass(frozen=True)
class ImpulseSettings:
    """Settings of `impulse`; the time step is 1 / ((substeps + 1) frames_per_second), Eq. 9."""

    frames_per_second: float = setting(240.0, unit="1/s", low=1.0, high=1e5, text="frames a second")
    substeps: int = setting(20, unit="-", low=0, high=10000, text="sub-steps a frame")
    iterations: int = setting(
        10,
        unit="-",
        low=1,
        high=1000,
        text="sweeps of the contact solver over the contacts; of a single block, more than 15 end "
        "once one changes nothing",
    )
    collision_margin: float = setting(
        1e-8,
        unit="m",
        low=0.0,
        high=0.1,
        text="a corner closer to the base is a contact that may close its gap in the step; where "
        "it is wider than a corner moves in a step, impacts come late by part of the step",
    )
    erp: float = setting(
        0.2, unit="-", low=0.0, high=1.0, text="part of a penetration that a step removes"
    )
    friction_box: int = friction_in_space()

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
class DirectSettings:
    """Settings of `direct`; the time step is 1 / ((substeps + 1) frames_per_second), Eq. 9.

    The paper prints neither stiffness nor damping of its compliant contacts. The defaults make
    them rigid: a block sinks by its weight over the stiffness, and its corners, overdamped, do not
    bounce. What matters is the relaxation time damping / stiffness, 5 ms: it is long against the
    step, for a penetration given back in a step would come back as fast as the corner came.
    """

    frames_per_second: float = setting(240.0, unit="1/s", low=1.0, high=1e5, text="frames a second")
    substeps: int = setting(20, unit="-", low=0, high=10000, text="sub-steps a frame")
    contact_stiffness: float = setting(
        1e15, unit="N/m", low=1e3, high=1e18, text="stiffness of the spring at a contact point"
    )
    contact_damping: float = setting(
        5e12, unit="N s/m", low=0.0, high=1e18, text="damping of the dashpot at a contact point"
    )
    friction_box: int = setting(
        0,
        unit="-",
        low=0,
        high=1,
        text="0: friction is bound by the normal impulses of the same step (exact cone); 1: by "
        "those of the last step (box)",
    )

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
class EventSettings:
    """Settings of `event`."""

    time_step: float = setting(
        5e-3,
        unit="s",
        low=1e-6,
        high=0.1,
        text="longest step, never more than 0.25 / frequency parameter; steps are shortened to end "
        "at impacts and at knots of the motion",
    )
    rest_rotation_ratio: float = setting(
        1e-6,
        unit="-",
        low=1e-9,
        high=1e-2,
        text="after an impact the block rests if its next swing would stay below this times the "
        "slenderness angle on either side",
    )
    friction_box: int = friction_in_space()

    def halved(self) -> Self:
        """The same settings with half of the time step."""
        return dataclasses.replace(self, time_step=0.5 * self.time_step)

    def with_step_scaled(self, factor: float) -> Self:
        """The same settings with the time step multiplied by a factor."""
        return dataclasses.replace(self, time_step=factor * self.time_step)


@dataclasses.dataclass(frozen=True)
class XpbdSettings:
    """Settings of `xpbd`; the time step is 1 / ((substeps + 1) frames_per_second), Eq. 9."""

    frames_per_second: float = setting(240.0, unit="1/s", low=1.0, high=1e5, text="frames a second")
    substeps: int = setting(20, unit="-", low=0, high=10000, text="sub-steps a frame")
    iterations: int = setting(
        8, unit="-", low=1, high=1000, text="sweeps of the position solver in a sub-step"
    )
    compliance: float = setting(
        0.0,
        unit="m/N",
        low=0.0,
        high=1e-3,
        text="how far a newton presses an end of an interface in, whatever the sizes of its "
        "blocks: one contact's, not a pressure's; 0 is rigid",
    )

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
class TwoBlockSettings:
    """Settings of `two-block`."""

    rest_rotation_ratio: float = setting(
        1e-9,
        unit="-",
        low=1e-12,
        high=1e-2,
        text="after an impact a contact that opens closes again if its next swing would stay below "
        "this times the slenderness angle of the block on it",
    )


@dataclasses.dataclass(frozen=True)
class DemSettings:
    """Settings of `dem`; the defaults are those of Table 5 of the paper.

    The paper's 0.2 sqrt(m / k) is a tenth of the stability limit 2 sqrt(m / k) of an undamped
    spring: `step_safety` = 0.1.
    """

    normal_stiffness: float = setting(
        1e9, unit="N/m^3", low=1e5, high=1e14, text="normal stiffness of an interface per area"
    )
    shear_stiffness: float = setting(
        1e9, unit="N/m^3", low=1e5, high=1e14, text="shear stiffness of an interface per area"
    )
    subcontacts: int = setting(
        5,
        unit="-",
        low=2,
        high=64,
        text="springs along an interface, evenly from end to end; the two at the ends stand for "
        "half of the area of the others",
    )
    subcontacts_across: int = setting(
        5,
        unit="-",
        low=2,
        high=16,
        text="for blocks in space: rows of such springs along the depth, spread likewise",
    )
    stiffness_damping: float = setting(
        2.25e-4,
        unit="s",
        low=0.0,
        high=1.0,
        text="stiffness-proportional damping: a dashpot of this times the stiffness beside every "
        "spring",
    )
    mass_damping: float = setting(
        0.0,
        unit="1/s",
        low=0.0,
        high=1e3,
        text="mass-proportional damping of the motion relative to the base",
    )
    cohesion: float = setting(
        0.0, unit="N/m^2", low=0.0, high=1e12, text="shear strength without load, until it fails"
    )
    tensile_strength: float = setting(
        0.0, unit="N/m^2", low=0.0, high=1e12, text="tensile strength, until it fails"
    )
    dilatancy: float = setting(
        0.0,
        unit="rad",
        low=0.0,
        high=1.0,
        text="angle at which slip opens an interface; beyond the friction angle slip wins energy",
    )
    friction_box: int = friction_in_space()
    time_step: float = setting(
        1e-3, unit="s", low=1e-8, high=0.1, text="longest step, where stability allows it"
    )
    step_safety: float = setting(
        0.2,
        unit="-",
        low=1e-3,
        high=2.0,
        text="longest step over the largest stable one, from the stiffest mode and its damping",
    )

    def halved(self) -> Self:
        """The same settings with half of the longest time step."""
        return dataclasses.replace(self, time_step=0.5 * self.time_step)

    def with_step_scaled(self, factor: float) -> Self:
        """The same settings with every lane's step multiplied by a factor, whatever limits it."""
        return dataclasses.replace(
            self, time_step=factor * self.time_step, step_safety=factor * self.step_safety
        )


SETTINGS: dict[str, type[Any]] = {
    "housner": HousnerSettings,
    "impulse": ImpulseSettings,
    "event": EventSettings,
    "direct": DirectSettings,
    "xpbd": XpbdSettings,
    "dem": DemSettings,
    "two-block": TwoBlockSettings,
}
"""Engine name -> settings dataclass."""


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
        settings_type: The dataclass, whose fields are made by `setting`.
        place: Dotted key of the table, for the error text.
        table: Values by field name.
        source: File or option, for the error text.
    """
    fields = {field.name: field for field in dataclasses.fields(settings_type)}
    values: dict[str, float | int] = {}
    for name, got in table.items():
        key = f"{place}.{name}"
        if name not in fields:
            near = difflib.get_close_matches(name, fields, 1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise InputError(
                source, key, got, f"unknown key{hint} (allowed: {listed(name, fields)})"
            )
        meta, whole = fields[name].metadata, isinstance(fields[name].default, int)
        unit = "" if meta["unit"] == "-" else f" {meta['unit']}"
        bound = f"must be from {meta['low']:g} to {meta['high']:g}{unit}"
        if isinstance(got, bool) or not isinstance(got, int if whole else (int, float)):
            raise InputError(source, key, got, f"{bound}, a {'whole ' if whole else ''}number")
        if not meta["low"] <= got <= meta["high"]:
            raise InputError(source, key, got, bound)
        values[name] = int(got) if whole else float(got)
    return settings_type(**values)
