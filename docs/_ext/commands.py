"""Commands and files of the manual: each `{command}` block is run when the manual is built.

A page has a folder of its own, `docs/_made/PAGE`, in which its blocks run in their order:

- `{file} PATH` writes a file, and shows it;
- `{command}` runs its lines in bash and shows them with what they print. Options: `head` and `tail`
  (lines of the output to show), `exit` (the exit code that is right), `hide` (`output` shows the
  command alone, `command` the output alone, `all` neither), `markdown` (the output is a part of the
  page);
- `{not-run} REASON` shows a command that no build can run, and says why.

All pages run before Sphinx reads the first one, so that a page may show a figure that another one
made. A page whose blocks and whose program have not changed is not run again.
"""

from __future__ import annotations

import concurrent.futures
import dataclasses
import functools
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective
from starter import started

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "docs"
MADE = "_made"
WORKERS = 2
WIDTH = 104
"""Characters of a line that a page has room for."""
LIMIT_S = 600
"""Longest time of one block [s], on a busy machine that compiles its kernels first."""

_FENCE = re.compile(
    r"^(?P<fence>`{3,})\{(?P<kind>command|file)\}(?P<argument>[^\n]*)\n"
    r"(?P<options>(?::[^\n]*\n)*)(?P<body>.*?)^(?P=fence)$",
    re.M | re.S,
)
_log = logging.getLogger(__name__)


