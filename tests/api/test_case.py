"""Cases as Python objects: they say the same as files, and refuse the same in the same words."""

import copy
import importlib.resources
import pickle
import tomllib

import numpy as np
import pandas as pd
import pytest

import warprock as wr
from tests.shared.case_texts import FREE, PULSE
from warprock.case.load import load_case
from warprock.case.text import case_names, data_folder
from warprock.case.writing import toml_text
from warprock.recordings import load_record

BLOCK = wr.Block(width="0.5 m", height="2 m", depth="0.5 m", density="2400 kg/m^3")


def case(**more) -> wr.Case:
    tables = {"block": BLOCK, "contact": wr.Contact(friction=1.0), "run": {"duration": "1 s"}}
    return wr.Case(**{**tables, **more})


@pytest.mark.parametrize("name", case_names())
def test_a_case_from_the_dict_of_a_file_is_that_file(name, monkeypatch):
    of_file = load_case(name)
    # Where its tables lie: a case of no file has them in the working folder.
    monkeypatch.chdir(data_folder(name, None))
    made = wr.Case.from_dict(of_file.raw, name=name)
    assert made == of_file
    assert (made.tables, made.shape, made.members) == (of_file.tables, of_file.shape, made.members)
    again = wr.Case.from_dict(tomllib.loads(made.to_toml()))
    assert again == made


def test_objects_arrays_and_plain_dicts_make_the_same_case():
    motion = {"waveform": "sine", "control": "acceleration", "frequency": "1 Hz", "cycles": 1}
    one = case(
        motion=wr.Motion(**motion),
        sweep=[
            wr.Sweep({"motion.amplitude": wr.with_unit(np.array([0.1, 0.2]), "g")}),
            wr.Sweep({"block.height": wr.Grid("1 m", "2 m", 3)}),
        ],
        sample=wr.Sample({"contact.friction": wr.Uniform(0.5, np.float64(0.9))}, lanes=np.int64(4)),
        engines={"event": {"time_step": np.float64(1e-3)}},
    )
    other = case(
        motion=motion,
        sweep=(
            {"motion.amplitude": ["0.1 g", "0.2 g"]},
            {"block.height": {"from": "1 m", "to": "2 m", "count": 3}},
        ),
        sample={
            "lanes": 4,
            "over": {"contact.friction": {"distribution": "uniform", "from": 0.5, "to": 0.9}},
        },
        engines={"event": {"time_step": 1e-3}},
    )
    assert one == other
    assert one.lane_count == 2 * 3 * 4
    assert one.engine_settings("event").time_step == 1e-3
    assert tomllib.loads(one.to_toml()) == one.raw


def test_a_list_of_blocks_is_a_stack_lowest_first():
    stack = case(block=[BLOCK, wr.Block(**{**BLOCK, "width": "0.3 m", "offset": "5 mm"})])
    assert stack.tables.stacked
    columns = ["width_1_m", "width_2_m", "offset_2_mm"]
    assert stack.lanes()[columns].iloc[0].tolist() == [0.5, 0.3, 5.0]


def test_a_table_makes_a_lane_a_row():
    sizes = np.random.default_rng(2).uniform(0.4, 2.0, (20, 2))
    table = pd.DataFrame(sizes, columns=["width_m", "height_m"]).assign(
        **{"label.name": [f"b{n}" for n in range(20)], "rotation_start_deg": 1.5}
    )
    block = {"depth": "0.5 m", "density": "1 t/m^3"}
    made = wr.Case.from_table(
        table, block=block, contact={"friction": 1.0}, run={"duration": "1 s"}
    )
    lanes = made.lanes()
    assert np.array_equal(lanes[["width_m", "height_m"]], sizes)
    assert lanes["name"].tolist() == table["label.name"].tolist()
    crossed = case(sweep=[table[["height_m"]], {"contact.friction": [0.5, 1.0]}])
    assert crossed.shape == (20, 2)


