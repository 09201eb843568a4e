"""Files of the strong-motion networks, written here as their formats are documented."""

import gzip
import hashlib
import pathlib
import re
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given, settings, strategies

from warprock.errors import InputError
from warprock.model.motion import Control
from warprock.recordings import load_channels, load_record
from warprock.recordings.loading import read_channels
from warprock.recordings.processing import parse_step, process

DATA = pathlib.Path(__file__).resolve().parents[1] / "data"
GRAVITY = 9.80665
WAVE = np.array([0.0, 0.125, -0.25, 9.5, -9.25, 0.0625, -0.5, 1.0, -9.75, 0.375, 0.25])
"""Numbers that fill their fields, so that no blank is left between some of them."""


def rows(values: Sequence[float], width: int, digits: int, per_line: int) -> list[str]:
    fields = [f"{value:{width}.{digits}f}".replace(" 0.", "  .") for value in values]
    assert all(len(field) == width for field in fields)
    return ["".join(fields[at : at + per_line]) for at in range(0, len(fields), per_line)]


def peer(fourth: str = "NPTS=     11, DT=   .0100 SEC,", third: str = "") -> str:
    body = [f"{value:15.7E}" for value in WAVE]
    return "\n".join(
        [
            "PEER NGA STRONG MOTION DATABASE RECORD",
            "Somewhere-02, 5/19/1940, A Station, 180",
            third or "ACCELERATION TIME SERIES IN UNITS OF G",
            fourth,
            "".join(body[:5]),
            "".join(body[5:10]),
            "".join(body[10:]),
        ]
    )


def esm(**changed: str) -> str:
    known = {
        "EVENT_NAME": "SOMEWHERE",
        "EVENT_ID": "EMSC-1",
        "EVENT_DATE_YYYYMMDD": "20190728",
        "NETWORK": "XX",
        "STATION_CODE": "ABC",
        "SAMPLING_INTERVAL_S": "0.005000",
        "NDATA": str(len(WAVE)),
        "STREAM": "HNE",
        "UNITS": "cm/s^2",
        "BASELINE_CORRECTION": "BASELINE REMOVED",
        "FILTER_TYPE": "BUTTERWORTH",
        "FILTER_ORDER": "2",
        "LOW_CUT_FREQUENCY_HZ": "0.1",
        "HIGH_CUT_FREQUENCY_HZ": "30",
        "HEADER_FORMAT": "DYNA 1.2",
        "PROCESSING": "manual",
        "DATA_LICENSE": "CC BY 4.0",
    } | changed
    known |= {f"USER{number}": "" for number in range(64 - len(known))}
    return "\n".join([f"{k}: {v}" for k, v in known.items()] + [f"{v:.6f}" for v in WAVE])


def knet(scale: str = "2000(gal)/8388608", samples: int = 11) -> str:
    head = {
        "Origin Time": "2018/01/24 19:51:00",
        "Lat.": "41.0",
        "Long.": "142.5",
        "Depth. (km)": "30",
        "Mag.": "6.2",
        "Station Code": "ABC001",
        "Station Lat.": "41.5",
        "Station Long.": "140.9",
        "Station Height(m)": "39",
        "Record Time": "2018/01/24 19:51:43",
        "Sampling Freq(Hz)": "11Hz",
        "Duration Time(s)": "1",
        "Dir.": "E-W",
        "Scale Factor": scale,
        "Max. Acc. (gal)": "4.0",
        "Last Correction": "2018/01/24 19:51:43",
        "Memo.": "",
    }
    counts = "".join(f"{round(1000 * v):9d}" + "\n" * (i % 8 == 7) for i, v in enumerate(WAVE))
    body = " ".join(counts.split()[:samples])
    return "\n".join([*(f"{name:18}{value}" for name, value in head.items()), body])


