"""The oracle of two stacked blocks against routes that share no formula with it.

The oracle takes everything from one Jacobian. Here stand the closed equations of motion, angular
momentum from finite velocities, the single-block oracle in the limits where the stack is one
block, and a time-stepping contact model that knows corners and no patterns.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import make_lanes, sines, velocity_steps
from tests.shared.corner_stepper import stepped_peaks
from tests.shared.marks import first
from tests.shared.two_block_motion import closed_form
from warprock.model.motion import Control, GroundMotions, Segment, StillBase
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.oracle.block import rock
from warprock.oracle.pair import TwoBlockResponse, rock_two_blocks
from warprock.oracle.pair_mechanics import (
    REST,
    Pattern,
    StackMechanics,
    TwoBlocks,
    opening,
)
from warprock.oracle.pair_swings import StackOutcome
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

PAIR = TwoBlocks(width=(0.2, 0.15), height=(0.6, 0.6), density=(128.16 / 0.12, 132.165 / 0.09))
"""Masses of 128.16 kg and 132.165 kg."""
CHAMFERED = TwoBlocks(width=(0.2, 0.15), height=(0.6, 0.6), chamfer=(0.005, 0.005))
HEAVY_BASE = TwoBlocks(width=(50.0, 0.15), height=(0.02, 0.6), density=(1e6, 1e3))
"""A lower block that nothing moves, a velocity step of the base by 1e-12 rad."""
PULSES = [(4.0, 4.0), (4.0, 5.0), (5.0, 3.0), (5.0, 4.0), (6.5, 2.0)]
"""Frequencies [Hz] and amplitudes [mm] of displacement whose accelerations lift the stack."""
SENSITIVE = (4.0, 4.0)
"""The pulse after which the upper block's peak hangs on the last digits of the input."""


def still(_time: float) -> float:
    return 0.0


def pushed(acceleration: float) -> list[Segment]:
    return [Segment(0.0, math.inf, 0.0, lambda _time: acceleration)]


def pulse(frequency: float, millimetres: float, factor: float = 1.0) -> list[Segment]:
    amplitude = factor * 1e-3 * millimetres * (2.0 * math.pi * frequency) ** 2
    return sines(Control.ACCELERATION, amplitude, frequency, 1.0).segments(0)


def random_blocks(rng: np.random.Generator) -> TwoBlocks:
    """From slabs to columns, light to heavy."""
    sizes = [tuple(rng.uniform(*bounds, 2)) for bounds in ((0.1, 0.6), (0.1, 1.0), (0.1, 1.0))]
    return TwoBlocks(*sizes, tuple(rng.uniform(500, 3000, 2)), tuple(rng.uniform(0, 0.02, 2)))


def test_the_known_accelerations() -> None:
    state = np.array((0.05, 0.12)), np.array((0.3, -0.4))
    found, _ = StackMechanics(PAIR).accelerations(Pattern(1, 1), *state, 1.5)
    np.testing.assert_allclose(found, (-4.00917638, -0.77064208), atol=5e-9)


def test_the_known_impact() -> None:
    choice = StackMechanics(PAIR).after_impulse(
        Pattern(1, 1), np.array((0.0, 0.1)), np.array((-0.5, 0.3)), (True, False)
    )
    assert choice.pattern == Pattern(-1, 1)
    np.testing.assert_allclose(choice.motion, (-0.37983683, 0.09930024), atol=5e-9)


def random_state(rng: np.random.Generator, pattern: Pattern) -> tuple[Array, Array]:
    """Rotations and rates that a pattern allows."""
    first = pattern.ground * rng.uniform(0, 0.3)
    rotation = np.array((first, first + pattern.interface * rng.uniform(0, 0.3)))
    rate = rng.uniform(-2, 2, 2)
    rate[0] = 0.0 if pattern.ground == 0 else rate[0]
    rate[1] = rate[0] if pattern.interface == 0 else rate[1]
    return rotation, rate


MOVING = [Pattern(*p) for p in itertools.product((-1, 0, 1), repeat=2) if p != (0, 0)]


