"""Records: what a file must say, what its quantity implies, and what is shipped."""

import hashlib
import pathlib
import re

import numpy as np
import pytest

from warprock.errors import InputError
from warprock.model.motion import Control, RecordMotions
from warprock.recordings import load_record, record_motions, record_names

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "cases" / "ground-motions"


def write(folder: pathlib.Path, text: str) -> str:
    path = folder / "motion.csv"
    path.write_text(text, encoding="utf-8")
    return str(path)


def sampled(folder: pathlib.Path, unit: str, samples: list[float], interval: str = "0.5 s") -> str:
    lines = "\n".join(repr(float(value)) for value in samples)
    return write(folder, f"# unit: {unit}\n# interval: {interval}\n{lines}\n")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("# interval: 0.01 s\n1\n2\n", "unit: got nothing"),
        ("# unit: furlong\n# interval: 0.01 s\n1\n2\n", "unit: got 'furlong'"),
        ("# unit: s\n# interval: 0.01 s\n1\n2\n", "unit: got 's'"),
        ("# unit: g\n1\n2\n", "interval: got nothing"),
        ("# unit: g\n# interval: 0.01\n1\n2\n", "interval: got '0.01'"),
        ("# unit: g\n# interval: 0 s\n1\n2\n", "interval: got '0 s'"),
        ("# unit: g\n# interval: -1 s\n1\n2\n", "interval: got '-1 s'"),
        ("# unit: g\n# interval: 1 s\n1\nnan\n2\n", "line 4: got 'nan'"),
        ("# unit: g\n# interval: 1 s\n1\n2\ninf\n", "line 5: got 'inf'"),
        ("# unit: g\n# interval: 1 s\n1\n0.1, 0.2\n", "line 4: got '0.1, 0.2'"),
        ("# unit: g\n# interval: 1 s\n1\nabc\n", "line 4: got 'abc'"),
        ("# unit: g\n# interval: 1 s\n1\n", "samples: got 1 samples, must be at least 2"),
        ("# unit: g\n# interval: 1 s\n", "samples: got 0 samples, must be at least 2"),
        (
            "# unit: m/s^2\n# interval: 1 s\n1\n-1000.1\n",
            "samples: got -1000.1 m/s^2 (sample 1), must be from -1000 m/s^2 to 1000 m/s^2",
        ),
        ("# unit: g\n# interval: 1 s\n1e308\n1\n", "samples: got inf m/s^2 (sample 0)"),
        ("# unit: m\n# interval: 1 s\n1\n101\n", "got 101 m (sample 1), must be from -100 m"),
        ("# unit: g\n# interval: 1e-300 s\n1\n2\n", "got 1e-300 s, must be from 1e-6 s to 1e5 s"),
        ("# unit: g\n# interval: 1e300 s\n1\n2\n", "got 1e+300 s, must be from 1e-6 s to 1e5 s"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path: pathlib.Path, text: str, said: str) -> None:
    file = write(tmp_path, text)
    with pytest.raises(InputError, match=re.escape(said)) as caught:
        load_record(file)
    assert str(caught.value).startswith(file)
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(not pathlib.Path("/dev/zero").exists(), reason="devices are files on POSIX")
def test_a_device_is_no_record() -> None:
    with pytest.raises(InputError, match=r"must be a file to read \(a device\)"):
        load_record("/dev/zero")


def test_a_missing_file_names_what_is_shipped(tmp_path: pathlib.Path) -> None:
    with pytest.raises(InputError, match="did you mean ridgecrest-2019-ccc-"):
        load_record("ridgecrest-2019-ccc-180")
    with pytest.raises(InputError, match="record"):
        load_record(str(tmp_path))
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not UTF-8"):
        load_record("binary.csv", relative_to=tmp_path)


@pytest.mark.parametrize(
    ("unit", "quantity", "size"),
    [
        ("m/s^2", Control.ACCELERATION, 1.0),
        ("gal", Control.ACCELERATION, 0.01),
        ("g", Control.ACCELERATION, 9.81),
        ("cm/s", Control.VELOCITY, 0.01),
        ("mm", Control.DISPLACEMENT, 0.001),
    ],
)
def test_the_unit_says_what_the_samples_are(
    tmp_path: pathlib.Path, unit: str, quantity: Control, size: float
) -> None:
    record = load_record(sampled(tmp_path, unit, [1.0, -3.0, 2.0], "20 ms"))
    assert record.quantity is quantity
    assert record.interval == 0.02
    assert record.duration == pytest.approx(0.04)
    assert record.samples == pytest.approx(size * np.array([1.0, -3.0, 2.0]))
    assert record.name == "motion"
    assert record.sha256 == hashlib.sha256(pathlib.Path(record.file).read_bytes()).hexdigest()


