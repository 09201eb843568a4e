"""The page for a decision: two printed sheets, as HTML and, where a browser is there, as PDF."""

from __future__ import annotations

import dataclasses
import os
import pathlib
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence

from warprock import __version__
from warprock.report.page import template
from warprock.running.files import replacing

BRIEF_PAGE = "brief.html"
BRIEF_PDF = "brief.pdf"
"""Names of the page and of its print in a folder of results."""
BROWSERS = (
    *("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"),
    *("microsoft-edge", "msedge"),
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
)
"""Programs that print a page to PDF without a screen, in this order."""
PRINT_SECONDS = 60.0
"""A browser that has not printed two sheets by then does not."""


@dataclasses.dataclass(frozen=True)
class BriefPage:
    """What the page holds.

    Attributes:
        title: The object.
        object: Its size and mass, in words.
        chances: Chances within spans of years: `span`, `percent`, `one_in`, `word`, `band`.
        picture: The object, an element `<svg>`.
        parts: Headings and the lines below each, on the first sheet.
        motions: Which motions make the rate, an element `<svg>`; empty without.
        helps: What helps, in lines.
        figure: The measures, an element `<svg>`; empty without.
        rows: The measures: `name`, `factor`, `band`, `chance`, `note`.
        left_out: What was left out.
        made: What made it.
    """

    title: str
    object: str
    chances: Sequence[Mapping[str, str]]
    picture: str
    parts: Sequence[tuple[str, Sequence[str]]]
    motions: str
    helps: Sequence[str]
    figure: str
    rows: Sequence[Mapping[str, str]]
    left_out: Sequence[str]
    made: str


def render_brief(page: BriefPage) -> str:
    """The page as HTML: one file that needs nothing beside it."""
    from markupsafe import Markup

    drawn = dataclasses.replace(
        page,
        picture=Markup(page.picture),
        motions=Markup(page.motions),
        figure=Markup(page.figure),
    )
    text: str = template("brief.html").render(page=drawn, version=__version__)
    return text


def find_browser() -> str | None:
    """A browser that can print; None where there is none."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


def print_page(page: pathlib.Path, browser: str) -> str:
    """Prints a page to the PDF beside it, whole or not at all.

    Args:
        page: The page.
        browser: The browser.

    Returns:
        Why it was not printed; empty where it was.
    """
    with tempfile.TemporaryDirectory(prefix="warprock-print-") as place:
        made = pathlib.Path(place) / BRIEF_PDF
        # A browser that root starts refuses its sandbox; the page is ours, and runs no script.
        root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
        asked = [browser, "--headless", *root, "--disable-gpu", "--no-first-run"]
        asked += [f"--user-data-dir={place}/profile", "--no-pdf-header-footer"]
        asked += [f"--print-to-pdf={made}", page.resolve().as_uri()]
        try:
            done = subprocess.run(
                asked, capture_output=True, timeout=PRINT_SECONDS, check=False, text=True
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            return f"{browser} did not print it: {error}"
        if done.returncode or not made.is_file():
            said = (done.stderr.strip().splitlines() or ["it said nothing"])[-1]
            return f"{browser} did not print it: {said}"
        with replacing(page.with_name(BRIEF_PDF)) as target:
            shutil.copyfile(made, target)
    return ""
