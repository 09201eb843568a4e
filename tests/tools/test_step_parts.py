"""Parts are cut from kernels so that the rest stays."""

from __future__ import annotations

import ast

import pytest

from tools import step_parts

CUT = [(engine, part) for engine in step_parts.KERNELS for part in ("account", "observation")]


@pytest.mark.parametrize(("engine", "part"), CUT)
def test_nothing_of_a_part_is_kept_and_the_rest_stays(engine: str, part: str) -> None:
    text = (step_parts.ROOT / "kernels" / step_parts.KERNELS[engine]).read_text(encoding="utf-8")
    before, after = ast.unparse(ast.parse(text)), step_parts.without(text, (part,))
    gone = [line for line in before.splitlines() if line not in after.splitlines()]
    names = step_parts.KEPT[part]
    assert gone
    for line in gone:
        (statement,) = ast.parse(line.strip()).body
        if isinstance(statement, ast.Assign):
            assert step_parts.root_name(statement.targets[0]) in names
        else:
            assert line.strip().startswith("observe")


def test_a_kernel_without_the_part_is_refused() -> None:
    text = (
        "def run_lanes():\n    for sample in sample_times:\n        while time:\n            pass\n"
    )
    with pytest.raises(SystemExit, match="has nothing of the account"):
        step_parts.without(text, ("account",))
