"""Builds what is released, and tries it where nothing else is.

    python -m tools.try_wheel OUT                                  # with the Python that runs this
    python -m tools.try_wheel OUT --python python3.12 --python python3.13
    python3.14 try_wheel.py OUT --wheel warprock-0.1.0-py3-none-any.whl   # built elsewhere

The source distribution is built from the tree and the wheel from it. The wheel is installed into a
new environment in OUT, one for each Python, with the packages that it requires. A wheel that was
built elsewhere needs this file and no tree: so it is tried in a container. There its commands
run in an empty folder, with an empty home, with packages that cannot be written to, and with
nothing on the search path but the environment: no git, no compiler, not this tree. Where root runs
this, `setpriv` takes root's right to write everywhere. It prints a line for each check; the exit
code is 1 if one failed.
"""

from __future__ import annotations

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]

WITHOUT_RIGHTS = ("setpriv", "--inh-caps=-dac_override", "--bounding-set=-dac_override")
"""Root may write to any file; this takes that right."""

MODULES = """
import importlib, pkgutil, warprock
names = [each.name for each in pkgutil.walk_packages(warprock.__path__, "warprock.")]
apart = ("warprock.kernels.", "warprock.programs.", "warprock.__main__")
for name in names:
    if not name.startswith(apart):
        importlib.import_module(name)
assert len(names) > 400, names
"""
"""Every module is there; kernels and programs of others are imported where they run."""

CASES = """
import warprock as wr
for name in wr.case_names():
    if "fema" not in name:
        case = wr.load_case(name)
        assert wr.expand_lanes(case, range(min(3, case.lane_count))).lanes.lane_count
"""

TEMPLATES = """
import pathlib, warprock as wr
from warprock.case.template import start_case
from warprock.case.text import template_kinds
from warprock.recordings.column_file import Reading
from warprock.running.catalogue import write_case
for kind in template_kinds():
    file = write_case(start_case(kind, reading=Reading()), pathlib.Path(kind) / "case.toml")[0]
    wr.load_case(file)
"""

ENGINES = """
import warprock as wr
from warprock.engines import ENGINES, engine_class
from warprock.running.options import RunOptions
for name in ("free-b0", "stack-sine-pulse", "space-free", "arch"):
    case = wr.load_case(name, ["run.duration=0.2 s"])
    scene = wr.expand_lanes(case, range(1)).scene
    for engine in ENGINES:
        if engine_class(engine).supports(scene) is None:
            run = wr.run_case(case, engine, RunOptions(workers=1))
            assert run.response.lane_count == case.lane_count, engine
"""

COMMAND = """
import subprocess
subprocess.run(["warprock", "--version"], check=True)
"""
"""The command is on the search path, and need not be called by Python."""

CHECKS: dict[str, list[str]] = {
    "starts": ["-m", "warprock", "--version"],
    "its command": ["-c", COMMAND],
    "all modules": ["-c", MODULES],
    "lists": ["-m", "warprock", "list"],
    "the machine": ["-m", "warprock", "doctor"],
    "all cases": ["-c", CASES],
    "all templates": ["-c", TEMPLATES],
    "a run with its page": ["-m", "warprock", "run", "pulse", "-e", "housner", "-o", "results"],
    "kernels": ["-c", ENGINES],
    "records": ["-m", "warprock", "records", "list"],
    "a table of the paper": ["-m", "warprock", "reproduce", "table6", "-o", "paper"],
}
"""What is tried in the environment, in this order: arguments of Python."""


def build(out: pathlib.Path) -> tuple[pathlib.Path, pathlib.Path]:
    """The source distribution of the tree, and the wheel that is built from it."""
    for old in (*out.glob("*.whl"), *out.glob("*.tar.gz")):
        old.unlink()
    command = [sys.executable, "-m", "build", "--outdir", str(out), str(ROOT)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    (source,), (wheel,) = out.glob("*.tar.gz"), out.glob("*.whl")
    return source, wheel


def install(python: str, wheel: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """A new environment with the wheel and what it requires; gives its Python."""
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([python, "-m", "venv", str(folder)], check=True)
    own = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    subprocess.run([own, "-m", "pip", "install", "--quiet", str(wheel)], check=True)
    return own


def protect(folder: pathlib.Path) -> None:
    """Takes the right to write in a folder and below it."""
    for place, _, files in os.walk(folder):
        for name in files:
            file = pathlib.Path(place) / name
            if not file.is_symlink():
                file.chmod(file.stat().st_mode & 0o555)
        pathlib.Path(place).chmod(0o555)


def environment(home: pathlib.Path, own: pathlib.Path) -> dict[str, str]:
    """The environment of a check: a home and a search path, and nothing else."""
    kept = {name: os.environ[name] for name in ("SYSTEMROOT", "TEMP") if name in os.environ}
    return {"HOME": str(home), "USERPROFILE": str(home), "PATH": str(own.parent), **kept}


def check(own: pathlib.Path, place: pathlib.Path) -> int:
    """Runs the checks in a new folder; gives how many failed."""
    shutil.rmtree(place, ignore_errors=True)
    home, work = place / "home", place / "work"
    home.mkdir(parents=True)
    work.mkdir()
    taken = WITHOUT_RIGHTS if hasattr(os, "geteuid") and os.geteuid() == 0 else ()
    failed = 0
    for name, arguments in CHECKS.items():
        begin = time.perf_counter()
        done = subprocess.run(
            [shutil.which(taken[0]), *taken[1:], own, *arguments] if taken else [own, *arguments],
            cwd=work,
            env=environment(home, own),
            capture_output=True,
            text=True,
            encoding="utf-8",
            check=False,
        )
        failed += done.returncode != 0
        print(f"  {name}: {'failed' if done.returncode else 'passed'}, ", end="")
        print(f"{time.perf_counter() - begin:.0f} s", flush=True)
        if done.returncode:
            print(done.stdout[-2000:] + done.stderr[-4000:])
    page = work / "results" / "report.html"
    if not page.exists() or "<svg" not in page.read_text(encoding="utf-8"):
        failed += 1
        print("  the page of the run has no figure")
    return failed


def main() -> int:
    """Builds, installs and checks."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    ask.add_argument("out", type=pathlib.Path)
    ask.add_argument("--python", action="append", default=[], help="a Python to try it with")
    ask.add_argument("--wheel", type=pathlib.Path, help="a wheel that is built already")
    asked = ask.parse_args()
    out = asked.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    if asked.wheel is None:
        source, wheel = build(out)
        print(f"{source.name}: {source.stat().st_size / 1e6:.1f} MB")
    else:
        wheel = asked.wheel.resolve(strict=True)
    print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB")
    failed = 0
    for python in asked.python or [sys.executable]:
        ask_version = [python, "-c", "import platform; print(platform.python_version())"]
        version = subprocess.check_output(ask_version, text=True).strip()
        print(f"Python {version}", flush=True)
        folder = out / f"python-{version}"
        own = install(python, wheel, folder)
        protect(folder)
        failed += check(own, out / f"empty-{version}")
        for place, _, _ in os.walk(folder):
            pathlib.Path(place).chmod(0o755)
    print(f"{failed} checks failed" if failed else "all checks passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
