"""What is said where a package is missing."""

from __future__ import annotations

import importlib.util

import pytest

from warprock.errors import InputError
from warprock.scenes.needs import NEEDS, require_package


@pytest.mark.parametrize("name", sorted(NEEDS))
def test_a_missing_package_is_one_line_with_what_installs_it(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda _name: None)
    extra = NEEDS[name][1]
    with pytest.raises(InputError, match=rf"pip install 'warprock\[{extra}\]'") as error:
        require_package("--viewer", name)
    assert "\n" not in str(error.value)


def test_what_needs_nothing_is_not_refused() -> None:
    require_package("--output", "gif")
