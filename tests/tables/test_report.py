"""The paper's tables as data, its conflicts, the terminal tables and the figures."""

from __future__ import annotations

import io
import struct

import numpy as np
import pandas as pd
import pytest

from tests.shared.marks import first
from warprock.case.columns import Columns
from warprock.figures import study as plots_study
from warprock.figures.drawing import write_drawings
from warprock.figures.sheet import style
from warprock.findings.sheets import heading
from warprock.paper import conflicts, plots_forced, plots_free, print_tables
from warprock.paper.printed import (
    INFERRED_NAMES,
    PAPER_COLUMNS,
    PAPER_NAMES,
    PAPER_TABLES,
    READING_NAMES,
    paper_table,
)
from warprock.paper.reproduce import TARGETS
from warprock.tables import compare as compared
from warprock.tables import terminal
from warprock.tables.terminal import plain_console
from warprock.verification.checks import CheckRow

TIMES = np.linspace(0.0, 10.0, 501)
READINGS = tuple(READING_NAMES)
INPUTS = ("3 Hz, 8 mm", "3.3 Hz, 6 mm")


def curve(phase: float) -> np.ndarray:
    return 0.2 * np.cos(8.0 * TIMES + phase) * np.exp(-0.4 * TIMES)


def lanes_of(ratio_by_reading: dict[str, list[float]]) -> Columns:
    """Evidence as a run would give it: the six inputs of Table 4 under every reading."""
    ratio = np.concatenate(list(ratio_by_reading.values()))
    return Columns(
        {
            "reading": [reading for reading, each in ratio_by_reading.items() for _ in each],
            "housner": ratio,
            "impulse": ratio,
            "impulse_rough": ratio,
            "slide_mm": np.ones_like(ratio),
            "first_swing": ratio,
        }
    )


@pytest.mark.parametrize("name", PAPER_TABLES)
def test_a_paper_table_names_the_paper_and_has_a_unit_in_every_number_column(name: str):
    import importlib.resources

    text = (importlib.resources.files("warprock.cases") / "paper" / f"{name}.csv").read_text()
    assert text.startswith("# ")
    assert "Discontinuum rocking of rigid masonry macro-blocks" in text.splitlines()[0]
    assert len(paper_table(name)) > 0


def test_table_4_is_the_acceleration_of_its_own_sine():
    table = paper_table("table4")
    rounding = 0.005 + 1e-9
    assert np.all(
        np.abs(conflicts.peak_acceleration() - table["peak_acceleration_m_s2"]) <= rounding
    )


def test_table_3_prints_the_angles_of_its_full_sizes():
    table = paper_table("table3")
    angle = np.arctan2(table["width_m"], table["height_m"])
    assert np.all(np.abs(angle - table["slenderness_angle_rad"]) <= 0.005 + 1e-9)


def test_tables_6_and_7_have_the_inputs_of_table_4():
    for name in ("table6", "table7"):
        keys = ["frequency_hz", "amplitude_mm"]
        pd.testing.assert_frame_equal(paper_table(name)[keys], paper_table("table4")[keys])
        assert set(PAPER_COLUMNS) < set(paper_table(name).columns)


def test_the_inferred_test_divides_by_one_minus_the_printed_error():
    printed = paper_table("table7")
    test = np.array([0.22, 0.15, 0.21, 0.1, 0.12, 0.13])
    sine = lanes_of(
        {
            "double-size": list(test * (1.0 - printed["analytical"] / 100.0)),
            "displacement": list(test * (1.0 - printed["bullet"] / 100.0) * 1.03),
            "acceleration": [0.3] * 6,
        }
    )
    by_analysis, by_bullet = conflicts.inferred_experiment(sine)
    np.testing.assert_allclose(by_analysis, test, rtol=1e-12)
    np.testing.assert_allclose(by_bullet, 1.03 * test, rtol=1e-12)
    text = next(
        c.text
        for c in conflicts.conflicts_of(["table7"], conflicts.Evidence(sine=sine))
        if c.item == 4
    )
    assert "agree within 2.9 %" in text
    assert "never measured" in text


def test_conflicts_follow_what_was_found():
    """The numbers in the text are those of the runs, not of the text."""
    pulse = lanes_of({reading: [0.5 + 0.01 * i for i in range(6)] for reading in READINGS})
    found = {
        c.title: c for c in conflicts.conflicts_of(["table6"], conflicts.Evidence(pulse=pulse))
    }
    assert {c.item for c in found.values()} == {1, 2, 3, 7, 8}
    assert ".5000 .5100 .5200 .5300 .5400 .5500" in found["the engines follow a displacement"].text


def test_conflicts_without_runs_need_no_runs():
    found = conflicts.conflicts_of(TARGETS, conflicts.Evidence())
    assert {c.item for c in found} == {1, 2, 3, 4, 5, 6, 7, 8, 11, 12}


