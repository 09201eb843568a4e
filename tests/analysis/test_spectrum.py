"""Rocking spectra: sizes, similarity, blocks that do not lift, the oracle, refusals, files."""

from __future__ import annotations

import dataclasses
import io
import json
import pathlib

import numpy as np
import pandas as pd
import pytest

from tests.shared.commands import invoke, succeed
from warprock.analysis.spectrum import Spectrum, run_spectrum
from warprock.case.case import Case
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.findings.spectrum import find_spectrum
from warprock.model import rocking
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.oracle.block import oracle_response
from warprock.tables.finding import print_finding
from warprock.tables.terminal import plain_console

Array = np.ndarray

CASE = """
title = "spectra of a pulse"
source = "a test"
[block]
depth = "0.5 m"
density = "2400 kg/m^3"
[contact]
friction = 1.0
{restitution}
[motion]
waveform = "sine"
control = "acceleration"
amplitude = "{amplitude!r} m/s^2"
frequency = "{frequency} Hz"
cycles = 1
[run]
duration = "{duration} s"
[spectrum]
period = {{ from = "{first} s", to = "{last} s", count = 25 }}
slenderness = {slenderness}
"""


def written(
    tmp_path: pathlib.Path,
    slenderness: str = '["8 deg", "16 deg"]',
    amplitude: float = 4.0,
    time: float = 1.0,
    more: str = "",
    restitution: str = "",
) -> Case:
    """One cycle of 2 Hz and blocks of 1.5 s to 6 s, all times as often as long as asked for."""
    text = CASE.format(
        amplitude=amplitude,
        frequency=2.0 / time,
        first=1.5 * time,
        last=6.0 * time,
        duration=8.0 * time,
        slenderness=slenderness,
        restitution=restitution,
    )
    file = tmp_path / "case.toml"
    file.write_text(text + more, encoding="utf-8")
    return load_case(file)


def curve(found: Spectrum, number: int = 0) -> Array:
    return found.ratio[found.lanes[0, number]]


def test_blocks_have_the_periods_and_the_angles_that_were_asked_for(tmp_path: pathlib.Path):
    case = written(tmp_path)
    lane_set = expand_lanes(case)
    inputs = lane_set.inputs
    assert list(inputs["slenderness"].unique()) == ["8 deg", "16 deg"]
    angle = rocking.slenderness_angle(inputs["width_m"], inputs["height_m"])
    np.testing.assert_allclose(angle, np.repeat(np.deg2rad([8.0, 16.0]), 25), rtol=1e-14)
    period = 2.0 * np.pi / rocking.frequency_parameter(inputs["width_m"], inputs["height_m"])
    np.testing.assert_allclose(period, np.tile(np.linspace(1.5, 6.0, 25), 2), rtol=1e-14)


def test_a_block_twice_as_slow_under_a_pulse_twice_as_long_rotates_as_much(tmp_path: pathlib.Path):
    """At one slenderness theta/alpha is a function of omega/p and of a/(g tan(alpha)) alone."""
    one, other = (run_spectrum(written(tmp_path, time=t), "housner") for t in (1.0, 2.0))
    stood = one.run.response["outcome"] != Outcome.OVERTURNED
    assert 10 < stood.sum() < len(stood)
    np.testing.assert_array_equal(one.run.response["outcome"], other.run.response["outcome"])
    # Round-off, and what few impacts make of it: rocking doubles a difference a few times.
    np.testing.assert_allclose(one.ratio, other.ratio, rtol=1e-8)
    np.testing.assert_allclose(other.period, 2.0 * one.period, rtol=1e-14)


def test_slender_blocks_of_one_strength_and_restitution_have_one_curve(tmp_path: pathlib.Path):
    """As the angle goes to 0, F(omega/p, a/(g tan(alpha)), eta) keeps no angle: order alpha^2."""
    found = {}
    for degrees in (4.0, 2.0, 0.1):
        amplitude = float(2.0 * 9.81 * np.tan(np.deg2rad(degrees)))
        case = written(
            tmp_path, f'["{degrees} deg"]', amplitude, restitution="angular_restitution = 0.9"
        )
        found[degrees] = curve(run_spectrum(case, "housner"))
    limit = found[0.1]
    stands = limit < 0.8  # closer to overturning a small difference grows
    assert stands.sum() >= 10
    off = {d: np.max(np.abs(found[d] - limit)[stands]) for d in (4.0, 2.0)}
    assert off[4.0] <= 2.0 * np.deg2rad(4.0) ** 2
    assert off[4.0] / off[2.0] == pytest.approx(4.0, rel=0.15)


def test_a_block_that_the_motion_cannot_lift_does_not_rotate(tmp_path: pathlib.Path):
    # tan(alpha) = 4 m/s^2 / g at 22.18 degrees.
    found = run_spectrum(written(tmp_path, '["22.1 deg", "22.3 deg", "40 deg"]'), "housner")
    assert np.all(curve(found, 0) > 0.0)
    assert np.all(curve(found, 1) == 0.0)
    assert np.all(curve(found, 2) == 0.0)


