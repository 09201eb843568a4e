"""Lanes of a case: which values meet in which lane, and what is refused."""

import math
import re

import numpy as np
import pytest

from tests.shared.case_texts import FREE
from tests.shared.marks import first
from tests.shared.shipped import RUNNABLE_CASES
from warprock import quantity
from warprock.case.ground_motions import case_records
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.model.motion import (
    HarmonicMotions,
    MotionKind,
    RickerMotions,
    SpatialMotions,
    StillBase,
)
from warprock.recordings import load_record
from warprock.recordings.intensity import spectral_accelerations

ANALYTIC_CASES = [name for name in RUNNABLE_CASES if name != "record-ridgecrest"]


@pytest.fixture
def expand(tmp_path):
    def expand_text(text, *overrides):
        file = tmp_path / "case.toml"
        file.write_text(text, encoding="utf-8")
        return expand_lanes(load_case(file, overrides))

    return expand_text


def motion(waveform, control, amplitude, *lines):
    return "\n".join(
        [
            FREE,
            "[motion]",
            f'waveform = "{waveform}"',
            f'control = "{control}"',
            'frequency = "2 Hz"',
            f'amplitude = "{amplitude}"',
            *lines,
        ]
    )


def test_first_axis_is_slowest_and_keys_of_an_axis_are_zipped():
    lane_set = expand_lanes(load_case("free-b1-b3"))
    assert lane_set.shape == (3, 3)
    assert list(lane_set.inputs["block"]) == ["B1"] * 3 + ["B2"] * 3 + ["B3"] * 3
    np.testing.assert_array_equal(lane_set.lanes.height, np.repeat([0.75, 1.0, 1.25], 3))
    ratio = np.tile([0.2, 0.5, 0.99], 3)
    # One product and one quotient of doubles.
    np.testing.assert_allclose(lane_set.inputs["rotation_ratio_start"], ratio, rtol=4.5e-16)
    # Table 3 of the paper prints the slenderness angles with two decimals.
    np.testing.assert_allclose(lane_set.lanes.slenderness_angle[::3], [0.59, 0.46, 0.38], atol=5e-3)
    assert isinstance(lane_set.motions, StillBase)
    assert lane_set.motions.lane_count == 9


def test_both_readings_of_b0():
    lane_set = expand_lanes(load_case("free-b0"))
    # 0.1974 rad and 0.942 belong to 5 m; the paper's 0.18 rad and 0.952 belong to 5.5 m.
    np.testing.assert_allclose(lane_set.lanes.slenderness_angle, [0.1974, 0.1799], atol=5e-5)
    np.testing.assert_allclose(lane_set.lanes.angular_restitution, [0.942, 0.952], atol=5e-4)


@pytest.mark.parametrize("name", ["single-sine-pulse", "single-continuous-sine"])
def test_the_inputs_of_table_4(name):
    lane_set = expand_lanes(load_case(name))
    inputs = lane_set.inputs
    assert list(inputs["reading"].unique()) == ["displacement", "acceleration", "double-size"]
    for reading in ("displacement", "acceleration", "double-size"):
        rows = inputs.iloc[lane_set.select({"reading": reading})]
        assert list(rows["frequency_hz"]) == [3.0, 3.3, 3.3, 5.0, 5.0, 5.0]
        assert list(rows["amplitude_mm"]) == [8.0, 6.0, 8.0, 4.0, 5.0, 6.0]
        # Printed in Table 4 with two decimals.
        printed = [2.84, 2.58, 3.44, 3.95, 4.93, 5.92]
        np.testing.assert_allclose(rows["peak_acceleration_m_s2"], printed, atol=5e-3)
        # A (2 pi f)^2 / (9.81 x 0.17), worked out by hand; full sizes or half, the ratio is one.
        ratios = [1.70, 1.55, 2.06, 2.37, 2.96, 3.55]
        np.testing.assert_allclose(rows["normalised_acceleration"], ratios, atol=5e-3)
    slip = lane_set.select({"reading": "double-size"})
    np.testing.assert_array_equal(lane_set.lanes.width[slip], 0.34)
    np.testing.assert_array_equal(lane_set.lanes.height[slip], 2.0)
    assert {True} == {width == 0.17 for width in lane_set.lanes.width[: slip[0]]}


