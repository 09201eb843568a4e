"""The contract that every engine keeps, and what they share: the way from lanes to a response."""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Mapping
from types import ModuleType
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from warprock.engines.bodies import box_bodies
from warprock.engines.decoding import histories, respond, side_fields
from warprock.engines.drums import column_fields, end_at_collapse
from warprock.engines.launching import Found, Kernel, Target, launch
from warprock.kernels.launch.instance import kernel_module
from warprock.model.drums import as_stacks_of_drums
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, UprightMotions
from warprock.model.response import Response, SampleTimes
from warprock.model.runnable import HIGHEST_STACK
from warprock.model.scene import SceneKind

HELD_IN_PLACE = ("transverse_wall", "tie", "top_load")
"""Tables that hold a block that otherwise stands as a free one does."""


@dataclasses.dataclass(frozen=True)
class AbstractEngine(abc.ABC):
    """A scheme that turns lanes and their ground motions into a response.

    Trouble in one lane is a value of that lane's status and never disturbs another.

    Attributes:
        settings: A frozen dataclass of `settings_type`; its defaults where None.
        target: Precision, device and form of its kernel.
    """

    settings: Any = None
    target: Target = Target()  # noqa: RUF009 (it is frozen)

    name: ClassVar[str]
    """Key in `ENGINES`."""
    settings_type: ClassVar[type[Any]]
    """Frozen dataclass of the engine's settings."""
    order: ClassVar[int | None]
    """Order in the time step of the error after impacts; None if the step is not the knob."""
    spatial: ClassVar[bool] = False
    """Whether its blocks can move in space."""
    bodies: ClassVar[tuple[bool, bool]] = (False, False)
    """Whether its blocks can be bodies that are no boxes, in the plane and in space."""
    highest: ClassVar[tuple[int, int]] = (6, 6)
    """Blocks in the highest stack that it runs, in the plane and in space."""
    stacked_bodies: ClassVar[bool] = False
    """Whether the blocks of its stacks in the plane can be such bodies."""
    rounded: ClassVar[bool] = False
    """Whether it can roll a body on rounded corners."""
    holds: ClassVar[bool] = False
    """Whether it knows what holds a block besides its base: walls and ties."""
    vertical: ClassVar[tuple[str, ...]] = ()
    """What it can run in the plane on a base that also moves upwards: block, stack."""
    restitution: ClassVar[str | None] = "finds the angular restitution from its contact law"
    """How it finds the angular restitution; None if it follows the one that a case prescribes."""
    slides: ClassVar[bool] = True
    """Whether its blocks can slide, so that its law of contact may have several solutions."""
    above_rigid: ClassVar[bool] = False
    """Whether its kernels give heights relative to those of a pile of rigid blocks."""
    starts_moving: ClassVar[tuple[str, ...]] = ()
    """Where boxes may start with velocities or be thrown: plane, space."""
    assemblies: ClassVar[bool] = False
    """Whether it runs assemblies of many blocks with joints."""
    solids: ClassVar[bool] = False
    """Whether it runs assemblies in space, too."""
    drums: ClassVar[bool] = False
    """Whether it runs an assembly that is a column of equal drums, as the stack that it is."""
    bodies_move: ClassVar[tuple[str, ...]] = ()
    """Where bodies may start with velocities or be thrown: plane, space."""
    reference_of: ClassVar[str | None] = None
    """Scenes of which others are held against it, for no time step adds an error: block, stack."""
    locates_events: ClassVar[bool] = False
    """Whether its steps end at events; else they have one length and pass over them."""
    preference: ClassVar[int | None] = None
    """Place in the order in which an engine is taken that was not named; None if it never is."""
    rests_exactly: ClassVar[bool] = False
    """Whether a block at rest does not move at all, until its base lifts it or makes it slide."""

    def __post_init__(self) -> None:
        if self.settings is None:
            object.__setattr__(self, "settings", self.settings_type())

    @classmethod
    def supports(cls, scene: SceneKind) -> str | None:
        """Why the engine cannot run a scene; None if it can."""
        if scene.assembly and scene.spatial and not cls.solids:
            return (
                f"{cls.name} runs no assemblies in space, and the case {scene.spatial_because}; "
                "assembly runs it"
            )
        if scene.assembly and cls.drums and scene.no_column:
            return (
                f"{cls.name} runs an [assembly] that is a column of equal drums with dry joints, "
                f"and {scene.no_column}; assembly and dem run it"
            )
        if scene.assembly and not (cls.assemblies or cls.drums):
            return (
                f"{cls.name} runs no assemblies, and the case has an [assembly]; assembly and dem "
                "run it"
            )
        if scene.beyond_the_plane and not cls.spatial and not scene.assembly:
            return scene.beyond_the_plane
        place = "in space" if scene.spatial else "in the plane"
        if scene.bodies and not cls.bodies[scene.spatial]:
            where = f" {place}" if any(cls.bodies) else ""
            return f"{cls.name} runs boxes alone{where}, and the case has a body (block.base)"
        if scene.held and not cls.holds:
            tables = " and ".join(scene.held)
            able = "housner and event run it"
            if not set(scene.held) <= set(HELD_IN_PLACE):
                able = "housner runs it"
            return (
                f"{cls.name} runs free-standing blocks, and the case holds its block ({tables}); "
                f"{able}"
            )
        if scene.rounded and not cls.rounded:
            return f"{cls.name} has sharp corners, and the case rounds them (block.corner_radius)"
        where = "space" if scene.spatial else "plane"
        if scene.vertical and ("stack" if scene.stacked else "block") not in cls.vertical:
            return cls._declines_vertical(scene)
        if scene.moving and where not in (
            cls.bodies_move if scene.on_points else cls.starts_moving
        ):
            pushed_up = "blocks whose base moves upwards" if scene.vertical else "blocks"
            what = "bodies" if scene.bodies else pushed_up
            return f"{cls.name} lets {what} go from rest {place}, and the case {scene.moving}"
        declined = cls.declines(scene)
        most = cls.highest[scene.spatial]
        if (
            declined is None
            and not (scene.assembly and cls.assemblies)
            and scene.block_count > most
        ):
            return (
                f"{cls.name} runs stacks of up to {most} blocks {place}, and the case has one of "
                f"{scene.block_count}; in the plane event runs up to {HIGHEST_STACK}, and assembly "
                "as many as a column of an [assembly] has"
            )
        if declined is None and scene.bodies and scene.stacked and not cls.stacked_bodies:
            declined = f"{cls.name} stacks boxes alone, and the case has a body in a stack"
        if declined is None and cls.restitution is not None and scene.restitution_given:
            return (
                f"{cls.name} {cls.restitution} and cannot follow the prescribed "
                "contact.angular_restitution"
            )
        return declined

    @classmethod
    def _declines_vertical(cls, scene: SceneKind) -> str:
        """Why it does not run a base that moves upwards in the plane, and what else can be done."""
        if cls.vertical:
            return (
                f"{cls.name} follows motion.z in the plane under single blocks, and the case has a "
                "stack"
            )
        cure = ' (model = "spatial")' if cls.spatial and not scene.bodies else ""
        where = f"; it does in space{cure}" if cls.spatial else ""
        return f"{cls.name} follows a base that moves along x in the plane, not motion.z{where}"

    @classmethod
    def declines(cls, scene: SceneKind) -> str | None:
        """Why its model is not for a scene, besides what its attributes say; None if it is."""
        return None

    def refuses(self, scene: SceneKind) -> str | None:
        """Why its settings are not for a scene that the engine supports; None if they are."""
        return None

    def longest_step(self, lanes: Lanes, motions: GroundMotions) -> npt.NDArray[np.float64]:
        """Longest step that every lane may take [s], shape [lane], of an engine with an order."""
        return np.full(lanes.lane_count, self.settings.time_step)

    def step_of_settings(self, lanes: Lanes, motions: GroundMotions) -> float:
        """Longest step that the settings ask for [s]; a lane may take shorter ones."""
        return float(self.settings.time_step)

    def reserve(self, lanes: Lanes) -> tuple[npt.NDArray[np.float64], str] | None:
        """Safety ratio (available / required), above 1; None if not applicable.

        Args:
            lanes: The lanes.

        Returns:
            The ratio, shape [lane], and what it is.
        """
        return None

    def lane_bytes(self, lanes: Lanes, motions: GroundMotions) -> int:
        """Memory that a lane takes while it runs [bytes], where chunks must heed it; else 0."""
        return 0

    def shares(self, lanes: Lanes) -> bool:
        """Whether several threads run one lane, so that lanes run one after another."""
        return False

    def alike_order(self, lanes: Lanes, motions: GroundMotions) -> npt.NDArray[np.intp] | None:
        """Order in which lanes of about the same cost lie side by side; None to leave them.

        Lanes of a pack wait for one another. The result of a lane does not depend on its place.
        """
        return None

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads what lanes and motions need, once, on the calling thread."""
        return

    @abc.abstractmethod
    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread.

        Args:
            lanes: Blocks and starts, shape [lane].
            motions: Ground motions of the same lanes.
            times: Duration and sampling.

        Returns:
            One value of every lane field a lane; `rotation` if histories were asked for. See
            `decoding.respond`.
        """


