"""Where the seed paper contradicts itself on single blocks: the numbers that show it.

Every item says what is printed, what the calculation gives and how sure the reading is; the words
are in `cases/paper/conflicts.toml`. What concerns stacks of blocks is in `conflicts_stack`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection

import numpy as np
import numpy.typing as npt

from warprock.case.columns import Columns
from warprock.paper.conflict_texts import Conflict, Parts, conflicts_about
from warprock.paper.printed import paper_columns
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

BLOCK = (0.17, 1.0, 0.502, 2670.0)
"""Full width, height and depth [m] and density [kg/m^3] of the paper's block "Single # 2"."""
TABLE4_HEIGHT = 0.75
"""Height [m] of the block that the normalised column of Table 4 belongs to."""
BED_STIFFNESS = 1e9
"""Contact stiffness of the paper's DEM model [N/m^3] (Table 5)."""
PRINTED_DAMPING = 2.25e-4
"""Damping factor of the paper's DEM model [s] (Table 5)."""
IMPACT_FREQUENCY = 1418.0
"""Frequency from which the paper derives that factor [Hz] (Table 5)."""


@dataclasses.dataclass(frozen=True)
class Evidence:
    """What the runs found, for the conflicts that need it.

    Attributes:
        pulse: Lanes of the sine-pulse case: `reading`, `frequency_hz`, `amplitude_mm`,
            `housner`, `impulse` (peak rotation ratios), `impulse_rough` (the same at friction
            5), `slide_mm` and `first_swing` (Housner's rotation ratio when, in the first 0.2 s,
            the displacement reading is largest); None where the target does not run them.
        sine: The same for the continuous sine, without `impulse_rough`.
    """

    pulse: Columns | None = None
    sine: Columns | None = None


def reading_of(table: Columns, reading: str, column: str) -> Array:
    """One column of the lanes of one reading, in the order of Table 4."""
    return np.asarray(table[column][table.among("reading", [reading])])


def peak_acceleration() -> Array:
    """Peak base acceleration A (2 pi f)^2 of the six inputs of Table 4 [m/s^2]."""
    inputs = paper_columns("table4")
    return np.asarray(1e-3 * inputs["amplitude_mm"] * (2.0 * np.pi * inputs["frequency_hz"]) ** 2)


def inferred_experiment(sine: Columns) -> tuple[Array, Array]:
    """Shake-table maxima (/ slenderness angle) that Table 7's errors imply, by two routes.

    The errors are read as underestimates, which the agreement of the routes supports.

    Returns:
        From the analytical column (our double-size reading), and from Bullet's column (our
        displacement reading), six values each.
    """
    printed = paper_columns("table7")
    slip = reading_of(sine, "double-size", "housner")
    displacement = reading_of(sine, "displacement", "housner")
    return (
        np.asarray(slip / (1.0 - 1e-2 * printed["analytical"])),
        np.asarray(displacement / (1.0 - 1e-2 * printed["bullet"])),
    )


def slip_deceleration(width: float, height: float, mu: float) -> float:
    """Deceleration of a corner that slips while its resting block starts to rock [m/s^2].

    With half sizes b, h and k^2 = (b^2 + h^2)/3 (central inertia / mass): the corner stays on the
    base, so its normal force N obeys N/m (1 + (b^2 - mu b h)/k^2) = g, and it slows down by
    N/m (mu + h (mu h - b)/k^2), friction on the centre and rotation about it together.

    Args:
        width: Full width [m].
        height: Full height [m].
        mu: Friction, above b/h and below the friction that a velocity step needs.
    """
    b, h = 0.5 * width, 0.5 * height
    k2 = (b * b + h * h) / 3.0
    normal = GRAVITY / (1.0 + (b * b - mu * b * h) / k2)
    return normal * (mu + h * (mu * h - b) / k2)


def _table4(_evidence: Evidence) -> Parts:
    width, height, depth, density = BLOCK
    acceleration = peak_acceleration()
    numbers = {
        "printed": paper_columns("table4")["normalised_acceleration"],
        "width": width,
        "height": height,
        "other_height": TABLE4_HEIGHT,
        "as_printed": acceleration / (GRAVITY * width / TABLE4_HEIGHT),
        "mass": width * height * depth * density,
        "true": acceleration / (GRAVITY * width / height),
    }
    return {"text": numbers}


def _displacement_drive(evidence: Evidence) -> Parts:
    if evidence.pulse is None:
        return {"text": {}}
    ours = reading_of(evidence.pulse, "displacement", "housner")
    stepping = reading_of(evidence.pulse, "displacement", "impulse")
    printed = paper_columns("table6")
    vortex, bullet = printed["vortex"], printed["bullet"]
    numbers = {
        "housner": ours,
        "vortex": vortex,
        "housner_off": 100 * np.max(np.abs(ours / vortex - 1)),
        "impulse": stepping,
        "vortex_off": 100 * np.max(np.abs(stepping / vortex - 1)),
        "bullet": bullet,
        "bullet_off": 100 * np.max(np.abs(stepping / bullet - 1)),
    }
    return {"text": {}, "pulse": numbers}


def _full_for_half(evidence: Evidence) -> Parts:
    half_diagonal = 0.5 * float(np.hypot(*BLOCK[:2]))
    opening = {"full": 2 * half_diagonal, "half": half_diagonal}
    if evidence.pulse is None:
        return {"text": opening}
    slip = reading_of(evidence.pulse, "double-size", "housner")
    printed = paper_columns("table6")["analytical"]
    numbers = {
        "slip": slip,
        "printed": printed,
        "five": np.max(np.abs(slip[:5] - printed[:5])),
        "sixth": printed[5],
        "our_sixth": slip[5:],
        "true": reading_of(evidence.pulse, "acceleration", "housner"),
    }
    return {"text": opening, "pulse": numbers}


