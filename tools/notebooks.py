"""The tutorials of the manual as notebooks, `examples/*.ipynb`: one source, docs/tutorials/*.md.

    python -m tools.notebooks                   # writes them
    python -m tools.notebooks --run             # executes them, each in an empty folder
    python -m tools.notebooks --run first risk

A command becomes a cell of bash, a file a cell that writes it, a figure a cell that shows it. The
notebooks hold no outputs. What runs in them is installed by `pip install "warprock[docs]"`.
"""

from __future__ import annotations

import argparse
import json
import os
import pathlib
import re
import sys
import tempfile
import time
from typing import Any

ROOT = pathlib.Path(__file__).resolve().parents[1]
TUTORIALS, EXAMPLES = ROOT / "docs" / "tutorials", ROOT / "examples"

LIMIT_S = 600
"""Longest time of a cell [s]: kernels are compiled at the first run."""

Cell = dict[str, Any]
"""A cell, as the format of notebooks has it (4.5)."""

_FENCE = re.compile(
    r"^(?P<fence>`{3,})\{(?P<kind>[\w-]+)\}(?P<argument>[^\n]*)\n"
    r"(?P<options>(?::[^\n]*\n)*)(?P<body>.*?)^(?P=fence)$\n?",
    re.M | re.S,
)
_HEAD = re.compile(r"\A---\n.*?^---\n", re.M | re.S)
_LINK = re.compile(r"\]\((?P<up>\.\./)?(?P<page>[\w/-]+\.md)")


def cells_of(page: str, text: str) -> list[Cell]:
    """The cells of a tutorial.

    Args:
        page: Its name.
        text: Its source.
    """
    text, found, at = _HEAD.sub("", text), [], 0
    for match in _FENCE.finditer(text):
        found += _prose(text[at : match.start()])
        found += _block(page, match)
        at = match.end()
    found += _prose(text[at:])
    for number, cell in enumerate(found):
        cell["id"] = f"{page}-{number}"
    return found


def _cell(kind: str, text: str) -> Cell:
    """A cell of text or code."""
    more = {"execution_count": None, "outputs": []} if kind == "code" else {}
    return {"cell_type": kind, "id": "", "metadata": {}, "source": text, **more}


def _prose(text: str) -> list[Cell]:
    """A cell of text, whose links lead to the pages of the manual; none where there is no text."""

    def place(match: re.Match[str]) -> str:
        folder = "docs/" if match["up"] else "docs/tutorials/"
        return f"](../{folder}{match['page']}"

    text = _LINK.sub(place, text).strip()
    return [_cell("markdown", text)] if text else []


def _block(page: str, match: re.Match[str]) -> list[Cell]:
    """The cells of a block."""
    body, argument = match["body"].rstrip("\n"), match["argument"].strip()
    if match["kind"] == "command":
        fails = re.search(r"^:exit: [1-9]", match["options"], re.M)
        return [_cell("code", f"%%bash{' --no-raise-error' if fails else ''}\n{body}")]
    if match["kind"] == "file":
        folder = pathlib.PurePosixPath(argument).parent
        made = [_cell("code", f"%mkdir -p {folder}")] if str(folder) != "." else []
        return [*made, _cell("code", f"%%writefile {argument}\n{body}")]
    if match["kind"] == "figure":
        path = argument.removeprefix(f"/_made/tutorials/{page}/")
        return [
            _cell("code", f'from IPython.display import Image\n\nImage("{path}")'),
            *_prose(body),
        ]
    if match["kind"] == "code-cell":
        return [_cell("code", body)]
    if match["kind"] == "not-run":
        return _prose(f"Not run here, for {argument}:\n\n```sh\n{body}\n```")
    raise SystemExit(f"docs/tutorials/{page}.md: no notebook has a block {{{match['kind']}}}")


def notebooks() -> dict[str, dict[str, Any]]:
    """The notebooks by the names of their pages."""
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return {
        page.stem: {
            "cells": cells_of(page.stem, page.read_text(encoding="utf-8")),
            "metadata": kernel,
            "nbformat": 4,
            "nbformat_minor": 5,
        }
        for page in sorted(TUTORIALS.glob("*.md"))
    }


def text_of(notebook: dict[str, Any]) -> str:
    """A notebook as its file holds it."""
    return json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"


def execute(page: str, notebook: dict[str, Any]) -> None:
    """Executes a notebook in an empty folder; a cell that fails raises."""
    import nbclient
    import nbformat

    with tempfile.TemporaryDirectory(prefix=f"warprock-{page}-") as folder:
        client = nbclient.NotebookClient(
            nbformat.from_dict(notebook), timeout=LIMIT_S, resources={"metadata": {"path": folder}}
        )
        client.execute()


def main() -> None:
    """Writes the notebooks, or executes them."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    ask.add_argument("pages", nargs="*", help="names of tutorials; none is all of them")
    ask.add_argument("--run", action="store_true", help="execute them")
    asked = ask.parse_args()
    found = notebooks()
    programs = str(pathlib.Path(sys.executable).parent)
    os.environ["PATH"] = os.pathsep.join((programs, os.environ["PATH"]))
    for page in asked.pages or found:
        begin = time.perf_counter()
        if asked.run:
            execute(page, found[page])
            print(f"{page}: {time.perf_counter() - begin:.0f} s", flush=True)
        else:
            EXAMPLES.mkdir(exist_ok=True)
            (EXAMPLES / f"{page}.ipynb").write_text(text_of(found[page]), encoding="utf-8")


if __name__ == "__main__":
    main()
