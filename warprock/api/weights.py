"""Weights of records as a caller gives them."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Mapping

import numpy as np

from warprock.analysis.groups import Weights, read_weights
from warprock.errors import InputError

AnyWeights = Mapping[str, float] | str | os.PathLike[str]
"""Weights by the name of the record, the path of a CSV file, or a column of the lane table."""


def weights_of(asked: AnyWeights | None) -> Weights | None:
    """Weights by record, or the column that has them; None where all weigh the same.

    Raises:
        InputError: A file that cannot be read, or a weight that is not above 0.
    """
    if asked is None:
        return None
    if isinstance(asked, Mapping):
        for name, weight in asked.items():
            if not (np.isfinite(weight) and weight > 0.0):
                raise InputError("--weights", str(name), weight, "must be finite and > 0")
        return {str(name): float(weight) for name, weight in asked.items()}
    path = pathlib.Path(asked)
    if path.suffix.lower() == ".csv" or path.is_file() or not isinstance(asked, str):
        return read_weights(path)
    return asked
