"""What an atlas says, counted and put into words: where each engine may be trusted.

Nothing here is a verdict of an author: every sentence is made from the numbers of the table.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.engines.soundness import BARRIER_SHARE, EXPLOSION_BOUND
from warprock.measure.atlas import GROWTH_BOUND

BOUNDS = (1e-3, 1e-2)
"""Errors over the slenderness angle at which engines are trusted."""
SHARE = 0.9
"""Part of the compared lanes that has to stay below a bound."""
DEEP = 1e-3
"""Penetration over the height of a block that is nothing to look at."""
RELEASED = 0.03
"""Start over the slenderness angle from which on a gain of energy is held against a step: what a
block let go from less holds is next to nothing."""
DEFECTS_SHOWN = 1
"""Worst lanes of an engine and precision on a map that are listed as defects."""

Mask = npt.NDArray[np.bool_]


def summarise(table: pd.DataFrame) -> dict[str, Any]:
    """Counts, sentences and defects of an atlas.

    Args:
        table: What `atlas.run_atlas` returned.

    Returns:
        `engines`, one entry an engine and precision: its counts, its limits and its `sentences`;
        `defects`, the worst lanes whose numbers are absurd although their status lets them pass.
    """
    engines = []
    for (engine, precision), rows in table.groupby(["engine", "precision"], sort=False):
        entry: dict[str, Any] = {"engine": engine, "precision": precision, **_counts(rows)}
        entry["limits"] = _limits(rows)
        entry["sentences"] = _sentences(entry, rows)
        engines.append(entry)
    return {"lanes": len(table), "engines": engines, "defects": _defects(table)}


def within(rows: pd.DataFrame, bound: float) -> float:
    """Part of the compared lanes whose error stays below a bound; NaN if none is compared.

    A compared lane without a usable number counts as one that does not.
    """
    count = int(rows["compared"].sum())
    return float((rows["error"] <= bound).sum() / count) if count else float("nan")


def reach(rows: pd.DataFrame, column: str, sound: Callable[[pd.DataFrame], bool]) -> float:
    """Largest value of a column up to which all lanes are sound; NaN if not at the least one."""
    found = float("nan")
    for value, part in rows.groupby(column):
        if not sound(part):
            break
        found = float(np.asarray(value, dtype=float))
    return found


def _all_usable(rows: pd.DataFrame) -> bool:
    return bool(rows["usable"].all() and not rows["absurd"].any())


def _shallow(rows: pd.DataFrame) -> bool:
    return bool(rows["penetration"].quantile(SHARE) <= DEEP)


def _holds(bound: float) -> Callable[[pd.DataFrame], bool]:
    return lambda lanes: within(lanes, bound) >= SHARE


def _counts(rows: pd.DataFrame) -> dict[str, Any]:
    free = rows["growth"].notna()
    return {
        "lanes": len(rows),
        "status": {str(k): int(v) for k, v in rows["status"].value_counts().items()},
        "not_finite": int((~rows["finite"]).sum()),
        "absurd": int(rows["absurd"].sum()),
        "free": int(free.sum()),
        "grew": int(rows["grew"].sum()),
        "compared": int(rows["compared"].sum()),
        **{f"within_{bound:g}": within(rows, bound) for bound in BOUNDS},
    }


def _limits(rows: pd.DataFrame) -> dict[str, Any]:
    """Largest step [s] or step over the stable one [-] at which an engine holds, by what holds."""
    found: dict[str, Any] = {}
    for column in ("step_s", "step_safety"):
        name = {"step_s": "step", "step_safety": "safety"}[column]
        part = rows[rows["map"] == name]
        if column not in part or not part[column].notna().any():
            continue
        for bound in BOUNDS:
            found[f"{column}_error_{bound:g}"] = reach(part, column, _holds(bound))
        released = part[part["start_ratio"] >= RELEASED]
        found[f"{column}_energy"] = reach(released, column, lambda lanes: not lanes["grew"].any())
        found[f"{column}_usable"] = reach(part, column, _all_usable)
    return found


def _sentences(entry: dict[str, Any], rows: pd.DataFrame) -> list[str]:
    named: dict[str, Callable[[pd.DataFrame, dict[str, Any]], list[str]]] = {
        "step": _of_steps,
        "stiffness": _of_stiffness,
        "safety": _of_safety,
        "mass": _of_mass,
        "shaking": _of_shaking,
        "friction": _of_friction,
    }
    found = [_of_all(entry), _of_penetration(rows)]
    for name, say in named.items():
        part = rows[rows["map"] == name]
        if len(part):
            found += say(part, entry["limits"])
    return found


def _of_all(entry: dict[str, Any]) -> str:
    words = ", ".join(f"{count} {name}" for name, count in entry["status"].items())
    found = f"{entry['lanes']} lanes ({words})"
    if entry["not_finite"] == 0:
        found += "; every number is finite"
    else:
        found += f"; {entry['not_finite']} lanes have a number that is not finite"
    if entry["absurd"]:
        share = _percent(entry["absurd"] / entry["lanes"])
        return f"{found}; {entry['absurd']} ({share}) have absurd numbers that their status passes."
    return f"{found}; no status passes an absurd number."


def _of_penetration(rows: pd.DataFrame) -> str:
    """How deep corners go, in parts of the block's height."""
    deep = rows["penetration"].dropna()
    if not (deep > 0.0).any():
        return "Nothing penetrates: it has no gaps."
    worst = f"at most {deep.max():.1e}"
    steps = rows[(rows["map"] == "step") & rows["penetration"].notna()]
    text = f"Penetration / height of the block: {worst} in any lane that may be used"
    if "step_s" not in rows or not steps["step_s"].notna().any():
        return f"{text}, nine in ten below {deep.quantile(SHARE):.1e}."
    held = reach(steps, "step_s", _shallow)
    return f"{text}; in free rocking nine in ten stay below {DEEP:g} {_up_to(held)}."


