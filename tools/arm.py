"""Holds the lanes of an emulated ARM processor against those of this one, bit for bit.

    python -m tools.arm FOLDER    # all engines, plane and space, both precisions
    python -m tools.arm FOLDER free-b1-b3 --engines event --precisions float64

It runs `tools.freeze` here and under emulation and compares the two lists of fingerprints, a line
for each response field. NumPy makes angles of attitudes, and its arc tangent has other last bits on
a processor with AVX-512 than on all others: here it does without. It needs Debian on an x86-64
processor, root's `apt-get` for the packages of arm64, and the package qemu-user-static. FOLDER
keeps what it brings, some 1.4 GB: Python 3.11 and its libraries for arm64 in FOLDER/root, the
packages of PyPI in FOLDER/site, with the versions that are installed here, the kernels that are
compiled there in FOLDER/kernels, and the fingerprints. Another run goes on from what is there. One
process is emulated: nothing that it starts would be.

An emulated processor compiles a kernel in one to five minutes; all of it takes some hours.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import itertools
import os
import pathlib
import shutil
import subprocess
import sys

from warprock.engines import ENGINES

ROOT = pathlib.Path(__file__).resolve().parents[1]

QEMU = "qemu-aarch64-static"
DEBIAN = (
    *("python3.11-minimal", "python3.11", "libpython3.11-minimal", "libpython3.11-stdlib", "libc6"),
    *("libstdc++6", "libgcc-s1", "zlib1g", "libexpat1", "libssl3", "libffi8", "libsqlite3-0"),
    *("libbz2-1.0", "liblzma5", "libuuid1", "libcrypt1", "libncursesw6", "libtinfo6"),
    *("libreadline8", "libdb5.3", "libnsl2", "libtirpc3"),
)
"""Debian's packages that Python for arm64 consists of."""
PYPI = (
    *("warp-lang", "numpy", "scipy", "pandas", "pyarrow", "pydantic", "click", "rich", "jinja2"),
    "matplotlib",
)
"""Packages that the lanes need; Newton is not among them."""
PLATFORMS = (34, 31, 28, 27, 24, 17)
"""Versions of the C library whose wheels are taken, the newest first."""

WITHOUT_AVX512 = "X86_V4"
"""What NumPy does without here, by its own name (from NumPy 2.4)."""

PLANE = ("free-b1-b3", "single-sine-pulse", "record-ridgecrest", "stack-sine-pulse")
SPACE = ("space-free", "space-biaxial", "stack-spatial-sine")
"""Shipped cases that every engine but `assembly` runs some of; an arch is made for that one."""


def prepare(folder: pathlib.Path) -> None:
    """Brings Python and its packages for arm64, where they are not there yet."""
    if shutil.which(QEMU) is None:
        raise SystemExit(f"{QEMU} is not there: apt-get install qemu-user-static")
    system, debs = folder / "root", folder / "debs"
    if not (system / "usr/bin/python3.11").exists():
        debs.mkdir(parents=True, exist_ok=True)
        subprocess.run(["dpkg", "--add-architecture", "arm64"], check=True)
        subprocess.run(["apt-get", "update", "-qq"], check=True)
        names = [f"{name}:arm64" for name in DEBIAN]
        subprocess.run(["apt-get", "download", "-qq", *names], cwd=debs, check=True)
        for each in sorted(debs.glob("*.deb")):
            subprocess.run(["dpkg-deb", "-x", str(each), str(system)], check=True)
    site = folder / "site"
    if not site.exists():
        platforms = [f"--platform=manylinux_2_{version}_aarch64" for version in PLATFORMS]
        wanted = [f"{name}=={importlib.metadata.version(name)}" for name in PYPI]
        pip = [sys.executable, "-m", "pip", "install", "--quiet", f"--target={site}.part"]
        only = ["--python-version=3.11", "--only-binary=:all:", "--no-compile"]
        subprocess.run(
            [*pip, *platforms, "--platform=manylinux2014_aarch64", *only, *wanted], check=True
        )
        pathlib.Path(f"{site}.part").rename(site)


def arch(folder: pathlib.Path) -> str:
    """A case of an arch, for `assembly`."""
    file = folder / "arch" / "case.toml"
    if not file.exists():
        made = [sys.executable, "-m", "warprock", "init", "arch", str(file)]
        subprocess.run(made, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    return str(file)


def fingerprints(command: list[str], file: pathlib.Path, **more: str) -> dict[str, str]:
    """Fingerprints by what they are of: those in a file, or those that a command prints."""
    if not file.exists():
        part = file.with_suffix(".part")
        with part.open("w", encoding="utf-8") as out:
            subprocess.run(command, cwd=ROOT, stdout=out, check=True, env={**os.environ, **more})
        part.rename(file)
    rows = (line.rsplit(" ", 1) for line in file.read_text(encoding="utf-8").splitlines())
    return {what: found for what, found in rows if what.startswith("lanes ")}


def compare(folder: pathlib.Path, case: str, asked: list[str]) -> tuple[int, list[str]]:
    """How many fields of a case are the same there as here, and which are not."""
    name = "-".join([pathlib.Path(case).parent.name if "/" in case else case, *asked])
    name = name.replace("--", "").replace("/", "-")
    freeze = ["-m", "tools.freeze", case, *asked]
    here = fingerprints(
        [sys.executable, *freeze], folder / f"{name}.x86", NPY_DISABLE_CPU_FEATURES=WITHOUT_AVX512
    )
    if not here:
        return 0, []
    there = fingerprints(
        [QEMU, "-L", str(folder / "root"), str(folder / "root/usr/bin/python3.11"), *freeze],
        folder / f"{name}.arm",
        PYTHONHOME=str(folder / "root/usr"),
        PYTHONPATH=f"{folder / 'site'}:{ROOT}",
        WARP_CACHE_PATH=str(folder / "kernels"),
        PYTHONPYCACHEPREFIX=str(folder / "bytecode"),
    )
    if here.keys() != there.keys():
        raise SystemExit(f"{case}: other fields there than here: {here.keys() ^ there.keys()}")
    return len(here), [what for what in here if here[what] != there[what]]


def main() -> int:
    """Compares what was asked for, and prints what differs."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    ask.add_argument("folder", type=pathlib.Path)
    ask.add_argument("cases", nargs="*")
    ask.add_argument("--engines", nargs="+", default=list(ENGINES))
    ask.add_argument("--precisions", nargs="+", default=["float64", "float32"])
    ask.add_argument("--lanes", default="3")
    ask.add_argument("--seconds", default="0.5")
    asked = ask.parse_args()
    folder = asked.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    prepare(folder)
    options = ["--lanes", asked.lanes, "--seconds", asked.seconds]
    total, other = 0, []
    cases = asked.cases or [*PLANE, *SPACE, arch(folder)]
    for case, engine, precision in itertools.product(cases, asked.engines, asked.precisions):
        only = [*options, "--engines", engine, "--precisions", precision]
        count, found = compare(folder, case, only)
        if not count:
            continue
        total, other = total + count, other + found
        same = f"{count - len(found)} of {count} fields have the same bits"
        print(f"{case} {engine} {precision}: {same}", flush=True)
    for what in other:
        print(f"  other bits: {what}")
    print(f"{total - len(other)} of {total} fields have the same bits")
    return 1 if other else 0


if __name__ == "__main__":
    sys.exit(main())
