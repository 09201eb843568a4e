"""A block is found again from its free rocking: without noise exactly, with noise as errors say."""

from __future__ import annotations

import functools
import re
import shlex

import numpy as np
import numpy.typing as npt
import pandas as pd
import pytest

import warprock as wr
from tests.shared.commands import succeed
from tests.shared.marks import first
from warprock.analysis.identification import (
    FITS,
    Estimate,
    Identified,
    identify_block,
    restitution_of,
)
from warprock.analysis.swings import Swings
from warprock.errors import InputError
from warprock.model import rocking
from warprock.model.hold import three_impacts

Array = npt.NDArray[np.float64]

WIDTH, HEIGHT = 0.5, 2.0
ANGLE = float(rocking.slenderness_angle(WIDTH, HEIGHT))
RATE = float(rocking.frequency_parameter(WIDTH, HEIGHT))
SEEDS = 200


@functools.cache
def history(given: float | None = None, wall: bool = False) -> tuple[Array, Array]:
    """Times and rotations of a block that is let go at half its slenderness angle."""
    contact = {"friction": 5.0} | ({} if given is None else {"angular_restitution": given})
    tables = {
        "block": {"width": "0.5 m", "height": "2 m", "depth": "0.5 m", "density": "2400 kg/m^3"},
        "contact": contact,
        "start": {"rotation_ratio": 0.5},
        "run": {"duration": "12 s"},
    }
    if wall:
        tables["transverse_wall"] = {"side": "left", "rebound": "three-impacts"}
    table = wr.run(tables, "housner", progress=False).history(0, "1 ms" if wall else "10 ms")
    return table["time_s"].to_numpy(), table["rotation_rad"].to_numpy()


@pytest.mark.parametrize("given", [None, 0.8])
@pytest.mark.parametrize("fits", [(), FITS[:1], FITS])
def test_a_history_without_noise_gives_back_its_block(given: float | None, fits: tuple[str, ...]):
    """To what the polynomials leave of a swing: 1e-11 to 1e-9 of what is looked for."""
    times, rotations = history(given)
    found = identify_block(times, rotations, ANGLE, RATE, fits)
    eta = float(rocking.angular_restitution(ANGLE)) if given is None else given
    assert found.restitution.value == pytest.approx(eta, rel=1e-8)
    assert found.slenderness_angle.value == pytest.approx(ANGLE, rel=1e-8)
    assert found.frequency_parameter is not None
    assert found.frequency_parameter.value == pytest.approx(RATE, rel=1e-8)
    assert found.ratios == pytest.approx(eta, rel=1e-6)
    assert found.swings.peak[0] == pytest.approx(np.abs(rotations[50:130]).max(), rel=1e-3)
    assert not found.one_sided


def test_a_fit_does_not_hang_on_its_guess():
    times, rotations = history()
    for angle, rate in ((None, None), (0.5, 9.0), (0.125, 0.1)):
        found = identify_block(times, rotations, angle, rate, FITS)
        assert found.slenderness_angle.value == pytest.approx(ANGLE, rel=1e-7)


@pytest.mark.thorough
def test_a_block_beside_a_wall_gives_its_rebound():
    found = identify_block(*history(wall=True), ANGLE, RATE)
    assert found.one_sided
    assert found.formula == pytest.approx(float(three_impacts(np.array(ANGLE))), rel=1e-12)
    assert found.restitution.value == pytest.approx(found.formula, rel=1e-8)


@functools.cache
def noisy(noise: float, seeds: int) -> list[Identified]:
    """What histories with noise of a standard deviation [rad] tell, one a seed."""
    times, rotations = history()
    found = []
    for seed in range(seeds):
        more = noise * np.random.default_rng(seed).standard_normal(len(times))
        found.append(identify_block(times, rotations + more, ANGLE, RATE, FITS[:1]))
    return found


