"""What a picture or a viewer needs besides the plain installation."""

from __future__ import annotations

import importlib.util

from warprock.errors import InputError, Said

NEEDS: dict[str, tuple[str, str]] = {
    "mp4": ("imageio_ffmpeg", "movie"),
    "usd": ("pxr", "usd"),
    "viser": ("viser", "viser"),
    "rerun": ("rerun", "rerun"),
    "window": ("pyglet", "window"),
}
"""Form or viewer -> the module that it needs, and the extra of ours that brings it."""


def require_package(option: str, name: str) -> None:
    """Refuses a form or a viewer whose package is not installed.

    Args:
        option: What was asked for, as errors name it.
        name: Key of `NEEDS`; others need nothing.

    Raises:
        InputError: It is not installed; the line says what installs it.
    """
    module, extra = NEEDS.get(name, ("", ""))
    if module and importlib.util.find_spec(module) is None:
        allowed = f"which is not installed: pip install 'warprock[{extra}]' brings it"
        raise InputError(option, "", Said(f"{name}, which needs the package {module}"), allowed)
