"""What there is to choose from, and what a case, a record or a machine holds, as functions."""

from __future__ import annotations

import pathlib
import pickle

import click
import pytest

import warprock as wr
from tests.shared.commands import succeed
from warprock.cli.main import main

NO_FUNCTION = {
    "init": "writes a file to edit",
    "animate": "writes a picture of a lane",
    "view": "opens a window",
    "report": "writes a page: `Found.report`",
    "check": "ends with an exit code, as a test does",
    "reproduce": "writes the tables and figures of a paper",
    "completion": "writes for a shell",
}
"""Commands that find nothing to hand over, with the reason."""

BELOW = {
    "records list": "records",
    "records info": "records",
    "records import": "import_records",
    "records generate": "generate_record",
    "sweep plan": "sweep",
    "sweep run": "sweep",
    "sweep merge": "sweep",
    "sweep status": "says how far the chunks of other processes are: `Found.show` of `sweep`",
    "bench assembly": "measures figures of the manual, on scenes of its own that no user sets",
    "bench blocks": "measures figures of the manual, on scenes of its own that no user sets",
    "bench sweep": "measures the commands of a sweep as they are typed, start included",
}
"""Commands below others: the function that does the same, or the reason why there is none."""

LOOKED_UP = {
    "list": (),
    "keys": ("block",),
    "explain": ("free-b0",),
    "records": ("ridgecrest-2019-ccc-090",),
    "doctor": (),
}


def test_every_command_that_finds_something_is_a_function():
    context = click.Context(main)
    commands = {name: main.get_command(context, name) for name in main.list_commands(context)}
    assert commands.keys() - set(wr.__all__) == set(NO_FUNCTION)
    below = {
        f"{name} {own}"
        for name, command in commands.items()
        if isinstance(command, click.Group)
        for own in command.commands
    }
    assert below == set(BELOW)
    assert {told for told in BELOW.values() if " " not in told} <= set(wr.__all__)


def test_files_are_made_records_as_the_commands_make_them(tmp_path: pathlib.Path):
    ours, theirs = tmp_path / "ours", tmp_path / "theirs"
    for folder in (ours, theirs):
        folder.mkdir()
    options = ("--seed", "7", "--peak", "0.3 g", "-o")
    succeed("records", "generate", *options, theirs / "noise.csv")
    succeed("records", "import", theirs / "noise.csv", "--step", "mean 1 s", "-o", theirs / "a.csv")
    noise = wr.generate_record(ours / "noise.csv", seed=7, peak="0.3 g")
    made = wr.import_records(ours / "noise.csv", ours / "a.csv", steps="mean 1 s")
    for name in ("noise.csv", "a.csv"):
        assert (ours / name).read_bytes() == (theirs / name).read_bytes()
    assert made.table["duration_s"].tolist() == noise.table["duration_s"].tolist()
    (ours / "weights.csv").write_text("record,weight\nnoise,1\na,3\n")
    both = [ours / "noise.csv", ours / "a.csv"]
    several = wr.import_records(both, tmp_path / "both", weights=ours / "weights.csv")
    assert several.table["name"].tolist() == ["noise", "a"]
    assert (tmp_path / "both.csv").read_text().splitlines()[2] == "both/a.csv,3.0"
    with pytest.raises(wr.InputError, match=r"^steps: got 'median'"):
        wr.import_records(ours / "noise.csv", ours / "b.csv", steps="median")
    with pytest.raises(wr.InputError, match=r"^peak: got"):
        wr.generate_record(ours / "b.csv", seed=7, peak="0.3 m")
    assert not (ours / "b.csv").exists()


@pytest.mark.parametrize(("name", "given"), LOOKED_UP.items())
def test_a_function_shows_what_its_command_prints(
    name: str, given: tuple[str, ...], capsys: pytest.CaptureFixture[str], tmp_path: pathlib.Path
):
    found = getattr(wr, name)(*given)
    found.show()
    shown = capsys.readouterr().out
    command = (name, "info", *given) if name == "records" else (name, *given)
    printed = succeed(*command).stdout
    assert printed.startswith(shown)
    assert found.finding.sentences[0] in printed
    assert len(found.table)
    again = pickle.loads(pickle.dumps(found))
    assert again.facts == found.facts
    saved = {file.name for file in found.save(tmp_path)}
    assert {f"{table}.parquet" for table in found.tables} <= saved
    assert found.figures() == []
    with pytest.raises(ValueError, match="has no page"):
        found.report()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"period": "1 s"}, "period: got '1 s', must be left out where no file is named"),
        ({"file": "nowhere"}, "must be a file or the name of a shipped record"),
        ({"file": "ridgecrest-2019-ccc-090", "fema_p695": True}, "must be left out where a file"),
        ({"file": "ridgecrest-2019-ccc-090", "width": "1 m"}, "must be given with height"),
        ({"file": 3}, "file: got 3, must be text, a path or None"),
    ],
)
def test_records_refuses_what_it_cannot_use(given: dict, said: str):
    with pytest.raises(wr.InputError, match=said):
        wr.records(**given)


def test_a_key_that_is_not_there_is_refused_with_what_is_near():
    with pytest.raises(wr.InputError, match="hight"):
        wr.keys("block.hight")
