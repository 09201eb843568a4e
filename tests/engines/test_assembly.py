"""Assemblies of many blocks, held to limit analysis, to other engines and to symmetries."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.assemblies import (
    NO_SLIDING,
    as_records,
    assembly_lanes,
    built,
    oppenheim,
    pushes,
    wall_1,
)
from tests.shared.blocks import make_lanes, make_stacks
from tests.shared.marks import first
from warprock.analysis.load_limit import collapse_load
from warprock.engines import ENGINES, engine_class
from warprock.engines.assembly import Assembly
from warprock.engines.assembly_packs import tree_of
from warprock.engines.launching import Form, Target
from warprock.model import patterns
from warprock.model.assembly import Assembly as Laid
from warprock.model.assembly import assemble
from warprock.model.hold import Frame, Hold
from warprock.model.motion import (
    Control,
    HarmonicMotions,
    PlanarMotions,
    StillBase,
    Waveform,
    harmonic_motions,
)
from warprock.model.response import (
    JointState,
    Outcome,
    Response,
    SampleTimes,
    Status,
    take_lanes,
)
from warprock.model.scene import scene_kind
from warprock.model.tilt import steady, tilt_motions
from warprock.running.batch import run_batch
from warprock.settings.engines import AssemblySettings
from warprock.units import GRAVITY

pytestmark = pytest.mark.usefixtures("two_rooms")

CREEP = 5e-5
"""Displacement of an assembly that stands, at .99 of its limit load, in 3 s after a rise of 1 s
[m]: what steps leave at the bound to which they are solved."""


def run(kinds: Laid | list[Laid], motions: PlanarMotions, end: float, **settings: Any) -> Response:
    kinds = kinds if isinstance(kinds, list) else [kinds] * motions.lane_count
    lanes = assembly_lanes(kinds)
    asked = AssemblySettings(**settings)
    return run_batch("assembly", lanes, motions, SampleTimes(end), settings=asked)


def drums(count: int) -> Laid:
    return built(patterns.column(1.0, 0.5, count), 0.7)


@pytest.mark.parametrize(
    ("kind", "load"),
    [
        (oppenheim(7), 0.3736),
        pytest.param(oppenheim(27), 0.3538, marks=pytest.mark.thorough),
        (drums(12), 1.0 / 6.0),
        pytest.param(drums(20), 0.1, marks=pytest.mark.thorough),
    ],
    ids=["7 voussoirs", "27 voussoirs", "12 drums", "20 drums"],
)
def test_what_does_not_slide_stands_below_its_limit_load_and_falls_above(kind: Laid, load: float):
    """Limit loads: Oppenheim (1992) by limit analysis; a column tips at its width over height.

    Their joints form chains, which leap to the solution of all contacts, and creep less than walls.
    """
    found = run(kind, pushes(load * np.array([0.99, 1.01]), 1.0, 4.0), 4.0)
    assert (found["status"] == Status.OK).all()
    assert found["peak_displacement"][0] < CREEP / 10.0
    assert found["opened_joints"][0] == 0
    assert found["peak_displacement"][1] > 1000.0 * CREEP
    assert found["opened_joints"][1] > 0


def test_columns_arches_and_frames_are_trees_and_walls_are_none():
    """Every block comes before its parent, and touches it."""
    colonnade = built(patterns.frame(1.0, 6.0, 5, 2.0, 3.0), NO_SLIDING)
    for kind in (drums(12), oppenheim(27), colonnade):
        tree = tree_of(kind)
        block, parent = tree.order.T
        assert sorted(block) == np.flatnonzero(~kind.fixed).tolist()
        place = {int(own): at for at, own in enumerate(block)} | {kind.count: len(block)}
        assert all(place[int(own)] < place[int(other)] for own, other in tree.order)
        pairs = {frozenset(pair) for pair in kind.joints.blocks.tolist()}
        assert {frozenset(each) for each in tree.order.tolist() if kind.count not in each} <= pairs
        first = np.where(tree.child % 2 == 0, *kind.joints.blocks.T)
        other = np.where(tree.child % 2 == 0, *kind.joints.blocks.T[::-1])
        assert not kind.fixed[first].any()
        assert (kind.fixed[other] == (tree.child >= 2)).all()
        links = tree.child < 2
        assert (parent[[place[int(own)] for own in first[links]]] == other[links]).all()
    assert len(tree_of(wall_1()).order) == 0


@pytest.mark.thorough
def test_a_wall_whose_joints_slide_falls_between_its_two_bounds():
    """Wall 1 of Ferris and Tin-Loi (2001).

    Coulomb's law has no single limit load there: it lies between .6399, found with a ramped load by
    an augmented Lagrangian, and .64286, the associative bound.
    """
    found = run(wall_1(), pushes([0.99 * 0.6399, 1.01 * 0.64286], 1.0, 4.0), 4.0)
    assert (found["status"] == Status.OK).all()
    assert found["peak_displacement"][0] < CREEP
    assert found["outcome"][1] == Outcome.OVERTURNED
    assert found["slid_joints"][1] > 0


@pytest.mark.thorough
def test_a_wall_with_an_opening_falls_between_its_two_bounds():
    """Wall 3 of Ferris and Tin-Loi (2001): 46 blocks.

    .3556 is the load, ramped, up to which an augmented Lagrangian finds it standing, .40369 the
    associative bound. Its sweeps change forces that balance one another, for hundreds of sweeps.
    """
    opening = patterns.Opening(0.6, 0.525, 0.4, 0.875)
    pieces = patterns.wall(0.4, 0.175, 4, 11, whole_first=True, openings=[opening])
    kind = built(pieces, friction=0.65)
    assert kind.count == 1 + 46
    bound = collapse_load(kind).load_factor
    assert bound == pytest.approx(0.40369, abs=6e-6)
    found = run(kind, pushes([0.99 * 0.3556, 1.01 * bound], 1.0, 3.0), 3.0)
    assert found["status"].tolist() == [Status.OK] * 2
    assert found["peak_displacement"][0] < CREEP
    assert found["outcome"][1] == Outcome.OVERTURNED


def sine(lanes: int, amplitude: npt.ArrayLike, frequency: float, cycles: float) -> HarmonicMotions:
    each = np.broadcast_to(np.asarray(amplitude, dtype=np.float64) * GRAVITY, lanes)
    start, length = np.zeros(lanes), np.full(lanes, cycles / frequency)
    control = [Control.ACCELERATION] * lanes
    each = np.array(each)
    return harmonic_motions(Waveform.SINE, control, each, np.full(lanes, frequency), start, length)


@pytest.mark.parametrize(("amplitude", "frequency"), first(1, [(0.4, 2.0), (0.5, 2.5)]))
def test_one_block_is_housners_with_an_error_of_the_first_order(amplitude: float, frequency: float):
    """The largest rotation of a block under a pulse, at steps from 1e-3 to 6.25e-5 s."""
    kind, motions = (
        built(patterns.column(0.5, 2.0, 1), NO_SLIDING),
        sine(1, amplitude, frequency, 1.0),
    )
    block = make_lanes(0.5, 2.0, friction=NO_SLIDING)
    exact = run_batch("housner", block, motions, SampleTimes(4.0))
    steps = 1e-3 / 2.0 ** np.arange(5)
    found = [run(kind, as_records(motions), 4.0, time_step=step) for step in steps]
    peaks = np.array([each["peak_rotation"][0] for each in found])
    errors = np.abs(peaks / exact["peak_rotation"][0] - 1.0)
    assert errors[0] < 0.03
    # Impacts come late by any part of a step, so that errors scatter about the line.
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] > 0.75
    assert found[-1]["uplift_time"][0] == pytest.approx(exact["uplift_time"][0], abs=1e-3)


def upright(
    times: npt.NDArray[np.float64], rotation: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """When a block that rocks is upright, from 0.5 s on [s]."""
    change = np.diff(rotation)
    through = (rotation[:-1] * rotation[1:] <= 0.0) & (np.abs(change) > 2e-5) & (times[:-1] > 0.5)
    last = np.flatnonzero(through)
    return times[last] - rotation[last] / change[last] * np.diff(times)[last]


@pytest.mark.thorough
def test_a_rocking_frame_is_that_of_makris_and_vassiliou():
    """Two columns and a beam of their joint mass rock as one: Makris and Vassiliou (2013).

    `housner` has their equation, with p^2 (1 + 2 gamma) / (1 + 3 gamma) and their restitution.
    """
    kind = built(patterns.frame(1.0, 6.0, 2, 2.0, 3.0), NO_SLIDING)
    motions = sine(2, [0.3, -0.3], 1.0, 1.0)
    column = make_lanes([1.0, 1.0], [6.0, 6.0], friction=NO_SLIDING)
    frame = Frame(np.array([2.0, 2.0]), np.array([1.0, 1.0]))
    restitution = frame.angular_restitution(column.slenderness_angle)
    lanes = dataclasses.replace(column, hold=Hold(frame=frame), angular_restitution=restitution)
    times = SampleTimes(6.0, 1e-3, places=True)
    exact = run_batch("housner", lanes, motions, dataclasses.replace(times, places=False))
    impacts = upright(times.times, exact["rotation"][0])
    assert len(impacts) == 3
    late = []
    for step in (4e-4, 1e-4):
        settings = AssemblySettings(time_step=step)
        found = run_batch("assembly", assembly_lanes([kind] * 2), motions, times, settings=settings)
        assert (found["status"] == Status.OK).all()
        # Half a step late of a swing that takes 1 s.
        assert found["peak_rotation"] == pytest.approx(exact["peak_rotation"], rel=0.5 * step)
        late.append(upright(times.times, found["turn"][0, 0]) - impacts)
    # Impacts are half a step late at most: steps have an error of the second order but for when the
    # frame lifts off, in a whole step.
    coarse, fine = np.abs(late)
    assert np.all(coarse < 0.5 * 4e-4)
    assert np.all(fine < 0.5 * 1e-4)
    assert np.all((coarse / fine)[1:] > 2.0)


def test_an_impact_takes_what_it_should_wherever_in_a_step_it_is():
    """Forces of a step in which a corner lands act up to the landing, and after it; see landing.py.

    Where an impact leaves r of an angular velocity, one solve of that step takes up to 1.5 (1 + r)
    A h too much, with A = p^2 sin(alpha) that with which an upright block is slowed down. Here a
    corner lands at 32 places of a step, and 224 times at its very end or just after it: Housner's
    block does so 1.2498071 s after the start, this one some .03 of a step earlier.
    """
    step, alpha = 2e-4, np.arctan2(1.0, 4.0)
    parts = np.concatenate([np.arange(32) / 32, np.linspace(-0.01, 0.05, 224) - 1.2498071 / step])
    starts, lanes = step * (parts % 1.0), len(parts)
    motions = dataclasses.replace(sine(lanes, 0.5, 1.0, 0.5), start=starts)
    block, times = make_lanes(np.ones(lanes), 4.0, friction=NO_SLIDING), SampleTimes(2.0, 2e-3)
    exact = run_batch("housner", block, motions, times)["rotation"]
    kind = built(patterns.column(1.0, 4.0, 1), NO_SLIDING)
    own, settings = assembly_lanes([kind], [0] * lanes), AssemblySettings(time_step=step)
    felt = as_records(motions)
    found = run_batch("assembly", own, felt, times, settings=settings)["rotation"]
    # The swing after the first impact: from its highest angle back to its speed at the impact.
    after = times.times > 1.3
    wanted, got = (np.abs(each[:, after]).max(axis=1) for each in (exact, found))
    speeds = [np.sqrt(2.0 * (np.cos(alpha - peak) - np.cos(alpha))) for peak in (wanted, got)]
    p = np.sqrt(0.75 * GRAVITY / np.hypot(0.5, 2.0))
    kept = 1.0 - 1.5 * np.sin(alpha) ** 2
    lost = p * (speeds[0] - speeds[1]) / ((1.0 + kept) * p * p * np.sin(alpha) * step)
    # Other errors of a swing are .015 at most at 3,072 starts. A corner that lands at the very end
    # of a step would take .5 too much in two steps of one solve each.
    assert np.abs(lost).max() < 0.02


@pytest.mark.parametrize("count", first(1, [2, 7]))
def test_a_column_of_drums_is_a_stack(count: int):
    """Equal drums, 2 m of them, under a pulse, in `event` at its own error of some 1e-5.

    `event` takes the column as the stack that it is: the same bits where the coordinates of two
    drums are exact, the same within that error where those of seven are rounded.
    """
    motions = sine(2, [0.4, 0.8], 2.5, 1.0)
    height = 2.0 / count
    stack = make_stacks([[0.5] * count] * 2, [[height] * count] * 2, friction=NO_SLIDING)
    stack = dataclasses.replace(stack, depth=np.ones_like(stack.width))
    times = SampleTimes(1.5, 0.05, places=True)
    exact = run_batch("event", stack, motions, times)
    column = built(patterns.column(0.5, height, count), NO_SLIDING)
    same = run_batch("event", assembly_lanes([column] * 2), motions, times)
    error = 0.0 if count == 2 else 1e-5
    assert same["peak_rotation"] == pytest.approx(exact["peak_rotation"].max(axis=1), abs=error)
    for name, wanted in (("turn", "rotation"), ("x", "x"), ("z", "z")):
        np.testing.assert_allclose(same[name], exact[wanted], rtol=0.0, atol=2.0 * error)
    step = 1e-4
    found = run(column, as_records(motions), 1.5, time_step=step)
    assert (found["status"] == Status.OK).all()
    # Joints open in a whole step: late by up to that, of a pulse of 0.4 s.
    assert found["uplift_time"] == pytest.approx(same["uplift_time"], abs=step)
    # Where six joints open, impacts have more than one answer: peaks scatter by up to 6e-4 at steps
    # of 0.4 to 0.0125 ms.
    close = step / 0.4 if count == 2 else 1e-3
    for name in ("peak_rotation", "peak_displacement", "peak_opening"):
        assert found[name] == pytest.approx(same[name], rel=close)
    # A joint may be at the bound from which it counts as opened.
    assert found["opened_joints"] == pytest.approx(same["opened_joints"], abs=1)


def test_a_column_falls_in_event_as_by_its_own_engine():
    """Two drums under long pulses: limit analysis says .25, and each says when and how."""
    kind, motions = built(patterns.column(0.5, 1.0, 2), NO_SLIDING), sine(2, [0.6, -0.6], 0.5, 1.0)
    located = run_batch("event", assembly_lanes([kind] * 2), motions, SampleTimes(2.0))
    stepped = run(kind, as_records(motions), 2.0)
    assert located["collapse_load"] == pytest.approx([0.25] * 2, rel=1e-6)
    # It takes some 0.02 s to move as fast as what counts as moving; the pulse rises meanwhile.
    assert stepped["collapse_load"] == pytest.approx([0.25] * 2, abs=0.6 * np.pi * 0.02)
    # Of the first order in steps of 1 ms: joints open, and close, each in a whole step.
    assert stepped["collapse_time"] == pytest.approx(located["collapse_time"], abs=0.01)
    for name in ("outcome", "joint_state"):
        np.testing.assert_array_equal(located[name], stepped[name])


def test_event_says_which_assembly_is_no_column_of_equal_drums():
    def declined(*kinds: Laid) -> str:
        scene = scene_kind(assembly_lanes(kinds), StillBase(len(kinds)), restitution_given=False)
        return engine_class("event").supports(scene) or ""

    assert not declined(drums(2))
    assert "is no upright rectangle" in declined(oppenheim())
    assert "1 and 2 of them (assembly.drums)" in declined(drums(1), drums(2))
    assert "up to 20 blocks" in declined(drums(21))
    broad, *pieces = patterns.column(1.0, 0.5, 2)
    top = patterns.rectangle(-0.5, 0.5, 0.5, 1.5)
    assert "block 2 is 1 m wide and 1 m high" in declined(
        built([broad, pieces[0], pieces[1]._replace(corners=top)], 0.7)
    )
    aside = pieces[1].corners + np.array([0.1, 0.0])
    assert "block 2 does not stand upon the middle" in declined(
        built([broad, pieces[0], pieces[1]._replace(corners=aside)], 0.7)
    )
    given = {"depth": 1.0, "density": 2000.0, "friction": 0.7}
    bonded = assemble([broad, *pieces], **given, cohesion=1e4, tension=1e4)
    assert "(assembly.joint_tensile_strength)" in declined(bonded)
    assert "(assembly.joint_cohesion)" in declined(
        assemble([broad, *pieces], **given, cohesion=1e4)
    )


def mixed(size: str) -> list[Laid]:
    """Lanes of two sorts of joints, of several sizes, in no order; `large` takes another kernel."""
    wall = {
        "large": wall_1,
        "small": lambda width=0.35: built(
            patterns.wall(width, 0.175, 2, 3, whole_first=False), 0.65
        ),
    }[size]
    arches = [
        built(patterns.arch(5.0, thickness, np.pi, 7), 0.8) for thickness in (0.6, 0.7, 0.8, 0.9)
    ]
    return [arches[0], wall(), arches[1], drums(2), arches[2], wall(0.4), arches[3]]


def assert_same(found: Response, wanted: Response) -> None:
    for name, values in wanted.fields.items():
        # There is a place for every joint of the lane that has most.
        own = values[:, : found[name].shape[1]] if name == "joint_state" else values
        np.testing.assert_array_equal(found[name], own, err_msg=name)


@pytest.mark.parametrize("size", first(1, ["small", "large"]))
def test_no_lane_depends_on_its_neighbours(size: str):
    kinds, motions = mixed(size), as_records(sine(7, np.linspace(0.2, 0.8, 7), 2.0, 1.0))
    together = run(kinds, motions, 1.0)
    for lane in range(7):
        places = np.array([lane])
        alone = run([kinds[lane]], motions.take(places), 1.0)
        assert_same(alone, take_lanes(together, places))


@pytest.mark.thorough
def test_both_forms_of_the_kernel_give_the_same_bits():
    kinds, motions = mixed("large"), sine(7, np.linspace(0.2, 0.8, 7), 2.0, 1.0)
    lanes, times = assembly_lanes(kinds), SampleTimes(0.5, 0.05)
    packed, plain = (Assembly(target=Target(form=form)).run(lanes, motions, times) for form in Form)
    assert_same(plain, packed)


def test_a_mirrored_motion_has_a_mirrored_answer():
    """An arch is its own mirror image; sweeps are not, and leave a thousandth of a step."""
    sizes = np.array([0.5, 0.6, 1.0])
    motions = sine(6, np.concatenate([sizes, -sizes]), 2.0, 1.0)
    found = run(oppenheim(7), as_records(motions), 2.0)
    assert (found["status"] == Status.OK).all()
    for name in ("peak_displacement", "peak_rotation"):
        there, back = np.split(found[name], 2)
        assert there == pytest.approx(back, rel=1e-3, abs=CREEP)
    assert (np.split(found["outcome"], 2)[0] == np.split(found["outcome"], 2)[1]).all()


@pytest.mark.thorough
def test_a_scene_that_is_turned_has_the_turned_answer():
    """Turned by phi, gravity is g cos(phi) across the joints and g sin(phi) along them.

    That is the upright scene under a sideways push of g tan(phi), slower by sqrt(cos(phi)). The
    push acts half a step later than gravity, of 400 steps of a motion that grows like t^2 or more.
    """
    phi, end = np.radians(20.0), 0.4
    turn = np.array([[np.cos(phi), np.sin(phi)], [-np.sin(phi), np.cos(phi)]])
    pieces = patterns.column(1.0, 0.5, 7)
    turned = [piece._replace(corners=np.asarray(piece.corners) @ turn.T) for piece in pieces]
    slow = np.sqrt(np.cos(phi))
    leaning = run(built(turned, 0.7), StillBase(1), end)
    upright = run(
        built(pieces, 0.7), pushes([np.tan(phi)], 1e-5, 1.0), end * slow, time_step=1e-3 * slow
    )
    assert leaning["peak_rotation"][0] > 0.01
    for name in ("peak_rotation", "peak_displacement", "peak_opening"):
        assert leaning[name] == pytest.approx(upright[name], rel=0.01)


def test_contacts_take_energy_and_give_none():
    """Random arches and walls under pulses: what contacts gave back is nothing against the work."""
    draw = np.random.default_rng(5)
    kinds = [
        built(patterns.arch(5.0, t, np.radians(e), 7), f)
        for t, e, f in zip(
            draw.uniform(0.6, 1.2, 24), draw.uniform(120.0, 180.0, 24),
            draw.uniform(0.4, 1.0, 24), strict=True,
        )
    ]  # fmt: skip
    motions = as_records(sine(24, draw.uniform(0.2, 1.2, 24), 2.0, 1.5))
    found = run(kinds, motions, 2.0)
    assert np.isin(found["status"], [Status.OK, Status.ITERATION_LIMIT]).all()
    assert (found["status"] == Status.OK).sum() >= 22
    moved = found["peak_displacement"] > 1e-3
    assert moved.sum() > 5
    assert (found["energy_lost"][moved] > 0.0).all()


def test_a_tilting_table_brings_down_what_limit_analysis_says():
    """An arch, to either side, and a column: when the motion begins that ends in their collapse."""
    kinds = [oppenheim(7), oppenheim(7), drums(12)]
    rate, end = np.radians([4.0, -4.0, 2.0]), np.full(3, 8.0)
    found = run(kinds, tilt_motions(steady(rate, np.zeros(3)), end), 8.0)
    assert found["outcome"].tolist() == [Outcome.OVERTURNED] * 3
    # It takes some 0.05 s to move as fast as what counts as moving; the load goes on meanwhile.
    assert found["collapse_load"] == pytest.approx([0.3736, 0.3736, 1.0 / 6.0], rel=0.015)
    there, back, column = (
        {
            tuple(kind.names[block] for block in pair)
            for pair, state in zip(kind.joints.blocks, row, strict=False)
            if state & JointState.OPENED
        }
        for kind, row in zip(kinds, found["joint_state"], strict=True)
    )
    ends = {("1", "left abutment"), ("7", "right abutment")}
    assert there == {*ends, ("3", "4"), ("5", "6")}
    assert back == {*ends, ("4", "5"), ("2", "3")}
    assert column == {("ground", "1")}


@pytest.mark.thorough
def test_walls_that_slide_and_fall_have_an_answer():
    """Random walls under strong pulses: at most one in 32 has a step that does not settle."""
    draw = np.random.default_rng(2)
    kinds = [
        built(patterns.wall(0.4, height, 5, 6, whole_first=False), friction)
        for height, friction in zip(
            draw.uniform(0.15, 0.3, 32), draw.uniform(0.3, 0.9, 32), strict=True
        )
    ]
    found = run(kinds, sine(32, draw.uniform(0.2, 1.5, 32), 2.0, 1.0), 1.0)
    assert (found["status"] == Status.OK).sum() >= 31
    assert (found["slid_joints"] > 0).sum() > 16
    # What steps leave, some micrometres a second, of what stands, and more of what is in motion.
    assert found["peak_penetration"].max() < 3e-4


@pytest.mark.thorough
def test_random_walls_of_dry_stone_have_an_answer():
    """Each has joints of its own, so that its lane runs alone; under pulses of up to 1.2 g."""
    kinds = [
        built(patterns.dry_stone(2.0, 1.2, 0.4, 0.2, 1.0, seed), friction)
        for seed, friction in enumerate(np.linspace(0.4, 0.9, 48))
    ]
    found = run(kinds, sine(48, np.linspace(0.3, 1.2, 48), 2.0, 1.0), 1.0)
    told = (Status.OK, Status.OUTSIDE_MODEL, Status.ITERATION_LIMIT)
    assert np.isin(found["status"], told).all()
    assert (found["status"] == Status.OK).sum() >= 43
    assert (found["slid_joints"] > 0).sum() > 24


def test_too_few_sweeps_are_no_answer_but_a_status():
    found = run(drums(12), pushes([0.1], 1.0, 1.0), 1.0, iterations=3)
    assert found["status"].tolist() == [Status.ITERATION_LIMIT]


def test_no_other_engine_but_dem_takes_assemblies_nor_this_one_anything_else():
    scene = scene_kind(assembly_lanes([oppenheim()]), StillBase(1), restitution_given=False)
    able = {name for name in ENGINES if engine_class(name).supports(scene) is None}
    assert able == {"assembly", "dem"}
    block = scene_kind(make_lanes(0.5, 1.0), StillBase(1), restitution_given=False)
    assert "[assembly]" in str(Assembly.supports(block))


def test_a_wall_that_slides_off_has_collapsed():
    """At friction .3 it slides on the ground from .3 of its weight on, as limit analysis says."""
    kind = built(patterns.wall(0.4, 0.175, 3, 3, whole_first=False), 0.3)
    found = run([kind] * 3, pushes([0.29, 0.5, 0.6], 0.2, 1.0), 1.0)
    slides = (Outcome.SLID_OFF, Outcome.SLID_OFF)
    assert found["outcome"][0] in (Outcome.AT_REST, Outcome.ROCKING)
    assert tuple(found["outcome"][1:]) == slides
    assert np.isnan(found["collapse_time"][0])
    # Longest joint of the half blocks at its ends, passed in a step of 1 ms.
    speed = np.sqrt(2.0 * GRAVITY * (0.6 - 0.3) * 0.2)
    assert found["peak_slide"][1:] == pytest.approx(0.2, abs=1e-3 * speed)
    # The wall moves as fast as what counts as moving within some .02 s; the push rises meanwhile.
    assert found["collapse_load"][1:] == pytest.approx(0.3, abs=0.02 * 0.6 / 0.2)


@pytest.mark.thorough
def test_random_assemblies_stand_below_their_limit_load_and_fall_above_it():
    """Arches and frames, in which nothing slides, stand at .99, walls at .96 of Coulomb's load.

    All fall at 1.01. Of 20 of each, one wall fell at .98 of that load, which is no bound; all
    others stood at .99.
    """
    draw, kinds, low, high = np.random.default_rng(41), [], [], []
    for _ in range(2):
        voussoirs, thickness = int(draw.integers(5, 16)), draw.uniform(1.3, 2.2)
        arch = patterns.arch(10.0, thickness, np.radians(draw.uniform(130.0, 170.0)), voussoirs)
        width, columns = draw.uniform(0.5, 1.2), int(draw.integers(2, 5))
        height = width * draw.uniform(3.0, 7.0)
        frame = patterns.frame(width, height, columns, 2.0 * width, draw.uniform(0.3, 1.0))
        length, course = draw.uniform(0.3, 0.5), draw.uniform(0.12, 0.25)
        wall = patterns.wall(length, course, 3, int(draw.integers(2, 6)), whole_first=False)
        frictions = (NO_SLIDING, NO_SLIDING, draw.uniform(0.5, 0.9))
        for pieces, friction in zip((arch, frame, wall), frictions, strict=True):
            kind = built(pieces, friction)
            limit = collapse_load(kind)
            kinds.append(kind)
            low.append(0.96 * limit.coulomb_load if limit.upper_bound else 0.99 * limit.load_factor)
            high.append(1.01 * limit.load_factor)
    found = run(kinds * 2, pushes(low + high, 1.0, 4.0), 4.0)
    assert (found["status"] == Status.OK).all()
    assert found["peak_displacement"][: len(kinds)].max() < CREEP
    # They still fall at the end, but are on their way.
    assert found["peak_displacement"][len(kinds) :].min() > 1000.0 * CREEP
