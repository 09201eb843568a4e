"""Worker processes end with the process that started them."""

from __future__ import annotations

import os
import pathlib
import signal
import subprocess
import sys
import time

TASKS = 40
SCRIPT = """
import pathlib, signal, sys, time
from warprock.processes import worker_processes

def work(k):
    pathlib.Path(sys.argv[1], f"{k}.txt").write_text("begun")
    time.sleep(0.25)

if __name__ == "__main__":
    # What a shell starts in the background has Ctrl-C ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with worker_processes(2) as pool:
        list(pool.map(work, range(int(sys.argv[2]))))
"""


def test_ctrl_c_drops_what_has_not_begun_and_leaves_no_process(tmp_path: pathlib.Path) -> None:
    """Ctrl-C at a terminal reaches the whole group of processes."""
    (tmp_path / "script.py").write_text(SCRIPT)
    (tmp_path / "out").mkdir()
    run = subprocess.Popen(
        [sys.executable, tmp_path / "script.py", tmp_path / "out", str(TASKS)],
        start_new_session=True,
        stderr=subprocess.PIPE,
    )
    while len(list((tmp_path / "out").iterdir())) < 3:
        assert run.poll() is None
        time.sleep(0.02)
    os.killpg(run.pid, signal.SIGINT)
    # A worker that is left over would keep its end of the pipe open.
    _, said = run.communicate(timeout=60)
    assert run.returncode != 0
    assert said.count(b"Traceback") == 1, said
    assert len(list((tmp_path / "out").iterdir())) < TASKS
