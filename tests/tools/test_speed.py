"""Speeds of two revisions: what is noise, and the table of the manual."""

from __future__ import annotations

import pathlib

import pytest

from tools import speed


@pytest.mark.parametrize(
    ("ours", "others", "said"),
    [
        ([1.2, 1.21, 1.19], [1.0, 1.01, 0.99], "slower"),
        ([0.8, 0.81, 0.79], [1.0, 1.01, 0.99], "faster"),
        ([1.02, 1.01, 1.02], [1.0, 1.0, 1.0], ""),
        # Rounds of one revision differ by more than the two revisions do.
        ([1.2, 1.3, 1.6], [1.0, 1.01, 0.99], ""),
        ([1.2, 1.2, 0.99], [1.0, 1.0, 1.0], ""),
    ],
)
def test_what_is_within_the_noise_is_not_called_slower(
    ours: list[float], others: list[float], said: str
) -> None:
    assert speed.judged(ours, others)[2] == said


def test_a_version_has_one_column_of_the_table(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = tmp_path / "history.md"
    table.write_text("# Speed\n\nWords.\n\n| scene |\n| --- |\n", encoding="utf-8")
    monkeypatch.setattr(speed, "TABLE", table)
    speed.keep("0.1.0", {"list": 3.14159, "keys": 5.0})
    speed.keep("0.2.0", {"list": 2.0, "keys": 5.0, "new": 1.0})
    speed.keep("0.1.0", {"list": 3.0, "keys": 4.0, "new": 1.5})
    assert table.read_text(encoding="utf-8").splitlines() == [
        *("# Speed", "", "Words.", ""),
        "| scene | 0.1.0 | 0.2.0 |",
        "| --- | --- | --- |",
        "| list | 3 | 2 |",
        "| keys | 4 | 5 |",
        "| new | 1.5 | 1 |",
    ]


def test_every_scene_runs_in_its_engine() -> None:
    import warprock as wr
    from warprock.engines import engine_class

    for scene in speed.SCENES.values():
        whole = wr.expand_lanes(wr.load_case(scene.case))
        assert engine_class(scene.engine).supports(whole.scene) is None
