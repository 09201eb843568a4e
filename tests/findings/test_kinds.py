"""Kinds of findings are found where they are declared, and known by what only they say."""

from __future__ import annotations

from warprock.findings.kinds import kinds
from warprock.running.run_file import COMMON


def test_every_kind_is_known_by_a_key_that_it_requires_and_no_other_has():
    found = kinds()
    assert {"modes", "curves", "incremental", "of", "study", "validation", "asked"} <= found.keys()
    for key, kind in found.items():
        assert key in kind.shape
        assert f"{key}?" not in COMMON
        assert not any(key in other.shape for other in found.values() if other is not kind)