def test_velocity_steps_follow_the_reading():
    lane_set = expand_lanes(load_case("single-sine-pulse"))
    motions = lane_set.motions
    assert isinstance(motions, HarmonicMotions)
    step = 2.0 * np.pi * lane_set.inputs["frequency_hz"] * lane_set.inputs["amplitude_mm"] / 1000.0
    moved = lane_set.select({"reading": "displacement"})
    # A 2 pi f, by another order of products: a few units in the last place.
    np.testing.assert_allclose(motions.velocity_step_start[moved], step[moved], rtol=1e-15)
    np.testing.assert_allclose(motions.velocity_step_stop[moved], -step[moved], rtol=1e-15)
    for reading in ("acceleration", "double-size"):
        shaken = lane_set.select({"reading": reading})
        np.testing.assert_array_equal(motions.velocity_step_start[shaken], 0.0)
        np.testing.assert_array_equal(motions.velocity_step_stop[shaken], 0.0)


WRITTEN = {
    "displacement": ("50 mm", "amplitude_mm", 50.0),
    "velocity": ("0.2 m/s", "amplitude_m_s", 0.2),
    "acceleration": ("0.4 g", "amplitude_m_s2", 3.924),
}


@pytest.mark.parametrize("control", ["displacement", "velocity", "acceleration"])
@pytest.mark.parametrize("kind", list(WRITTEN))
def test_an_amplitude_of_any_kind_gives_the_same_sine_under_any_control(control, kind, expand):
    text, column, value = WRITTEN[kind]
    lane_set = expand(motion("sine", control, text, "cycles = 2"))
    w = 2.0 * math.pi * 2.0
    peak = {"displacement": 0.05 * w * w, "velocity": 0.2 * w, "acceleration": 3.924}[kind]
    assert isinstance(lane_set.motions, HarmonicMotions)
    # Powers of 2 pi f multiplied and divided out again: a few roundings.
    assert lane_set.motions.acceleration_amplitude[0] == pytest.approx(peak, rel=2e-15)
    assert lane_set.inputs["peak_acceleration_m_s2"][0] == pytest.approx(peak, rel=2e-15)
    assert lane_set.inputs[column][0] == value
    assert lane_set.inputs["stop_s"][0] == 1.0
    assert [name for name in lane_set.inputs if name.startswith("amplitude")] == [column]


@pytest.mark.parametrize("control", ["displacement", "velocity", "acceleration"])
def test_the_peak_acceleration_of_a_ricker_pulse(control, expand):
    text = WRITTEN[control][0]
    lane_set = expand(motion("ricker", control, text))
    motions = lane_set.motions
    assert isinstance(motions, RickerMotions)
    times = np.linspace(motions.start[0], motions.stop[0], 200_001)
    sampled = np.max(np.abs(motions.acceleration(times, 0)))
    # Samples 1e-5 s apart miss a peak of curvature (2 pi f)^2 x a few by less than 1e-7 of it.
    assert lane_set.inputs["peak_acceleration_m_s2"][0] == pytest.approx(sampled, rel=1e-7)


def test_a_motion_stops_after_its_duration_or_its_cycles(expand):
    lane_set = expand(motion("sine", "velocity", "1 m/s", 'duration = "3 s"', 'start = "1 s"'))
    assert (lane_set.inputs["start_s"][0], lane_set.inputs["stop_s"][0]) == (1.0, 4.0)
    lane_set = expand(motion("cosine", "velocity", "1 m/s", "cycles = 3", 'start = "1 s"'))
    assert (lane_set.inputs["start_s"][0], lane_set.inputs["stop_s"][0]) == (1.0, 2.5)


def test_grids_are_linear_or_logarithmic(expand):
    grid = (
        '[[sweep]]\nblock.height = { from = "1 m", to = "200 cm", count = 5 }\n'
        '[[sweep]]\ncontact.friction = { from = 0.01, to = 100, count = 5, spacing = "log" }\n'
    )
    lane_set = expand(FREE + grid)
    assert lane_set.shape == (5, 5)
    np.testing.assert_array_equal(lane_set.lanes.height[::5], [1.0, 1.25, 1.5, 1.75, 2.0])
    # Powers of ten through logarithms: some roundings.
    np.testing.assert_allclose(
        lane_set.lanes.friction[:5], [0.01, 0.1, 1.0, 10.0, 100.0], rtol=1e-14
    )


