"""Settings of the programs of others: a dataclass each, every field with unit, bound and meaning.

This file imports none of them, so that a case can be validated without having them. The step is the
knob they share: they take at least so many steps a second, as many in each frame.
"""

from __future__ import annotations

import dataclasses
from typing import Any

from warprock.settings.engines import setting


def _rate(default: float) -> Any:
    return setting(
        default, unit="1/s", low=10.0, high=1e6, text="steps a second, rounded up to whole frames"
    )


def _sweeps(default: int) -> Any:
    return setting(default, unit="-", low=1, high=1000, text="iterations of the contact solver")


@dataclasses.dataclass(frozen=True)
class MujocoSettings:
    """Settings of `mujoco`."""

    steps_per_second: float = _rate(4800.0)


@dataclasses.dataclass(frozen=True)
class BulletSettings:
    """Settings of `bullet`."""

    steps_per_second: float = _rate(4800.0)
    iterations: int = _sweeps(50)
    breaking_threshold: float = setting(
        1e-4,
        unit="m",
        low=0.0,
        high=0.1,
        text="gap at which a contact is dropped; the 20 mm that it starts with end rocking early",
    )
    contact_slop: float = setting(
        0.0,
        unit="m",
        low=0.0,
        high=0.1,
        text="penetration that is left alone: a block sinks in by so much before it is held",
    )


@dataclasses.dataclass(frozen=True)
class BlenderSettings:
    """Settings of `blender`; its sub-steps are those of a frame that make up the steps."""

    steps_per_second: float = _rate(4800.0)
    frames_per_second: float = setting(
        960.0, unit="1/s", low=1.0, high=32767.0, text="frames a second, at which the base has keys"
    )
    iterations: int = _sweeps(50)
    collision_shape: int = setting(
        0, unit="-", low=0, high=2, text="0: box; 1: convex hull; 2: mesh of triangles"
    )
    collision_margin: float = setting(
        0.0, unit="m", low=0.0, high=0.1, text="collision margin of hulls and meshes"
    )


@dataclasses.dataclass(frozen=True)
class NewtonXpbdSettings:
    """Settings of `newton-xpbd`.

    Its velocities come from differences of places in float32. Where a step moves a block by less
    than these resolve, it stands still: at 2400 steps a second block B2 of the paper, let go at
    0.99 of its slenderness angle, never falls; at 480 it does.
    """

    steps_per_second: float = _rate(960.0)
    iterations: int = _sweeps(10)


@dataclasses.dataclass(frozen=True)
class NewtonMujocoSettings:
    """Settings of `newton-mujoco`."""

    steps_per_second: float = _rate(480.0)
    iterations: int = _sweeps(50)


@dataclasses.dataclass(frozen=True)
class NewtonVbdSettings:
    """Settings of `newton-vbd`."""

    steps_per_second: float = _rate(2400.0)
    iterations: int = _sweeps(10)


@dataclasses.dataclass(frozen=True)
class NewtonSemiImplicitSettings:
    """Settings of `newton-semi-implicit`, whose contacts are springs as stiff as a step allows."""

    steps_per_second: float = _rate(4800.0)


@dataclasses.dataclass(frozen=True)
class NewtonFeatherstoneSettings:
    """Settings of `newton-featherstone`, with the springs of `newton-semi-implicit`."""

    steps_per_second: float = _rate(4800.0)


@dataclasses.dataclass(frozen=True)
class NewtonKaminoSettings:
    """Settings of `newton-kamino`."""

    steps_per_second: float = _rate(480.0)


@dataclasses.dataclass(frozen=True)
class NewtonSteelSettings:
    """Settings of `newton-steel`."""

    steps_per_second: float = _rate(2400.0)
    iterations: int = _sweeps(12)


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