def test_conflicts_of_the_paper_say_what_can_be_calculated():
    """Worked out by hand: 0.17 m / 1.0 m, atan(1/5), 1 / (201 x 240)."""
    text = {c.item: c.text for c in conflicts.conflicts_of(TARGETS, conflicts.Evidence())}
    assert "1.70 1.55 2.06 2.37 2.96 3.55" in text[1]
    assert "0.1974 rad and 0.942" in text[5]
    assert "0.1799 rad and 0.952" in text[5]
    assert "needs 2.19" in text[7]
    assert "2.07e-05 s" in text[12]


def test_a_slipping_corner_slows_down_as_newton_and_euler_say():
    """Unknowns: acceleration of the centre, angular acceleration, normal force of the corner."""
    width, height, mu, gravity = 0.17, 1.0, 1.0, 9.81
    b, h = 0.5 * width, 0.5 * height
    inertia = (width**2 + height**2) / 12.0
    # The base runs to +x; the block leans to -x about its -x corner, at (-b, -h) from the centre.
    # Friction drags the corner to +x. Angular acceleration is positive counter-clockwise.
    equations = np.array(
        [
            [1.0, 0.0, 0.0, -mu],
            [0.0, 1.0, 0.0, -1.0],
            [0.0, 0.0, inertia, b - h * mu],
            [0.0, 1.0, -b, 0.0],
        ]
    )
    along, _, turning, normal = np.linalg.solve(equations, [0.0, -gravity, 0.0, 0.0])
    assert normal > gravity
    corner = along + h * turning
    assert conflicts.slip_deceleration(width, height, mu) == pytest.approx(corner, rel=1e-12)


