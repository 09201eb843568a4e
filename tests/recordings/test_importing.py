"""Many files at once: patterns, folders, names, and nothing written where one is bad."""

from __future__ import annotations

import os

import numpy as np
import pytest

from tests.cli.test_records import facts, run
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.recordings import column_file, load_record, loading
from warprock.recordings.importing import FEW, Importing, Reading, import_files
from warprock.recordings.processing import parse_step
from warprock.recordings.summary import record_row

READ = ("--column", "2", "--unit", "-1 g", "--interval", "1.25 ms")


@pytest.fixture
def raw(tmp_path):
    folder = tmp_path / "raw"
    (folder / "deeper").mkdir(parents=True)
    times = np.arange(400)
    for number in range(3):
        rows = [f"{t}\t{np.sin(0.1 * t) * (number + 1):.6f} {t}\r\n" for t in times]
        (folder / f"test {number}.txt").write_text("".join(rows))
    (folder / ".hidden").write_text("nothing")
    return folder


def test_a_folder_and_a_pattern_give_the_same_files(raw, tmp_path):
    found = facts("import", str(raw), *READ, "-o", str(tmp_path / "a"))
    assert [row["name"] for row in found] == ["test 0", "test 1", "test 2"]
    assert found[2]["pga_m_s2"] == pytest.approx(3.0 * 9.81, rel=1e-3)
    run("import", str(raw / "*.txt"), *READ, "-o", str(tmp_path / "b"))
    run("import", str(raw / "test 1.txt"), *READ, "-o", str(tmp_path / "one.csv"))
    for name in ("test 0.csv", "test 1.csv", "test 2.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    one = (tmp_path / "one.csv").read_bytes().replace(b"name: one", b"name: test 1")
    assert one == (tmp_path / "a" / "test 1.csv").read_bytes()
    assert sorted(os.listdir(tmp_path)) == ["a", "b", "one.csv", "raw"]


def test_processes_share_many_files(raw, tmp_path):
    files = [str(raw / f"test {number}.txt") for number in range(3)]
    for number in range(FEW):
        files.append(str(raw / f"more{number}.txt"))
        (raw / f"more{number}.txt").write_bytes((raw / "test 0.txt").read_bytes())
    how = Importing(Reading("2", "-1 g", "1.25 ms"))
    rows = import_files(files, how, tmp_path / "out", 2)
    assert [row["name"] for row in rows] == [os.path.basename(file)[:-4] for file in files]
    assert load_record(rows[1]["file"]).samples[16] == pytest.approx(-9.81 * 1.999147, rel=1e-6)


def test_a_displacement_beside_is_merged(raw, tmp_path):
    made = (*READ, "--displacement", "3, 1e-3 mm", "--step", "merge 20 Hz")
    (found,) = facts("import", str(raw / "test 0.txt"), *made, "-o", str(tmp_path / "m.csv"))
    assert "below 20 Hz from the displacement" in found["processing"]
    (found,) = facts(
        "import", str(raw / "test 0.txt"), "--column", "3", "--unit", "mm", "--interval", "1 ms",
        "--step", "differentiate", "-o", str(tmp_path / "d.csv"),
    )  # fmt: skip
    assert load_record(str(tmp_path / "d.csv")).quantity == "acceleration"


def test_a_file_of_two_motions_is_read_and_parsed_once(raw, tmp_path, monkeypatch):
    seen = {"read_bytes": 0, "plain_columns": 0}

    def counted(room, name):
        work = getattr(room, name)

        def count(*arguments):
            seen[name] += 1
            return work(*arguments)

        monkeypatch.setattr(room, name, count)

    counted(loading, "read_bytes")
    counted(column_file, "plain_columns")
    asked = Reading("2", "-1 g", "1.25 ms")
    how = Importing(asked, asked._replace(column="3", unit="mm"), (parse_step("merge 20 Hz"),))
    files = [str(raw / f"test {number}.txt") for number in range(3)]
    (first, *_) = import_files(files, how, tmp_path / "out", 1)
    assert seen == {"read_bytes": 3, "plain_columns": 3}
    # What is told of a record is what its file says, and not more.
    assert first == {**record_row(load_record(first["file"])), "file": first["file"]}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("*.none",), "FILE: got '*.none', must have at least one file"),
        (("raw", "--name", "x"), "--name: got x, must be left out for 3 records"),
        (("raw", "raw/deeper/../test 1.txt"), "must be the only test 1: raw/test 1.txt has that"),
        (("raw", "--displacement", "6"), "--displacement: got '6', must be a column and its unit"),
        (("raw", "--step", "trim 0 s, 9 s"), "trim: got 'cut out from 0 s to 9 s', must have its"),
        (("raw", "ridgecrest"), "must be a file or the name of a shipped record"),
    ],
)
def test_what_cannot_be_imported_writes_nothing(raw, tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert said in run("import", *arguments, *READ, "-o", "out", code=2)
    assert os.listdir(tmp_path) == ["raw"]


def test_a_folder_is_not_written_over_itself(raw, monkeypatch):
    run("import", str(raw), *READ, "-o", str(raw.parent / "out"))
    said = run("import", str(raw.parent / "out"), "-o", str(raw.parent / "out"), code=2)
    assert "must not be written over: name another folder than" in said


def test_records_of_a_table_share_a_pool_of_what_the_lanes_follow(raw, tmp_path):
    run("import", str(raw), *READ, "-o", str(tmp_path / "records"))
    (tmp_path / "tests.csv").write_text(
        "file,scale,duration\n"
        + "".join(f"records/test {k}.csv,0.01,{0.2 + 0.1 * k} s\n" for k in (0, 1, 2, 1))
    )
    (tmp_path / "case.toml").write_text(
        'title = "t"\nsource = "s"\n[contact]\nfriction = 0.8\n[motion]\nwaveform = "record"\n'
        '[block]\nwidth = "0.4 m"\ndepth = "0.4 m"\nheight = "2 m"\ndensity = "2 t/m^3"\n'
        '[run]\n[sweep]\ntable = "tests.csv"\n'
    )
    case = load_case(tmp_path)
    assert expand_lanes(case).ends.tolist() == pytest.approx([0.2, 0.3, 0.4, 0.3])
    assert len(expand_lanes(case).motions.pool_velocity) == 3 * 400
    few = expand_lanes(case, range(1, 4)).motions
    assert len(few.pool_velocity) == 2 * 400
    alone = few.take(np.array([1]))
    compact = alone.compact()
    assert (len(compact.pool_velocity), compact.offset.tolist()) == (400, [0])
    times = np.linspace(0.0, 0.6, 50)
    assert compact.acceleration(times, 0).tolist() == alone.acceleration(times, 0).tolist()