@pytest.mark.parametrize("pattern", MOVING)
def test_the_jacobian_gives_the_equations_written_out(pattern: Pattern) -> None:
    rng = np.random.default_rng(3)
    for _ in range(100):
        blocks = random_blocks(rng)
        rotation, rate = random_state(rng, pattern)
        base = rng.uniform(-20, 20)
        found, _ = StackMechanics(blocks).accelerations(pattern, rotation, rate, base)
        wanted = closed_form(blocks, pattern, rotation, rate, base)
        # Round-off: two sums of about ten terms of 100 rad/s^2.
        np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("pattern", MOVING)
def test_energy_is_constant_along_every_pattern(pattern: Pattern) -> None:
    rng = np.random.default_rng(4)
    step = 1e-4
    for _ in range(20):
        mechanics = StackMechanics(random_blocks(rng))
        rotation, rate = random_state(rng, pattern)
        bend, _ = mechanics.accelerations(pattern, rotation, rate, 0.0)

        def energy(time: float) -> float:
            place = rotation + time * rate + 0.5 * time**2 * bend  # noqa: B023
            speed = rate + time * bend  # noqa: B023
            kinetic = mechanics.kinetic_energy(pattern, place, speed)  # noqa: B023
            return kinetic + mechanics.potential_energy(pattern, place)  # noqa: B023

        power = (energy(step) - energy(-step)) / (2.0 * step)
        scale = mechanics.kinetic_energy(pattern, rotation, rate) + abs(energy(0.0))
        # The central difference errs by step^2 times rates of 10 to 100 /s, cubed.
        assert abs(power) <= 1e-3 * scale


def touching_states(
    rng: np.random.Generator,
) -> list[tuple[Pattern, Array, Array, tuple[bool, bool]]]:
    """One state before an impact of each of the four kinds."""
    (s1, s2), (first, second) = rng.choice([-1, 1], 2).tolist(), rng.uniform(0, 0.3, 2)
    (down, shut), free = rng.uniform(0.01, 2, 2), rng.uniform(-2, 2)
    return [
        (
            Pattern(s1, s2),
            np.array((0.0, s2 * second)),
            np.array((-s1 * down, free)),
            (True, False),
        ),
        (
            Pattern(s1, s2),
            np.full(2, s1 * first),
            np.array((free, free - s2 * shut)),
            (False, True),
        ),
        (Pattern(0, s2), np.zeros(2), np.array((0.0, -s2 * shut)), (True, True)),
        (Pattern(s1, 0), np.zeros(2), np.full(2, -s1 * down), (True, True)),
    ]


def centres(blocks: TwoBlocks, pattern: Pattern, rotation: npt.NDArray[np.complex128]) -> list:
    """Interface pivot and both centres as complex numbers x + j z would be, in two parts each."""
    b, c = blocks.ground_half_width, blocks.interface_half_width

    def turned(x: float, z: float, angle: np.complex128) -> npt.NDArray[np.complex128]:
        cos, sin = np.cos(angle), np.sin(angle)
        return np.array((x * cos + z * sin, z * cos - x * sin))

    foot = np.array((pattern.ground * b, 0.0))
    height = blocks.height[0]
    low = foot + turned(-foot[0], 0.5 * height, rotation[0])
    pivot = foot + turned(pattern.interface * c - foot[0], height, rotation[0])
    high = pivot + turned(-pattern.interface * c, 0.5 * blocks.height[1], rotation[1])
    return [foot, pivot, low, high]


def momenta(
    blocks: TwoBlocks, before: Pattern, after: Pattern, rotation: Array, rate: Array
) -> tuple[float, float]:
    """Angular momentum, clockwise, of the whole about the new foot and of the upper block about
    the new pivot. Velocities of the pattern before by a complex step, exact to round-off."""
    step = 1e-30
    moved = centres(blocks, before, rotation + 1j * step * rate)
    foot, pivot, low, high = (
        np.real(p) for p in centres(blocks, after, rotation.astype(np.complex128))
    )
    spins = []
    for k, (place, about) in enumerate(((low, foot), (high, foot), (high, pivot))):
        block = min(k, 1)
        velocity = np.imag(moved[2 + block]) / step
        mass = blocks.mass[block]
        inertia = mass * (blocks.width[block] ** 2 + blocks.height[block] ** 2) / 12.0
        arm = place - about
        spins.append(inertia * rate[block] + mass * (arm[1] * velocity[0] - arm[0] * velocity[1]))
    return float(spins[0] + spins[1]), float(spins[2])