def test_one_point_grids_and_no_sweep_at_all(expand):
    point = '[[sweep]]\nblock.height = { from = "2 m", to = "3 m", count = 1 }\n'
    assert list(expand(FREE + point).lanes.height) == [2.0]
    assert expand(FREE).lanes.lane_count == 1


def test_restitution_is_housners_unless_given(expand):
    lane_set = expand(FREE)
    # sin^2 = b^2 / (b^2 + h^2) = 0.2 for 0.5 x 1: 1 - 1.5 x 0.2.
    assert lane_set.lanes.angular_restitution[0] == pytest.approx(0.7, rel=1e-15)
    assert not lane_set.scene.restitution_given
    lane_set = expand(FREE, "contact.angular_restitution=0.9")
    assert lane_set.lanes.angular_restitution[0] == 0.9
    assert lane_set.scene.restitution_given


FEWER = {
    "record-sample": ["sample.lanes=40"],
    "rocking-spectrum": ['spectrum.period={ from = "1 s", to = "8 s", count = 5 }'],
    "fragility-five-blocks": ["motion.scale=[0.5, 1.0]"],
}


@pytest.mark.parametrize("name", first(10, sorted(ANALYTIC_CASES, key=len)))
def test_lanes_alone_are_the_lanes_of_the_whole(name):
    case = load_case(name, FEWER.get(name, ()))
    whole = expand_lanes(case)
    for start, stop in [(0, 1), (1, case.lane_count), (case.lane_count - 1, case.lane_count)]:
        part = expand_lanes(case, range(start, stop))
        assert part.inputs.equals(whole.inputs.iloc[start:stop].reset_index(drop=True))
        np.testing.assert_array_equal(part.lanes.width, whole.lanes.width[start:stop])
        chosen = whole.motions.take(slice(start, stop))
        # A record has a segment a sample, so a few lanes will do.
        few = range(min(stop - start, 5))
        pairs = zip(_directions(part.motions), _directions(chosen), strict=True)
        for ours, theirs in pairs:
            assert [len(ours.segments(lane)) for lane in few] == [
                len(theirs.segments(lane)) for lane in few
            ]


def _directions(motions):
    return motions.components if isinstance(motions, SpatialMotions) else (motions,)


MILLION = (
    'sweep=[{ motion.frequency = { from = "1 Hz", to = "10 Hz", count = 1000, spacing = "log" } }, '
    '{ motion.amplitude = { from = "0.1 g", to = "2 g", count = 1000 } }]'
)


@pytest.mark.thorough
def test_a_million_lanes_are_judged_by_their_axes(monkeypatch):
    calls = []
    read = quantity.parse_any
    monkeypatch.setattr(
        quantity, "parse_any", lambda got, kinds: calls.append(got) or read(got, kinds)
    )
    case = load_case("single-sine-pulse", ["motion.control=acceleration", MILLION])
    lane_set = expand_lanes(case)
    assert lane_set.lanes.lane_count == len(lane_set.inputs) == 1_000_000
    # The few values of the tables and both ends of both grids; never one a lane.
    assert len(calls) < 50
    lane = 123_456
    alone = expand_lanes(case, range(lane, lane + 1))
    assert alone.inputs.equals(lane_set.inputs.iloc[[lane]].reset_index(drop=True))
    assert lane_set.inputs["amplitude_m_s2"][lane] == pytest.approx(
        9.81 * (0.1 + 1.9 * 456 / 999), rel=1e-14
    )


def test_labels_select_lanes():
    lane_set = expand_lanes(load_case("free-b1-b3"))
    np.testing.assert_array_equal(lane_set.select({}), np.arange(9))
    np.testing.assert_array_equal(lane_set.select({"block": "B2"}), [3, 4, 5])
    with pytest.raises(InputError, match="must be a label of the case"):
        lane_set.select({"reading": "double-size"})
    with pytest.raises(InputError, match="must select at least one lane"):
        lane_set.select({"block": "B4"})


