"""What a page holds: plain data that the template lays out, made by one module a kind of result."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from warprock.findings.sheets import Sheet


@dataclasses.dataclass(frozen=True)
class Picture:
    """A figure.

    Attributes:
        file: Name of its file in the folder, which tells figures apart.
        title: What it shows, in one line.
        alt: What a reader who cannot see it is told.
        source: The picture as a `data:` address.
        digest: SHA-256 of the file in the folder that shows the same.
    """

    file: str
    title: str
    alt: str
    source: str
    digest: str = ""


@dataclasses.dataclass(frozen=True)
class Proof:
    """A statement with what shows it, such as a conflict in the seed paper.

    Attributes:
        title: The statement.
        text: What shows it.
    """

    title: str
    text: str


@dataclasses.dataclass(frozen=True)
class Chapter:
    """One set of results.

    Attributes:
        kind: What it is, in a word or two: `Run`, `Overturning map`.
        title: Title of the case, or of the work.
        found: What came out, in sentences made from the numbers.
        asked: What was asked: names and texts.
        background: Where the inputs come from, in paragraphs.
        case_text: The case as it was run, as text; empty where there is none.
        scenes: Lanes to play, ready for JSON; None where there are none.
        pictures: Its figures.
        sheets: Its tables.
        proofs: Statements with what shows them, under `proofs_title`.
        proofs_title: What the proofs are.
        words: Words of the tables that need a meaning: word, number of lanes, meaning.
        provenance: What the numbers depend on: names and texts.
        citations: What to cite besides warprock.
        parts: Smaller chapters inside, such as a table of the seed paper.
    """

    kind: str
    title: str
    found: Sequence[str] = ()
    asked: Sequence[tuple[str, str]] = ()
    background: Sequence[str] = ()
    case_text: str = ""
    scenes: Mapping[str, Any] | None = None
    pictures: Sequence[Picture] = ()
    sheets: Sequence[Sheet] = ()
    proofs: Sequence[Proof] = ()
    proofs_title: str = ""
    words: Sequence[tuple[str, int, str]] = ()
    provenance: Sequence[tuple[str, str]] = ()
    citations: Sequence[str] = ()
    parts: Sequence[Chapter] = ()


@dataclasses.dataclass(frozen=True)
class Page:
    """One page.

    Attributes:
        title: Its title.
        command: The command that wrote it; empty where none is known.
        chapters: What it holds.
        files: Files of the folder, and what each is.
        written: When it was written, in words.
        version: Version of warprock that wrote it.
    """

    title: str
    command: str
    chapters: Sequence[Chapter]
    files: Sequence[tuple[str, str]]
    written: str
    version: str
