"""What is said while kernels are compiled."""

import os
import time

from warprock.running import compiling


def test_compiling_is_said_once_where_it_takes_long(tmp_path, monkeypatch):
    monkeypatch.setattr(compiling, "PATIENCE", 0.1)
    monkeypatch.setattr(compiling, "_GLANCE", 0.01)
    monkeypatch.setattr("warp.config.kernel_cache_dir", str(tmp_path))
    said = []
    with compiling.saying_when_compiling(said.append):
        time.sleep(0.2)
        assert not said
        (tmp_path / f"kernel_p{os.getpid()}_t1").mkdir()
        time.sleep(0.4)
    assert said == [compiling.TEXT]
