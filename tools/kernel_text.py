"""Prints a kernel as Warp reads it, with its rows written out (`kernels/launch/rows.py`).

python -m tools.kernel_text impulse/stack_run --blocks 3
python -m tools.kernel_text event/block_run --motion record --precision float32
"""

from __future__ import annotations

import argparse

from warprock.kernels.launch.instance import LANE_WIDTH, kernel_module
from warprock.kernels.launch.rows import TEXTS


def main() -> None:
    """Prints the text of the kernel that was asked for."""
    ask = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    ask.add_argument("file", help="path in kernels/ without its ending, such as impulse/block_run")
    ask.add_argument("--precision", default="float64")
    ask.add_argument("--motion", default="still")
    ask.add_argument("--friction", default="cone")
    ask.add_argument("--iterations", type=int, default=10)
    ask.add_argument("--blocks", type=int, default=1)
    ask.add_argument("--lanes", type=int, default=LANE_WIDTH)
    ask.add_argument("--points", type=int, default=4)
    ask.add_argument("--vertical", action="store_true")
    ask.add_argument("--chains", action="store_true")
    ask.add_argument("--thrown", action="store_true")
    ask.add_argument("--springs", action="store_true")
    ask.add_argument("--bonds", action="store_true")
    ask.add_argument("--trees", action="store_true")
    asked = vars(ask.parse_args())
    module = kernel_module(asked.pop("file"), **asked)
    if module.__name__ not in TEXTS:
        raise SystemExit(f"{module.__file__} has no kernel with rows: Warp reads it as it stands")
    print(TEXTS[module.__name__], end="")


if __name__ == "__main__":
    main()
