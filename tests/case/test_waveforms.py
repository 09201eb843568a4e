"""Families of waveforms: what they need is declared, and every waveform has one."""

from __future__ import annotations

import pytest

from warprock.case.motion import Direction
from warprock.case.waveforms import FAMILIES, FAMILY_OF, Family
from warprock.model.motion import Waveform


def test_every_waveform_has_one_family():
    assert list(FAMILY_OF) == list(Waveform)
    assert sum(len(family.waveforms) for family in FAMILIES) == len(FAMILY_OF)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.waveforms[0])
def test_its_keys_are_declared(family: Family):
    declared = Direction.declared()
    assert set(family.keys) | set(family.shown) <= set(declared)
    assert set(family.shown) <= set(family.keys)
    assert not set(family.needs) & set(family.may)
    for name in family.shown:
        assert declared[name].columns


def test_every_key_belongs_to_a_waveform():
    known = {name for family in FAMILIES for name in family.keys} | {"waveform"}
    assert known == set(Direction.declared())
