"""Programs beside ours in `bench`: rows, and what is held against what."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from tests.shared.programs import PACKAGES, absent, present
from warprock.cli.main import main
from warprock.engines import ENGINES
from warprock.measure import bench, peers
from warprock.model import rocking
from warprock.model.motion import StillBase
from warprock.run import machine
from warprock.run.batch import run_batch

OURS = {"engine": "event", "error": 5e-5, "cpu_s_per_simulated_s": 1.0}
OURS["cpu_s_per_simulated_s_alone"] = 2.0


@pytest.mark.extra
@pytest.mark.parametrize("peer", peers.PEERS)
def test_the_row_of_a_peer_is_what_it_ran(peer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    present(peer)
    monkeypatch.setattr(peers, "SUBSTEPS", (2, 4))
    for other in set(peers.PEERS) - {peer}:
        absent(monkeypatch, PACKAGES[other])
    found = peers.compare([OURS], 0.0)
    assert len(found["missing"]) == len(peers.PEERS) - 1
    assert [row["steps_per_s"] for row in found["rows"]] == [480.0, 960.0]
    for row in found["rows"]:
        assert row["peer"] == peer
        assert 0.0 < row["error"] < 0.2
        assert row["cpu_s_per_simulated_s"] == pytest.approx(row["cpu_s"] / bench.ERROR_DURATION)
        assert row["cost / event"] == pytest.approx(row["cpu_s_per_simulated_s"])
        assert row["cost / event_alone"] == pytest.approx(row["cpu_s_per_simulated_s"] / 2)
    # Some twenty times on a busy machine: packed lanes against one scene at a time.
    assert found["space"][f"ratio to {peer}"] > 5.0
    # No finer run is started that would not fit.
    monkeypatch.setattr(peers, "CPU_LIMIT", 0.0)
    assert [row["steps_per_s"] for row in peers.compare([OURS], 0.0)["rows"]] == [480.0]


def test_accuracy_is_what_the_coarsest_setting_gives() -> None:
    row = bench.accuracy_row("event", 0.1)
    assert row["error"] <= bench.ACCURACY
    assert row["reached"]
    assert 0.0 < row["cpu_s_per_simulated_s"] < row["cpu_s_per_simulated_s_alone"]
    # The error is that of the very setting, taken by hand.
    first = next(
        s for s in bench.ACCURACY_SETTINGS["event"] if 1 / s.time_step == row["steps_per_s"]
    )
    lanes = bench.b0_lanes(np.array([bench.B0_RATIO]))
    assert lanes.rotation_start[0] == 0.5 * rocking.slenderness_angle(1.0, 5.0)
    response = run_batch("event", lanes, StillBase(1), bench.b0_times(), settings=first)
    assert bench.b0_error(response.times, response["rotation"][0]) == row["error"]
    with pytest.raises(ValueError, match="times"):
        bench.b0_error(response.times[:-1], response["rotation"][0][:-1])


@pytest.mark.thorough
def test_accuracy_that_is_not_reached_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    coarse = bench.ACCURACY_SETTINGS["impulse"][:1]
    monkeypatch.setitem(bench.ACCURACY_SETTINGS, "impulse", coarse)
    row = bench.accuracy_row("impulse", 0.1)
    assert row["error"] > bench.ACCURACY
    assert not row["reached"]
    assert row["settings"] == "240 frames x 200 steps"
    assert row["steps_per_s"] == 240 * 200


@pytest.mark.thorough
def test_bench_prints_both_kinds_of_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole command with measurements that end at once, the peers absent."""
    for peer in peers.PEERS:
        absent(monkeypatch, PACKAGES[peer])
    monkeypatch.setattr(machine, "core_count", lambda: 1)
    monkeypatch.setattr(bench, "command_seconds", lambda *_: 0.5)
    monkeypatch.setattr(bench, "LANES", 64)
    # Of the other engines other tests measure what they need.
    monkeypatch.setattr(bench, "ENGINES", ("housner", "event"))
    result = CliRunner().invoke(main, ["bench", "--seconds", "0", "--json"])
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert found["peers"]["rows"] == []
    assert len(found["peers"]["missing"]) == len(peers.PEERS)
    names = [row["engine"] for row in found["accuracy"]]
    assert set(names) == {row["engine"] for row in found["rows"]} <= set(ENGINES)
    event = next(row for row in found["accuracy"] if row["engine"] == "event")
    assert event["error"] <= bench.ACCURACY


@pytest.mark.extra
@pytest.mark.parametrize("peer", peers.PEERS)
def test_a_peer_is_held_against_an_event_no_less_accurate(
    peer: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    present(peer)
    monkeypatch.setattr(peers, "SUBSTEPS", (20,))
    ours = [{**OURS, "error": 0.5}]
    (row,) = peers.measure(peer, ours, 0.1)
    assert row["event_error"] <= row["error"] < 0.5
    assert len(ours) == 2
    assert row["cost / event"] == pytest.approx(
        row["cpu_s_per_simulated_s"] / ours[1]["cpu_s_per_simulated_s"]
    )
