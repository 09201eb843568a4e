"""What `doctor` says of a machine, and what commands say where kernels cannot be kept."""

from __future__ import annotations

import errno
import json
import os
import pathlib
import subprocess
import sys

import pytest

from tests.shared.commands import invoke
from warprock.engines import ENGINES
from warprock.errors import InputError
from warprock.kernels.launch.instance import kernel_module
from warprock.running.devices import keeping_kernels


def test_doctor_reports_this_machine():
    result = invoke("doctor", "--json")
    found = json.loads(result.stdout)
    assert result.exit_code == (1 if found["missing"] else 0)
    assert found["cores"] >= 1
    assert {"cpu"} <= {device["device"] for device in found["devices"]}
    assert all(found["versions"].values())
    assert set(found["engines"]) == set(ENGINES)


def test_doctor_counts_built_kernels_by_engine(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    built = ("event.block_run__1_ab", "event_space.body_run__2_cd", "two_block.stack_run__3_ef")
    for name in (*built, "spatial_event_launch__4_01"):
        folder = tmp_path / f"wp_warprock.kernels.{name}"
        folder.mkdir()
        (folder / "kernel.o").write_bytes(b"0" * 1000)
    (tmp_path / "wp_newton.solvers_23").mkdir()
    monkeypatch.setattr("warp.config.kernel_cache_dir", str(tmp_path))
    cache = json.loads(invoke("doctor", "--json").stdout)["kernel_cache"]
    assert cache["built_modules"] == 4
    assert cache["bytes"] == 4000
    assert cache["built_by_engine"] == {"event": 2, "two-block": 1, "earlier versions": 1}


BOTH = """if 1:
    import json
    from click.testing import CliRunner
    from warprock.cli.main import main
    run, doctor = (CliRunner().invoke(main, each) for each in (["run", "free-b0"], ["doctor"]))
    print(json.dumps([[run.exit_code, run.stderr], [doctor.exit_code, doctor.stdout]]))
"""


@pytest.mark.thorough
def test_without_room_for_kernels_one_line_says_where_to_put_them(tmp_path: pathlib.Path):
    file = tmp_path / "file"
    file.touch()
    cache = file / "cache"
    # Both commands in one process of their own: Warp settles its cache when it starts.
    done = subprocess.run(
        [sys.executable, "-c", BOTH],
        env={**os.environ, "WARP_CACHE_PATH": str(cache)},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.stderr == ""
    (run, run_said), (doctor, doctor_said) = json.loads(done.stdout)
    said = f"kernel cache: got '{cache}"
    assert (run, doctor) == (2, 1)
    assert run_said.startswith(f"error: {said}")
    assert run_said.count("\n") == 1
    assert f"missing: {said}" in doctor_said
    assert all("WARP_CACHE_PATH" in text for text in (run_said, doctor_said))


def test_what_the_cache_of_kernels_is_not_to_blame_for_says_what_it_is():
    with pytest.raises(FileNotFoundError, match="no_such_kernel"), keeping_kernels():
        kernel_module("no_such_kernel", precision="float64")
    with pytest.raises(BrokenPipeError), keeping_kernels():
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")
    with pytest.raises(InputError, match="No space left on device"), keeping_kernels():
        raise OSError(errno.ENOSPC, "No space left on device")


def test_doctor_exits_with_1_when_something_is_missing(monkeypatch: pytest.MonkeyPatch):
    from warprock.measure import doctor

    monkeypatch.setattr(doctor, "PACKAGES", (*doctor.PACKAGES, "no-such-package"))
    result = invoke("doctor")
    assert result.exit_code == 1
    assert "package no-such-package is not installed" in result.stdout