def test_impacts_keep_the_angular_momenta_of_what_pivots() -> None:
    rng = np.random.default_rng(5)
    for _ in range(100):
        blocks = random_blocks(rng)
        for before, rotation, rate, closed in touching_states(rng):
            after = StackMechanics(blocks).after_impulse(before, rotation, rate, closed)
            if after.pattern == REST:
                continue
            old = momenta(blocks, before, after.pattern, rotation, rate)
            new = momenta(blocks, after.pattern, after.pattern, rotation, after.motion)
            size = 1e-12 * (abs(old[0]) + abs(old[1]) + 1.0)
            if after.pattern.ground != 0:
                assert abs(old[0] - new[0]) <= 100 * size
            if after.pattern.interface != 0:
                assert abs(old[1] - new[1]) <= 100 * size


def test_impacts_have_one_outcome_lose_energy_and_have_a_mirror_image() -> None:
    rng = np.random.default_rng(6)
    for _ in range(200):
        mechanics = StackMechanics(random_blocks(rng))
        for pattern, rotation, rate, closed in touching_states(rng):
            choice = mechanics.after_impulse(pattern, rotation, rate, closed)
            assert choice.admissible_count == 1
            opens = opening(choice.pattern, choice.motion)
            assert all(opens[k] > 0.0 for k in (0, 1) if closed[k] and choice.pattern[k])
            before = mechanics.kinetic_energy(pattern, rotation, rate)
            after = mechanics.kinetic_energy(choice.pattern, rotation, choice.motion)
            assert after <= before * (1.0 + 1e-13)
            mirrored = mechanics.after_impulse(
                Pattern(-pattern.ground, -pattern.interface), -rotation, -rate, closed
            )
            assert mirrored.pattern == (-choice.pattern.ground, -choice.pattern.interface)
            np.testing.assert_allclose(mirrored.motion, -choice.motion, rtol=1e-12, atol=1e-15)


def test_a_velocity_step_of_the_base_lifts_a_flat_stack() -> None:
    # Friction carries the base along; nothing flat can take the moment of an impulse.
    rng = np.random.default_rng(7)
    for _ in range(200):
        mechanics = StackMechanics(random_blocks(rng))
        step = rng.uniform(-1, 1)
        choice = mechanics.after_impulse(REST, np.zeros(2), np.zeros(2), (True, True), step)
        assert choice.admissible_count == 1
        assert choice.pattern != REST


def usable(found: TwoBlockResponse) -> TwoBlockResponse:
    assert found.status == Status.OK
    assert found.odd_choice_count == 0
    assert np.all(np.isfinite(found.rotation))
    return found


@pytest.mark.thorough
@pytest.mark.parametrize(
    "start",
    [
        (0.01, 0.01),
        pytest.param((0.03, -0.05), marks=pytest.mark.thorough),
    ],
)
def test_the_energy_lost_is_what_a_released_stack_had(start: tuple[float, float]) -> None:
    mechanics = StackMechanics(CHAMFERED)
    found = usable(
        rock_two_blocks(
            CHAMFERED, StillBase(1).segments(0), SampleTimes(12.0), rotation_start=start
        )
    )
    assert found.outcome == StackOutcome.AT_REST
    pattern = Pattern(int(np.sign(start[0])), int(np.sign(start[1] - start[0])))
    had = mechanics.potential_energy(pattern, np.array(start))
    had -= mechanics.potential_energy(REST, np.zeros(2))
    # A thousand swings, each integrated to 1e-11, and gravity's round-off on 10 N m.
    np.testing.assert_allclose(found.energy_lost, had, rtol=1e-8)
    assert np.all(found.rotation[:, -1] == 0.0)


