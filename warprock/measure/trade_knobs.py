"""Which settings of each engine `trade` measures; a new engine adds one row here."""

from __future__ import annotations

import math
from collections.abc import Mapping

Settings = Mapping[str, float | int]

STEPS = (2, 20, 63, 200, 630)
"""Sub-steps of a frame of 1/240 s that the engines with frames are tried with."""

EVENT_STEPS = (5e-2, 2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)
"""Steps of `event` [s]; single boxes that rock are exact enough at the coarse ones."""

BLOCK_LOAD = 2.67e3
"""Mass over its base of a block of stone 1 m high [kg/m^2]: what swings on an area of springs."""


def _damp(stiffness: float, *, subcontacts: int, safety: float = 0.2) -> Settings:
    """Springs of a stiffness [N/m^3] with dashpots critical for a block of stone 1 m high."""
    return {
        "normal_stiffness": stiffness,
        "shear_stiffness": stiffness,
        "stiffness_damping": float(f"{2.0 * math.sqrt(BLOCK_LOAD / stiffness):.3g}"),
        "subcontacts": subcontacts,
        "step_safety": safety,
    }


TRADE_KNOBS: dict[str, tuple[Settings, ...]] = {
    "housner": ({},),
    "two-block": ({},),
    "event": tuple({"time_step": step} for step in EVENT_STEPS),
    "impulse": (
        {"frames_per_second": 10.0, "substeps": 20},
        {"frames_per_second": 50.0, "substeps": 20},
        *({"frames_per_second": 240.0, "substeps": count} for count in STEPS),
        *({"iterations": count} for count in (3, 20)),
    ),
    "direct": (
        {"frames_per_second": 10.0, "substeps": 20},
        {"frames_per_second": 50.0, "substeps": 20},
        *({"frames_per_second": 240.0, "substeps": count} for count in STEPS),
        *({"contact_stiffness": stiffness} for stiffness in (1e7, 1e9)),
        {"friction_box": 1},
    ),
    "xpbd": (
        {"frames_per_second": 10.0, "substeps": 20},
        {"frames_per_second": 50.0, "substeps": 20},
        *({"frames_per_second": 240.0, "substeps": count} for count in STEPS),
        {"iterations": 1},
        *({"compliance": compliance} for compliance in (1e-10, 1e-8)),
    ),
    "dem": (
        {},
        {"step_safety": 0.8},
        *(_damp(1e10, subcontacts=count) for count in (5, 10)),
        *(_damp(stiffness, subcontacts=2) for stiffness in (1e9, 1e10, 1e11, 1e12)),
        *(_damp(stiffness, subcontacts=2, safety=0.8) for stiffness in (1e10, 1e11, 1e12)),
    ),
}
"""Engine -> fields of its settings that differ from their defaults, from coarse to fine. An engine
without a row is measured with its defaults."""
