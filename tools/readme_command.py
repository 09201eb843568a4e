"""Prints one of the README's two commands, so that what is tested is what is read there."""

from __future__ import annotations

import pathlib
import re
import sys

COMMANDS = ("reproduce", "test")
"""Names of the README's ```bash blocks, in their order."""


def readme_command(name: str) -> str:
    """The text of one of the README's ```bash blocks.

    Args:
        name: One of `COMMANDS`.
    """
    readme = pathlib.Path(__file__).resolve().parent.parent / "README.md"
    blocks = re.findall(r"^```bash\n(.*?)\n```$", readme.read_text("utf-8"), re.M | re.S)
    if len(blocks) != len(COMMANDS):
        raise SystemExit(f"README.md: got {len(blocks)} bash blocks, must be {len(COMMANDS)}")
    return str(blocks[COMMANDS.index(name)])


if __name__ == "__main__":
    print(readme_command(sys.argv[1]))
