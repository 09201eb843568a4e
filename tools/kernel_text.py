"""Prints a kernel as Warp reads it, with its rows written out (`kernels/launch/rows.py`).

python -m tools.kernel_text impulse/stack_run --blocks 3
python -m tools.kernel_text event/block_run --motion record --precision float32
"""

from __future__ import annotations

import argparse
from typing import Any

from warprock.kernels.launch.instance import Variant, kernel_module
from warprock.kernels.launch.rows import TEXTS


def main() -> None:
    """Prints the text of the kernel that was asked for."""
    ask = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    ask.add_argument("file", help="path in kernels/ without its ending, such as impulse/block_run")
    usual = Variant("float64", iterations=10, points=4)
    for name, value in usual._asdict().items():
        kind: Any = {"action": "store_true"} if value is False else {"type": type(value)}
        ask.add_argument(f"--{name}", default=value, **kind)
    asked = vars(ask.parse_args())
    module = kernel_module(asked.pop("file"), **asked)
    if module.__name__ not in TEXTS:
        raise SystemExit(f"{module.__file__} has no kernel with rows: Warp reads it as it stands")
    print(TEXTS[module.__name__], end="")


if __name__ == "__main__":
    main()