def _of_steps(rows: pd.DataFrame, limits: dict[str, Any]) -> list[str]:
    if "step_s_energy" not in limits:
        shares = " and ".join(f"{_percent(within(rows, b))} within {b:g}" for b in BOUNDS)
        return [f"Free rocking, no time step: {shares} of the slenderness angle. {_grown(rows)}"]
    low, high = rows["step_s"].min(), rows["step_s"].max()
    texts = [f"{bound:g} {_up_to(limits[f'step_s_error_{bound:g}'])}" for bound in BOUNDS]
    return [
        f"Free rocking at steps of {low:.2g} to {high:.2g} s: the error of nine lanes in ten stays "
        f"below {', below '.join(texts)}. Blocks let go from {RELEASED:g} of the slenderness angle "
        f"or more gain no energy {_up_to(limits['step_s_energy'])}; every number may be used "
        f"{_up_to(limits['step_s_usable'])}. {_grown(rows)}"
    ]


def _of_stiffness(rows: pd.DataFrame, _limits: dict[str, Any]) -> list[str]:
    spans: list[tuple[int, float, str]] = []
    for value, part in rows.groupby("step_s"):
        held = [
            float(np.asarray(stiffness, dtype=float))
            for stiffness, lanes in part.groupby("stiffness_n_m3")
            if within(lanes, BOUNDS[1]) >= SHARE
        ]
        step = float(np.asarray(value, dtype=float))
        if held:
            spans.append((len(held), step, f"{_span(held)} N/m^3 at steps of {step:.2g} s"))
    where = max(spans)[2] if spans else "no stiffness at any step"
    return [
        f"Contact stiffness: nine lanes in ten are within {BOUNDS[1]:g} of a rigid block at "
        f"{where}. {_grown(rows)}"
    ]


def _of_safety(rows: pd.DataFrame, limits: dict[str, Any]) -> list[str]:
    reached = limits["step_safety_usable"]
    text = f"up to {reached:.2g}" if reached == reached else "not even at the smallest"
    tried = f"{rows['step_safety'].min():.2g} to {rows['step_safety'].max():.2g}"
    return [
        f"Step over the largest stable one ({tried} tried): every number may be used {text}. "
        f"{_grown(rows)}"
    ]