@pytest.mark.thorough
def test_errors_cover_the_truth():
    """Two standard errors cover 95 % of normal errors: of 80 within 85 % to 100 %, four sigma."""
    noise = 1e-4
    found, eta = noisy(noise, 80), float(rocking.angular_restitution(ANGLE))
    for each, truth in (("restitution", eta), ("slenderness_angle", ANGLE)):
        estimates: list[Estimate] = [getattr(one, each) for one in found]
        z = np.array([(e.value - truth) / e.error for e in estimates])
        assert np.mean(np.abs(z) <= 2.0) >= 0.85
        # A spread that is not there makes errors of the restitution larger, never smaller.
        assert (0.45 if each == "restitution" else 0.7) <= np.sqrt(np.mean(z**2)) <= 1.2
        assert abs(np.mean(z)) <= 0.4
    measured = np.array([one.swings.noise for one in found])
    assert np.mean(measured) == pytest.approx(noise, rel=0.01)


def chain(spread: float, noise: float, seed: int, count: int = 13) -> Swings:
    """Peaks of a block whose impacts differ, read with an error."""
    random = np.random.default_rng(seed)
    energy, peaks = np.cos(0.5 * ANGLE) - np.cos(ANGLE), []
    for _ in range(count):
        peaks.append(ANGLE - np.arccos(energy + np.cos(ANGLE)))
        energy *= (0.9 + spread * random.standard_normal()) ** 2
    read = np.array(peaks) + noise * random.standard_normal(count)
    ones = np.ones(count)
    return Swings(ones, ones, read, ones, ones, ones, ones, noise)


@pytest.mark.parametrize(("spread", "noise"), first(1, [(0.01, 5e-4), (0.02, 1e-5), (0.0, 5e-4)]))
def test_errors_know_impacts_that_differ_from_those_that_are_read_badly(spread, noise):
    """As above: 95 % within two standard errors, less four sigma of 200."""
    found = [restitution_of(chain(spread, noise, seed), Estimate(ANGLE)) for seed in range(SEEDS)]
    z = np.array([(each.value - 0.9) / each.error for each, _ in found])
    assert np.mean(np.abs(z) <= 2.0) >= 0.87
    assert (0.7 if spread else 0.45) <= np.sqrt(np.mean(z**2)) <= 1.25
    assert np.mean([each for _, each in found]) == pytest.approx(spread, abs=0.002)


def test_reading_errors_of_neighbours_cancel():
    """A peak that is read too large raises one ratio and lowers the next: the ends alone count."""
    found, _ = restitution_of(chain(0.0, 5e-4, 1), Estimate(ANGLE))
    alone = [restitution_of(chain(0.02, 5e-4, 1), Estimate(ANGLE))[0].error, found.error]
    assert alone[1] < 0.3 * alone[0]


@pytest.mark.parametrize(
    ("angle", "noise", "said"),
    [
        (ANGLE, 0.03, "got 0 whole swings between impacts, must have at least 3"),
        (0.05, 0.0, "must stay below the slenderness angle, 0.05 rad"),
    ],
)
def test_a_history_that_says_nothing_is_refused(angle: float, noise: float, said: str):
    times, rotations = history()
    more = noise * np.random.default_rng(1).standard_normal(len(times))
    with pytest.raises(InputError, match=said):
        identify_block(times, rotations + more, angle, RATE)


def test_a_block_at_rest_is_refused():
    with pytest.raises(InputError, match="0 whole swings"):
        identify_block(np.arange(100.0), np.zeros(100), ANGLE, RATE)


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("wall", first(1, [False, True]))
@pytest.mark.parametrize(
    "known", [["--width", "0.5 m", "--height", "2 m"], ["--slenderness", f"{ANGLE:.12g} rad"]]
)
def test_the_command_that_is_named_next_runs_the_block_that_was_found(known, wall, tmp_path):
    times, rotations = history(0.9, wall=wall)
    file = tmp_path / "tilt.csv"
    pd.DataFrame({"time_s": times, "rotation_rad": rotations}).to_csv(file, index=False)
    done = succeed("identify", file, *known, "-o", tmp_path / "found")
    named = re.findall(r"^next: warprock (.*)$", done.stdout, re.M)
    succeed(*shlex.split(named[0]), "-o", tmp_path / "out")
    row = pd.read_parquet(tmp_path / "out" / "lanes.parquet").iloc[0]
    # The command has four digits.
    assert row["slenderness_angle_rad"] == pytest.approx(ANGLE, rel=2e-3)
    kept = "wall_rebound" if wall else "angular_restitution"
    assert row[kept] == pytest.approx(three_impacts(ANGLE) if wall else 0.9, rel=2e-3)
