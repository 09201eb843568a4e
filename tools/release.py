"""Makes a release, up to the upload: everything but what cannot be taken back.

    python -m tools.release 0.1.0 OUT --python python3.12

Nothing changes in this tree. A clone of its last commit, OUT/source, gets the notebooks of today's
tutorials and the version: the section
of the changelog loses its mark "(unreleased)" and a new one begins, CITATION.cff gets version and
date, both are committed, and the commit gets the tag, from which the version of the package is
read. From there the source distribution and the wheel are built and tried (`tools.try_wheel`), and
the manual is built into OUT/docs/VERSION, in an environment that has the wheel: so it says its
version. Each page of it links to OUT/docs/index.html, which lists the manuals of all versions that
have a tag. OUT/notes.md holds the notes. What is left to do is printed at the end.
"""

from __future__ import annotations

import argparse
import datetime
import os
import pathlib
import re
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]

VERSION = re.compile(r"(\d+)\.(\d+)\.(\d+)")
MARK = " (unreleased)"
"""What the heading of the changelog's top section has until its release."""


def git(source: pathlib.Path, *arguments: str) -> str:
    """What git prints in a folder."""
    done = subprocess.run(
        ["git", *arguments], cwd=source, check=True, capture_output=True, text=True
    )
    return done.stdout.strip()


def section(changelog: str, version: str) -> str:
    """The lines of a version in the changelog.

    Raises:
        SystemExit: It has no such section, or one without lines.
    """
    head = rf"^## {re.escape(version)}(?: \(unreleased\))?\n"
    found = re.search(rf"{head}(.*?)(?=^## |\Z)", changelog, re.M | re.S)
    if found is None or not found[1].strip():
        raise SystemExit(f"CHANGELOG.md: has no lines below a heading '## {version}{MARK}'")
    return found[1].strip()


def judge(source: pathlib.Path, version: str) -> None:
    """Refuses a version that cannot be the next one.

    Raises:
        SystemExit: It is no version, is not above those that there are, or is not what the top of
            the changelog is for.
    """
    parts = VERSION.fullmatch(version)
    if parts is None:
        raise SystemExit(f"version: got {version!r}, must be three numbers, such as 0.1.0")
    tags = [VERSION.fullmatch(tag[1:]) for tag in git(source, "tag", "--list", "v*").split()]
    known = [tuple(map(int, each.groups())) for each in tags if each is not None]
    if known and tuple(map(int, parts.groups())) <= max(known):
        least = ".".join(map(str, max(known)))
        raise SystemExit(f"version: got {version}, must be above {least}, which has a tag")
    top = re.search(r"^## (.*)$", (source / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
    if top is None or top[1] != version + MARK:
        wanted, got = f"## {version}{MARK}", top and top[0]
        raise SystemExit(f"CHANGELOG.md: its first section must be '{wanted}', got {got!r}")


def mark(source: pathlib.Path, version: str, day: datetime.date) -> str:
    """Gives the clone its version: changelog, citation, commit, tag; gives the notes.

    Args:
        source: The clone.
        version: The version.
        day: The day of its release.
    """
    judge(source, version)
    file = source / "CHANGELOG.md"
    text = file.read_text(encoding="utf-8")
    notes = section(text, version)
    major, minor, _ = map(int, version.split("."))
    opened = f"## {major}.{minor + 1}.0{MARK}\n\n## {version}"
    file.write_text(text.replace(f"## {version}{MARK}", opened, 1), encoding="utf-8")
    cite = source / "CITATION.cff"
    lines = [
        line
        for line in cite.read_text(encoding="utf-8").splitlines()
        if not line.startswith(("version:", "date-released:"))
    ]
    at = next(number for number, line in enumerate(lines) if line.startswith("license:"))
    lines[at:at] = [f"version: {version}", f"date-released: {day}"]
    cite.write_text("\n".join(lines) + "\n", encoding="utf-8")
    git(source, "commit", "--quiet", "--all", "--message", f"Version {version}")
    git(source, "tag", "--annotate", f"v{version}", "--message", f"warprock {version}")
    return notes


def versions_page(versions: list[str]) -> str:
    """The page that lists the manuals of versions.

    Args:
        versions: The newest first; the manual of each is a folder beside the page.
    """
    rows = "\n".join(f'<li><a href="{each}/index.html">{each}</a></li>' for each in versions)
    return (
        '<!doctype html>\n<html lang="en">\n<head><meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        "<title>Manuals of warprock</title></head>\n"
        '<body style="font-family: sans-serif; margin: 2em">\n'
        f"<h1>Manuals of warprock</h1>\n<p>The newest first.</p>\n<ul>\n{rows}\n</ul>\n"
        "</body>\n</html>\n"
    )


def build_manual(source: pathlib.Path, version: str, out: pathlib.Path) -> pathlib.Path:
    """The manual of a version, in a new environment with its wheel; gives its folder.

    Args:
        source: The clone.
        version: The version.
        out: Folder that holds dist/, and gets docs/.
    """
    (wheel,) = (out / "dist").glob(f"warprock-{version}-*.whl")
    python = str(out / "manual" / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))
    run(source, sys.executable, "-m", "venv", str(out / "manual"))
    run(source, python, "-m", "pip", "install", "--quiet", f"{wheel}[docs,dxf]")
    docs = out / "docs"
    build = ["-m", "sphinx", "-W", "--keep-going", "-q", "-A", "versions=../index.html"]
    run(source, python, *build, "docs", str(docs / version))
    tags = git(source, "tag", "--list", "v*", "--sort=-version:refname").split()
    (docs / "index.html").write_text(versions_page([tag[1:] for tag in tags]), encoding="utf-8")
    return docs / version


def run(source: pathlib.Path, *command: str) -> None:
    """Runs a command in a folder, and says so; ends if it fails."""
    print("+", shlex.join(command), flush=True)
    if subprocess.run(command, cwd=source, check=False).returncode:
        raise SystemExit(f"{shlex.join(command)}: failed")


def main() -> None:
    """Makes the release."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    ask.add_argument("version")
    ask.add_argument("out", type=pathlib.Path)
    ask.add_argument("--python", action="append", default=[], help="a Python to try the wheel with")
    asked = ask.parse_args()
    judge(ROOT, asked.version)
    out = asked.out.resolve()
    source = out / "source"
    if source.exists():
        raise SystemExit(f"{source}: must not exist already")
    out.mkdir(parents=True, exist_ok=True)
    git(ROOT, "clone", "--quiet", str(ROOT), str(source))
    run(source, sys.executable, "-m", "tools.notebooks")
    git(source, "add", "examples")
    notes = mark(source, asked.version, datetime.datetime.now(datetime.UTC).date())
    (out / "notes.md").write_text(f"# warprock {asked.version}\n\n{notes}\n", encoding="utf-8")
    pythons = [word for python in asked.python for word in ("--python", python)]
    run(source, sys.executable, "-m", "tools.try_wheel", str(out / "dist"), *pythons)
    manual = build_manual(source, asked.version, out)
    print(f"warprock {asked.version} is made. What is left, and cannot be taken back:")
    print(f"  git pull {source} && git push && git push origin v{asked.version}")
    print(f"  python -m twine upload {out}/dist/warprock-{asked.version}*")
    print(f"  publish {manual} and {manual.parent}/index.html beside the manuals of other versions")
    print(f"  publish {out}/notes.md with the tag")


if __name__ == "__main__":
    main()