def _of_mass(rows: pd.DataFrame, _limits: dict[str, Any]) -> list[str]:
    low, high = rows["mass_ratio"].min(), rows["mass_ratio"].max()
    ends = f"upper over lower mass {low:.0e} to {high:.0e}"
    if rows["iterations"].notna().any():
        shares = ", ".join(
            f"{_percent(within(part, BOUNDS[1]))} with {int(np.asarray(count))}"
            for count, part in rows.groupby("iterations")
        )
        text = f"lanes within {BOUNDS[1]:g} of two-block by sweeps of the solver: {shares}"
    else:
        text = f"{_percent(within(rows, BOUNDS[1]))} of the lanes within {BOUNDS[1]:g} of two-block"
    return [f"Two blocks, {ends}: {text}. {_grown(rows)}"]


def _of_shaking(rows: pd.DataFrame, _limits: dict[str, Any]) -> list[str]:
    same = _percent(float(rows["same_outcome"].mean()))
    shares = " and ".join(f"{_percent(within(rows, b))} within {b:g}" for b in BOUNDS)
    return [
        f"Sine bursts to {rows['amplitude_g'].max():.2g} g and {rows['frequency_hz'].max():.2g} Hz "
        f"at default settings, lanes that do not slide: {shares} of the slenderness angle; {same} "
        "stand or fall as Housner's block."
    ]


def _of_friction(rows: pd.DataFrame, _limits: dict[str, Any]) -> list[str]:
    shares = " and ".join(f"{_percent(within(rows, b))} within {b:g}" for b in BOUNDS)
    return [
        f"Friction {rows['friction'].min():.2g} to {rows['friction'].max():.2g} at default "
        f"settings, lanes that friction holds: {shares} of the slenderness angle. {_grown(rows)}"
    ]


def _grown(rows: pd.DataFrame) -> str:
    """How many lanes without base motion gained energy, and in what range."""
    free = int(rows["growth"].notna().sum())
    grew, absurd = int(rows["grew"].sum()), int(rows["absurd"].sum())
    if not grew:
        return (
            f"No lane of {free} without base motion gained more than {_percent(GROWTH_BOUND)} of "
            "its energy."
        )
    beyond = f", and {absurd} are absurd" if absurd else ""
    return (
        f"{grew} of {free} lanes without base motion ({_percent(grew / free)}) gained more than "
        f"{_percent(GROWTH_BOUND)} of what they held{beyond}."
    )


def _defects(table: pd.DataFrame) -> list[dict[str, Any]]:
    """The worst lanes of every engine, precision and map that a status should have caught."""
    found: list[dict[str, Any]] = []
    wrong = table[table["absurd"]]
    keys: list[Hashable] = ["engine", "precision", "map"]
    for _, rows in wrong.groupby(keys, sort=False):
        worst = rows.sort_values("growth", ascending=False).head(DEFECTS_SHOWN)
        for record in worst.to_dict("records"):
            kept = {str(k): v for k, v in record.items() if v == v}
            found.append({"of": len(rows), **kept})
    return found


def _up_to(step: float) -> str:
    return f"up to {step:.2g} s" if step == step else "(not even at the smallest step)"


def _span(values: list[float]) -> str:
    return f"{values[0]:.1e}" if len(values) == 1 else f"{values[0]:.1e} to {values[-1]:.1e}"


def _percent(share: float) -> str:
    """A share as a percentage; prints 0 % or 100 % only where that is exact."""
    if share != share:
        return "none compared"
    text = f"{100.0 * share:.1f} %"
    if text == "100.0 %" and share < 1.0:
        return "> 99.9 %"
    if text == "0.0 %" and share > 0.0:
        return "< 0.1 %"
    return text.replace(".0 %", " %")


def explain_words() -> str:
    """What the words of the summary mean."""
    return (
        "Error: largest |rotation - reference| / slenderness angle over a run; the reference is "
        "housner for single blocks and two-block for stacks. Penetration: how deep a corner was in "
        "what it stands on, at rest or when it landed. Gained energy: more than "
        f"{_percent(GROWTH_BOUND)} of what was held at the start, on a still base. Absurd: a "
        "usable status with a number that is not finite, a rotation beyond pi/2, or a gain of more "
        f"than {EXPLOSION_BOUND:g} times the energy held and {_percent(BARRIER_SHARE)} of what "
        "overturns the blocks."
    )