REFUSED = [
    (
        motion("cosine", "displacement", "8 mm", "cycles = 1"),
        "motion.control",
        "got displacement, must be velocity or acceleration with waveform cosine",
    ),
    (
        motion("ricker", "acceleration", "8 mm"),
        "motion.amplitude",
        "got 0.008 m, must be of the kind of motion.control with waveform ricker",
    ),
    (
        motion("sine", "velocity", "1 m/s", "cycles = 1", 'start = "5 s"'),
        "motion.start",
        "got 5 s, must be before the end of the run, 5 s",
    ),
    (
        FREE + '[start]\nrotation = "27 deg"\n',
        "start.rotation",
        "got 27 deg, must be less than the block's slenderness angle, 26.5651 deg",
    ),
    (
        FREE + '[start]\nrotation = "-27 deg"\n',
        "start.rotation",
        "got -27 deg, must be less than the block's slenderness angle, 26.5651 deg",
    ),
    (
        motion("sine", "velocity", "1 m/s", "cycles = 1")
        + '\n[[sweep]]\nmotion.waveform = ["sine", "ricker"]\n',
        "motion.waveform",
        "got ricker, sine, must be of one family in a case",
    ),
    (FREE + '[[sweep]]\nlabel.width_m = ["a"]\n', "sweep.label.width_m", "must not be the name"),
    (FREE + '[[sweep]]\nlabel.status = ["a"]\n', "sweep.label.status", "must not be the name"),
    (
        FREE
        + '[[check]]\nkind = "peaks"\nengine = "housner"\nbecause = "b"\nvalues = [0.1, 0.2]\n'
        + "tolerance = 1e-3\n",
        "check[0].values",
        "got 2 values, must be 1, one for each lane selected",
    ),
]


@pytest.mark.parametrize(("text", "key", "words"), REFUSED)
def test_values_that_do_not_fit_together_are_refused(text, key, words, expand, tmp_path):
    with pytest.raises(InputError) as caught:
        expand(text)
    assert str(caught.value).startswith(f"{tmp_path / 'case.toml'}: {key}: got ")
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_first_bad_lane_is_named(expand):
    sweep = '[[sweep]]\nstart.rotation = ["1 deg", "30 deg", "40 deg"]\n'
    with pytest.raises(InputError, match=r"got 30 deg, .* \(lane 1\)"):
        expand(FREE + sweep)


def test_no_lanes_at_all_are_refused():
    case = load_case("free-b0")
    with pytest.raises(InputError, match=r"free-b0/case\.toml: sweep: got 0 lanes, must make"):
        expand_lanes(case, range(0))


def test_a_rotation_is_given_by_angle_or_by_ratio(expand):
    by_angle = expand(FREE, "start.rotation=10 deg")
    assert by_angle.lanes.rotation_start[0] == pytest.approx(math.radians(10.0), rel=4.5e-16)
    by_ratio = expand(FREE, "start.rotation_ratio=-0.5")
    start = by_ratio.lanes.rotation_start[0]
    assert start == pytest.approx(-0.5 * math.atan(0.5), rel=4.5e-16)


def test_the_record_case_scales_one_record():
    case = load_case("record-ridgecrest")
    lane_set = expand_lanes(case)
    inputs = lane_set.inputs
    (record,) = case_records(case)
    assert lane_set.scene.motion is MotionKind.RECORD
    assert list(inputs["record"].unique()) == [record.name]
    # An accelerogram's peak is its largest sample.
    peak = np.abs(inputs["scale"]) * np.max(np.abs(record.samples))
    np.testing.assert_allclose(inputs["peak_acceleration_m_s2"], peak, rtol=4.5e-16)
    # The scales span uplift, g tan(alpha), and the run outlasts the record.
    assert inputs["normalised_acceleration"].min() < 1.0 < inputs["normalised_acceleration"].max()
    assert case.sample_times.duration > record.duration


RECORD = "# unit: {unit}\n# interval: 0.5 s\n0\n1\n-2\n0\n"


def record_case(*names):
    listed = ", ".join(f'"{name}"' for name in names)
    return (
        f'{FREE}[motion]\nwaveform = "record"\n[[sweep]]\nmotion.record = [{listed}]\n'
        "[[sweep]]\nmotion.scale = [1.0, 3.0]\n"
    )


