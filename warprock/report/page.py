"""The page itself: one HTML file that needs nothing beside it, laid out by the template."""

from __future__ import annotations

import functools
import importlib.resources
import json
import pathlib
from collections.abc import Mapping
from typing import Any

from warprock.report.content import Page
from warprock.running.files import replacing

REPORT = "report.html"
"""Name of the page in a folder of results."""

ROWS_OPEN = 25
"""Rows of a table that are open at first."""


def render(page: Page) -> str:
    """A page as HTML.

    Args:
        page: What it holds.
    """
    from markupsafe import Markup

    text: str = template("page.html").render(
        page=page,
        style=Markup(_shipped("page.css")),
        script=Markup(_shipped("page.js")),
        scenes_json=_scenes_json,
        rows_open=ROWS_OPEN,
    )
    return text


def write_page(page: Page, folder: pathlib.Path) -> pathlib.Path:
    """Writes a page to a folder, whole or not at all.

    Args:
        page: What it holds.
        folder: Where to; it exists.

    Returns:
        The file.
    """
    path = folder / REPORT
    text = render(page)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def _scenes_json(scenes: Mapping[str, Any]) -> Any:
    """Scenes as they stand in a script element: nothing in them can end it."""
    from markupsafe import Markup

    text = json.dumps(scenes, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return Markup(text.replace("<", "\\u003c"))


def template(name: str) -> Any:
    """A template of this room."""
    return _environment().get_template(name)


@functools.cache
def _environment() -> Any:
    import jinja2

    return jinja2.Environment(
        loader=jinja2.FunctionLoader(_shipped),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def _shipped(name: str) -> str:
    file = importlib.resources.files("warprock.report").joinpath(name)
    return file.read_text(encoding="utf-8")
