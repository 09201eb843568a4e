"""What limit analysis tells: one load, or the interval of loads where joints slide."""

from __future__ import annotations

import pytest

import warprock as wr

WALL = wr.Assembly(
    pattern="wall",
    block_length="0.4 m",
    block_height="0.175 m",
    blocks=4,
    courses=11,
    openings=[["0.6 m", "0.525 m", "0.4 m", "0.875 m"]],
    density="2000 kg/m^3",
)
COLUMN = wr.Assembly(
    pattern="column", drum_width="1 m", drum_height="0.5 m", drums=12, density="2000 kg/m^3"
)


def case(assembly: wr.Assembly) -> wr.Case:
    return wr.Case(
        assembly=assembly, contact=wr.Contact(friction=0.65), run=wr.Times(duration="1 s")
    )


def test_where_joints_slide_both_ends_of_the_interval_are_told():
    """Wall 3 of Ferris and Tin-Loi (2001)."""
    found = wr.limit(case(WALL), progress=False)
    told = " ".join(found.finding.sentences)
    assert "under a sideways load between 0.356 and 0.404 of its weight" in told
    assert "on a table that tilts by 19.6 to 22.0 degrees" in told
    assert "the assembly may fall anywhere from there to the bound" in told
    row = found.table.iloc[0]
    assert row["upper_bound"]
    assert row["coulomb_load_factor"] < row["load_factor"]


def test_where_none_slides_there_is_one_load():
    found = wr.limit(case(COLUMN), progress=False)
    told = " ".join(found.finding.sentences)
    assert "under a sideways load of 0.167 of its weight" in told
    assert "upper bound" not in told
    row = found.table.iloc[0]
    assert row["coulomb_load_factor"] == pytest.approx(row["load_factor"])