def one_lane(path: str, scale: float = 1.0, start: float = 0.0) -> RecordMotions:
    return record_motions([load_record(path)], index=[0], scale=[scale], start=[start])


def followed(motions: RecordMotions, lane: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, velocity and displacement just after each knot, from the segments alone."""
    times, velocities, displacements = [], [], []
    velocity = displacement = 0.0
    for part in motions.segments(lane):
        velocity += part.velocity_step
        times.append(part.start)
        velocities.append(velocity)
        displacements.append(displacement)
        if not np.isfinite(part.stop):
            break
        span = part.stop - part.start
        begin, middle, end = (part.acceleration(part.start + f * span) for f in (0.0, 0.5, 1.0))
        # Simpson's rule and its like for the double integral are exact for linear acceleration.
        displacement += velocity * span + span**2 * (begin + 2.0 * middle) / 6.0
        velocity += span * (begin + 4.0 * middle + end) / 6.0
    return np.array(times), np.array(velocities), np.array(displacements)


def test_acceleration_samples_are_joined_by_lines(tmp_path: pathlib.Path) -> None:
    samples = [0.5, 2.0, -1.0, 0.25]
    motions = one_lane(sampled(tmp_path, "m/s^2", samples))
    at = np.array([0.0, 0.25, 0.5, 1.2, 1.49])
    expected = np.interp(at, [0.0, 0.5, 1.0, 1.5], samples)
    assert motions.acceleration(at, 0) == pytest.approx(expected)
    assert motions.acceleration(np.array([1.51, 9.0]), 0) == pytest.approx([0.0, 0.0])
    _, velocity, _ = followed(motions)
    assert motions.pool_velocity == pytest.approx(velocity)
    assert velocity[-1] == pytest.approx(0.5 * (1.25 + 0.5 - 0.375))
    assert motions.velocity_step_start[0] == motions.velocity_step_stop[0] == 0.0


def test_velocity_samples_are_joined_by_lines_and_the_base_stops(tmp_path: pathlib.Path) -> None:
    samples = [0.5, 2.0, -1.0, 0.25]
    motions = one_lane(sampled(tmp_path, "m/s", samples))
    _, velocity, _ = followed(motions)
    assert velocity == pytest.approx([0.5, 2.0, -1.0, 0.0])
    assert motions.pool_velocity == pytest.approx(velocity)
    assert motions.acceleration(np.array([0.1, 0.6]), 0) == pytest.approx([3.0, -6.0])
    assert motions.velocity_step_start[0] == 0.5
    assert motions.velocity_step_stop[0] == -0.25


@pytest.mark.parametrize(
    ("unit", "samples"),
    [
        ("m/s", [-3e-17, 0.5, -0.2, 2.9e-17]),
        # A cubic whose slope is zero at both ends.
        ("m", [3.0 * t**2 - 2.0 * t**3 for t in np.linspace(0.0, 1.0, 8)]),
    ],
)
def test_round_off_at_an_end_is_no_velocity_step(
    tmp_path: pathlib.Path, unit: str, samples: list[float]
) -> None:
    motions = one_lane(sampled(tmp_path, unit, samples))
    assert motions.velocity_step_start[0] == motions.velocity_step_stop[0] == 0.0


def test_displacement_samples_are_met_and_joined_smoothly(tmp_path: pathlib.Path) -> None:
    samples = [0.0, 0.3, -0.2, 0.4, 0.1, 0.15]
    path = sampled(tmp_path, "m", samples)
    motions = one_lane(path)
    times, velocity, displacement = followed(motions)
    assert displacement == pytest.approx(samples, abs=1e-14)
    assert motions.pool_velocity == pytest.approx(velocity, abs=1e-13)
    assert velocity[-1] == pytest.approx(0.0, abs=1e-13)
    # Continuous acceleration at the inner knots; 1e-9 s times the slope of about 100 m/s^3.
    inner = times[1:-1]
    assert motions.acceleration(inner - 1e-9, 0) == pytest.approx(
        motions.acceleration(inner, 0), abs=1e-6
    )
    record = load_record(path)
    assert record.acceleration[:-1] == pytest.approx(motions.acceleration(times[:-1], 0))


def test_a_sampled_cubic_is_its_own_spline(tmp_path: pathlib.Path) -> None:
    times = 0.5 * np.arange(6)
    motions = one_lane(sampled(tmp_path, "m", list(times**3 - 2.0 * times)))
    inside = np.array([0.1, 0.7, 2.4])
    assert motions.acceleration(inside, 0) == pytest.approx(6.0 * inside)
    assert motions.velocity_step_start[0] == pytest.approx(-2.0)
    assert motions.velocity_step_stop[0] == pytest.approx(-(3.0 * 2.5**2 - 2.0))


@pytest.mark.parametrize("count", [2, 3])
def test_a_displacement_record_may_be_short(tmp_path: pathlib.Path, count: int) -> None:
    samples = [0.0, 0.3, 0.4][:count]
    _, _, displacement = followed(one_lane(sampled(tmp_path, "m", samples)))
    assert displacement == pytest.approx(samples, abs=1e-15)


def test_scale_and_start_apply_to_everything(tmp_path: pathlib.Path) -> None:
    path = sampled(tmp_path, "m/s", [0.5, 2.0, -1.0])
    times, velocity, displacement = followed(one_lane(path))
    later, faster, further = followed(one_lane(path, scale=-2.0, start=0.7))
    assert later == pytest.approx(np.append(0.0, times + 0.7))
    assert faster == pytest.approx(np.append(0.0, -2.0 * velocity))
    assert further == pytest.approx(np.append(0.0, -2.0 * displacement))


def test_lanes_share_a_pool(tmp_path: pathlib.Path) -> None:
    (tmp_path / "a").mkdir()
    first = load_record(sampled(tmp_path / "a", "m/s^2", [1.0, 2.0, 3.0], "0.1 s"))
    second = load_record(sampled(tmp_path, "m/s", [1.0, 5.0], "0.2 s"))
    motions = record_motions([first, second], index=[1, 0, 1], scale=[1.0, 2.0, 3.0], start=0.0)
    assert motions.lane_count == 3
    assert len(motions.pool_acceleration) == 5
    at = np.array([0.05])
    found = [float(motions.acceleration(at, lane)[0]) for lane in range(3)]
    assert found == pytest.approx([20.0, 3.0, 60.0])
    assert motions.take(slice(1, 3)).acceleration(at, 1) == pytest.approx([60.0])


def test_every_shipped_record_is_in_the_notice_with_its_hash() -> None:
    notice = (FOLDER / "NOTICE").read_text(encoding="utf-8")
    listed = dict(
        reversed(line.split()) for line in notice.splitlines() if re.match(r"[0-9a-f]{64}  ", line)
    )
    found = {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in FOLDER.iterdir()
        if path.name != "NOTICE"
    }
    assert listed == found
    assert [f"{name}.csv" for name in record_names()] == sorted(found)


@pytest.mark.parametrize("name", record_names())
def test_a_shipped_record_is_fit_to_drive_a_block(name: str) -> None:
    record = load_record(name)
    assert record.name == name
    assert record.source
    assert record.licence
    assert 60.0 <= record.duration <= 80.0
    _, velocity, displacement = followed(record_motions([record], index=[0], scale=1.0, start=0.0))
    # 8 digits a sample leave 1e-8 x the peak velocity x the square root of the samples; a
    # drifting record would be off by parts of its peaks.
    assert abs(velocity[-1]) < 1e-5 * record.peak_velocity
    assert abs(displacement[-1]) < 1e-3 * np.max(np.abs(displacement))


def test_the_records_of_one_station_are_its_two_directions() -> None:
    records = {name: load_record(name) for name in record_names()}
    stations = {name.rpartition("-")[0] for name in records}
    assert len(stations) == 3
    for station in stations:
        first, second = (records[f"{station}-{azimuth}"] for azimuth in ("090", "360"))
        assert first.original_sha256 == second.original_sha256
        assert not np.array_equal(first.samples, second.samples)


def test_a_file_is_read_again_only_if_it_has_changed(tmp_path: pathlib.Path) -> None:
    path = sampled(tmp_path, "m/s^2", [1.0, 2.0, 3.0])
    first = load_record(path)
    assert load_record(path) is first
    # Of the same length, within the same tick of the clock.
    sampled(tmp_path, "m/s^2", [1.0, 2.0, 4.0])
    assert load_record(path).samples[-1] == 4.0


def test_a_velocity_is_greatest_where_the_acceleration_crosses_zero(tmp_path: pathlib.Path) -> None:
    # a = 1 - 2 t: v = t - t^2, 0 at both samples.
    record = load_record(write(tmp_path, "# unit: m/s^2\n# interval: 1 s\n1\n-1\n"))
    assert record.peak_velocity == pytest.approx(0.25, rel=1e-15)
