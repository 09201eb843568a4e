"""What a figure says of the lanes that it shows."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from warprock.figures import histories
from warprock.figures.outcomes import Peaks
from warprock.findings.run import peak_sentences
from warprock.model.ratios import NO_TURN
from warprock.model.response import Outcome, Response
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


@pytest.mark.parametrize(("ratio", "rotates"), [(NO_TURN, False), (2.0 * NO_TURN, True)])
def test_figure_and_sentence_agree_on_what_does_not_rotate(ratio: float, rotates: bool) -> None:
    ratios = np.array([0.0, ratio])
    drawn = Peaks(ratios, np.full(2, Outcome.AT_REST)).message()
    table = pd.DataFrame(
        {"status": "ok", "outcome": "at_rest", "peak_rotation_ratio": ratios, "lane": [0, 1]}
    )
    said = peak_sentences({"case": {"resolved": {}}}, table)[0]
    assert ("none rotates" not in drawn) == ("No block that stayed up rotated" not in said)
    assert ("none rotates" not in drawn) == rotates


def test_the_enlarged_part_says_of_a_lane_that_it_overturned_before() -> None:
    """All panels of a column share their times, which are those of another lane."""
    times = np.linspace(0.0, 10.0, 101)
    ratios = np.stack([0.5 * np.sin(times), np.where(times < 3.0, 0.1, 9.0)])[:, None]
    fields = {"outcome": np.array([Outcome.ROCKING, Outcome.OVERTURNED])}
    response = cast(Response, Seen(times, fields))
    curves = histories._Curves(response, ratios, 10.0)
    shown = histories.ShownLanes(np.array([[0], [1]]), ("stands", "falls"), ("",))
    for lane, window, said in ((0, (4.0, 6.0), []), (1, (4.0, 6.0), ["overturned before"])):
        axes = Figure().subplots()
        histories._draw_panel(axes, curves, shown, lane, window)
        assert [text.get_text() for text in axes.texts] == said


class Seen(SimpleNamespace):
    """What `histories` reads of a response."""

    def __init__(self, times: Any, fields: Any) -> None:
        super().__init__(times=times, fields=fields)

    def __getitem__(self, name: str) -> Any:
        return self.fields[name]
