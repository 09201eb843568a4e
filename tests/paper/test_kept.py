"""Answers of the oracle that are kept beside the kernels."""

import dataclasses

import numpy as np
import pytest

from warprock.model.response import SampleTimes
from warprock.paper import kept as module
from warprock.paper.kept import kept


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """A function that asks for an answer, and the answers that had to be made."""
    monkeypatch.setattr(module, "kernel_folder", lambda: str(tmp_path))
    made = []

    def make():
        made.append(len(made))
        return np.array([0.1, 0.2])

    return (lambda *of: kept(make, *of)), made


def test_the_sources_of_an_answer_are_all_that_the_oracle_reads(python):
    read = "{m.__package__ for n, m in sys.modules.items() if n.startswith('warprock')}"
    done = python("-c", f"import sys, warprock.oracle.block; print(*{read})")
    assert done.returncode == 0, done.stderr
    assert "warprock.oracle" in done.stdout.split()
    assert set(done.stdout.split()) <= set(module.SOURCES)


def test_an_answer_is_made_once_for_what_decides_it(asked):
    ask, made = asked
    times, widths = SampleTimes(3.0, 0.01), np.array([0.5, 0.17])
    for _ in range(2):
        assert ask(times, widths).tolist() == [0.1, 0.2]
    assert made == [0]
    # The last bit of a width, another duration and another type are other questions.
    other = np.nextafter(widths, 1.0)
    for each in [(times, other), (dataclasses.replace(times, duration=4.0), widths), (times, 3, 0)]:
        ask(*each)
    assert made == [0, 1, 2, 3]


def test_an_answer_of_other_sources_is_made_anew(asked, monkeypatch):
    ask, made = asked
    ask(1.0)
    monkeypatch.setattr(module, "SOURCES", ("warprock.oracle",))
    ask(1.0)
    monkeypatch.setattr("importlib.metadata.version", lambda _: "0")
    ask(1.0)
    assert made == [0, 1, 2]


@pytest.mark.parametrize("text", [b"", b"\x93NUMPY", b"no array"])
def test_a_file_that_cannot_be_read_is_written_anew(asked, tmp_path, text):
    ask, made = asked
    ask(1.0)
    (file,) = (tmp_path / module.FOLDER).iterdir()
    file.write_bytes(text)
    assert ask(1.0).tolist() == ask(1.0).tolist() == [0.1, 0.2]
    assert made == [0, 1]


def test_a_folder_that_cannot_be_written_to_keeps_nothing(asked, tmp_path):
    ask, made = asked
    (tmp_path / module.FOLDER).write_text("in the way")
    assert ask(1.0).tolist() == ask(1.0).tolist() == [0.1, 0.2]
    assert made == [0, 1]


def test_what_has_no_bytes_is_refused(asked):
    ask, _ = asked
    with pytest.raises(TypeError, match="no bytes of object"):
        ask(object())
