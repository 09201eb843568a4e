"""MuJoCo beside Housner's equation for blocks that something holds.

MuJoCo's step and the forces that it is given are of first order: with eight times the steps the
mean error of the lanes has to fall to a third at most. A perfect first order would leave an eighth,
but of an impact the error depends on where in its step it falls.

Soft contacts push a block out of what it sank in, at up to 1 / (4 damping_ratio^2) of the rate with
which it came, which no step lessens: at a damping ratio of 20 that is nothing to be seen.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import make_lanes, sines
from tests.shared.commands import succeed
from tests.shared.strips import strips
from warprock.errors import DeclinedError
from warprock.model.hold import Frame, Hold, Ties, TopLoad
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, StillBase
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.programs.pulls import PulledTie
from warprock.programs.table import require_scenes, run_program
from warprock.running.batch import run_batch
from warprock.settings.programs import BulletSettings, MujocoSettings
from warprock.units import GRAVITY

mujoco = pytest.mark.extra
COARSE, FINE = 2400.0, 19200.0


def errors(
    lanes: Lanes, motions: object, times: SampleTimes
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Largest distance from Housner's equation over the slenderness angle, at both steps."""
    pytest.importorskip("mujoco")
    ours = run_batch("housner", lanes, motions, times)
    assert np.all(ours["status"] == Status.OK)
    assert not np.any(ours["outcome"] == Outcome.OVERTURNED)
    found = []
    for rate in (COARSE, FINE):
        known = MujocoSettings(steps_per_second=rate, damping_ratio=20.0)
        require_scenes("mujoco", lanes, motions, times, known)
        theirs = run_program("mujoco", lanes, motions, times, known).response
        assert np.all(theirs["peak_slide"] < 1e-4)
        gap = np.abs(theirs["rotation"] - ours["rotation"]).max(axis=1)
        found.append(gap / lanes.slenderness_angle)
    return found[0], found[1]


def falls(coarse: npt.NDArray[np.float64], fine: npt.NDArray[np.float64], most: float) -> None:
    """The error falls with the step; no lane is off by two to three times what was measured."""
    assert fine.mean() < coarse.mean() / 3.0
    assert fine.max() < most


def hold(lanes: Lanes, hold: Hold) -> Lanes:
    return dataclasses.replace(lanes, hold=hold)


def ties(lanes: Lanes, rows: Sequence[dict[str, float]]) -> Ties:
    """One tie a lane, at the top; forces are shares of what tips the block, stiffness of W / H."""
    weight = GRAVITY * lanes.mass
    tipping = 0.5 * weight * lanes.width / lanes.height

    def of(name: str, default: float) -> npt.NDArray[np.float64]:
        return np.array([row.get(name, default) for row in rows])

    return Ties(
        side=of("side", 1.0)[:, None],
        height=lanes.height[:, None],
        stiffness=(of("stiffness", 1.0) * weight / lanes.height)[:, None],
        slack=(of("slack", 0.0) * lanes.width)[:, None],
        prestress=(of("prestress", 0.0) * tipping)[:, None],
        yield_force=(of("yields", np.inf) * tipping)[:, None],
        ultimate_elongation=(of("breaks", np.inf) * lanes.width)[:, None],
        pushes=of("pushes", 0.0)[:, None] > 0.0,
    )


@mujoco
def test_ties_pull_as_in_housner():
    lanes = make_lanes([0.6, 0.5, 0.6, 0.7, 0.6], [3.0, 2.5, 3.0, 3.5, 2.0], -0.4, 5.0)
    rows = [
        {"stiffness": 0.3},
        {"slack": 0.05, "stiffness": 0.5},
        {"prestress": 0.2, "yields": 0.5, "stiffness": 3.0},
        {"breaks": 0.2, "stiffness": 0.5},
        {"side": -1.0, "pushes": 1.0, "yields": 0.4, "stiffness": 2.0},
    ]
    lanes = hold(lanes, Hold(ties=ties(lanes, rows)))
    coarse, fine = errors(lanes, StillBase(5), SampleTimes(2.0, 0.01))
    falls(coarse, fine, 1e-3)


@mujoco
def test_loads_press_as_in_housner():
    lanes = make_lanes([0.6, 0.5, 0.6, 0.5], [3.0, 2.5, 3.0, 2.5], [-0.4, 0.4, 0.3, -0.3], 5.0)
    weight = GRAVITY * lanes.mass
    load = TopLoad(
        weight=weight * [0.3, 0.5, 0.2, 0.0],
        eccentricity=lanes.width * [0.2, 0.0, -0.3, 0.0],
        thrust=weight * [0.0, 0.0, 0.0, 0.02],
        stays=np.array([False, False, True, False]),
    )
    coarse, fine = errors(hold(lanes, Hold(load=load)), StillBase(4), SampleTimes(2.0, 0.01))
    falls(coarse, fine, 4e-3)


@mujoco
def test_a_wall_catches_a_block_as_in_housner():
    lanes = make_lanes([0.6, 0.5, 0.4], [4.8, 5.0, 2.0], [-0.5, -0.5, 0.5], 5.0)
    lanes = hold(lanes, Hold(np.array([1.0, 1.0, -1.0]), np.zeros(3)))
    coarse, fine = errors(lanes, StillBase(3), SampleTimes(2.0, 0.01))
    falls(coarse, fine, 3e-4)


