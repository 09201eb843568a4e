"""Assemblies on springs, for the soft-spring engine: where they stand, and how long a step may be.

Every joint has a normal and a shear spring at each of its two ends, where the engine `assembly` has
its contacts. Each stands for half of the area of the joint. A block rocks on the spring at one end
as on a rigid corner. A closed joint is three times as stiff against a turn as on springs all along.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from warprock.engines.assembly import CREEP, Assembly
from warprock.engines.assembly_packs import block_columns, joint_columns
from warprock.engines.dem_springs import round_frequency, stable_step
from warprock.model.assembly import Assembly as Laid
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

STEPS_AN_OCTAVE = 4
"""Lengths of steps from one to its double. Lanes side by side take steps of one length; by rounding
to a row of lengths there are many that may lie side by side."""

TRIALS = 60
"""Trials of which springs bear and which slip at rest."""


@dataclasses.dataclass(frozen=True)
class SprungAssembly(Assembly):
    """Assemblies on springs: the engine `dem` where a lane is one."""

    name: ClassVar[str] = "dem"
    settings_type = DemSettings
    on_springs: ClassVar[bool] = True

    def longest_step(self, lanes: Lanes, motions: GroundMotions) -> Array:
        """Longest step of every lane [s], from its stiffest mode, of a row of lengths."""
        own = lanes.assembly
        assert own is not None
        highest = np.array([springs_of(kind, self.settings).highest for kind in own.kinds])
        longest = self.settings.time_step
        limit = self.settings.step_safety * stable_step(highest, self.settings)
        down = np.ceil(STEPS_AN_OCTAVE * np.log2(longest / np.minimum(limit, longest)))
        return np.asarray(longest * np.exp2(-down / STEPS_AN_OCTAVE))[own.lane]

    @property
    def after_collapse(self) -> float:
        """A lane ends at its collapse: only joints have springs [s]."""
        return 0.0

    def knobs(self, module: Any) -> Any:
        """Settings as the kernel takes them, but for time steps."""
        knobs, own = module.Knobs(), self.settings
        knobs.gravity = GRAVITY
        knobs.stiffness.gravity = GRAVITY
        knobs.stiffness.normal_stiffness = own.normal_stiffness
        knobs.stiffness.shear_stiffness = own.shear_stiffness
        knobs.stiffness.shear_flexibility = 1.0 / own.shear_stiffness
        knobs.stiffness.stiffness_damping = own.stiffness_damping
        knobs.stiffness.mass_damping = own.mass_damping
        knobs.stiffness.cohesion = own.cohesion
        knobs.stiffness.tensile_strength = own.tensile_strength
        knobs.stiffness.dilatancy = math.tan(own.dilatancy)
        return knobs

    def columns(
        self, lanes: Lanes, blocks: int, joints: int
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Fields of the structs of blocks and joints, [lane, block] and [lane, joint] each."""
        own = lanes.assembly
        assert own is not None
        places, touching = block_columns(own, blocks), joint_columns(own, joints)
        starts = [springs_of(kind, self.settings) for kind in own.kinds]
        shift = np.stack([_filled(each.shift, blocks) for each in starts])[own.lane]
        stretch = np.stack([_filled(each.stretch, joints) for each in starts])[own.lane]
        area = np.stack([_filled(each.area, joints) for each in starts])[own.lane]
        for axis, name in enumerate(("x", "z", "theta")):
            places[name] = places[name] + shift[..., axis]
        return places, touching | {
            "area": area, "first": stretch[..., 0], "second": stretch[..., 1],
        }  # fmt: skip

    def calm(self, lanes: Lanes, steps: Array) -> Array:
        """Speed up to which a corner counts as still [m/s], shape [lane].

        A part of that at which an assembly sways on its springs whose base starts with gravity.
        """
        own = lanes.assembly
        assert own is not None
        lowest = np.array([springs_of(kind, self.settings).lowest for kind in own.kinds])
        return np.asarray(CREEP * GRAVITY / lowest)[own.lane]


def _filled(values: Array, room: int) -> Array:
    spare = [(0, room - len(values))] + [(0, 0)] * (values.ndim - 1)
    return np.pad(values, spare)


@dataclasses.dataclass(frozen=True, eq=False)
class Springs:
    """An assembly on springs, at rest under its weight.

    Attributes:
        area: Area that each end of a joint stands for [m^2], shape [joint].
        shift: Of the blocks from where they are on rigid joints: x, z [m] and rotation [rad],
            shape [block, 3].
        stretch: Of the shear springs [m], shape [joint, end].
        lowest, highest: Angular frequencies of small motions with all joints closed and sticking
            [rad/s].
    """

    area: Array
    shift: Array
    stretch: Array
    lowest: float
    highest: float


