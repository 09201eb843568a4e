"""Engines and programs of others held to the shipped experiments, for a page of the manual.

    python -m tools.experiments                      # the tables of docs/explanation/experiments.md
    python -m tools.experiments granite mine/rig     # with tests of your own, on the terminal

The cases `cube-tosses` and `square-drops` run in every engine that can throw a box and in MuJoCo
and Bullet (the extras `mujoco` and `bullet`). A case of your own is a folder with a case.toml whose
tests say what was observed, as the guide "Hold engines to tests" has it; nothing of it is written
to the manual.
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

EXPERIMENTS = {
    "cube-tosses": (
        *("event", "event@restitution=0.125", "event@restitution=0.125,restitution_law=1"),
        *("impulse", "impulse@restitution=0", "dem"),
        *("mujoco", "bullet", "bullet@restitution=0.125"),
    ),
    "square-drops": (
        *("event", "event@restitution_law=1", "event@restitution=0"),
        *("impulse", "impulse@restitution=0", "dem"),
        *("mujoco", "mujoco@contact_time=10,damping_ratio=0.25"),
        *("bullet", "bullet@restitution=0.45"),
    ),
}
"""Cases and the engines and programs that run them."""
LABELS = {"cube-tosses": "toss", "square-drops": "drop"}
"""The label that counts the lanes of a case. The case is named for several of them."""
COLUMNS = {
    "position_error_mm": "position [mm]",
    "rotation_error_deg": "rotation [deg]",
    "position_error_at_end_mm": "position at the end [mm]",
    "rotation_error_at_end_deg": "rotation at the end [deg]",
}

BEGIN, END = "% python -m tools.experiments: {}, begin", "% python -m tools.experiments: {}, end"
"""Lines of the page between which the table of a case stands."""


def spread_text(values: pd.Series) -> str:
    """Mean and standard error of numbers."""
    numbers = values.dropna().to_numpy(dtype=float)
    return f"{numbers.mean():.1f} ± {numbers.std(ddof=1) / np.sqrt(len(numbers)):.1f}"


def lanes_text(table: pd.DataFrame, case: str, day: datetime.date) -> str:
    """Engines side by side on observed lanes, and lane by lane.

    Args:
        table: A row a lane and engine: columns of `COLUMNS`, `engine`, `same_face`, and the label.
        case: Of `EXPERIMENTS`.
        day: The day of the run.
    """
    engines, label = list(dict.fromkeys(table["engine"])), LABELS[case]
    lanes = f"{table[label].nunique()} {case.split('-')[1]}"
    rows = [f"| {lanes}, {day:%B %Y} | {' | '.join(COLUMNS.values())} | right face |"]
    rows += ["| --- " * (len(COLUMNS) + 2) + "|"]
    for engine in engines:
        own = table[table["engine"] == engine]
        cells = [spread_text(own[column]) for column in COLUMNS]
        face = f"{100.0 * own['same_face'].astype(float).mean():.0f} %"
        rows.append(f"| {engine} | {' | '.join(cells)} | {face} |")
    apart = table.pivot(index=label, columns="engine", values="position_error_mm")
    pairs = [
        f"- {engine}: {spread_text(apart[engine] - apart[engines[0]])} mm" for engine in engines[1:]
    ]
    said = f"Position less that of `{engines[0]}`, {label} by {label}, mean ± standard error:"
    return "\n".join(["", *rows, "", said, "", *pairs, ""])


def with_table(page: str, case: str, text: str) -> str:
    """The page with another table of a case."""
    begin, end = BEGIN.format(case), END.format(case)
    before, after = page.split(begin)[0], page.split(end)[1]
    return f"{before}{begin}\n{text}\n{end}{after}"


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
        page, day = PAGE.read_text(encoding="utf-8"), datetime.datetime.now(datetime.UTC).date()
        for case, engines in EXPERIMENTS.items():
            found = wr.compare(case, list(engines), progress=False)
            page = with_table(page, case, lanes_text(found.table, case, day))
        PAGE.write_text(page, encoding="utf-8")
        print(PAGE)


if __name__ == "__main__":
    main()