@mujoco
def test_columns_and_beam_as_bodies_rock_as_one_block_of_housner():
    """The block of Makris and Vassiliou: another frequency parameter and another restitution."""
    lanes = make_lanes([1.0, 0.6, 1.0], [6.0, 4.8, 3.0], [0.5, -0.5, 0.3], 5.0)
    frame = Frame(np.array([2.0, 4.0, 6.0]), np.array([1.0, 0.3, 2.0]))
    kept = frame.angular_restitution(lanes.slenderness_angle)
    lanes = dataclasses.replace(lanes, hold=Hold(frame=frame), angular_restitution=kept)
    coarse, fine = errors(lanes, StillBase(3), SampleTimes(3.0, 0.01))
    falls(coarse, fine, 1e-3)


@mujoco
def test_a_wall_and_a_tie_on_a_base_that_moves():
    lanes = make_lanes([0.6, 0.5], [4.8, 4.0], 0.0, 5.0)
    held = Hold(np.array([1.0, -1.0]), np.zeros(2))
    tied = ties(lanes, [{"yields": 0.3, "slack": 0.02}, {"side": -1.0, "breaks": 0.1}])
    lanes = hold(lanes, dataclasses.replace(held, ties=tied))
    pull = 2.0 * GRAVITY * lanes.width / lanes.height
    motions = sines(Control.ACCELERATION, pull, np.array([1.0, 1.0]), cycles=1.0)
    ours = run_batch("housner", lanes, motions, SampleTimes(2.5, 0.01))
    assert np.all(ours["peak_rotation"] > 0.05 * lanes.slenderness_angle)
    coarse, fine = errors(lanes, motions, SampleTimes(2.5, 0.01))
    falls(coarse, fine, 1e-3)


@mujoco
def test_compare_sets_mujoco_beside_a_facade(tmp_path):
    pytest.importorskip("mujoco")
    case = tmp_path / "case.toml"
    succeed("init", "facade", case, "-s", "transverse_wall.rebound=plastic")
    told = succeed(
        "compare", case, "-e", "mujoco@steps_per_second=1200", "-e", "mujoco",
        "-s", "run.duration=1 s",
    )  # fmt: skip
    assert "mujoco@steps_per_second=1200 is within" in told.stdout
    # A program is no engine of `run`.
    assert "-e mujoco" not in told.stdout.rpartition("next:")[2]


@mujoco
def test_compare_sets_a_frame_and_its_column_side_by_side_and_leaves_a_page(tmp_path):
    pytest.importorskip("mujoco")
    case, folder = tmp_path / "case.toml", tmp_path / "results"
    frame = ("-s", "frame.columns=2", "-s", "frame.beam_mass=10 t", "-s", "contact.friction=1")
    succeed("init", "free", case, "-s", "block.width=1 m", "-s", "block.height=6 m", *frame)
    asked = ("-e", "housner", "-e", "mujoco", "-s", "start.rotation_ratio=0.3")
    told = succeed("compare", case, *asked, "-s", "run.duration=1 s", "-o", folder)
    assert "mujoco is within" in told.stdout
    assert (folder / "report.html").is_file()
    assert "damping_ratio = 2.0" in (folder / "costs.csv").read_text(encoding="utf-8")


def test_what_a_program_is_not_given_it_declines():
    pytest.importorskip("mujoco")
    lanes, times = make_lanes([0.6], [4.8], -0.5, 5.0), SampleTimes(1.0, 0.01)
    wall = hold(lanes, Hold(np.array([1.0]), np.array([0.3])))
    strip = strips(lanes, 0.5, 0.0, 0.0)
    for name, held, said in (
        ("mujoco", wall, "plastic"),
        ("mujoco", strip, "in one piece only; the case has strip"),
        ("bullet", wall, "free-standing blocks only; the case has transverse_wall"),
    ):
        settings = MujocoSettings() if name == "mujoco" else BulletSettings()
        with pytest.raises(DeclinedError, match=said):
            require_scenes(name, held, StillBase(1), times, settings)


def test_a_tie_keeps_what_it_yielded_and_stays_broken():
    inf = np.inf
    tie = PulledTie(1.0, (0.3, 1.0), 100.0, 50.0, inf, pushes=False, free=0.1)
    assert [tie.force(e) for e in (0.0, 0.2, 1.1, 1.0, 0.6, 0.5)] == pytest.approx(
        [0.0, 10.0, 50.0, 40.0, 0.0, 0.0]
    )
    both = PulledTie(1.0, (0.3, 1.0), 100.0, 50.0, inf, pushes=True, free=0.0)
    assert [both.force(e) for e in (0.2, -1.0, 0.0)] == pytest.approx([20.0, -50.0, 50.0])
    brittle = PulledTie(1.0, (0.3, 1.0), 100.0, inf, 0.5, pushes=False, free=0.0)
    assert [brittle.force(e) for e in (0.4, 0.5, 0.2)] == pytest.approx([40.0, 0.0, 0.0])