def png_size(path) -> tuple[int, int]:
    head = path.read_bytes()[:24]
    assert head[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", head[16:24])


def figure_makers():
    engines = {"housner": curve(0.0), "impulse": curve(0.05)}
    readings = {reading: curve(index) for index, reading in enumerate(READINGS)}
    six = np.linspace(0.1, 0.3, 6)
    peaks = pd.DataFrame(
        [
            {"reading": reading, "source": engine, "peak_rotation_ratio": value}
            for engine in engines
            for reading in READINGS
            for value in six
        ]
    )
    windows = ((0.0, 2.0), (8.0, 10.0))
    panels = [(name, engines) for name in INPUTS]
    printed = dict.fromkeys((*PAPER_COLUMNS, *INFERRED_NAMES), six)
    return {
        "free": lambda: plots_free.draw_free_response("free", TIMES, [("B0", engines)]),
        "study": lambda: plots_study.draw_histories(
            "study", "B0", TIMES, curve(0.0), {("impulse", "substeps", 20.0): curve(0.1)}
        ),
        "panels": lambda: plots_free.draw_free_panels("panels", TIMES, panels),
        "windows": lambda: plots_forced.draw_windows(
            "windows", "t", TIMES, panels, windows, [0.2, 0.1]
        ),
        "readings": lambda: plots_forced.draw_readings(
            "readings", "t", TIMES, [(name, readings) for name in INPUTS], windows
        ),
        "trends": lambda: plots_forced.draw_trends(
            "trends", "t", peaks, printed, [("printed", six), ("true", 1.3 * six)]
        ),
    }


@pytest.fixture(scope="module")
def drawings():
    found = {name: make() for name, make in figure_makers().items()}
    for each in found.values():
        with style():
            each.figure.draw_without_rendering()
    return found


@pytest.mark.parametrize("name", first(1, figure_makers()))
def test_a_figure_is_written_at_print_resolution(tmp_path, drawings, name: str):
    (path,) = write_drawings([drawings[name]], tmp_path)
    width, _height = png_size(path)
    assert width >= 7.0 * 150
    assert [file.name for file in tmp_path.iterdir()] == [f"{name}.png"]
    assert "\n" not in drawings[name].title
    assert drawings[name].title in drawings[name].alt


def test_no_text_of_a_figure_is_smaller_than_8_points_and_legends_cover_no_curve(drawings):
    for drawing in drawings.values():
        figure = drawing.figure
        texts = figure.findobj(match=lambda artist: hasattr(artist, "get_fontsize"))
        assert min(text.get_fontsize() for text in texts if text.get_text()) >= 8.0
        legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
        assert legends
        for legend in legends:
            box = legend.get_window_extent()
            for axes in figure.axes:
                assert not box.overlaps(axes.get_window_extent())
        labelled = [axes for axes in figure.axes if axes.get_xlabel()]
        assert labelled
        assert all(
            "[" in axes.get_xlabel()
            or "printed" in axes.get_xlabel()
            or axes.get_xlabel() == "true"
            for axes in labelled
        )


def printed_text(function, *arguments, width: int = 80) -> str:
    stream = io.StringIO()
    function(*arguments, plain_console(file=stream, width=width))
    return stream.getvalue()


def reproduction_rows(target: str) -> list[dict]:
    rows = []
    for key in [(3.0, 8.0), (5.0, 6.0)]:
        shared = {"target": target, "frequency_hz": key[0], "amplitude_mm": key[1]}
        for reading in READINGS:
            for source in ("housner", "impulse", "oracle"):
                rows.append(
                    shared | {"reading": reading, "source": source, "peak_rotation_ratio": 0.1234}
                )
                if source != "oracle":
                    rows[-1] |= {
                        "error_5s_ratio": 1.25e-3,
                        "error_run_ratio": 2.5e-2,
                        "peak_error": -0.0123,
                        "rest_time_error_s": None,
                        "peak_slide_mm": 1.5,
                        "holds": reading != "displacement",
                        "why": "" if reading != "displacement" else "slides 1.5 mm",
                    }
        for name in PAPER_NAMES:
            rows.append(
                shared
                | {"reading": "as printed", "source": f"paper-{name}", "peak_rotation_ratio": 0.321}
                | {"abs_error_pct": None if name == "dem" else 17.0}
            )
        for reading in ("double-size", "displacement"):
            rows.append(
                shared
                | {"reading": reading, "source": "inferred-experiment", "peak_rotation_ratio": 0.2}
            )
    return rows


@pytest.mark.parametrize("target", ["table6", "table7"])
def test_a_reproduction_fits_an_80_column_terminal(target: str):
    found = {
        "target": target,
        "rows": reproduction_rows(target),
        "conflicts": [{"item": 1, "title": "a title", "text": "what [is] wrong"}],
        "files": ["results/table.csv"],
    }
    text = printed_text(print_tables.print_reproduction, found)
    lines = text.splitlines()
    assert "…" not in text
    assert all(heading in text for heading in ("displacement", "acceleration", "double-size"))
    assert text.count("0.1234") == 18
    assert "-1.23%" in text
    assert "no: a" in text
    assert f"a: {compared.SLIDES}" in text
    assert "what [is] wrong" in text
    assert any("wrote results/table.csv" in line for line in lines)
    if target == "table6":
        assert text.count("0.321") == 24
    else:
        assert "-38" in text  # 0.1234 against an inferred 0.2
        assert text.count(" 17") == 18


def test_checks_are_printed_with_what_failed():
    shared = {"case": "c", "name": "n", "engine": "e", "lanes": "all", "because": "of it"}
    rows = [
        CheckRow(**shared, value=1.0e-3, limit=4.0e-3, ok=True, note="worst lane: x"),
        CheckRow(**shared, value=np.nan, limit=4.0e-3, ok=False, note="nothing was checked"),
    ]
    text = printed_text(compared.print_checks, rows)
    assert "1 passed, 1 failed" in text
    assert "FAILED" in text
    assert "nothing was checked" in text
    assert "worst lane" not in text


def test_a_comparison_is_printed_engine_under_engine():
    row = {
        "lane": "B1 0.2",
        "engine": "housner",
        "peak_rotation_ratio": 0.5,
        "outcome": "at_rest",
        "error_5s_ratio": 0.0,
        "error_run_ratio": None,
        "peak_error": 0.0,
        "rest_time_error_s": 0.0,
        "peak_slide_mm": 0.0,
        "holds": True,
        "why": "",
        "friction_needed": 0.314,
    }
    found = {
        "case": "free",
        "engines": ["housner", "impulse"],
        "rows": [row, row | {"engine": "impulse"}],
    }
    text = printed_text(compared.print_comparison, found, width=100)
    assert text.count("B1 0.2") == 1
    assert "impulse" in text
    assert text.count("0.314") == 2


@pytest.mark.parametrize("width", [20, 40, 80])
def test_a_narrow_terminal_cuts_no_word_and_no_number(width: int, monkeypatch: pytest.MonkeyPatch):
    row = {
        "lane": 12,
        "label": "a block of some size",
        "peak_rotation_ratio": 0.123456,
        "outcome": "overturned",
        "rest_time_s": 12.3456,
        "rotation_error_rad": 1.23e-5,
    }
    words = ("12", "block", "0.123456", "overturned", "12.3456", "1.23e-05")
    measured = ("12", "block", "0.123", "overturned", "12.3", "1.23e-5", "rotation", "[rad]")
    table = terminal.plain_table("A title", row, ["label"])
    table.add_row(*map(str, row.values()))
    stream = io.StringIO()
    narrow = plain_console(file=stream, width=width)
    terminal.print_table(narrow, table)
    assert narrow.width == width
    monkeypatch.setattr(terminal, "wide_stdout", lambda: plain_console(file=stream, width=width))
    assert all(word in stream.getvalue() for word in words), stream.getvalue()
    stream.seek(0)
    stream.truncate()
    terminal.print_rows("A title", [row, row])
    printed = stream.getvalue()
    assert all(printed.count(word) >= (2 if word[0].isdigit() else 1) for word in measured), printed
    # Columns that have no room are printed below, before a line is longer than the terminal.
    assert max(map(len, printed.splitlines())) <= max(width, len("12  overturned"))


def test_headings_are_words_with_units():
    headings = {"peak_time_s": "peak time [s]", "frequency_hz": "frequency [Hz]", "lane": "lane"}
    assert {name: heading(name).label for name in headings} == headings
