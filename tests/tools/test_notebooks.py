"""The notebooks of `examples/` are the tutorials of the manual."""

from __future__ import annotations

import json
import re

from tools.notebooks import EXAMPLES, ROOT, notebooks, text_of

FOUND = notebooks()


def test_the_files_are_notebooks_of_tutorials() -> None:
    files = {path.stem: path for path in EXAMPLES.glob("*.ipynb")}
    assert {"first", "script"} <= files.keys() <= FOUND.keys()
    for page, file in files.items():
        held = json.loads(file.read_text(encoding="utf-8"))
        assert text_of(held) == file.read_text(encoding="utf-8")
        assert held["cells"][0]["id"] == f"{page}-0"
        assert all(not cell.get("outputs") for cell in held["cells"])


def test_every_command_and_file_of_a_tutorial_is_a_cell() -> None:
    for page, notebook in FOUND.items():
        source = (ROOT / "docs" / "tutorials" / f"{page}.md").read_text(encoding="utf-8")
        code = [cell["source"] for cell in notebook["cells"] if cell["cell_type"] == "code"]
        for kind, begins in (("command", "%%bash"), ("file", "%%writefile")):
            wanted = len(re.findall(rf"^```+\{{{kind}\}}", source, re.M))
            assert sum(cell.startswith(begins) for cell in code) == wanted, page
        assert not any("```{" in cell["source"] for cell in notebook["cells"])


def test_links_lead_to_pages_that_are_there() -> None:
    for notebook in FOUND.values():
        for path in re.findall(r"\]\((\.\./docs/[\w/-]+\.md)", json.dumps(notebook)):
            assert (EXAMPLES / path).exists(), path