def csmip(volume: int, start: str, width: int, digits: int) -> str:
    kind = "Uncorrected" if volume == 1 else "Corrected"
    lines = []
    for channel, azimuth in ((1, "90 Deg"), (2, "Up")):
        lines += [
            f"{kind} Accelerogram Data             Processed: 07/06/19, CGS  abc",
            "Station Id. ABC     35.525N, 117.365W    Q330    s/n 4114",
            "                     Start time:  7/06/19, 03:19:37.0 UTC (GPS)",
            f"Chan  {channel}: {azimuth}",
            "    1  100    1    3    3",
            start,
            *rows((3 - 2 * channel) * WAVE, width, digits, 8),
        ]
        if volume == 2:
            velocity = start.replace("accel", "veloc").replace("cm/sec2", "cm/sec")
            lines += [velocity, *rows(7.0 + WAVE, width, digits, 8)]
        lines.append(f"/&  ----------  End of data for channel  {channel}  ----------")
    return "\r\n".join(lines) + "\r\n"


V1_START = " 11 Accelerogram points at 100 pts/sec in units of g.       Format: (8f9.6)  "
V2_START = " 11 points of accel data equally spaced at  .010 sec, in cm/sec2. (8f10.6)    "


def geonet(kind: str = "Corrected", interval: float = 0.02) -> str:
    lines = []
    for component in ("N10E", "S80E", "Up"):
        whole = np.zeros(40, dtype=int)
        whole[33:36] = (11, 11, 0) if kind == "Corrected" else (11, 0, 0)
        real = np.zeros(60)
        real[24:26] = 0.005, interval
        text = ["-"] * 16
        text[0] = f"{kind} accelerogram 20161113_ABC GNS Science"
        text[1] = "Site ABC      42 31 24S"
        text[7] = "2016 November 13         11:02:56 UT"
        text[11] = "Band-pass filter transition bands are .10-.25 Hz and 24.50-25.50 Hz"
        text[12] = f"Component {component}  Longitudinal Accelerometer Axis"
        lines += text
        lines += ["".join(f"{v:8d}" for v in part) for part in whole.reshape(4, 10)]
        lines += ["".join(f"{v:8.4f}" for v in part) for part in real.reshape(6, 10)]
        lines += rows(1000.0 * WAVE, 8, 1, 10)
        if kind == "Corrected":
            lines += rows(7.0 + WAVE, 8, 2, 10)
    return "\n".join(lines)


FILES: dict[str, tuple[Callable[[], str], float, float, int]] = {
    "peer": (peer, GRAVITY, 0.01, 1),
    "esm": (esm, 0.01, 0.005, 1),
    "knet": (knet, 1000 * 0.01 * 2000 / 8388608, 1 / 11, 1),
    "csmip-1": (lambda: csmip(1, V1_START, 9, 6), GRAVITY, 0.01, 2),
    "csmip-2": (lambda: csmip(2, V2_START, 10, 6), 0.01, 0.01, 2),
    "geonet-1": (lambda: geonet("Uncorrected", 0.005), 1.0, 0.005, 3),
    "geonet-2": (geonet, 1.0, 0.02, 3),
}
"""Format -> its text, size of its unit in m/s^2, interval [s], channels."""


def written(folder: pathlib.Path, text: str, name: str = "motion.dat") -> str:
    (folder / name).write_bytes(text.encode("latin-1"))
    return str(folder / name)


@pytest.mark.parametrize("name", FILES)
def test_a_format_is_told_by_what_a_file_begins_with(tmp_path: pathlib.Path, name: str) -> None:
    text, size, interval, count = FILES[name]
    path = written(tmp_path, text())
    channels = load_channels(path)
    assert len(channels) == count
    first = channels[0]
    assert first.quantity is Control.ACCELERATION
    # The fields hold 5 decimals or more of these dyadic numbers; counts are rounded to 1e-3.
    assert first.samples == pytest.approx(size * np.round(WAVE, 3 if name == "knet" else 4))
    assert first.interval == pytest.approx(interval, rel=1e-15)
    assert first.sha256 == hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()
    assert first.source
    assert first.processing
    assert first.direction
    assert load_record(f"{path}#1" if count > 1 else path) is first