class Block(NamedTuple):
    """A block of a page that is run or written.

    Attributes:
        kind: "command" or "file".
        argument: Path of a file.
        exit: Exit code that is right.
        body: The command, or what the file holds.
        line: Line of the page on which it starts.
    """

    kind: str
    argument: str
    exit: int
    body: str
    line: int


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What a block printed, what was wrong with it, if anything, and how long it took [s]."""

    printed: str
    wrong: str = ""
    seconds: float = 0.0


def blocks_of(text: str) -> list[Block]:
    """The blocks of a page, in their order."""
    found = []
    for match in _FENCE.finditer(text):
        asked = re.search(r"^:exit: (\d+)$", match["options"], re.M)
        line = text.count("\n", 0, match.start()) + 1
        code = int(asked[1]) if asked else 0
        found.append(Block(match["kind"], match["argument"].strip(), code, match["body"], line))
    return found


def run_block(block: Block, folder: pathlib.Path, first: str = "") -> Outcome:
    """Runs a command, or writes a file, in the folder of its page.

    Args:
        block: The command or the file.
        folder: Of its page.
        first: Folder whose programs are found before all others.
    """
    if block.kind == "file":
        path = folder / block.argument
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.body, encoding="utf-8")
        return Outcome("")
    programs = [first, str(pathlib.Path(sys.executable).parent), os.environ["PATH"]]
    start = time.monotonic()
    run = functools.partial(
        subprocess.run,
        ["bash", "-euo", "pipefail", "-c", block.body],
        cwd=folder,
        env={
            **os.environ,
            "PATH": os.pathsep.join(filter(None, programs)),
            "NO_COLOR": "1",
            "MANUAL_ROOT": str(ROOT),
        },
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    try:
        done = run()
    except subprocess.TimeoutExpired:
        return Outcome("", f"took more than {LIMIT_S} s", LIMIT_S)
    wrong = ""
    if done.returncode != block.exit:
        wrong = f"exit code {done.returncode}, must be {block.exit}: {done.stderr[-2000:]}"
    printed = done.stdout + (done.stderr if block.exit else "")
    return Outcome(
        re.sub(r"[ \t]+$", "", printed, flags=re.M).rstrip(), wrong, time.monotonic() - start
    )


def run_page(page: str, made: pathlib.Path, program: str, first: str) -> list[Outcome]:
    """Runs the blocks of a page, or reads what they printed when they ran last.

    Args:
        page: Its name, without ending.
        made: Folder below which the folders of pages lie.
        program: What stands for the state of the program.
        first: See `run_block`.
    """
    blocks = blocks_of((DOCS / f"{page}.md").read_text(encoding="utf-8"))
    folder, kept = made / page, made / f"{page}.json"
    if not blocks:
        return []
    state = hashlib.sha256(repr((blocks, program)).encode()).hexdigest()
    if kept.is_file():
        last = json.loads(kept.read_text(encoding="utf-8"))
        if last["state"] == state:
            return [Outcome(**each) for each in last["outcomes"]]
        kept.unlink()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    outcomes = [run_block(block, folder, first) for block in blocks]
    if not any(outcome.wrong for outcome in outcomes):
        told = {"state": state, "outcomes": [dataclasses.asdict(each) for each in outcomes]}
        kept.write_text(json.dumps(told), encoding="utf-8")
    return outcomes


def _program() -> str:
    """The state of the program: when its sources were changed last."""
    folders = (ROOT / "warprock", ROOT / "kernels", ROOT / "cases")
    files = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
    sources = [path for path in files if path.suffix != ".pyc"]
    return str(max(path.stat().st_mtime_ns for path in sources))


def _run_all(app: Sphinx) -> None:
    pages = sorted(app.project.discover(app.config.exclude_patterns))
    program, made = _program(), pathlib.Path(app.srcdir) / MADE
    with (
        tempfile.TemporaryDirectory() as short,
        started(pathlib.Path(short)) as first,
        concurrent.futures.ThreadPoolExecutor(WORKERS) as pool,
    ):
        done = pool.map(lambda page: run_page(page, made, program, str(first)), pages)
        outcomes = dict(zip(pages, done, strict=True))
    for page, found in outcomes.items():
        blocks = blocks_of((DOCS / f"{page}.md").read_text(encoding="utf-8"))
        for block, outcome in zip(blocks, found, strict=True):
            if outcome.wrong:
                _log.warning("%s%s", block.body, outcome.wrong, location=(page, block.line))
    app.manual_outcomes = outcomes  # type: ignore[attr-defined]


class _Shown(SphinxDirective):
    """A block that was run before: it takes the next outcome of its page."""

    has_content = True

    def outcome(self) -> Outcome:
        """What the block printed."""
        page = self.env.docname
        counts = self.env.temp_data.setdefault("manual_blocks", {})
        place = counts[page] = counts.get(page, -1) + 1
        found: list[Outcome] = self.env.app.manual_outcomes[page]  # type: ignore[attr-defined]
        return found[place]

    def code(self, text: str, language: str, caption: str = "") -> nodes.Node:
        """A block of code."""
        shown = nodes.literal_block(text, text, language=language)
        self.set_source_info(shown)
        if not caption:
            return shown
        around = nodes.container("", literal_block=True, classes=["literal-block-wrapper"])
        around += nodes.caption(caption, caption)
        around += shown
        return around


def _wrapped(line: str) -> list[str]:
    """A sentence in lines that a page has room for; a row of a table as it is."""
    if len(line) <= WIDTH or "  " in line.strip() or "\u2500" in line:
        return [line]
    return textwrap.wrap(line, WIDTH, subsequent_indent="  ")


class Command(_Shown):
    """A command and what it prints."""

    option_spec: ClassVar[dict[str, Callable[[str], Any]]] = {
        "head": directives.nonnegative_int,
        "tail": directives.nonnegative_int,
        "exit": directives.nonnegative_int,
        "hide": lambda word: directives.choice(word, ("output", "command", "all")),
        "markdown": directives.flag,
    }

    def run(self) -> list[nodes.Node]:
        """Nodes of the command and of its output."""
        printed, hidden = self.outcome().printed, self.options.get("hide", "")
        if "markdown" in self.options:
            return self.parse_text_to_nodes(printed, allow_section_headings=True)
        found = []
        if hidden not in ("command", "all"):
            found.append(self.code("\n".join(self.content), "sh"))
        if printed and hidden not in ("output", "all"):
            shown = self.code(self._cut(printed), "text")
            shown["classes"] = ["printed"]
            found.append(shown)
        return found

    def _cut(self, printed: str) -> str:
        lines = [part for line in printed.splitlines() for part in _wrapped(line)]
        head, tail = self.options.get("head"), self.options.get("tail", 0)
        if (head is None and not tail) or len(lines) <= (head or 0) + tail:
            return "\n".join(lines)
        kept = lines[: head or 0], lines[len(lines) - tail :]
        return "\n".join([*kept[0], "...", *kept[1]])


class File(_Shown):
    """A file that the reader writes."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Nodes of the file, its name above it."""
        self.outcome()
        path = self.arguments[0]
        language = {"toml": "toml", "py": "python", "csv": "text", "txt": "text", "obj": "text"}[
            path.rpartition(".")[2]
        ]
        return [self.code("\n".join(self.content), language, path)]


class NotRun(_Shown):
    """A command that no build of the manual can run, and why."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Nodes of the command, the reason below it."""
        shown = self.code("\n".join(self.content), "sh")
        reason = nodes.paragraph("", f"Not run when this manual is built: {self.arguments[0]}.")
        reason["classes"] = ["not-run"]
        return [shown, reason]


def setup(app: Sphinx) -> dict[str, Any]:
    """Adds the directives to Sphinx."""
    app.add_directive("command", Command)
    app.add_directive("file", File)
    app.add_directive("not-run", NotRun)
    app.connect("builder-inited", _run_all)
    return {"version": "1", "parallel_read_safe": False, "parallel_write_safe": True}