def assert_is_one_block(
    found: Array, motions: GroundMotions, times: SampleTimes, size: tuple[float, float], atol: float
) -> None:
    """The rotations of a run are those of a single block of a width and a height [m]."""
    start = float(found[0])
    lanes = make_lanes(size[0], size[1], start / math.atan2(*size))
    single = rock(lanes, motions, 0, times)
    np.testing.assert_allclose(found, single.rotation, rtol=0.0, atol=atol)
    assert np.abs(single.rotation).max() > 0.01


LIMIT_TIMES = SampleTimes(1.5, 0.01)
DRIVEN = [
    sines(Control.ACCELERATION, 5.0, 3.0, 2.0),
    # Velocity steps of 0.2 m/s at the start and at the end.
    sines(Control.DISPLACEMENT, 0.2 / (6.0 * math.pi), 3.0, 1.0),
]


# A velocity step of 0.4 m/s from rest: a step that pulls at a tilted stack would part it.
ONE_STEP = velocity_steps(np.array([0.4]), np.zeros(1), np.ones(1))


@pytest.mark.parametrize("motions", first(1, [DRIVEN[0], StillBase(1), ONE_STEP]))
def test_a_glued_stack_is_one_block(motions: GroundMotions) -> None:
    blocks = TwoBlocks(width=(0.3, 0.3), height=(1.05, 0.05))
    angle = 0.1 if isinstance(motions, StillBase) else 0.0
    found = usable(
        rock_two_blocks(blocks, motions.segments(0), LIMIT_TIMES, rotation_start=(angle, angle))
    )
    assert not found.patterns[:, 1].any()
    np.testing.assert_array_equal(found.rotation[0], found.rotation[1])
    assert_is_one_block(found.rotation[0], motions, LIMIT_TIMES, (0.3, 1.1), 1e-9)


@pytest.mark.parametrize("motions", first(1, [*DRIVEN[::-1], StillBase(1)]))
def test_a_thin_plate_on_top_does_not_count(motions: GroundMotions) -> None:
    blocks = TwoBlocks(width=(0.3, 0.3), height=(1.0, 1e-7))
    angle = 0.1 if isinstance(motions, StillBase) else 0.0
    found = usable(
        rock_two_blocks(blocks, motions.segments(0), LIMIT_TIMES, rotation_start=(angle, angle))
    )
    # The plate has 1e-7 of the mass, at the top; a few impacts make 1e-5 of it.
    assert_is_one_block(found.rotation[0], motions, LIMIT_TIMES, (0.3, 1.0), 2e-6)


@pytest.mark.parametrize("motions", first(1, [*DRIVEN[::-1], StillBase(1)]))
def test_a_block_on_a_heavy_squat_one_is_alone(motions: GroundMotions) -> None:
    angle = 0.1 if isinstance(motions, StillBase) else 0.0
    found = usable(
        rock_two_blocks(HEAVY_BASE, motions.segments(0), LIMIT_TIMES, rotation_start=(0.0, angle))
    )
    assert found.peak_rotation[0] <= 1e-11
    assert_is_one_block(found.rotation[1], motions, LIMIT_TIMES, (0.15, 0.6), 1e-9)


def test_the_upper_block_falls_like_a_single_one() -> None:
    motions = sines(Control.ACCELERATION, 8.0, 1.0, 1.0)
    found = usable(rock_two_blocks(HEAVY_BASE, motions.segments(0), LIMIT_TIMES))
    single = rock(make_lanes(0.15, 0.6), motions, 0, LIMIT_TIMES)
    assert single.outcome == Outcome.OVERTURNED
    assert found.outcome == StackOutcome.UPPER_OVERTURNED
    np.testing.assert_allclose(found.peak_rotation, (0.0, 0.5 * math.pi), atol=1e-9)
    np.testing.assert_allclose(found.peak_time[1], single.peak_time, atol=1e-8)


@pytest.mark.parametrize("side", [1, -1])
def test_the_accelerations_that_lift(side: int) -> None:
    (m1, m2), (h1, h2) = CHAMFERED.mass, (0.5 * h for h in CHAMFERED.height)
    stack = CHAMFERED.ground_half_width * (m1 + m2) / (m1 * h1 + m2 * (2 * h1 + h2))
    for blocks, ratio, lifted in (
        (CHAMFERED, stack, (-side, 0)),
        (HEAVY_BASE, 0.25, (0, -side)),
    ):
        for factor, last in ((1.0 - 1e-9, REST), (1.0 + 1e-9, lifted)):
            base = side * factor * ratio * GRAVITY
            found = usable(rock_two_blocks(blocks, pushed(base), SampleTimes(0.02)))
            assert tuple(found.patterns[-1]) == last