@pytest.mark.parametrize(
    "fourth",
    [
        "NPTS=     11, DT=   .0100 SEC,",
        "NPTS=  11, DT= .01000 SEC",
        "NPTS= 11, DT= 0.01",
        "  11    0.0100  NPTS, DT",
        "   11   1.0E-02    NPTS, DT",
    ],
)
def test_the_fourth_line_of_peer_changed_over_the_years(
    tmp_path: pathlib.Path, fourth: str
) -> None:
    record = load_record(written(tmp_path, peer(fourth)))
    assert record.interval == 0.01
    assert len(record.samples) == len(WAVE)


def test_peer_files_of_velocity_and_displacement(tmp_path: pathlib.Path) -> None:
    for word, unit, quantity in (
        ("VELOCITY", "CM/S", Control.VELOCITY),
        ("DISPLACEMENT", "CM", Control.DISPLACEMENT),
    ):
        text = peer(third=f"{word} TIME SERIES IN UNITS OF {unit}")
        record = load_record(written(tmp_path, text))
        assert record.quantity is quantity
        assert record.samples == pytest.approx(0.01 * WAVE)


def test_numbers_that_a_sign_parts(tmp_path: pathlib.Path) -> None:
    text = peer("NPTS= 4, DT= .01").splitlines()[:4]
    record = load_record(written(tmp_path, "\n".join([*text, "-.12E-01-.34E+00 0.5-6.25"])))
    assert record.samples == pytest.approx(GRAVITY * np.array([-0.012, -0.34, 0.5, -6.25]))


@pytest.mark.parametrize("wanted", ["2", "Up", "up"])
def test_a_channel_is_named_behind_its_file(tmp_path: pathlib.Path, wanted: str) -> None:
    path = written(tmp_path, csmip(1, V1_START, 9, 6), "a.v1")
    record = load_record(f"a.v1#{wanted}", relative_to=tmp_path)
    assert record.name == "a#2"
    assert record.direction == "Up"
    with pytest.raises(InputError, match=re.escape("got 2 channels, must be followed by #")):
        load_record(path)
    with pytest.raises(
        InputError,
        match=re.escape("got channel 3, must be followed by # and a channel: 1 (90 Deg), 2"),
    ):
        load_record(f"{path}#3")


def lines_changed(text: str, at: int, line: str | None) -> str:
    lines = text.splitlines()
    lines[at:] = [] if line is None else [line, *lines[at + 1 :]]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (lines_changed(peer(), 2, "SPECTRUM"), "line 3: got 'SPECTRUM', must name the quantity"),
        (peer(third="ACCELERATION IN UNITS OF FT"), "line 3: got 'ACCELERATION IN UNITS OF FT'"),
        (peer("POINTS= 11"), "line 4: got 'POINTS= 11', must have NPTS and DT"),
        (peer("NPTS= 11, DT= 0.0"), "line 4: got '0.0', must have a time between samples > 0 s"),
        (peer("NPTS= 12, DT= 0.01"), "line 4: got 11 samples, must be followed by the 12 samples"),
        (lines_changed(peer(), 5, "0.1 0.2 x 0.4"), "line 6: got 'x', must be finite numbers"),
        (lines_changed(peer(), 5, "0.1 nan"), "line 6: got 'nan', must be finite numbers"),
        (esm(HEADER_FORMAT="DYNA 1.0"), "line 15: got 'HEADER_FORMAT: DYNA 1.0'"),
        (esm(UNITS=""), "line 9: got nothing, must be a unit"),
        (esm(NDATA="many"), "line 7: got 'NDATA: many', must have the number of samples"),
        (esm(SAMPLING_INTERVAL_S="-1"), "line 6: got '-1', must have a time between samples > 0"),
        (esm().replace("STREAM", "BROOK"), "line 1: got 'EVENT_NAME: SOMEWHERE', must begin"),
        (lines_changed(esm(), 70, "much"), "line 71: got 'much', must be finite numbers"),
        (knet("2000/8388608"), "line 14: got 'Scale Factor      2000/8388608', must be such as"),
        (knet(samples=9), "line 17: got 9 samples, must be followed by the 11 samples"),
        (knet().replace("Memo.", "Merno"), "line 17: got 'Merno', must be the last line of 17"),
        (knet().replace("Sampling Freq", "Frequency    "), "must begin a header of 17 lines"),
        (lines_changed(csmip(1, V1_START, 9, 6), 6, None), "line 6: got 0 samples"),
        (
            lines_changed(csmip(1, V1_START, 9, 6), 6, " 0.1234567.1.3456"),
            "line 7: got '7.1.3456', must be finite numbers",
        ),
        (csmip(1, "no start", 9, 6), "must have a line such as '7500 points of accel"),
        (
            csmip(1, "UNITS OF UNCOR ACCEL ARE SEC AND G/10.", 9, 6),
            "must be sampled at equal time steps",
        ),
        ("Corrected acceleration    (Format v01.20 with 13 text lines)", "COSMOS files are not"),
        (geonet(interval=0.0), "line 23: got '0.0000', must have a time between samples > 0 s"),
        (lines_changed(geonet(), 12, "-"), "line 13: got '-', must name the component"),
        (lines_changed(geonet(), 18, "      no"), "line 19: got 'no', must be finite numbers"),
        (lines_changed(geonet(), 30, "stop"), "line 31: got 'stop', must start a component"),
        ("what is this\n1\n2\n", "line 1: got 'what is this', must begin a file of a known format"),
    ],
)
def test_a_bad_file_is_refused_with_its_line(tmp_path: pathlib.Path, text: str, said: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError, match=re.escape(said)) as caught:
        load_channels(path)
    assert str(caught.value).startswith(path)
    assert "\n" not in str(caught.value)


