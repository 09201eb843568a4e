"""Contacts of assemblies that no joint declares: impacts, falls, and the heap after a collapse."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.assemblies import assembly_lanes, built, pushes
from warprock.engines.assembly import Assembly
from warprock.engines.launching import Form, Target
from warprock.model import patterns
from warprock.model.assembly import Assembly as Laid
from warprock.model.assembly import Piece
from warprock.model.motion import PlanarMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status, take_lanes
from warprock.running.batch import run_batch
from warprock.settings.engines import AssemblySettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

pytestmark = pytest.mark.usefixtures("two_rooms")

ON = 100.0
"""A lane goes on after its collapse to the end of its run [s]."""

SUNK = 4e-3
"""How deep blocks of a heap may lie in one another, over the half diagonal of the smallest one: an
edge that has less beside another one is no contact, and what steps have let in stays."""


def run(
    kinds: list[Laid], motions: PlanarMotions, end: float, interval: float, **settings: Any
) -> Response:
    asked = AssemblySettings(after_collapse=ON, **settings)
    times = SampleTimes(end, interval, places=True)
    return run_batch("assembly", assembly_lanes(kinds), motions, times, settings=asked)


def outlines(kind: Laid, found: Response, lane: int) -> list[Array]:
    """Corners of the blocks at the end of a run, those that can move first [m]."""
    free, fixed = np.flatnonzero(~kind.fixed), np.flatnonzero(kind.fixed)
    polygons = []
    for place, block in enumerate(free):
        turn = -found["turn"][lane, place, -1]
        c, s = np.cos(turn), np.sin(turn)
        arm = kind.corners[block] - kind.centre[block]
        centre = [found[name][lane, place, -1] for name in ("x", "z")]
        polygons.append(arm @ np.array([[c, s], [-s, c]]) + centre)
    return polygons + [kind.corners[block] for block in fixed]


def depth(one: Array, other: Array) -> float:
    """How deep a convex polygon lies in another one, by separating axes; negative apart [m]."""
    apart = -np.inf
    for first, second in ((one, other), (other, one)):
        along = np.roll(first, -1, axis=0) - first
        length = np.hypot(*along.T)
        outward = np.stack([along[:, 1], -along[:, 0]], axis=1)[length > 0.0]
        outward /= length[length > 0.0, None]
        beyond = second[None] - first[length > 0.0][:, None]
        apart = max(apart, float((beyond * outward[:, None]).sum(axis=2).min(axis=1).max()))
    return -apart


def may_sink(kind: Laid) -> float:
    """How deep its blocks may lie in one another [m]."""
    arm = (kind.corners - kind.centre[:, None])[~kind.fixed]
    return SUNK * float(np.hypot(arm[..., 0], arm[..., 1]).max(axis=1).min())


def deepest(kind: Laid, found: Response, lane: int) -> float:
    """The deepest of any pair of blocks, and of any block in the ground [m]."""
    polygons = outlines(kind, found, lane)
    pairs = [depth(a, b) for k, a in enumerate(polygons) for b in polygons[:k]]
    free = polygons[: int((~kind.fixed).sum())]
    return max(*pairs, kind.ground - min(float(each[:, 1].min()) for each in free))


def speed(found: Response, lane: int) -> float:
    """The fastest centre between the last two samples [m/s]."""
    way = [np.diff(found[name][lane, :, -2:])[:, 0] for name in ("x", "z")]
    return float(np.hypot(*way).max() / np.diff(found.times[-2:])[0])


GROUND = Piece("ground", patterns.rectangle(-9.0, -0.1, 9.0, 0.0), fixed=True)


def boxes(*corners: tuple[float, float, float, float], friction: float) -> Laid:
    """Boxes [left, bottom, right, top] on the ground."""
    return built(
        [GROUND, *(Piece(str(k), patterns.rectangle(*box)) for k, box in enumerate(corners))],
        friction,
    )


def side_by_side(sign: float) -> Laid:
    """Two blocks 0.1 m apart, the first twice as long and free to slide; others far from them.

    Of all scenes here the joints and blocks are so many that they share a kernel.
    """
    long, short = (0.0, 0.0, 0.8, 0.3), (0.9, 0.0, 1.3, 0.3)
    far = [(4.0 + k, 0.0, 4.5 + k, 0.3) for k in range(4)]
    placed = [(min(sign * a, sign * c), b, max(sign * a, sign * c), d) for a, b, c, d in
              (long, short, *far)]  # fmt: skip
    kind = boxes(*placed, friction=0.0)
    joints = dataclasses.replace(kind.joints, friction=np.array([0.0, 0.6] + 4 * [0.9]))
    return dataclasses.replace(kind, joints=joints)


def test_a_block_that_slides_into_another_shares_its_momentum():
    """A plastic impact from the side: v m / (m + M), with v from the way to it under a load."""
    load, gap, step = 0.4, 0.1, 1e-4
    kinds = [side_by_side(1.0), side_by_side(-1.0)]
    found = run(kinds, pushes([load, -load], 1e-3, 0.35), 0.35, step, time_step=step)
    came = np.sqrt(2.0 * load * GRAVITY * gap)
    for lane, sign in enumerate((1.0, -1.0)):
        velocity = sign * np.diff(found["x"][lane, :2]) / step
        hit = int(np.argmax(velocity[1] > 0.1))
        # The load rises in a millisecond, and acts for some steps about the impact.
        slack = 5.0 * load * GRAVITY * 1e-3
        assert velocity[0, hit - 2] == pytest.approx(came, abs=slack)
        together = velocity[:, hit + 2]
        assert together == pytest.approx(came * 2.0 / 3.0, abs=slack)
        # Then they go on together: friction holds a third of their weight by 0.6 of it.
        later = velocity[:, hit + 500]
        rate = GRAVITY * (load - 0.6 / 3.0)
        # Sweeps leave a thousandth of what a step does.
        assert later - together == pytest.approx(rate * 498.0 * step, rel=1e-3)
    # The mirrored lane has the mirrored motion, to what sweeps leave.
    there, back = (found["x"][lane] - found["x"][lane][:, :1] for lane in (0, 1))
    np.testing.assert_allclose(there, -back, atol=1e-6)
    assert found["status"].tolist() == [Status.OK] * 2


def thin_arch(thickness: float) -> Laid:
    """A semicircular arch of a radius of 2 m, too thin to stand: it needs 0.1 of its radius."""
    return built(patterns.arch(2.0, thickness, np.pi, 5), 0.6)


def row() -> Laid:
    """Blocks in a row on the ground, and a slender one on one of them that tips over."""
    low = [(0.5 * k, 0.0, 0.5 * k + 0.4, 0.2 + 0.05 * k) for k in range(5)]
    return boxes(*low, (1.1, 0.3, 1.3, 0.8), friction=0.9)


def heaps() -> tuple[list[Laid], PlanarMotions]:
    """Lanes of two sorts of joints that fall to pieces; the base of the first one is still."""
    kinds = [thin_arch(0.12), row(), thin_arch(0.1), row(), thin_arch(0.14)]
    return kinds, pushes([0.0, 0.6, 0.2, -0.6, -0.1], 0.1, 2.5)


def test_what_falls_lies_still_in_the_end_beside_and_on_others():
    """With a still base contacts took what the blocks lost of their height, to round-off."""
    kinds, motions = heaps()
    found = run(kinds, motions, 2.5, 0.1)
    assert found["status"].tolist() == [Status.OK] * 5
    assert found["outcome"].tolist() == [Outcome.OVERTURNED] * 5
    for lane, kind in enumerate(kinds):
        assert max(deepest(kind, found, lane), found["peak_penetration"][lane]) < may_sink(kind)
    # Under the load of the others the slender block tumbles on. What is slower than g makes it in a
    # tenth of a step lies still.
    for lane in (0, 2, 4):
        assert speed(found, lane) < 1e-3
        assert found["rest_time"][lane] < 2.5
    free = ~kinds[0].fixed
    drop = kinds[0].centre[free, 1] - found["z"][0, :5, -1]
    assert found["energy_lost"][0] == pytest.approx(GRAVITY * kinds[0].mass[free] @ drop, rel=1e-6)
    assert (found["energy_lost"] > 0.0).all()


@pytest.mark.thorough
def test_a_lane_that_falls_has_the_same_bits_alone_and_in_both_forms():
    kinds, motions = heaps()
    found = run(kinds, motions, 1.2, 0.1)
    assert (found["outcome"] == Outcome.OVERTURNED).sum() >= 3
    alone = run([kinds[1]], motions.take(np.array([1])), 1.2, 0.1)
    for name, values in take_lanes(found, np.array([1])).fields.items():
        np.testing.assert_array_equal(alone[name], values, err_msg=name)
    plain = Assembly(AssemblySettings(after_collapse=ON), Target(form=Form.PLAIN))
    apart = plain.run(assembly_lanes(kinds), motions, SampleTimes(1.2, 0.1, places=True))
    for name, values in found.fields.items():
        np.testing.assert_array_equal(apart[name], values, err_msg=name)


def stones(draw: np.random.Generator) -> Laid:
    """A dry-stone wall 2 m long, of courses and blocks of random sizes."""
    pieces = [Piece("ground", patterns.rectangle(0.0, -0.1, 2.0, 0.0), fixed=True)]
    low = 0.0
    for course in range(draw.integers(3, 6)):
        high = low + draw.uniform(0.12, 0.3)
        cuts = np.cumsum(draw.uniform(0.2, 0.6, 10))
        ends = [0.0, *cuts[cuts < 1.85].tolist(), 2.0]
        pieces += [
            Piece(f"{course}.{place}", patterns.rectangle(left, low, right, high))
            for place, (left, right) in enumerate(itertools.pairwise(ends))
        ]
        low = high
    return built(pieces, draw.uniform(0.3, 0.9))


@pytest.mark.thorough
def test_random_walls_that_are_shaken_down_have_an_answer_or_say_why():
    draw = np.random.default_rng(3)
    kinds = [stones(draw) for _ in range(8)]
    found = run(kinds, pushes(draw.uniform(0.3, 1.2, 8), 0.2, 2.0), 2.0, 0.5)
    assert np.isin(found["status"], [Status.OK, Status.ITERATION_LIMIT]).all()
    assert (found["status"] == Status.OK).sum() >= 7
    assert (found["outcome"] == Outcome.OVERTURNED).any()
    for lane in np.flatnonzero(found["status"] == Status.OK):
        assert deepest(kinds[lane], found, int(lane)) < may_sink(kinds[lane])
