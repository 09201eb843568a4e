"""Large assemblies, run by a team of threads, held to the packed form of the same law."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.assemblies import NO_SLIDING, assembly_lanes, built, oppenheim, pushes, wall_1
from warprock.engines import assembly
from warprock.engines.assembly import Assembly
from warprock.engines.assembly_team import colours_of, lay_out
from warprock.engines.launching import Form, Target, Team
from warprock.model import patterns
from warprock.model.assembly import Assembly as Laid
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch

pytestmark = pytest.mark.usefixtures("two_rooms")

SCENES = [wall_1(), wall_1(), oppenheim(27), built(patterns.column(1.0, 0.5, 20), NO_SLIDING)]
LOADS = [0.5, 0.7, 0.36, 0.099]
"""Two that stand and two that fall: limits .64, .3538, .1."""


@pytest.fixture
def small_ones_are_large(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets teams run assemblies of any size."""
    monkeypatch.setattr(assembly, "LARGE", 0)


def by_team(kinds: list[Laid], loads: list[float], end: float, threads: int = 1) -> Response:
    target = Target(team=Team(threads))
    times = SampleTimes(end, 0.5)
    return Assembly(target=target).run(assembly_lanes(kinds), pushes(loads, 1.0, end), times)


@pytest.mark.thorough
def test_a_team_finds_what_packed_lanes_find(monkeypatch: pytest.MonkeyPatch):
    """Both settle steps to 1e-5 m/s, in another order of contacts; so do histories and joints.

    What falls parts from what falls by exp(p t), p of some 2 / s: by 1e-5 m times some hundreds in
    3 s, a hundredth of how far it has fallen.
    """
    packed = by_team(SCENES, LOADS, 3.0)
    monkeypatch.setattr(assembly, "LARGE", 0)
    alone = by_team(SCENES, LOADS, 3.0)
    for name in ("status", "outcome"):
        assert alone[name].tolist() == packed[name].tolist()
    stood = packed["peak_displacement"] < 1e-4
    assert stood.tolist() == [True, False, False, True]
    assert alone["peak_displacement"][stood].max() < 1e-4
    for name in ("peak_displacement", "peak_rotation", "peak_opening"):
        assert alone[name][~stood] == pytest.approx(packed[name][~stood], rel=0.01)
    # At one time: what falls turns at up to 3 rad/s, and may be 10 ms late.
    assert alone["rotation"] == pytest.approx(packed["rotation"], abs=0.03)
    assert (alone["opened_joints"] > 0).tolist() == (packed["opened_joints"] > 0).tolist()
    # The two walls fall by the same joints; the mechanism of the arch is that of its limit load.
    assert (alone["joint_state"][2] == packed["joint_state"][2]).all()


@pytest.mark.thorough
def test_threads_change_no_bit(small_ones_are_large: None):
    one, two = (by_team(SCENES[:2], LOADS[:2], 0.5, threads) for threads in (1, 2))
    for name, values in one.fields.items():
        np.testing.assert_array_equal(two[name], values, err_msg=name)


def test_joints_of_a_colour_share_no_block_that_can_move():
    kind = built(patterns.wall(0.4, 0.2, 9, 7, whole_first=True), 0.6)
    colours = colours_of(kind)
    for colour in range(colours.max() + 1):
        blocks = kind.joints.blocks[colours == colour].reshape(-1)
        moving = blocks[~kind.fixed[blocks]]
        assert len(np.unique(moving)) == len(moving)
    # A block in a bond has six neighbours.
    assert colours.max() + 1 <= 8
    layout = lay_out(kind, 32)
    assert sorted(layout.joint[layout.joint >= 0]) == list(range(kind.joints.count))


@pytest.mark.thorough
def test_large_and_small_lanes_in_one_batch(monkeypatch: pytest.MonkeyPatch):
    """Each has the form of its own size, and its numbers alone."""
    monkeypatch.setattr(assembly, "LARGE", 96)
    wide = built(patterns.wall(0.4, 0.2, 6, 6, whole_first=True), 0.6)
    assert wide.joints.count > 96 >= wall_1().joints.count
    kinds = [wall_1(), wide, wall_1()]
    times, loads = SampleTimes(0.02), np.array([0.1, 0.1, 0.2])
    together = run_batch("assembly", assembly_lanes(kinds), pushes(loads, 1.0, 1.0), times)
    assert (together["status"] == Status.OK).all()
    for lane in (0, 1):
        own = pushes(loads[[lane]], 1.0, 1.0)
        alone = run_batch("assembly", assembly_lanes([kinds[lane]]), own, times)
        assert alone["peak_displacement"][0] == together["peak_displacement"][lane]
        assert alone["energy_lost"][0] == together["energy_lost"][lane]


@pytest.mark.thorough
def test_a_team_of_single_lanes_is_the_same_within_the_bound_of_a_step(small_ones_are_large: None):
    """The plain form adds up in another order: steps settled to 1e-5 m/s part by 1e-5 m in 1 s."""
    packed = by_team(SCENES[2:3], LOADS[2:3], 1.0)
    plain = Assembly(target=Target(form=Form.PLAIN)).run(
        assembly_lanes(SCENES[2:3]), pushes(LOADS[2:3], 1.0, 1.0), SampleTimes(1.0)
    )
    assert plain["peak_displacement"] == pytest.approx(packed["peak_displacement"], abs=1e-5)


@pytest.mark.thorough
def test_a_wall_of_six_hundred_blocks_stands_and_falls():
    """Sideways it slides on its lowest joints at the latest: friction times gravity."""
    kind = built(patterns.wall(0.4, 0.2, 24, 24, whole_first=True), 0.4)
    found = run_batch(
        "assembly", assembly_lanes([kind, kind]), pushes([0.1, 0.6], 0.1, 1.0), SampleTimes(0.3)
    )
    assert (found["status"] == Status.OK).all()
    assert found["peak_displacement"][0] < 1e-4
    assert found["slid_joints"][1] > 0
    assert found["outcome"].tolist()[0] != Outcome.OVERTURNED
