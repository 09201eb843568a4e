"""Programs of others and plain loops beside ours in `bench`: what is tried, and what is printed."""

from __future__ import annotations

import html
import json
import pathlib
import re

import numpy as np
import pytest

from tests.shared.commands import succeed
from tests.shared.programs import PACKAGES, absent, present
from warprock.findings.bench import find_device_bench
from warprock.measure import bench, peers, price
from warprock.model.motion import StillBase
from warprock.programs.loops import plain_loop
from warprock.programs.table import run_program
from warprock.running import machine
from warprock.settings.programs import PEER_SETTINGS


@pytest.mark.thorough
@pytest.mark.extra
@pytest.mark.parametrize("peer", peers.PEERS)
def test_finer_steps_are_tried_for_as_long_as_the_budget_lasts(
    peer: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    present(peer)
    monkeypatch.setattr(peers, "RATES", (200.0, 400.0, 800.0))
    monkeypatch.setitem(peers.KNOBS, peer, peers.KNOBS[peer][:2])
    every = peers.peer_trials(peer, 1e3)
    assert [trial.steps_per_s for trial in every] == pytest.approx(
        [200.0] * 2 + [400.0] * 2 + [800.0] * 2
    )
    assert len({trial.settings for trial in every}) == 6
    for trial in every:
        assert trial.cost == trial.cost_alone > 0.0
        assert trial.error <= trial.error_most < 0.7
    assert min(trial.error for trial in every[-2:]) < 0.02
    # What a step takes is not known before the first run; then nothing more fits.
    assert len(peers.peer_trials(peer, 1e-9)) == 1
    assert 2 < len(peers.peer_trials(peer, 0.6 * sum(t.cost for t in every) * 45.0)) < 6


@pytest.mark.extra
def test_settings_of_mujoco_change_its_contacts() -> None:
    present("mujoco")
    kinds = [
        PEER_SETTINGS["mujoco"](**knob)
        for knob in ({}, {"damping_ratio": 8.0}, {"contact_time": 4.0}, {"impedance": 0.9})
    ]
    lanes, still = price.b0_lanes(price.STARTS[4:5]), StillBase(1)
    usual, *others = (
        run_program("mujoco", lanes, still, price.TIMES, kind).response["rotation"]
        for kind in kinds
    )
    for other in others:
        assert np.abs(other - usual).max() > 1e-4


def test_a_loop_is_tried_alone_and_over_many_blocks() -> None:
    """In Python alone: what Numba compiles is the same text."""
    trial = peers._loop_trial(plain_loop(lambda function: function), 0.1, 8, 1)
    assert trial.error < 1e-4
    assert trial.error <= trial.error_most
    assert min(trial.cost, trial.cost_alone) > 0.0


def test_scipys_loop_is_tried_within_its_time() -> None:
    (first,) = peers.scipy_trials(0.0)
    assert first.settings == "RK45, tolerance 0.01"
    assert 0.0 < first.error < 0.3


@pytest.mark.thorough
@pytest.mark.usefixtures("pages_bare")
def test_bench_prints_all_kinds_of_row(
    monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path
) -> None:
    """The whole command with measurements that end at once, all that is not ours absent."""
    for package in (*(PACKAGES[peer] for peer in peers.PEERS), "numba"):
        absent(monkeypatch, package)
    monkeypatch.setattr(machine, "core_count", lambda: 1)
    monkeypatch.setattr(bench, "command_seconds", lambda *_: 0.5)
    monkeypatch.setattr(bench, "LANES", 64)
    # Of the other engines other tests measure what they need.
    monkeypatch.setattr(bench, "ENGINES", ("housner", "event"))
    for flags in (["--json"], ["-o", str(tmp_path)]):
        result = succeed("bench", "--seconds", "0", *flags)
        if flags != ["--json"]:
            assert "Not installed: numba: " in result.stdout
            assert "Met by no setting tried in its time: scipy loop at 0.01" in result.stdout
            *_, came_out, then = result.stdout.splitlines()
            assert re.fullmatch(
                r"\w+ makes .* steps of a block a second on this machine\.", came_out
            )
            assert then == "next: warprock trade"
            page = html.unescape((tmp_path / "report.html").read_text(encoding="utf-8"))
            assert f"<p>{came_out}</p>" in page
            assert "Steps of a block in space in a CPU second, one core" in page
            continue
        found = json.loads(result.stdout)
        assert found["prices"]["tried"] == {"scipy loop": 1}
        assert len(found["prices"]["missing"]) == len(peers.PEERS) + 1
        rows = found["prices"]["rows"]
        assert [row["name"] for row in rows] == ["housner", "event", "scipy loop"] * 4
        assert {row["engine"] for row in found["rows"]} == {"housner", "event"}


def test_a_device_has_a_row_an_engine_and_scene_and_a_column_a_number_of_lanes() -> None:
    key = {"engine": "event", "scene": "free", "precision": "float32", "cpu_lanes_per_s": 2e5}
    rows = [
        {**key, "lanes": 1000, "lanes_per_s": 4e4, "kernel_lanes_per_s": 5e4},
        {**key, "lanes": 10_000, "lanes_per_s": 3e5, "kernel_lanes_per_s": None},
    ]
    machine = {"cpu": "a processor", "cores": 2}
    told = find_device_bench(
        {"device": "a card", "machine": machine, "duration": 5.0, "rows": rows}
    )
    (sheet,) = told.sheets
    heads = ["engine", "scene", "precision", "1,000", "10,000", "kernel", "cpu"]
    assert [each.text for each in sheet.headings] == heads
    assert sheet.rows == [["event", "free", "float32", "40,000", "3.00e5", "-", "2.00e5"]]
    assert told.sentences == ["event runs 3.00e5 lanes a second there."]
    assert told.json["rows"][1]["lanes"] == 10_000
