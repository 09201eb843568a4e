"""The table of inputs of lanes, as columns; a DataFrame is made of it when one is asked for."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.axes import Texts

if TYPE_CHECKING:
    import pandas as pd


@dataclasses.dataclass(frozen=True)
class Inputs:
    """Inputs of lanes.

    Attributes:
        columns: An array of numbers or `Texts` by the name of the column, shape [lane].
    """

    columns: Mapping[str, Any]

    def take(self, chosen: npt.NDArray[np.intp]) -> Inputs:
        """Those of some lanes, in any order and as often as they are named."""
        return Inputs(
            {
                name: Texts(column.values, column.codes[chosen])
                if isinstance(column, Texts)
                else column[chosen]
                for name, column in self.columns.items()
            }
        )

    def equal(self, name: str, value: object) -> npt.NDArray[np.bool_]:
        """Whether a column has a value, shape [lane]."""
        column = self.columns[name]
        if not isinstance(column, Texts):
            return np.asarray(column == value)
        known = np.array([text == value for text in column.values], dtype=bool)
        return np.asarray(known[column.codes])

    def distinct(self, name: str) -> list[Any]:
        """Values of a column, each once, in order of their first appearance."""
        column = self.columns[name]
        values = column.codes if isinstance(column, Texts) else column
        _, first = np.unique(values, return_index=True)
        found = values[np.sort(first)].tolist()
        return [column.values[code] for code in found] if isinstance(column, Texts) else found

    @functools.cached_property
    def frame(self) -> pd.DataFrame:
        """The table as a DataFrame, texts as categories."""
        import pandas as pd

        return pd.DataFrame(
            {
                name: pd.Categorical.from_codes(column.codes, pd.Index(column.values))
                if isinstance(column, Texts)
                else column
                for name, column in self.columns.items()
            }
        )
