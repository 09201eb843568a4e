"""A table as columns says the same as the DataFrame that is made of it."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.case.axes import Texts
from warprock.case.columns import Columns

TABLE = Columns(
    {
        "lane": np.arange(3),
        "outcome": Texts(("at_rest", "rocking"), np.array([1, 0, 1], dtype=np.int32)),
        "height_m": np.array([1.0, 2.0, 4.0]),
        "opened": ["a", "", "b"],
    },
    {"columns": {"height_m": {"unit": "m", "text": "Height"}}},
)


def test_names_rows_and_values_are_those_of_the_frame():
    frame = TABLE.frame
    assert list(TABLE) == list(frame)
    assert len(TABLE) == len(frame) == 3
    assert "outcome" in TABLE
    assert "rotation" not in TABLE
    assert TABLE.records == frame.to_dict("records")
    assert TABLE.head(2).records == frame.head(2).to_dict("records")
    assert frame.attrs == TABLE.attrs


@pytest.mark.parametrize(
    ("name", "values"), [("outcome", ["rocking", "-"]), ("opened", ["a", "b"])]
)
def test_rows_with_one_of_some_values_are_found(name: str, values: list[str]):
    assert TABLE.among(name, values).tolist() == TABLE.frame[name].isin(values).tolist()


def test_distinct_values_come_in_order_of_appearance():
    assert TABLE.distinct("outcome") == ["rocking", "at_rest"]
    assert TABLE.distinct("height_m") == [1.0, 2.0, 4.0]
