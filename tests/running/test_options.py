"""How lanes are run: options are those of the batch; progress counts on over several batches."""

from __future__ import annotations

import inspect

import pytest

from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.running.batch import run_batch
from warprock.running.case_run import require_options, run_case
from warprock.running.options import RunOptions


def test_the_batch_takes_every_option_but_the_tolerance():
    asked = RunOptions("float32", "cpu", 3, None, print)
    known = inspect.signature(run_batch).parameters
    assert set(asked.of_batch) <= set(known)
    assert asked.of_batch == {
        "precision": "float32",
        "device": "cpu",
        "workers": 3,
        "progress": print,
        "form": None,
    }


def test_progress_counts_on_from_the_batches_before():
    seen: list[int] = []
    counted = RunOptions(progress=seen.append).counting_from(40)
    assert counted.progress is not None
    counted.progress(2)
    assert seen == [42]
    assert RunOptions().counting_from(40).progress is None
    assert counted.without_progress() == RunOptions()


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (RunOptions(precision="float16"), "--precision"),
        (RunOptions(device="cuda:77"), "--device"),
        (RunOptions(workers=0), "--workers"),
        (RunOptions(tolerance=1.0), "--tolerance"),
    ],
)
def test_options_out_of_bounds_are_refused(options: RunOptions, word: str):
    with pytest.raises(InputError, match=word):
        require_options("housner", options)


def test_without_a_tolerance_no_error_is_estimated():
    case = load_case("free-b0")
    once = run_case(case, "event", RunOptions(tolerance=None), histories=False)
    assert "rotation_error" not in once.response.fields
    assert once.options.tolerance is None