def test_a_real_raw_file_is_the_one_that_its_header_tells_of(tmp_path: pathlib.Path) -> None:
    packed = DATA / "ridgecrest-2019-clc-channel-1.v1.gz"
    raw = tmp_path / "clc.v1"
    raw.write_bytes(gzip.decompress(packed.read_bytes()))
    record = load_record(str(raw))
    assert (len(record.samples), record.interval, record.direction) == (31932, 0.01, "90 Deg")
    # "Max = .344 g, at 234.360 sec." and, with more digits, .3442498 in the header of numbers.
    at = int(np.argmax(np.abs(record.samples)))
    assert at * record.interval == pytest.approx(234.36)
    assert record.samples[at] == pytest.approx(0.3442498 * GRAVITY, abs=0.5e-6 * GRAVITY)


def test_a_shipped_record_is_made_again_from_its_raw_file(tmp_path: pathlib.Path) -> None:
    raw = tmp_path / "clc.v1"
    packed = DATA / "ridgecrest-2019-clc-channel-1.v1.gz"
    raw.write_bytes(gzip.decompress(packed.read_bytes()))
    shipped = load_record("ridgecrest-2019-clc-090")
    steps = ["mean 20 s", "bandpass 0.1 Hz, 25 Hz", "trim 215 s, 285 s", "taper 2 s, 5 s"]
    motion, said = process(load_record(str(raw)), [parse_step(step) for step in steps])
    assert said == shipped.processing
    # Eight digits are written; the filter's round-off is far below.
    assert motion.samples == pytest.approx(shipped.samples, rel=1e-7, abs=1e-9)


@given(data=strategies.data())
@settings(max_examples=60, derandomize=True)
def test_whatever_is_in_a_file_the_answer_is_channels_or_one_line(
    data: strategies.DataObject,
) -> None:
    content = bytearray(FILES[data.draw(strategies.sampled_from(list(FILES)))][0]().encode())
    for _ in range(data.draw(strategies.integers(1, 4))):
        at = data.draw(strategies.integers(0, len(content)))
        out = data.draw(strategies.sampled_from([0, 0, 1, 8, 80, 300, len(content)]))
        odd = [b"", b"-", b"9" * 400, b"1e400", b"nan", b"\n", b"\x00\xff", b"              "]
        content[at : at + out] = data.draw(strategies.sampled_from(odd))
    channels, said = [], ""
    try:
        channels = read_channels("a file", bytes(content))[0]
    except InputError as error:
        said = str(error)
    assert channels or (said.startswith("a file: ") and "\n" not in said)
    for channel in channels:
        assert len(channel.samples) >= 2
        assert np.all(np.isfinite(channel.samples))
        assert 0.0 < channel.interval < np.inf
