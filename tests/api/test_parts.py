"""Tables of a case as objects: values are judged as they are made."""

import inspect

import numpy as np
import pandas as pd
import pytest

import warprock as wr
from warprock.api.parts import Part, _Declared
from warprock.case.reference import find_sections

DECLARED = [
    wr.Block,
    wr.Assembly,
    wr.Contact,
    wr.TransverseWall,
    wr.Tie,
    wr.TopLoad,
    wr.Frame,
    wr.Strip,
    wr.Start,
    wr.Motion,
    wr.Support,
    wr.Times,
]


@pytest.mark.parametrize("part", DECLARED)
def test_every_key_is_in_the_signature_and_in_the_docstring(part: type[_Declared]):
    names = list(inspect.signature(part).parameters)
    wanted = [key for table in part._tables for key in table.declared()]
    assert set(wanted) <= set(names)
    arguments = part.__doc__.partition("Args:")[2].partition("Raises:")[0]
    for name in names:
        assert f"    {name}: " in arguments
    assert all(len(line) <= 100 for line in arguments.splitlines())


def test_the_objects_have_all_keys_of_case_files():
    wanted = {
        row.key.rpartition(".")[2]
        for section in find_sections()
        for row in section.keys
        if row.key.startswith(("block.", "assembly.", "contact.", "start.", "motion.", "run."))
    }
    found = {name for part in DECLARED for name in inspect.signature(part).parameters}
    assert wanted <= found


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: wr.Block(heigth="1 m"), "Block: heigth: got '1 m', unknown key"),
        (lambda: wr.Block(height=np.float64(1.0)), "Block: height: got 1.0, must be a length with"),
        (lambda: wr.Block(height="1 mm", width="0.1 mm"), "Block: width: got '0.1 mm', must be"),
        (lambda: wr.Contact(friction="wet"), "Contact: friction: got 'wet'"),
        (lambda: wr.Motion(waveform="sinus"), "did you mean sine?"),
        (lambda: wr.Times(duration="5 m"), "Times: duration: got '5 m', must be a time with a"),
        (lambda: wr.with_unit(1, "furlong"), "with_unit: unit: got 'furlong', must be one of m,"),
    ],
)
def test_a_value_that_no_case_may_have_is_refused_at_once(make, said):
    with pytest.raises(wr.InputError) as error:
        make()
    assert said in str(error.value)


def test_none_is_not_given_and_a_part_is_a_mapping():
    block = wr.Block(width="1 m", height=None)
    assert isinstance(block, Part)
    assert dict(block) == {"width": "1 m"}
    assert block == {"width": "1 m"}
    assert repr(block) == "Block(width='1 m')"


def test_numbers_get_a_unit_one_by_one():
    assert wr.with_unit(pd.Series([1, 2]), "mm") == ["1 mm", "2 mm"]
    assert wr.with_unit((0.1, np.float32(0.5)), "m/s²") == ["0.1 m/s²", "0.5 m/s²"]
