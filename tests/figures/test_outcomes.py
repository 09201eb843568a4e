"""What a figure says of the lanes that it shows."""

import numpy as np
import pytest

from warprock.figures.outcomes import Peaks
from warprock.model.response import Outcome
from warprock.model.words import ASSEMBLY


@pytest.mark.parametrize(
    ("ratio", "words"),
    [(0.25, "the block rotates by up to 0.25 of"), (1e-5, "the block rotates by below 0.0001 of")],
)
def test_the_largest_rotation_of_those_that_stand_reads_well(ratio: float, words: str) -> None:
    outcome = np.array([Outcome.OVERTURNED, Outcome.AT_REST])
    assert words in Peaks(np.array([2.0, ratio]), outcome).message()


def test_assemblies_collapse() -> None:
    outcome = np.array([Outcome.OVERTURNED, Outcome.AT_REST])
    said = Peaks(np.array([2.0, 0.25]), outcome, ASSEMBLY).message()
    assert said.startswith("Of 2 lanes 1 collapse; in the others a block rotates by up to 0.25 of")
