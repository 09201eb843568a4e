"""The analyses as functions: they find what the commands of their names find."""

import functools
import html
import json
import pathlib

import pytest
from matplotlib.figure import Figure

import warprock as wr
from tests.shared.commands import succeed
from warprock.tables.terminal import plain

pytestmark = pytest.mark.usefixtures("nothing_rendered")

QUIET = {"progress": False}

SPECTRUM = {"run.duration": "20 s", "spectrum.period": wr.Grid("1 s", "4 s", 3)}
MAP = {
    "run.duration": "6 s",
    "sweep": [
        {"motion.frequency": ["1 Hz", "2 Hz"]},
        {"motion.amplitude": wr.Grid("0.01 g", "0.15 g", 6)},
    ],
}
SAMPLE = {"sample.lanes": 16}
IDA = {"motion.scale": [0.5, 1.0], "run.duration": "20 s"}

TIMES = {"wall_time_s", "finished", "warnings", "table"}
"""Facts that differ from run to run, and the name of a table."""


def of_command(folder: pathlib.Path, name: str, case: wr.Case, *options: str) -> dict:
    file = folder / "case.toml"
    file.write_text(case.to_toml(), encoding="utf-8")
    done = succeed(name, file, "-e", "housner", "--json", *options)
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    ("name", "case", "changes", "asked", "options"),
    [
        ("spectrum", "rocking-spectrum", SPECTRUM, {}, ()),
        ("map", "overturning-map", MAP, {"accuracy": 0.01}, ("--accuracy", "0.01")),
        ("sensitivity", "sobol-single-block", SAMPLE, {"resamples": 10}, ("--resamples", "10")),
        (
            "ida",
            "record-ridgecrest",
            IDA,
            {"count": 4, "accuracy": 0.5, "to": 5.0},
            ("--count", "4", "--accuracy", "0.5", "--to", "5"),
        ),
    ],
)
def test_an_analysis_finds_what_its_command_finds(name, case, changes, asked, options, tmp_path):
    made = wr.load_case(case, changes).override({"check": []})
    found = getattr(wr, name)(made, "housner", **asked, **QUIET)
    wanted = of_command(tmp_path, name, made, *options)
    same = found.facts.keys() & wanted.keys() - TIMES - {"case", "plan", "records"}
    assert len(same) > 5
    assert {key: plain(found.facts[key]) for key in same} == {key: wanted[key] for key in same}
    drawings = found.figures()
    assert len(drawings) == 1
    assert drawings[0].alt
    assert found.plot().axes
    files = found.save(tmp_path / "out")
    assert {"run.json", f"{drawings[0].name}.png"} <= {path.name for path in files}
    assert files[-1] == tmp_path / "out/report.html"
    assert drawings[0].alt in html.unescape(files[-1].read_text(encoding="utf-8"))
    assert len(repr(found)) < 120
    assert '<img alt="' in found._repr_html_()
    assert_one_group_is_drawn(found)


def assert_one_group_is_drawn(found: wr.Found) -> None:
    """On axes of one's own, with words at both of them; a group that is not there is refused."""
    axes = Figure().subplots()
    assert found.plot(ax=axes) is axes
    assert axes.get_xlabel()
    assert axes.get_legend_handles_labels()[1]
    with pytest.raises(wr.InputError, match=r"group: got 99, must be a group of lanes from 0"):
        found.plot(ax=axes, group=99)


def test_fragility_of_a_run_of_its_table_and_of_its_folder_are_one(tmp_path, capsys):
    run = wr.run("sobol-single-block", "housner", overrides=SAMPLE, **QUIET)
    wr.write_run(run.found, tmp_path)
    ask = functools.partial(wr.fragility, limit=[0.35, "overturning"], max_doubt=1)
    of_run, of_table, of_folder = ask(run), ask(run.table), ask(tmp_path)
    assert of_run.table.equals(of_table.table)
    assert of_run.table.equals(of_folder.table)
    assert of_run.table["limit_state"].tolist() == ["0.35", "overturning"]
    assert_one_group_is_drawn(of_run)
    of_run.show()
    assert "Fragility over peak_acceleration_m_s2" in capsys.readouterr().out
    # A fit is written beside the run that it was made from.
    of_folder.save(tmp_path)
    assert {"lanes.parquet", "fragility.csv", "fragility.png"} <= {
        path.name for path in tmp_path.iterdir()
    }


def test_a_sweep_goes_on_where_it_was_and_has_the_lanes_of_a_run(tmp_path):
    case = wr.load_case("sobol-single-block", SAMPLE)
    ask = functools.partial(wr.sweep, case, tmp_path, "housner", chunk=12, **QUIET)
    first = ask()
    chunk = next((tmp_path / "chunks").glob("*0001*"))
    chunk.unlink()
    again = ask()
    run = wr.run(case, "housner", **QUIET)
    for found in (first, again):
        assert found.facts["chunks_done"] == 3
        assert found.table["peak_rotation_rad"].equals(run.table["peak_rotation_rad"])
    assert again.report() == tmp_path / "report.html"
    with pytest.raises(ValueError, match="where the sweep lies"):
        again.report(tmp_path / "elsewhere")
    assert again.save(tmp_path / "elsewhere") == [tmp_path / "elsewhere/lanes.parquet"]
    assert wr.fragility(again, max_doubt=1).table.equals(wr.fragility(run, max_doubt=1).table)


def test_a_comparison_has_tables_and_a_page(tmp_path, capsys):
    over = {"run.duration": "2 s"}
    found = wr.compare("free-b0", ["housner", "event"], overrides=over, **QUIET)
    assert found.table["engine"].tolist() == ["housner", "housner", "event", "event"]
    names = [path.name for path in found.save(tmp_path)]
    assert names == ["comparison.parquet", "comparison.csv", "run.json", "report.html"]
    assert found.report() == tmp_path / "report.html"
    with pytest.raises(ValueError, match="has no figure"):
        found.plot()
    assert "<table" in found._repr_html_()
    found.show()
    assert "free-b0" in capsys.readouterr().out


def test_a_study_has_a_row_a_lane_and_setting():
    changes = {"study.engines": ["impulse"], "study.vary": {"substeps": [10, 20]}}
    quick = {"engines.impulse.substeps": 20, "engines.impulse.iterations": 10}
    found = wr.study(
        "sensitivity-b0", overrides={**changes, **quick, "run.duration": "1 s"}, **QUIET
    )
    assert found.table["value"].tolist() == [10.0, 10.0, 20.0, 20.0]
    assert [drawing.name for drawing in found.figures()] == ["study", "histories"]
