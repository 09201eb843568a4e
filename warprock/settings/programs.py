"""Settings of the programs of others: a dataclass each, every field declared by a `SettingKey`.

This file imports none of them, so that a case can be validated without having them. The step is the
knob they share: they take at least so many steps a second, as many in each frame.
"""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any

from warprock.settings.setting import SettingKey

_RATE = SettingKey("steps a second, rounded up to whole frames", 10.0, 1e6, "1/s")
_SWEEPS = SettingKey("iterations of the contact solver", 1, 1000)


@dataclasses.dataclass(frozen=True)
class MujocoSettings:
    """Settings of `mujoco`."""

    steps_per_second: Annotated[float, _RATE] = 4800.0
    contact_time: Annotated[
        float, SettingKey("time constant of a contact over the time step", 2.0, 1000.0)
    ] = 2.0
    damping_ratio: Annotated[float, SettingKey("damping ratio of a contact", 0.1, 100.0)] = 2.0
    impedance: Annotated[
        float, SettingKey("share of the force that a contact would take if rigid", 0.5, 0.9999)
    ] = 0.9999


@dataclasses.dataclass(frozen=True)
class BulletSettings:
    """Settings of `bullet`."""

    steps_per_second: Annotated[float, _RATE] = 4800.0
    iterations: Annotated[int, _SWEEPS] = 50
    breaking_threshold: Annotated[
        float,
        SettingKey(
            "gap at which a contact is dropped; the 20 mm that it starts with end rocking early",
            0.0,
            0.1,
            "m",
        ),
    ] = 1e-4
    contact_slop: Annotated[
        float,
        SettingKey(
            "penetration that is left alone: a block sinks in by so much before it is held",
            0.0,
            0.1,
            "m",
        ),
    ] = 0.0
    restitution: Annotated[
        float, SettingKey("normal restitution of the blocks and of their base", 0.0, 1.0)
    ] = 0.0


@dataclasses.dataclass(frozen=True)
class BlenderSettings:
    """Settings of `blender`; its sub-steps are those of a frame that make up the steps."""

    steps_per_second: Annotated[float, _RATE] = 4800.0
    frames_per_second: Annotated[
        float, SettingKey("frames a second, at which the base has keys", 1.0, 32767.0, "1/s")
    ] = 960.0
    iterations: Annotated[int, _SWEEPS] = 50
    collision_shape: Annotated[
        int, SettingKey("0: box; 1: convex hull; 2: mesh of triangles", 0, 2)
    ] = 0
    collision_margin: Annotated[
        float, SettingKey("collision margin of hulls and meshes", 0.0, 0.1, "m")
    ] = 0.0


@dataclasses.dataclass(frozen=True)
class NewtonXpbdSettings:
    """Settings of `newton-xpbd`.

    Its velocities come from differences of places in float32. Where a step moves a block by less
    than these resolve, it stands still: at 2400 steps a second block B2 of the paper, let go at
    0.99 of its slenderness angle, never falls; at 480 it does.
    """

    steps_per_second: Annotated[float, _RATE] = 960.0
    iterations: Annotated[int, _SWEEPS] = 10


@dataclasses.dataclass(frozen=True)
class NewtonMujocoSettings:
    """Settings of `newton-mujoco`."""

    steps_per_second: Annotated[float, _RATE] = 480.0
    iterations: Annotated[int, _SWEEPS] = 50


@dataclasses.dataclass(frozen=True)
class NewtonVbdSettings:
    """Settings of `newton-vbd`."""

    steps_per_second: Annotated[float, _RATE] = 2400.0
    iterations: Annotated[int, _SWEEPS] = 10


@dataclasses.dataclass(frozen=True)
class NewtonSemiImplicitSettings:
    """Settings of `newton-semi-implicit`, whose contacts are springs as stiff as a step allows."""

    steps_per_second: Annotated[float, _RATE] = 4800.0


@dataclasses.dataclass(frozen=True)
class NewtonFeatherstoneSettings:
    """Settings of `newton-featherstone`, with the springs of `newton-semi-implicit`."""

    steps_per_second: Annotated[float, _RATE] = 4800.0


@dataclasses.dataclass(frozen=True)
class NewtonKaminoSettings:
    """Settings of `newton-kamino`."""

    steps_per_second: Annotated[float, _RATE] = 480.0


@dataclasses.dataclass(frozen=True)
class NewtonSteelSettings:
    """Settings of `newton-steel`."""

    steps_per_second: Annotated[float, _RATE] = 2400.0
    iterations: Annotated[int, _SWEEPS] = 12


PEER_SETTINGS: dict[str, type[Any]] = {
    "mujoco": MujocoSettings,
    "bullet": BulletSettings,
    "blender": BlenderSettings,
    "newton-xpbd": NewtonXpbdSettings,
    "newton-mujoco": NewtonMujocoSettings,
    "newton-vbd": NewtonVbdSettings,
    "newton-semi-implicit": NewtonSemiImplicitSettings,
    "newton-featherstone": NewtonFeatherstoneSettings,
    "newton-kamino": NewtonKaminoSettings,
    "newton-steel": NewtonSteelSettings,
}
"""Name of a program -> settings dataclass."""
