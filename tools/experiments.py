"""Engines and programs of others held to the shipped experiments, for a page of the manual.

    python -m tools.experiments                      # the table of docs/explanation/experiments.md
    python -m tools.experiments granite mine/rig     # with tests of your own, on the terminal

The tosses of `cube-tosses` run in every engine that can throw a box and in MuJoCo and Bullet (the
extras `mujoco` and `bullet`). A case of your own is a folder with a case.toml whose tests say what
was observed, as the guide "Hold engines to tests" has it; nothing of it is written to the manual.
"""

from __future__ import annotations

import argparse
import datetime
import pathlib

import numpy as np
import pandas as pd

import warprock as wr

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "explanation" / "experiments.md"

TOSSES = "cube-tosses"
ENGINES = (
    *("event", "impulse", "impulse@restitution=0", "dem"),
    *("mujoco", "bullet", "bullet@restitution=0.125"),
)
COLUMNS = {
    "position_error_mm": "position [mm]",
    "rotation_error_deg": "rotation [deg]",
    "position_error_at_rest_mm": "position at rest [mm]",
    "rotation_error_at_rest_deg": "rotation at rest [deg]",
}

BEGIN, END = "% python -m tools.experiments: begin", "% python -m tools.experiments: end"
"""Lines of the page between which the table stands."""


def spread_text(values: pd.Series) -> str:
    """Mean and standard error of numbers."""
    numbers = values.dropna().to_numpy(dtype=float)
    return f"{numbers.mean():.1f} ± {numbers.std(ddof=1) / np.sqrt(len(numbers)):.1f}"


def tosses_text(table: pd.DataFrame, day: datetime.date) -> str:
    """Engines side by side on the tosses, and toss by toss.

    Args:
        table: A row a toss and engine: columns of `COLUMNS`, `engine`, `toss` and `same_face`.
        day: The day of the run.
    """
    engines = list(dict.fromkeys(table["engine"]))
    count = table["toss"].nunique()
    rows = [f"| {count} tosses, {day:%B %Y} | {' | '.join(COLUMNS.values())} | right face |"]
    rows += ["| --- " * (len(COLUMNS) + 2) + "|"]
    for engine in engines:
        own = table[table["engine"] == engine]
        cells = [spread_text(own[column]) for column in COLUMNS]
        face = f"{100.0 * own['same_face'].astype(float).mean():.0f} %"
        rows.append(f"| {engine} | {' | '.join(cells)} | {face} |")
    apart = table.pivot(index="toss", columns="engine", values="position_error_mm")
    pairs = [
        f"- {engine}: {spread_text(apart[engine] - apart[engines[0]])} mm" for engine in engines[1:]
    ]
    said = f"Position less that of `{engines[0]}`, toss by toss, mean ± standard error:"
    return "\n".join(["", *rows, "", said, "", *pairs, ""])


def with_table(page: str, text: str) -> str:
    """The page with another table."""
    before, after = page.split(BEGIN)[0], page.split(END)[1]
    return f"{before}{BEGIN}\n{text}\n{END}{after}"


def main() -> None:
    """Writes the page, or prints cases of one's own."""
    ask = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    ask.add_argument("cases", nargs="*", help="folders of cases with observed tests")
    asked = ask.parse_args()
    for case in asked.cases:
        wr.validate(case, progress=False).show()
    if not asked.cases:
        found = wr.compare(TOSSES, list(ENGINES), progress=False)
        day = datetime.datetime.now(datetime.UTC).date()
        page = with_table(PAGE.read_text(encoding="utf-8"), tosses_text(found.table, day))
        PAGE.write_text(page, encoding="utf-8")
        print(PAGE)


if __name__ == "__main__":
    main()
