"""Fast reading of plain numbers: the same numbers as one by one, and nothing else."""

import numpy as np
import pytest

from warprock.errors import InputError
from warprock.recordings import column_file, loading
from warprock.recordings.column_file import Reading
from warprock.recordings.loading import load_record, read_channels
from warprock.recordings.rows import plain_column, plain_columns

NUMBERS = np.random.default_rng(3).normal(size=(60, 4)) * 10.0 ** np.arange(-6, 6, 3)


def test_plain_numbers_are_read_to_the_last_bit():
    assert plain_column([repr(float(x)) for x in NUMBERS[:, 3]]).tolist() == NUMBERS[:, 3].tolist()
    for separator, mark in ((",", ", "), (";", ";"), (None, " \t "), (None, "\t")):
        lines = [mark.join(repr(float(x)) for x in row) + "  " for row in NUMBERS]
        found = plain_columns([*lines, "", " "], separator, 4, [3, 1])
        assert found.tolist() == NUMBERS[:, [2, 0]].tolist()


def test_a_tab_at_the_end_of_a_row_is_no_cell_and_does_not_make_reading_slow(monkeypatch):
    rows = "time [s]\tacc\t\r\n" + "".join(f"{0.01 * k:g}\t{k % 3}\t\r\n" for k in range(50))
    lines = rows.splitlines()[1:]
    assert plain_columns(lines, "\t", 2, [2])[:, 0].tolist() == [k % 3 for k in range(50)]
    # As reading line by line has it.
    ((fast,),) = read_channels("raw.txt", rows.encode(), [Reading("2", "1 m/s^2")])
    monkeypatch.setattr(column_file, "plain_columns", lambda *_: None)
    ((slow,),) = read_channels("raw.txt", rows.encode(), [Reading("2", "1 m/s^2")])
    np.testing.assert_array_equal(fast.samples, slow.samples)


@pytest.mark.parametrize("line", ["nan", "inf", "a", "1 2", "1,2", "0x1", "", "1_0"])
def test_what_is_not_plain_is_left(line):
    assert plain_columns(["1 2", line, "3 4"], None, 2, [1]) is None or line == "1 2"
    assert plain_column(["1", line, "3"]) is None or line == ""


@pytest.mark.parametrize("rows", [["1 2", "3", "4 5 6"], ["1 2 3"], ["1"], []])
def test_rows_of_other_lengths_are_left(rows):
    assert plain_columns(rows, None, 2, [1]) is None


def test_a_raw_file_mixes_tabs_and_blanks_and_has_a_sign_of_its_own():
    rows = "".join(f"{k} \t{k % 3}\t  {2 * k}\t{-k}\r\n" for k in range(50))
    ((channel,),) = read_channels("raw.txt", rows.encode(), [Reading("2", "-0.5 g", "1.25 ms")])
    assert channel.interval == 0.00125
    assert channel.samples == pytest.approx([-0.5 * 9.81 * (k % 3) for k in range(50)], rel=1e-15)
    assert channel.processing == "column 2, read as -0.5 g"
    with pytest.raises(InputError, match=r"line 51: got 3 fields, must have 4 fields"):
        read_channels("raw.txt", f"{rows}1 2 3\n".encode(), [Reading("2", "g", "1 s")])
    with pytest.raises(InputError, match=r"--unit: got '0 g', must be a unit of a motion"):
        read_channels("raw.txt", rows.encode(), [Reading("2", "0 g", "1 s")])


def test_a_file_of_several_megabytes_is_read():
    rows = "0.00000\t-0.027815\t0.000330 -0.001303\r\n" * 2**17
    assert len(rows) > 4 * 2**20
    ((channel,),) = read_channels("raw.txt", rows.encode(), [Reading("4", "in", "1.25 ms")])
    assert channel.samples.shape == (2**17,)


def test_records_stay_while_there_is_room(tmp_path, monkeypatch):
    parsed = []

    def counted(*arguments):
        parsed.append(arguments[0])
        return read(*arguments)

    read = loading.read_channels
    monkeypatch.setattr(loading, "read_channels", counted)
    monkeypatch.setattr(loading, "_kept", {})
    files = []
    for number in range(300):
        files.append(tmp_path / f"{number}.csv")
        files[-1].write_text("# unit: g\n# interval: 1 s\n1\n2\n3\n")
    for _ in range(2):
        for file in files:
            load_record(str(file))
    assert len(parsed) == 300
    monkeypatch.setattr(loading, "SAMPLES_KEPT", 2 * 3)
    for file in files[:3]:
        file.write_text("# unit: g\n# interval: 1 s\n1\n2\n4\n")
        load_record(str(file))
    assert [key[0] for key in loading._kept] == [str(file) for file in files[1:3]]