def _opposite_phase(evidence: Evidence) -> Parts:
    if evidence.pulse is None:
        return {"text": {}}
    moved = reading_of(evidence.pulse, "displacement", "first_swing")
    accelerated = reading_of(evidence.pulse, "double-size", "first_swing")
    return {"text": {}, "pulse": {"moved": moved, "accelerated": accelerated}}


def _table7(evidence: Evidence) -> Parts:
    if evidence.sine is None:
        return {"text": {}}
    by_analysis, by_bullet = inferred_experiment(evidence.sine)
    numbers = {
        "slip": reading_of(evidence.sine, "double-size", "housner"),
        "by_analysis": by_analysis,
        "by_bullet": by_bullet,
        "apart": 100 * np.max(np.abs(by_analysis / by_bullet - 1.0)),
        "true": reading_of(evidence.sine, "acceleration", "housner"),
    }
    return {"text": {}, "sine": numbers}


def _b0_height(_evidence: Evidence) -> Parts:
    parts = []
    for height in (5.0, 5.5):
        angle = float(np.arctan2(1.0, height))
        restitution = 1 - 1.5 * np.sin(angle) ** 2
        parts.append({"height": height, "angle": angle, "restitution": restitution})
    return {"text": {"parts": parts}}


def _table3_sizes(_evidence: Evidence) -> Parts:
    table = paper_columns("table3")
    blocks = table.take(np.sort(np.unique(table["block"].astype(str), return_index=True)[1]))
    printed = blocks["slenderness_angle_rad"]
    computed = np.arctan2(blocks["width_m"], blocks["height_m"])
    return {"text": {"printed": printed, "computed": computed}}


def _friction(evidence: Evidence) -> Parts:
    width, height = BLOCK[:2]
    inputs = paper_columns("table4")
    step = 2e-3 * np.pi * inputs["frequency_hz"] * inputs["amplitude_mm"]
    mu = float(np.tan(np.deg2rad(45.0)))
    slowing = slip_deceleration(width, height, mu)
    time, slide = 1e3 * step / slowing, 500.0 * step**2 / slowing
    opening = {
        "friction": mu,
        "needed": (4.0 * width**2 + height**2) / (3.0 * width * height),
        "least_step": step.min(),
        "most_step": step.max(),
        "least_time": time.min(),
        "most_time": time.max(),
        "least_slide": slide.min(),
        "most_slide": slide.max(),
        "least_alone": 1e3 * step.min() / (mu * GRAVITY),
        "most_alone": 1e3 * step.max() / (mu * GRAVITY),
    }
    if evidence.pulse is None:
        return {"text": opening}
    ours, slipping, rough, slid = (
        reading_of(evidence.pulse, "displacement", column)
        for column in ("housner", "impulse", "impulse_rough", "slide_mm")
    )
    off = 100.0 * (slipping / ours - 1.0)
    numbers = {
        "least": slid.min(),
        "most": slid.max(),
        "low": off.min(),
        "high": off.max(),
        "rough": 100 * np.max(np.abs(rough / ours - 1)),
    }
    return {"text": opening, "pulse": numbers}


def _dem_damping(_evidence: Evidence) -> Parts:
    _, height, _, density = BLOCK
    omega = float(np.sqrt(BED_STIFFNESS / (density * height)))
    zeta = 0.5 * PRINTED_DAMPING * omega
    root = np.sqrt(1.0 - zeta**2)
    # Restitution of a spring-dashpot contact that cannot pull (Schwager and Poeschel 2007).
    restitution = np.exp(
        -(zeta / root) * (np.pi - np.arctan(2.0 * zeta * root / (root**2 - zeta**2)))
    )
    numbers = {
        "printed": PRINTED_DAMPING,
        "frequency": IMPACT_FREQUENCY,
        "factor": 1.0 / (np.pi * IMPACT_FREQUENCY),
        "stiffness": BED_STIFFNESS,
        "bounce": omega / (2 * np.pi),
        "zeta": 100 * zeta,
        "restitution": restitution,
    }
    return {"text": numbers}


def _text_and_tables(_evidence: Evidence) -> Parts:
    analytical = paper_columns("table7")["analytical"]
    times = paper_columns("run-times").records
    bullet = {(row["system"], row["excitation"]): row["bullet_s"] for row in times}
    numbers = {
        "low": analytical.min(),
        "high": analytical.max(),
        "pulse_time": bullet["single", "pulse"],
        "sine_time": bullet["single", "sine"],
    }
    return {"text": numbers}


def _time_step(_evidence: Evidence) -> Parts:
    step = 1.0 / ((200 + 1) * 240.0)
    return {"text": {"step": step, "rate": 1 / step}}


_ITEMS = (
    ("table4", _table4),
    ("displacement_drive", _displacement_drive),
    ("full_for_half", _full_for_half),
    ("opposite_phase", _opposite_phase),
    ("table7", _table7),
    ("b0_height", _b0_height),
    ("table3_sizes", _table3_sizes),
    ("friction", _friction),
    ("dem_damping", _dem_damping),
    ("text_and_tables", _text_and_tables),
    ("time_step", _time_step),
)
"""Name of each conflict, and what finds its numbers."""


def conflicts_of(targets: Collection[str], evidence: Evidence) -> list[Conflict]:
    """The conflicts that concern one of the targets."""
    return conflicts_about(targets, _ITEMS, evidence)