def test_records_are_found_beside_the_case_file(expand, tmp_path):
    (tmp_path / "small.csv").write_text(RECORD.format(unit="cm/s^2"))
    (tmp_path / "large.csv").write_text(RECORD.format(unit="g"))
    lane_set = expand(record_case("small.csv", "large.csv"))
    inputs = lane_set.inputs
    assert list(inputs["record"]) == ["small.csv", "small.csv", "large.csv", "large.csv"]
    assert list(inputs["scale"]) == [1.0, 3.0, 1.0, 3.0]
    # Largest sample times unit times scale, products of doubles.
    np.testing.assert_allclose(
        inputs["peak_acceleration_m_s2"], [0.02, 0.06, 19.62, 58.86], rtol=1e-15
    )
    times = np.array([0.25, 0.5, 0.75])
    wanted = 3.0 * 9.81 * np.array([0.5, 1.0, -0.5])
    np.testing.assert_allclose(lane_set.motions.acceleration(times, 3), wanted, rtol=1e-14)


def test_a_bad_sample_names_the_record_file_and_its_line(expand, tmp_path):
    (tmp_path / "bad.csv").write_text(RECORD.format(unit="g").replace("-2", "nan"))
    with pytest.raises(InputError, match=r"bad\.csv: line 5: got 'nan', must be one finite"):
        expand(record_case("bad.csv"))


def test_a_record_without_a_unit_is_refused(expand, tmp_path):
    (tmp_path / "bare.csv").write_text("# interval: 0.5 s\n0\n1\n")
    with pytest.raises(InputError, match=r"bare\.csv: unit: got nothing, must be a line"):
        expand(record_case("bare.csv"))


def test_a_record_that_does_not_exist_is_refused(expand, tmp_path):
    with pytest.raises(InputError) as caught:
        expand(record_case("no-such.csv"))
    assert str(caught.value).startswith(
        f"{tmp_path / 'case.toml'}: motion.record: got 'no-such.csv'"
    )
    case = load_case("record-ridgecrest", ["motion.record=no-such-record"])
    with pytest.raises(
        InputError, match=r"^-s: motion.record: got 'no-such-record', must be a file"
    ):
        expand_lanes(case)


def test_a_record_is_scaled_to_a_target():
    period = "motion.sa_period=1 s"
    record = load_record("ridgecrest-2019-ccc-090")
    own = spectral_accelerations(record, [1.0])[0]
    to_peak = expand_lanes(
        load_case("record-ridgecrest", ["motion.target_pga=0.1 g, 0.4 g", period])
    ).inputs
    np.testing.assert_allclose(to_peak["peak_acceleration_m_s2"], [0.981, 3.924], rtol=1e-14)
    factors = np.array([0.981, 3.924]) / record.peak_acceleration
    np.testing.assert_allclose(to_peak["scale"], factors, rtol=1e-12)
    np.testing.assert_allclose(to_peak["spectral_acceleration_m_s2"], factors * own, rtol=1e-12)
    to_sa = expand_lanes(load_case("record-ridgecrest", ["motion.target_sa=0.2 g", period])).inputs
    assert to_sa["spectral_acceleration_m_s2"][0] == pytest.approx(0.2 * 9.81, rel=1e-14)
    assert to_sa["scale"][0] == pytest.approx(0.2 * 9.81 / own, rel=1e-12)


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["motion.target_sa=0.2 g"], "motion.sa_period: got nothing, must be given with"),
        (["motion.target_pga=200 g"], "-s: motion.target_pga: got '200 g', must be more than 0 g"),
    ],
)
def test_a_target_that_cannot_be_met_is_refused(overrides: list[str], words: str):
    with pytest.raises(InputError, match=re.escape(words)):
        expand_lanes(load_case("record-ridgecrest", overrides))


def test_what_a_record_cannot_say_is_refused(expand, tmp_path):
    (tmp_path / "slow.csv").write_text(RECORD.format(unit="g"))
    (tmp_path / "still.csv").write_text(RECORD.format(unit="g").replace("1\n-2", "0\n0"))
    with pytest.raises(InputError, match=r"sa_period: got '0.004 s', must be at least 0.005 s for"):
        expand(record_case("slow.csv"), "motion.sa_period=4 ms")
    with pytest.raises(InputError, match=r"target_pga: got 9.81 m/s\^2, must be at most 1000"):
        expand(record_case("still.csv"), "motion.target_pga=1 g")


def test_a_case_without_a_record_has_none():
    assert case_records(load_case("free-b0")) == []
    assert case_records(load_case("single-sine-pulse")) == []
