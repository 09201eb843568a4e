"""Kinds of findings are found where they are declared, and known by what only they say."""

from __future__ import annotations

from warprock.findings.kinds import KNOWN_BY_FILE, every_kind, kind_of_file, kinds
from warprock.running.run_file import COMMON


def test_every_kind_is_known_by_a_key_that_it_requires_and_no_other_has():
    found = kinds()
    assert {"modes", "curves", "incremental", "of", "study", "validation", "asked"} <= found.keys()
    for key, kind in found.items():
        assert key in kind.shape
        assert f"{key}?" not in COMMON
        assert not any(key in other.shape for other in found.values() if other is not kind)


def test_every_kind_that_is_known_by_a_file_is_found_by_it():
    assert {each.file for each in every_kind()} - {""} == KNOWN_BY_FILE.keys()
    assert all(kind_of_file(name).file == name for name in KNOWN_BY_FILE)