@functools.lru_cache(maxsize=4096)
def springs_of(kind: Laid, settings: DemSettings) -> Springs:
    """An assembly on springs, at rest under its weight."""
    area = 0.5 * kind.joints.lengths * kind.depth
    normal, shear = _directions(kind)
    each = np.repeat(area, 2)
    hard, soft = settings.normal_stiffness * each, settings.shear_stiffness * each
    free = np.repeat(~kind.fixed, 3)
    inertia = kind.mass * kind.gyration
    masses = np.stack([kind.mass, kind.mass, inertia], axis=1).ravel()[free]
    normal, shear = normal[:, free], shear[:, free]
    whole = (normal.T * hard) @ normal + (shear.T * soft) @ shear
    scaled = whole / np.sqrt(masses[:, None] * masses)
    squares = np.linalg.eigvalsh(scaled)
    weight = np.zeros(len(free))
    weight[1::3] = -GRAVITY * kind.mass
    rest = _Rest(normal, shear, hard, soft, np.repeat(kind.joints.friction, 2), settings)
    place, drag = rest.solve(weight[free], each)
    shift = np.zeros(len(free))
    shift[free] = place
    highest = float(round_frequency(np.sqrt(squares[-1:]))[0])
    lowest = math.sqrt(max(float(squares[0]), TINY * float(squares[-1])))
    return Springs(area, shift.reshape(-1, 3), (-drag / soft).reshape(-1, 2), lowest, highest)


TINY = 1e-12
"""Least square of a frequency over the largest one: round-off."""


def _directions(kind: Laid) -> tuple[Array, Array]:
    """How motions of the blocks open and slide contacts, shape [contact, 3 block] each."""
    joints, count = kind.joints, 2 * kind.joints.count
    places = joints.ends.reshape(count, 2)
    n = np.repeat(joints.normal, 2, axis=0)
    t = np.stack([-n[:, 1], n[:, 0]], axis=1)
    rows = np.arange(count)
    found = []
    for way in (n, t):
        each = np.zeros((count, kind.count, 3))
        for side, sign in ((0, 1.0), (1, -1.0)):
            block = np.repeat(joints.blocks[:, side], 2)
            arm = places - kind.centre[block]
            moment = arm[:, 0] * way[:, 1] - arm[:, 1] * way[:, 0]
            each[rows, block] = sign * np.column_stack([way, moment])
        found.append(each.reshape(count, -1))
    return found[0], found[1]


@dataclasses.dataclass(frozen=True)
class _Rest:
    """Springs of contacts: how motions open and slide them, their stiffness, their friction."""

    normal: Array
    shear: Array
    hard: Array
    soft: Array
    friction: Array
    settings: DemSettings

    def solve(self, load: Array, area: Array) -> tuple[Array, Array]:
        """Where the blocks are at rest under a load, and shear forces T [N], shape [contact].

        Springs that would pull beyond their strength open, and those whose shear force is beyond
        their bound hold that. Where there is no equilibrium, what the last trial found.
        """
        presses, sticks = np.ones((2, len(area)), dtype=bool)
        drag: Array = np.zeros_like(area)
        place: Array = np.zeros_like(load)
        for _ in range(TRIALS):
            hard, soft = self.hard * presses, self.soft * (presses & sticks)
            stiffness = (self.normal.T * hard) @ self.normal + (self.shear.T * soft) @ self.shear
            forces = load + self.shear.T @ np.where(presses & ~sticks, drag, 0.0)
            place = np.asarray(np.linalg.lstsq(stiffness, forces, rcond=None)[0], dtype=np.float64)
            push: Array = -self.hard * (self.normal @ place)
            now = push > -self.settings.tensile_strength * area
            bound = self.friction * np.maximum(push, 0.0) + self.settings.cohesion * area
            wanted = -self.soft * (self.shear @ place)
            holds, before = np.abs(wanted) <= bound, drag
            drag = np.asarray(np.where(now, np.clip(wanted, -bound, bound), 0.0))
            settled = np.allclose(drag, before, rtol=1e-9, atol=1e-9 * float(np.abs(load).max()))
            same = np.array_equal(now, presses) and np.array_equal(holds, sticks) and settled
            presses, sticks = now, holds
            if same:
                break
        return place, drag