@dataclasses.dataclass(frozen=True)
class KernelEngine(AbstractEngine):
    """An engine whose scheme is a file of kernels in `kernels/`: what they share."""

    def kernel_lanes(self, lanes: Lanes, motions: GroundMotions) -> Lanes:
        """Lanes as its kernels take them: boxes are bodies where the base moves upwards, too.

        Most kernels of single boxes do not know such a base. Columns of an assembly are stacks.
        """
        if self.drums and lanes.assembly is not None:
            return as_stacks_of_drums(lanes)
        if isinstance(motions, UprightMotions) and lanes.body is None and not lanes.stacked:
            return dataclasses.replace(lanes, body=box_bodies(lanes))
        return lanes

    @abc.abstractmethod
    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene, or the lanes of one, with these settings and this target.

        `warm_up` and `run` ask here, and so does `warprock explain`.
        """

    def kernel_note(self, scene: SceneKind) -> str:
        """What is to be said of that kernel, or of another that runs some lanes; empty if none."""
        return ""

    def module_of(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        """The instance of that kernel's file for lanes and motions."""
        kernel = self.kernel_of(lanes)
        module: ModuleType = kernel_module(
            kernel.file,
            precision=self.target.precision,
            motion=motions.kind.value,
            iterations=kernel.iterations,
            blocks=lanes.block_count,
            lanes=kernel.lanes,
            friction=kernel.friction,
            points=kernel.points,
            vertical=isinstance(motions, UprightMotions),
            chains=lanes.profiles is not None,
            prescribed=lanes.restitution_given,
            thrown=kernel.thrown,
            bounces=kernel.bounces,
        )
        return module

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels for lanes and motions, once, on the calling thread."""
        import warp as wp

        module = self.module_of(self.kernel_lanes(lanes, motions), motions)
        wp.load_module(module.__name__, device=self.target.device)

    @abc.abstractmethod
    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes, by the names of its arguments; see `launching.launch`.

        Args:
            module: Its instance.
            lanes: Blocks and starts, shape [lane].
            motions: Ground motions of the same lanes.
            times: Duration and sampling.
        """

    @abc.abstractmethod
    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> Mapping[str, npt.NDArray[Any]]:
        """The lane fields of a response, from the results of the kernel.

        Returns:
            Shape [lane]; [lane, block] where they belong to blocks, single ones too.
        """

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread.

        Args:
            lanes: Blocks and starts, shape [lane].
            motions: Ground motions of the same lanes.
            times: Duration and sampling.

        Returns:
            One value of every lane field a lane; `rotation` if histories were asked for.
        """
        seen = self.kernel_lanes(lanes, motions)
        module = self.module_of(seen, motions)
        inputs = self.inputs(module, seen, motions, times)
        of_column = lanes.assembly is not None
        if of_column:
            end_at_collapse(lanes, inputs["lanes"])
        found = launch(module, self.target, motions, times, **inputs)
        found = found.above_ground(seen.block_count)
        fields = dict(self.fields(seen, motions, times, found))
        if found.sides is not None and lanes.bodies:
            fields |= side_fields(found.sides, fields["peak_rotation"].reshape(lanes.lane_count))
        fields |= histories(
            seen if of_column else lanes, found, times, above_rigid=self.above_rigid
        )
        if of_column:
            fields = column_fields(lanes, motions, found, fields)
        return respond(self.name, lanes, fields, times)
