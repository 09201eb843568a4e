"""Columns of a table as keys of a sweep."""

import numpy as np
import pandas as pd
import pytest

from warprock.case.input_columns import columns_of
from warprock.case.keys import SWEEP_KEYS
from warprock.case.sweep_file_columns import swept_columns
from warprock.errors import InputError


@pytest.mark.parametrize(
    ("column", "values", "key", "meant"),
    [
        ("height_m", [1.5, 2], "block.height", ["1.5 m", "2.0 m"]),
        ("height_mm", [1500, 2000], "block.height", ["1500 mm", "2000 mm"]),
        ("block.height [cm]", [150.0], "block.height", ["150.0 cm"]),
        ("block.height", ["5 ft"], "block.height", ["5 ft"]),
        ("chamfer_2_mm", [5.0], "block.2.chamfer", ["5.0 mm"]),
        ("width_6_in", [5.0], "block.6.width", ["5.0 in"]),
        ("amplitude_g", [0.3], "motion.amplitude", ["0.3 g"]),
        ("amplitude_m_s2", [0.3], "motion.amplitude", ["0.3 m/s^2"]),
        ("frequency_hz_y", [3.0], "motion.y.frequency", ["3.0 Hz"]),
        ("frequency_rad_s", [3.0], "motion.frequency", ["3.0 rad/s"]),
        ("motion.duration [s]", [3.0], "motion.duration", ["3.0 s"]),
        ("rotation_start_deg", [3.0], "start.rotation", ["3.0 deg"]),
        ("rotation_start_1_rad", [3.0], "block.1.rotation", ["3.0 rad"]),
        ("rotation_ratio_start", [0.5], "start.rotation_ratio", [0.5]),
        ("friction", [0.5, 1], "contact.friction", [0.5, 1.0]),
        ("friction_deg", [45], "contact.friction", ["45 deg"]),
        ("waveform", pd.Categorical(["sine"]), "motion.waveform", ["sine"]),
        ("label.name", ["a"], "label.name", ["a"]),
    ],
)
def test_a_column_is_a_key_in_its_unit(column, values, key, meant):
    assert swept_columns(pd.DataFrame({column: values}), "table") == {key: meant}


def test_every_column_that_shows_a_key_is_read_as_that_key():
    keys = [key.replace(".N.", ".3.") for key in SWEEP_KEYS]
    keys += [key.replace("motion.", "motion.z.") for key in keys if key.startswith("motion.")]
    for key in keys:
        for column in columns_of(key):
            table = pd.DataFrame({column: ["as it is"]})
            assert swept_columns(table, "table") == {key: ["as it is"]}, column


def test_numbers_keep_every_bit():
    values = np.random.default_rng(1).uniform(0.1, 10.0, 100)
    (texts,) = swept_columns(pd.DataFrame({"height_m": values}), "table").values()
    assert [float(text.removesuffix(" m")) for text in texts] == values.tolist()


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"heigth_m": [1.0]}, "table: heigth_m: got the column, must be a key, such as block.he"),
        ({"height_m": [1.0], "height_mm": [1.0]}, "table: height_mm: got 'block.height', must be"),
        ({"height_m": [1.0, np.nan]}, "must be given in every row (row 1)"),
        ({"height_m": []}, "table: got 0 rows, must have at least one row"),
        ({"peak_rotation_rad": [1.0]}, "table: peak_rotation_rad: got the column, must be a key"),
    ],
)
def test_what_is_no_column_of_a_case_is_refused(columns, said):
    with pytest.raises(InputError) as error:
        swept_columns(pd.DataFrame(columns), "table")
    assert said in str(error.value)
