"""Prints the functions that take most arguments, give most values back, or are longest.

    python -m tools.widest                 of all sources, kernels included
    python -m tools.widest kernels/event   of one folder or file

A function with ten numbers hides the thing that has no name yet. What is slow is found otherwise:
`python -m cProfile -s tottime -m warprock run CASE` for the host, `warprock bench` for kernels, and
`-Rpass=loop-vectorize` among the compiler's flags (kernels/launch/instance.py) for loops over
lanes.
"""

from __future__ import annotations

import argparse
import ast
import pathlib
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parents[1]


class Width(NamedTuple):
    """How wide a function is: arguments, values given back, lines."""

    arguments: int
    values: int
    lines: int
    place: str


def widths(file: pathlib.Path) -> list[Width]:
    """The functions of a source file."""
    found = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            given = node.args
            arguments = len(given.posonlyargs + given.args + given.kwonlyargs)
            returns = [each.value for each in ast.walk(node) if isinstance(each, ast.Return)]
            values = max(
                (len(v.elts) if isinstance(v, ast.Tuple) else 1 for v in returns), default=0
            )
            assert node.end_lineno is not None
            place = f"{file.relative_to(ROOT)}:{node.lineno}: {node.name}"
            found.append(Width(arguments, values, node.end_lineno - node.lineno + 1, place))
    return found


def main() -> None:
    """Prints the widest of the functions that were asked for."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    ask.add_argument("places", nargs="*", default=["warprock", "kernels"], help="folders or files")
    ask.add_argument("--count", type=int, default=15, help="how many of each kind (15)")
    asked = ask.parse_args()
    files = [
        file
        for place in map((ROOT / ".").joinpath, asked.places)
        for file in ([place] if place.is_file() else sorted(place.rglob("*.py")))
    ]
    found = [width for file in files for width in widths(file)]
    for index, title in enumerate(("arguments", "values given back", "lines")):
        print(title)
        for width in sorted(found, key=lambda each: -each[index])[: asked.count]:
            print(f"  {width[index]:4d}  {width.place}")


if __name__ == "__main__":
    main()