def test_the_inputs_of_a_lane_table_make_the_same_lanes_again():
    first = wr.load_case("free-b1-b3").lanes()
    columns = ["width_m", "height_m", "depth_m", "density_kg_m3", "friction", "rotation_start_rad"]
    again = wr.Case.from_table(first[columns], run={"duration": "1 s"}).lanes()
    pd.testing.assert_frame_equal(first[columns], again[columns], check_exact=True)


@pytest.mark.parametrize("text", [FREE, PULSE])
@pytest.mark.parametrize(
    ("table", "key", "value"),
    [
        ("block", "height", "5.5"),
        ("block", "height", 5.5),
        ("block", "heigth", "5 m"),
        ("block", "width", "2 km"),
        ("contact", "friction", True),
        ("run", "duration", "0 s"),
        ("sample", "lanes", 0),
    ],
)
def test_a_dict_and_a_file_are_refused_in_the_same_words(write, text, table, key, value):
    tables = tomllib.loads(text)
    tables.setdefault(table, {})[key] = value
    with pytest.raises(wr.InputError) as of_dict:
        wr.Case.from_dict(tables)
    file = write(toml_text(tables))
    with pytest.raises(wr.InputError) as of_file:
        wr.load_case(file)
    assert str(of_dict.value) == str(of_file.value).replace(str(file), "Case")


def test_overrides_are_values_and_go_before_sweeps():
    free = wr.load_case("free-b0")
    changed = free.override({"block.height": "4 m", "start.rotation": "2 deg"})
    assert (free.lane_count, changed.lane_count) == (2, 1)
    assert "rotation_ratio" not in changed.raw["start"]
    assert changed == free.override(["block.height=4 m", "start.rotation=2 deg"])
    assert changed == wr.load_case("free-b0", {"block.height": "4 m", "start.rotation": "2 deg"})
    settings = free.override({"engines.event.time_step": np.float64(2e-3)})
    assert settings.engine_settings("event").time_step == 2e-3
    with pytest.raises(wr.InputError, match=r"^overrides: block.heigt: .* did you mean height\?"):
        free.override({"block.heigt": "4 m"})


def test_a_case_is_short_to_look_at_and_can_be_copied():
    made = case(sweep={"block.height": ["1 m", "2 m"]}, name="a <cabinet>")
    assert repr(made) == "Case(a <cabinet>: 2 lanes over block.height)"
    assert repr(load_case("sobol-single-block")).startswith("<case sobol-single-block: ")
    html = made._repr_html_()
    assert "a &lt;cabinet&gt;" in html
    assert "[block]" in html
    for again in (copy.deepcopy(made), pickle.loads(pickle.dumps(made))):
        assert again == made
        assert again.lane_count == 2
    with pytest.raises(AttributeError):
        made.name = "another"
    assert made != case()


def test_relative_records_start_from_the_folder(tmp_path):
    shipped = importlib.resources.files("warprock.cases") / "ground-motions"
    (tmp_path / "mine.csv").write_bytes((shipped / "ridgecrest-2019-ccc-090.csv").read_bytes())
    motion = wr.Motion(waveform="record", record="mine.csv")
    lanes = case(motion=motion, folder=tmp_path).lanes()
    assert lanes["peak_acceleration_m_s2"].iloc[0] == pytest.approx(5.15, abs=0.01)


def test_samples_become_a_record(tmp_path):
    samples = np.random.default_rng(3).normal(size=50)
    file = wr.save_record(tmp_path / "new/mine.csv", samples, interval="20 ms", unit="m/s^2")
    record = load_record(file)
    assert record.name == "mine"
    np.testing.assert_allclose(record.samples, samples, rtol=1e-7)
    assert record.interval == 0.02
    for samples, unit, said in (
        ([1.0, np.nan], "g", "mine.csv"),
        ([1.0], "g", "mine.csv"),
        ([1.0, 2.0], "furlong", "unit: got 'furlong'"),
    ):
        with pytest.raises(wr.InputError) as error:
            wr.save_record(file, samples, interval="20 ms", unit=unit)
        assert said in str(error.value)
        assert ".tmp" not in str(error.value)
    assert load_record(file).sha256 == record.sha256
