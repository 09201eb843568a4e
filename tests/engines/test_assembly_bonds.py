"""Bonded joints of assemblies: when they tear and slide, in closed form, and what they leave."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.assemblies import assembly_lanes, pushes
from warprock.engines import engine_class
from warprock.model import patterns
from warprock.model.assembly import Assembly as Laid
from warprock.model.assembly import Piece, assemble
from warprock.model.response import JointState, Outcome, Response, SampleTimes, Status
from warprock.model.scene import scene_kind
from warprock.running.batch import run_batch
from warprock.settings.engines import AssemblySettings
from warprock.units import GRAVITY

pytestmark = pytest.mark.usefixtures("two_rooms")

DENSITY, DEPTH, FRICTION = 2000.0, 1.0, 0.5
CLOSE = 0.002
"""Part of a strength below and above which a joint holds and breaks: forces are solved to a
hundred thousandth of the weight."""


def bonded(
    free: tuple[float, float, float, float],
    *fixed: tuple[float, float, float, float],
    **bond: float,
) -> Laid:
    """A box [left, bottom, right, top] that can move, and others."""
    pieces = [Piece("block", patterns.rectangle(*free))]
    pieces += [Piece(str(k), patterns.rectangle(*box), fixed=True) for k, box in enumerate(fixed)]
    return assemble(pieces, depth=DEPTH, density=DENSITY, friction=FRICTION, **bond)


def run(kinds: list[Laid], loads: list[float], end: float) -> Response:
    """Loads rise for 0.5 s."""
    motions = pushes(loads, 0.5, end)
    asked = AssemblySettings(settled=1e-5)
    return run_batch("assembly", assembly_lanes(kinds), motions, SampleTimes(end), settings=asked)


def hanging(eccentricity: float, tension: float) -> Laid:
    """A block of 0.4 by 0.5 m high above a plinth, by a joint 0.2 m long to one above it."""
    above = (0.1 - eccentricity, 0.5, 0.3 - eccentricity, 0.7)
    plinth = (-0.2, -3.0, 0.6, -2.0)
    return bonded((0.0, 0.0, 0.4, 0.5), above, plinth, tension=tension, cohesion=1e9)


@pytest.mark.thorough
def test_a_block_that_hangs_tears_off_by_the_stress_at_the_edge():
    """N = f_t A / (1 + 6 e / d): what hangs at a distance e from the middle of the joint."""
    weight, area, length = DENSITY * 0.2 * GRAVITY, 0.2 * DEPTH, 0.2
    kinds = []
    for eccentricity in (0.0, 0.05, 0.1):
        strength = weight / area * (1.0 + 6.0 * eccentricity / length)
        kinds += [hanging(eccentricity, part * strength) for part in (1.0 + CLOSE, 1.0 - CLOSE)]
    found = run(kinds, [0.0] * 6, 0.2)
    assert found["broken_joints"].tolist() == [0, 1] * 3
    assert np.isnan(found["joint_break_time"][::2]).all()
    assert (found["joint_break_time"][1::2] < 0.01).all()
    # What has torn off falls freely, and has fallen once it is lower by half of the joint: it
    # tears in one step of 1 ms, and is seen to have fallen in another.
    fall = np.sqrt(2.0 * 0.5 * length / GRAVITY)
    assert found["collapse_time"][1::2] == pytest.approx(fall, abs=0.002)
    # The others hang: solves leave 1e-5 of what g does in a step, in each of 200 steps.
    left = 1e-5 * GRAVITY * 1e-3
    assert (found["peak_displacement"][::2] < 200 * 1e-3 * left).all()
    assert (found["joint_state"][1::2, 0] & JointState.BROKEN).all()


def standing(cohesion: float, tension: float = 1e9) -> Laid:
    """A block of 0.4 by 0.2 m on the ground."""
    ground = (-1.0, -0.1, 1.4, 0.0)
    return bonded((0.0, 0.0, 0.4, 0.2), ground, tension=tension, cohesion=cohesion)


@pytest.mark.thorough
def test_a_block_slides_at_cohesion_and_friction_and_tips_at_its_tension():
    """Sideways at c A + friction N; over its edge where the weight and the load pull f_t there."""
    weight, area = DENSITY * 0.08 * GRAVITY, 0.4 * DEPTH
    cohesion, load = 2000.0, 0.8
    slides = (cohesion * area + FRICTION * weight) / weight
    # Stress at the edge under a load at half height: -N / A + 6 (load N h / 2) / (A d).
    tension = (-1.0 + 6.0 * load * 0.1 / 0.4) * weight / area
    kinds = [standing(cohesion)] * 2
    kinds += [standing(1e9, tension * part) for part in (1.0 + CLOSE, 1.0 - CLOSE)]
    found = run(kinds, [slides * (1.0 - CLOSE), slides * (1.0 + CLOSE), load, load], 0.7)
    assert found["broken_joints"].tolist() == [0, 1, 0, 1]
    assert found["status"].tolist() == [Status.OK] * 4
    # The load rises to CLOSE above what breaks them within 0.5 s; a step is 1 ms.
    early = 0.5 * CLOSE + 1e-3
    assert found["joint_break_time"][[1, 3]] == pytest.approx([0.5, 0.5], abs=early)
    # A joint that has broken is dry: there the block slides on at friction alone.
    assert found["slid_joints"].tolist() == [0, 1, 0, 1]
    way = 0.5 * GRAVITY * (slides - FRICTION) * 0.2**2
    # The way goes with the square of the time of 0.2 s that it slides.
    assert found["peak_slide"][1] == pytest.approx(way, rel=2.0 * early / 0.2)


@pytest.mark.thorough
def test_a_bonded_column_stands_where_a_dry_one_falls_until_its_lowest_joint_tears():
    """Four drums, 0.4 m wide and 1.2 m high: dry they fall at 1 / 3 of their weight sideways."""
    width, height, tension = 0.4, 1.2, 1e5
    weight, area = DENSITY * width * height * GRAVITY, width * DEPTH
    tears = (tension * area / weight + 1.0) * width / (3.0 * height)
    kinds = [
        assemble(
            patterns.column(width, height / 4, 4), depth=DEPTH, density=DENSITY,
            friction=1.0, tension=tension, cohesion=1e9,
        )
    ] * 2  # fmt: skip
    found = run(kinds, [tears * (1.0 - CLOSE), tears * (1.0 + CLOSE)], 1.5)
    assert found["status"].tolist() == [Status.OK] * 2
    assert found["outcome"].tolist() == [Outcome.AT_REST, Outcome.OVERTURNED]
    assert found["broken_joints"].tolist() == [0, 1]
    both = JointState.OPENED | JointState.BROKEN
    assert found["joint_state"][1, 0] & both == both
    assert not found["joint_state"][1, 1:].any()
    assert found["joint_break_time"][1] < found["collapse_time"][1]
    assert found["energy_lost"][1] > -1e-6 * weight


def test_dem_takes_bonds_from_its_settings():
    lanes = assembly_lanes([standing(1e3)])
    scene = scene_kind(lanes, pushes([0.1], 0.5, 1.0), restitution_given=False)
    assert "engines.dem.tensile_strength" in str(engine_class("dem").supports(scene))
