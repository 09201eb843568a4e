"""What is said where somebody waits."""

import os
import time
import types

from warprock.running import waiting


def test_compiling_is_said_once_where_it_takes_long(tmp_path, monkeypatch):
    monkeypatch.setattr(waiting, "PATIENCE", 0.1)
    monkeypatch.setattr(waiting, "_GLANCE", 0.01)
    monkeypatch.setattr("warp.config.kernel_cache_dir", str(tmp_path))
    said = []
    with waiting.saying_what_takes_long(said.append):
        time.sleep(0.2)
        assert not said
        (tmp_path / f"kernel_p{os.getpid()}_t1").mkdir()
        time.sleep(0.4)
    assert said == [waiting.TEXT]


def test_a_run_of_minutes_is_announced_once_and_a_short_one_is_not(monkeypatch):
    clock = iter([10.0, 22.0, 10.0, 11.0, *[0.0] * waiting.ENOUGH])
    told = types.SimpleNamespace(perf_counter=lambda: next(clock), monotonic=time.monotonic)
    monkeypatch.setattr(waiting, "time", told)
    said = []
    with waiting.saying_what_takes_long(said.append):
        for _ in range(2):
            # 300 of 4,000 lanes in 12 s and in 1 s, and everything twice: 304 s and 25 s are left.
            forecast = waiting.Forecast(4000, 2.0, ", and more")
            for done in range(100, 1000, 100):
                forecast(done)
    assert said == ["some 5 minutes to go, and more"]
    # Lanes that are counted anew, chunk by chunk, tell nothing.
    forecast = waiting.Forecast(4000)
    for _ in range(waiting.ENOUGH):
        forecast(1000)