def test_a_ramp_lifts_when_it_passes_the_threshold() -> None:
    ramp = [Segment(0.0, math.inf, 0.0, lambda time: 5.0 * time)]
    found = usable(rock_two_blocks(HEAVY_BASE, ramp, SampleTimes(0.6)))
    # The transition is overstepped by a nanosecond.
    assert found.pattern_times[1] == pytest.approx(0.25 * GRAVITY / 5.0, abs=1.1e-9)


def test_mirrored_motion_mirrors_the_answer() -> None:
    times = SampleTimes(0.6, 0.01)
    found = rock_two_blocks(CHAMFERED, pulse(4.0, 5.0), times)
    mirrored = rock_two_blocks(CHAMFERED, pulse(4.0, 5.0, -1.0), times)
    np.testing.assert_allclose(mirrored.rotation, -found.rotation, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(mirrored.patterns, -found.patterns)
    np.testing.assert_allclose(mirrored.energy_lost, found.energy_lost, rtol=1e-12)


@pytest.mark.thorough
def test_the_longest_step_does_not_matter() -> None:
    times = SampleTimes(1.0, 0.01)
    found = rock_two_blocks(CHAMFERED, pulse(4.0, 5.0), times)
    finer = rock_two_blocks(CHAMFERED, pulse(4.0, 5.0), times, longest_step=0.002, rtol=1e-12)
    # Ten impacts multiply what the integrator leaves, 1e-12, by some thousands.
    np.testing.assert_allclose(found.rotation, finer.rotation, rtol=0.0, atol=1e-8)
    np.testing.assert_array_equal(found.patterns, finer.patterns)


@pytest.mark.parametrize(
    ("frequency", "millimetres"),
    [
        PULSES[1],
        *(pytest.param(*each, marks=pytest.mark.thorough) for each in PULSES if each != PULSES[1]),
    ],
)
def test_pulses_agree_with_corners_in_small_steps(frequency: float, millimetres: float) -> None:
    motion = pulse(frequency, millimetres)
    found = usable(rock_two_blocks(CHAMFERED, motion, SampleTimes(1.0)))
    stepped = stepped_peaks(CHAMFERED, motion[0], 1.0, 1e-4)
    # First order: impacts come up to 1e-4 s late, of swings that last 10 ms and more.
    assert found.peak_rotation[0] == pytest.approx(stepped[0], rel=0.02)
    if (frequency, millimetres) == SENSITIVE:
        # Two impacts 0.8 ms apart; the next test shows what they do to the upper block.
        assert found.peak_rotation[1] == pytest.approx(stepped[1], rel=0.2)
    else:
        assert found.peak_rotation[1] == pytest.approx(stepped[1], rel=0.01)


@pytest.mark.thorough
def test_one_pulse_is_sensitive() -> None:
    # Three parts in a thousand of the amplitude are fifty of the upper block's peak.
    peaks = [
        rock_two_blocks(CHAMFERED, pulse(*SENSITIVE, factor), SampleTimes(1.0)).peak_rotation
        for factor in (1.0, 0.997, 0.999, 1.003)
    ]
    lower, upper = (np.array(peaks)[:, k] / peaks[0][k] for k in (0, 1))
    assert np.ptp(lower) < 0.05
    assert np.ptp(upper) > 0.3


@pytest.mark.parametrize(
    ("key", "value"), [("width", (0.2, 0.0)), ("height", (math.nan, 1.0)), ("chamfer", (0.1, 0.0))]
)
def test_impossible_blocks_are_refused(key: str, value: tuple[float, float]) -> None:
    sizes = {"width": (0.2, 0.15), "height": (0.6, 0.6)} | {key: value}
    with pytest.raises(ValueError, match=key):
        TwoBlocks(**sizes)
