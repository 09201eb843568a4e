"""Lanes with durations of their own: each is the lane that it would be alone."""

import numpy as np
import pytest

from warprock.case.lanes import expand_lanes
from warprock.case.load import build_case
from warprock.engines import ENGINES
from warprock.engines.launching import Form
from warprock.errors import InputError
from warprock.model.response import FIELDS
from warprock.running.case_run import run_case, run_lanes
from warprock.running.lane_table import history_table, lane_table
from warprock.running.options import RunOptions
from warprock.running.provenance import duration_facts

DURATIONS = [0.9, 2.0, 1.3]
LANES = {
    "block.height": ["1.6 m", "1.7 m", "1.8 m"] * 2,
    "run.duration": [f"{duration} s" for duration in DURATIONS] * 2,
}


def case_of(sweep, interval="50 ms", **run):
    raw = {
        "title": "durations",
        "source": "made up",
        "block": {"width": "0.4 m", "depth": "0.4 m", "density": "2 t/m^3", "height": "1.6 m"},
        "contact": {"friction": 0.9},
        "start": {"rotation_ratio": 0.5},
        "run": {"sample_interval": interval, **run},
        "sweep": [sweep],
    }
    return build_case("durations", "case.toml", None, raw)


def alone(lane):
    return case_of({"block.height": [LANES["block.height"][lane]]}, duration=f"{DURATIONS[lane]} s")


ENGINES_HERE = [
    pytest.param(name, marks=() if name == "housner" else pytest.mark.thorough)
    for name in ENGINES
    if name not in ("two-block", "assembly")  # which run no single block
]


@pytest.mark.parametrize("engine", ENGINES_HERE)
@pytest.mark.parametrize("tolerance", [None, 0.01])
def test_a_lane_is_the_same_alone_to_the_last_bit(engine, tolerance):
    done, options = (
        [],
        RunOptions(workers=2, tolerance=tolerance, progress=lambda n: done.append(n)),
    )
    # Few lanes a duration run one a thread of the kernel; built on a worker thread, it would need
    # headers of its own, which take twice as long as itself.
    run_case(alone(0), engine, RunOptions(form=Form.PLAIN))
    found = run_case(case_of(LANES), engine, options).response
    assert done[-1] == max(done) == 6
    for lane in range(3):
        own = run_case(alone(lane), engine, RunOptions(tolerance=tolerance)).response
        count = len(own.times)
        for name, values in own.fields.items():
            for row in (lane, lane + 3):
                got = found[name][row]
                if FIELDS[name].dims[-1] == "sample":
                    assert np.isnan(got[..., count:]).all()
                    got = got[..., :count]
                assert got.tobytes() == values[0].tobytes(), name


def test_tables_say_when_each_lane_ends():
    run = run_case(case_of(LANES), "housner")
    table = lane_table(run.lane_set, run.response)
    assert table["duration_s"].tolist() == DURATIONS * 2
    assert table["undecided"].all()
    assert duration_facts(run.lane_set) == {"duration_s": 2.0, "shortest_duration_s": 0.9}
    again = run_lanes(run, [4, 0])
    for row, (lane, last) in enumerate([(4, 2.0), (0, 0.9)]):
        history = history_table(again, row, run.lane_set, lane)
        assert history["time_s"].iloc[-1] == pytest.approx(last, abs=1e-12)
        assert not history.isna().any(axis=None)


def test_equal_durations_make_no_difference():
    swept = expand_lanes(case_of({"run.duration": ["2 s", "2000 ms"]}))
    assert swept.durations is None
    assert swept.times.duration == 2.0


def test_what_needs_one_duration_refuses_several():
    lane_set = expand_lanes(case_of(LANES))
    with pytest.raises(InputError, match=r"run.duration: got 0.9 s to 2 s, must be the same"):
        _ = lane_set.times


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"sweep": {"run.duration": ["2 s", "20 ms"]}}, "got 0.02 s, must be at least run.sample_"),
        (
            {"sweep": {"run.duration": ["1 s", "0 s"]}},
            r"run.duration\[1\]: got '0 s', must be more",
        ),
    ],
)
def test_a_duration_that_cannot_be_used_is_refused(changes, said):
    with pytest.raises(InputError, match=said):
        expand_lanes(case_of(**{"sweep": LANES, **changes}))


def test_a_motion_starts_before_the_end_of_its_own_lane():
    motion = {"waveform": "sine", "control": "acceleration", "frequency": "2 Hz", "cycles": 1}
    raw = dict(case_of(LANES).raw) | {"motion": {**motion, "amplitude": "0.1 g", "start": "1 s"}}
    del raw["start"]
    with pytest.raises(InputError, match=r"must be before the end of the run, 0.9 s \(lane 0\)"):
        expand_lanes(build_case("durations", "case.toml", None, raw))


@pytest.mark.parametrize("table", ["sample", "ensemble"])
def test_a_duration_is_not_drawn(table):
    raw = dict(case_of({"block.height": ["1 m"]}, duration="2 s").raw)
    drawn = {"distribution": "uniform", "from": "1 s", "to": "2 s"}
    given = {"lanes": 4, "over": {"run.duration": drawn}}
    if table == "ensemble":
        given = {"members": 4, "spread": {"run.duration": "1 s"}}
    with pytest.raises(InputError, match=r"run.duration: got .*unknown key"):
        build_case("durations", "case.toml", None, raw | {table: given})
