"""The [sample] table of a case: what it draws, and what it refuses."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest
import scipy.stats

from tests.shared.sweeps import CASE, write_case
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.figures.drawing import write_drawings
from warprock.figures.run import draw_run
from warprock.running.case_run import run_case
from warprock.tables.swept import drawn_inputs

UNIFORM = '{ distribution = "uniform", from = "0.5 m", to = "2 m" }'


@pytest.fixture
def file(tmp_path: pathlib.Path) -> pathlib.Path:
    return write_case(tmp_path)


@pytest.mark.parametrize("sampling", ["sobol", "lhs"])
def test_lanes_follow_their_distributions(file: pathlib.Path, sampling: str):
    case = load_case(file, ["sample.lanes=1000", f"sample.sampling={sampling}"])
    assert (case.shape, case.lane_count) == ((2, 1000), 2000)
    inputs = expand_lanes(case).inputs
    # A stratified sample lies closer to its distribution than independent draws do.
    height, scale = inputs["height_m"][:1000], inputs["scale"][:1000]
    assert scipy.stats.kstest(height, scipy.stats.uniform(0.5, 1.5).cdf).statistic < 0.005
    assert scipy.stats.kstest(scale, scipy.stats.lognorm(0.5).cdf).statistic < 0.005
    assert abs(np.corrcoef(height, scale)[0, 1]) < 0.1
    assert (inputs["width_m"] == 0.2).all()


def test_every_cell_of_the_sweep_has_the_same_sample(file: pathlib.Path):
    inputs = expand_lanes(load_case(file)).inputs
    near, far = (inputs[inputs["site"] == site] for site in ("near", "far"))
    for column in ("height_m", "scale"):
        np.testing.assert_array_equal(near[column], far[column])
    assert set(near["start_s"]) == {0.0}
    assert set(far["start_s"]) == {0.1}


def test_some_lanes_are_those_of_the_whole(file: pathlib.Path):
    case = load_case(file)
    whole = expand_lanes(case)
    for lanes in (range(100, 200), range(299, 300)):
        part = expand_lanes(case, lanes)
        expected = whole.inputs.iloc[lanes.start : lanes.stop].reset_index(drop=True)
        assert part.inputs.equals(expected)
        assert part.first == lanes.start


def test_values_of_a_list_are_as_likely(file: pathlib.Path):
    widths = 'sample.over.block.width=["0.1 m", "0.2 m", "0.4 m"]'
    text = 'sample.over.motion.record=["shake.csv", "ridgecrest-2019-ccc-090"]'
    inputs = expand_lanes(load_case(file, [widths, text, "sample.lanes=1024"])).inputs[:1024]
    counts = inputs["width_m"].value_counts()
    assert sorted(counts.index) == [0.1, 0.2, 0.4]
    # Of 1024 stratified points a third is within one.
    assert counts.max() - counts.min() <= 2
    assert inputs["record"].value_counts().tolist() == [512, 512]


def test_an_override_fixes_what_was_drawn(file: pathlib.Path):
    case = load_case(file, ["block.height=1.5 m", "sample.lanes=5"])
    inputs = expand_lanes(case).inputs
    assert set(inputs["height_m"]) == {1.5}
    assert inputs["scale"][:5].nunique() == 5


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("lanes = 150", "lanes = 0", ["sample.lanes", "got 0", "from 1 to 1073741824"]),
        ("lanes = 150", "", ["sample.lanes", "got nothing"]),
        ("lanes = 150", "lanes = 9\nseed = -1", ["sample.seed", "got -1"]),
        ("lanes = 150", "lanes = 9\nsampling = 'sobel'", ["sample.sampling", "mean sobol?"]),
        ("lanes = 150", "lanes = 9\nlane = 3", ["sample.lane", "did you mean lanes?"]),
        ("block.height", "block.hight", ["sample.over.block.hight", "mean block.height?"]),
        ("block.height", "run.duration", ["sample.over.run.duration", "unknown key"]),
        ("block.height", "motion.start", ["sample.over.motion.start", "not in both"]),
        (UNIFORM, "3", ["sample.over.block.height", "a distribution", "a list"]),
        (UNIFORM, "[]", ["sample.over.block.height", "at least one value"]),
        ("uniform", "normal", [".distribution", "'normal'", "uniform, loguniform, lognormal"]),
        ('from = "0.5 m"', 'least = "0.5 m"', ["block.height.least", "unknown key"]),
        ('from = "0.5 m"', 'from = "3 m"', ["block.height.to", "'2 m'", "more than 3 m"]),
        ('from = "0.5 m"', 'from = "2 m"', ["block.height.to", "'2 m'", "more than 2 m"]),
        ('from = "0.5 m"', 'from = "0 m"', ["block.height.from", "'0 m'", "at least 1 mm"]),
        ('from = "0.5 m"', 'from = "5 g"', ["block.height.from", "a length"]),
        ('from = "0.5 m", ', "", ["block.height.from", "got nothing", "distribution uniform"]),
        ("median = 1.0", "median = -1.0", ["motion.scale.median", "> 0"]),
        ("dispersion = 0.5", "dispersion = 0", ["motion.scale.dispersion", "more than 0"]),
        ("dispersion = 0.5", "dispersion = 3", ["motion.scale.to", "would reach", "at most 1000"]),
        ("dispersion = 0.5", "dispersion = 0.5, from = 2.0", ["scale.median", "between from"]),
        ("[sample.over]", "[ensemble]\nmembers = 3\n[sample.over]", ["beside [ensemble]"]),
    ],
)
def test_what_cannot_be_drawn_is_refused(tmp_path: pathlib.Path, old, new, words):
    assert old in CASE
    file = write_case(tmp_path, CASE.replace(old, new))
    with pytest.raises(InputError) as error:
        load_case(file)
    for word in [str(file), *words]:
        assert word in str(error.value), f"{word!r} is not in {error.value}"


def test_a_figure_shows_every_input_that_was_drawn(
    file: pathlib.Path, tmp_path: pathlib.Path, unrendered: None
):
    records = 'sample.over.motion.record=["shake.csv", "ridgecrest-2019-ccc-090"]'
    case = load_case(file, ["sample.lanes=20", records, "run.sample_interval=0.1 s"])
    titles = [each.title for each in drawn_inputs(case)]
    assert titles == ["height [m]", "scale of the record [-]", "record"]
    assert [each.logarithmic for each in drawn_inputs(case)] == [False, True, False]
    run = run_case(case, "housner", histories=False)
    files = write_drawings(draw_run(run), tmp_path)
    assert [path.name for path in files] == ["histories.png", "peaks.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in files)


def test_a_key_that_the_waveform_does_not_have_is_refused(file: pathlib.Path):
    drawn = 'sample.over.motion.frequency={distribution="uniform", from="1 Hz", to="2 Hz"}'
    with pytest.raises(InputError, match=r"motion\.frequency.*with waveform record"):
        load_case(file, [drawn])