def test_scipy_finds_the_same_spectrum(tmp_path: pathlib.Path):
    found = run_spectrum(written(tmp_path), "housner")
    some = found.lanes[0, :, ::12].ravel()
    lane_set = found.run.lane_set
    answer = oracle_response(
        lane_set.lanes.take(some), lane_set.motions.take(some), SampleTimes(8.0), rtol=1e-10
    )
    np.testing.assert_array_equal(answer["outcome"], found.run.response["outcome"][some])
    expected = answer["peak_rotation"] / lane_set.lanes.slenderness_angle[some]
    # The integrator's tolerance, grown by the impacts.
    np.testing.assert_allclose(found.ratio[some], expected, rtol=1e-6)


def test_axes_of_the_sweep_are_panels(tmp_path: pathlib.Path):
    sweep = '[[sweep]]\nlabel.pulse = ["weak", "strong"]\nmotion.amplitude = ["2 m/s^2", "4 m/s^2"]'
    found = run_spectrum(written(tmp_path, more=sweep), "housner")
    assert found.groups == ("weak", "strong")
    assert found.lanes.shape == (2, 2, 25)
    alone = run_spectrum(written(tmp_path), "housner")
    np.testing.assert_array_equal(found.ratio[found.lanes[1]], alone.ratio[alone.lanes[0]])


@pytest.mark.usefixtures("unrendered")
def test_the_command_writes_what_it_prints(tmp_path: pathlib.Path):
    written(tmp_path)
    out = tmp_path / "out"
    result = succeed("spectrum", tmp_path, "-o", out, "--json")
    found = json.loads(result.stdout)
    table = pd.read_parquet(out / "spectrum.parquet")
    assert len(table) == found["lanes"] == len(found["rows"]) == 50
    assert found["rows"][3]["peak_rotation_ratio"] == table["peak_rotation_ratio"][3]
    assert table["period_s"].between(1.5 - 1e-9, 6.0 + 1e-9).all()
    assert (out / "spectrum.png").read_bytes()[:4] == b"\x89PNG"
    assert json.loads((out / "run.json").read_text())["curves"] == ["8 deg", "16 deg"]
    printed = invoke("spectrum", tmp_path).stdout
    last = table["peak_rotation_ratio"].iloc[-1]
    assert f"{last:.4f}" in printed


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("-s block.width=1 m", "block.width: got a value, must not be given beside"),
        ("-s spectrum.period=[]", "spectrum.period: got \\[\\], must be a list"),
        (
            '-s spectrum.period=["0 s"]',
            "spectrum.period\\[0\\]: got '0 s', must be at least",
        ),
        ('-s spectrum.slenderness=["90 deg"]', "less than 90 deg"),
        ('-s spectrum.slenderness=["9 deg", "9 deg"]', "must not have a value twice"),
        ('-s spectrum.colour=["red"]', "unknown key \\(allowed: period, slenderness\\)"),
        ('-s spectrum.slenderness=["0.01 deg"]', "block.width .* at least 1 mm"),
        ('-s spectrum.period=["1 s", "99 s"]', "block.width .* at most 1 km"),
        ("-s spectrum=1", "spectrum: got 1, must be a table"),
    ],
)
def test_a_spectrum_that_is_none_is_refused(change: str, words: str, tmp_path: pathlib.Path):
    written(tmp_path)
    with pytest.raises(InputError, match=words):
        load_case(tmp_path, [change.removeprefix("-s ")])


def test_the_table_says_which_blocks_fell_and_which_have_no_number(tmp_path: pathlib.Path):
    found = run_spectrum(written(tmp_path, '["8 deg"]'), "housner")
    first, last = int(found.lanes[0, 0, 0]), int(found.lanes[0, 0, -1])
    assert found.run.response["outcome"][first] == Outcome.OVERTURNED
    found.run.response.fields["status"][last] = Status.NONFINITE
    stream = io.StringIO()
    print_finding(find_spectrum(found), plain_console(file=stream, width=100))
    cells = dict(line.split() for line in stream.getvalue().splitlines() if len(line.split()) == 2)
    assert (cells["1.5"], cells["6"]) == ("fell", "-")
    middle = int(found.lanes[0, 0, 16])
    assert cells[f"{found.period[middle]:.3g}"] == f"{found.ratio[middle]:.4f}"


@pytest.mark.parametrize("name", ["sample", "ensemble", "study"])
def test_other_tables_that_make_lanes_are_refused(name: str, tmp_path: pathlib.Path):
    case = written(tmp_path)
    both = dataclasses.replace(case, raw={**case.raw, name: {}})
    with pytest.raises(InputError, match=rf"{name}: got a table, must not be given beside"):
        run_spectrum(both, "housner")


def test_a_case_without_a_spectrum_or_a_motion_is_refused(tmp_path: pathlib.Path):
    with pytest.raises(InputError, match="spectrum: got nothing, must be given"):
        run_spectrum(load_case("single-sine-pulse"), "housner")
    text = CASE.format(
        amplitude=1.0,
        frequency=1,
        first=1,
        last=2,
        duration=1,
        slenderness='["9 deg"]',
        restitution="",
    )
    motion = text.index("[motion]"), text.index("[run]")
    (tmp_path / "case.toml").write_text(text[: motion[0]] + text[motion[1] :], encoding="utf-8")
    with pytest.raises(InputError, match="motion: got nothing"):
        run_spectrum(load_case(tmp_path), "housner")
    panels = '[[sweep]]\nmotion.amplitude = ["2 m/s^2", "4 m/s^2"]'
    with pytest.raises(InputError, match=r"label\.NAME"):
        run_spectrum(written(tmp_path, more=panels), "housner")
