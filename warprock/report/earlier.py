"""What a page that is about to be replaced still has to give: its drawings, and its lanes to play.

A page is written anew by every command that adds to a folder, and by `warprock report`. Only the
command that ran the lanes had them at hand, so that what still fits the files is taken over.
"""

from __future__ import annotations

import html
import json
import pathlib
import re
from typing import Any

from warprock.reading import read_bytes
from warprock.report.page import REPORT

_IMAGE = re.compile(r'<img src="([^"]*)" alt="[^"]*" data-file="[^"]*" data-digest="([0-9a-f]+)">')
_SCENES = re.compile(
    r'<script type="application/json" id="[^"]*" class="scenes" data-digest="([0-9a-f]+)">(.*?)'
    r"</script>",
    re.DOTALL,
)


def earlier_sources(folder: pathlib.Path) -> dict[str, str]:
    """Figures of the page that is there: SHA-256 of the file that shows the same -> its address."""
    return {digest: html.unescape(source) for source, digest in _IMAGE.findall(_text(folder))}


def earlier_scenes(folder: pathlib.Path, digest: str) -> dict[str, Any] | None:
    """The lanes to play of the page that is there.

    Args:
        folder: The folder.
        digest: SHA-256 of its `run.json`, of whose run they must be.
    """
    for found, text in _SCENES.findall(_text(folder)):
        if found == digest:
            try:
                scenes = json.loads(text)
            except ValueError:
                # A page that was edited or damaged has none to give.
                continue
            return scenes if isinstance(scenes, dict) else None
    return None


def _text(folder: pathlib.Path) -> str:
    path = folder / REPORT
    return read_bytes(path).decode(errors="replace") if path.is_file() else ""
