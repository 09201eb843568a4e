"""The page of experiments: what its rows say of a table of tosses."""

from __future__ import annotations

import datetime

import numpy as np
import pandas as pd

from tools.experiments import (
    BEGIN,
    COLUMNS,
    END,
    EXPERIMENTS,
    PAGE,
    lanes_text,
    spread_text,
    with_table,
)


def test_a_row_holds_means_and_standard_errors() -> None:
    assert spread_text(pd.Series([1.0, 2.0, 3.0, np.nan])) == "2.0 ± 0.6"


def test_the_page_sets_engines_side_by_side_and_toss_by_toss() -> None:
    rows = [
        {"toss": toss, "engine": engine, "same_face": toss > 0}
        | dict.fromkeys(COLUMNS, 10.0 * toss + more)
        for engine, more in (("event", 0.0), ("mujoco", 1.5))
        for toss in range(4)
    ]
    text = lanes_text(pd.DataFrame(rows), "cube-tosses", datetime.date(2026, 11, 28))
    assert "| 4 tosses, November 2026 |" in text
    assert "| event | 15.0 ± 6.5 | 15.0 ± 6.5 | 15.0 ± 6.5 | 15.0 ± 6.5 | 75 % |" in text
    assert "- mujoco: 1.5 ± 0.0 mm" in text
    begin, end = BEGIN.format("cube-tosses"), END.format("cube-tosses")
    page = with_table(f"before\n{begin}\nold\n{end}\nafter\n", "cube-tosses", text)
    assert page == f"before\n{begin}\n{text}\n{end}\nafter\n"


def test_the_page_of_the_manual_holds_a_table_of_all() -> None:
    text = PAGE.read_text(encoding="utf-8")
    for case, engines in EXPERIMENTS.items():
        table = text[text.index(BEGIN.format(case)) : text.index(END.format(case))]
        for engine in engines:
            assert f"| {engine} |" in table
