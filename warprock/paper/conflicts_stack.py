"""Where Section 6 of the seed paper contradicts itself on two stacked blocks: the numbers.

Like `conflicts`: every item says what is printed, what the calculation gives and how sure it is.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.paper.conflict_texts import Conflict, Numbers, Parts, conflicts_about
from warprock.paper.printed import REFERENCE_DEGREES, as_number, paper_columns

if TYPE_CHECKING:
    import pandas as pd

Array = npt.NDArray[np.float64]

LOWER, UPPER = (0.20, 0.60, 0.40), (0.15, 0.60, 0.55)
"""Full width, height and depth of the paper's stacked blocks as printed [m]."""
LOW_TOP_HEIGHT = 0.55
"""Height of the upper block [m] with which the outline of the stack has the printed angle."""
CHAMFER = 0.005
"""What the paper cuts off every corner [m]."""
ROUGHLY = 0.01
"""Half of the last printed digit of Tables 11 and 12, as a share."""
MISFITS = ((4.0, 3.0), (5.0, 2.0))
"""Inputs (Hz, mm) whose printed analytical values no reading of the paper gives."""
FITTED = ((4.0, 4.0), (4.0, 5.0), (5.0, 3.0), (5.0, 4.0), (6.5, 2.0))
"""Inputs whose printed analytical values the acceleration reading gives."""
OVERTURNED = ((4.0, 5.0), (5.0, 4.0))
"""Inputs of continuous sine under which the upper block fell in the tests, as Table 11 has it."""
CEILING = 90.0 / REFERENCE_DEGREES
"""Rotation ratio that stands for a fall in the paper's tables."""


@dataclasses.dataclass(frozen=True)
class StackEvidence:
    """What the runs found, for the conflicts that need it; None where a target does not run it.

    Attributes:
        pulse: Peaks under one cycle: `frequency_hz`, `amplitude_mm`, `reading`, `geometry`,
            `edges`, `block`, `source`, `peak_rotation_ratio` (/ 9.85 deg).
        sine: The same under continuous sine.
        smoother: As `pulse`, of the run at friction 0.6.
        places: Printed values of Tables 9 and 10 in our ensembles: `geometry`, `block`, `source`,
            `percentile`, and `spread`, the range of the middle 90 % of members / their median.
        tests: The tests behind Tables 11 and 12 by block, as the analytical column and as Bullet's
            imply them.
        collapse: Cells of the collapse case: `amplitude`, `frequency_hz`, `members` and
            `collapsed_share`.
    """

    pulse: pd.DataFrame | None = None
    sine: pd.DataFrame | None = None
    smoother: pd.DataFrame | None = None
    places: pd.DataFrame | None = None
    tests: Mapping[str, tuple[Array, Array]] | None = None
    collapse: pd.DataFrame | None = None


def peaks_of(
    table: pd.DataFrame, source: str, reading: str, geometry: str, block: str, edges: str
) -> Array:
    """Peaks of one source and reading, in the order of Table 8."""
    mask = (
        table[["source", "reading", "geometry", "block", "edges"]]
        == [source, reading, geometry, block, edges]
    ).all(axis=1)
    return np.asarray(table.loc[mask, "peak_rotation_ratio"].to_numpy(dtype=float))


def analytical_peaks(table: pd.DataFrame, block: str) -> Array:
    """Peaks of the analytical model in the reading that fits the paper's analytical columns."""
    return peaks_of(table, "two-block", "acceleration", "equal-depths", block, "chamfered")


def rows_at(inputs: tuple[tuple[float, float], ...]) -> npt.NDArray[np.intp]:
    """Where some inputs are in Table 8."""
    table = paper_columns("table8")
    keys = list(zip(table["frequency_hz"], table["amplitude_mm"], strict=True))
    return np.array([keys.index(key) for key in inputs])


def read_printed(name: str, column: str) -> Array:
    """A column of a printed table; NaN where it is no number."""
    return np.array([as_number(cell) for cell in paper_columns(name)[column]])


def _angle(width: float, centre: float) -> float:
    return float(np.rad2deg(np.arctan2(0.5 * width, centre)))


def centre_height(equal_depths: bool) -> float:
    """Height of the common centre of mass of the printed stack [m]."""
    (w1, h1, d1), (w2, h2, d2) = LOWER, UPPER
    m1, m2 = w1 * h1 * (1.0 if equal_depths else d1), w2 * h2 * (1.0 if equal_depths else d2)
    return (m1 * 0.5 * h1 + m2 * (h1 + 0.5 * h2)) / (m1 + m2)


def _reference_angle(_evidence: StackEvidence) -> Parts:
    width, height = LOWER[:2]
    by_depths, by_equal = (_angle(width, centre_height(equal)) for equal in (False, True))
    cut, cut_equal = (
        _angle(width - 2.0 * CHAMFER, centre_height(equal)) for equal in (False, True)
    )
    lower, upper = (float(np.rad2deg(np.arctan2(w, h))) for w, h, _ in (LOWER, UPPER))
    numbers = {
        "printed": REFERENCE_DEGREES,
        "by_depths": by_depths,
        "by_equal": by_equal,
        "cut": cut,
        "cut_equal": cut_equal,
        "outline": float(np.rad2deg(np.arctan2(width, height + LOW_TOP_HEIGHT))),
        "low_top": LOW_TOP_HEIGHT,
        "lower": lower,
        "upper": upper,
    }
    return {"text": numbers}


def _analytical_columns(evidence: StackEvidence) -> Parts:
    if evidence.pulse is None:
        return {"text": {}}
    parts, fitted = [], rows_at(FITTED)
    for block, name in (("top", "table9"), ("bottom", "table10")):
        ours = analytical_peaks(evidence.pulse, block)[fitted]
        theirs = read_printed(name, "analytical")[fitted]
        off = 100 * np.max(np.abs(ours / theirs - 1.0))
        parts.append({"block": block, "ours": ours, "theirs": theirs, "off": off})
    dash = analytical_peaks(evidence.pulse, "top")[0]
    return {"text": {}, "pulse": {"parts": parts, "dash": dash}}


def _misfits(evidence: StackEvidence) -> Parts:
    where = rows_at(MISFITS)
    top, bottom = (read_printed(name, "analytical")[where] for name in ("table9", "table10"))
    opening = {"top": top, "bottom": bottom}
    if evidence.pulse is None:
        return {"text": opening}
    ours = analytical_peaks(evidence.pulse, "top")[where]
    ratio = top / ours
    return {"text": opening, "pulse": {"ours": ours, "low": ratio.min(), "high": ratio.max()}}


def _depths(evidence: StackEvidence) -> Parts:
    if evidence.pulse is None:
        return {"text": {}}
    names = {
        "printed": "as printed",
        "equal-depths": "equal depths",
        "low-top": "equal depths, top 0.55 m high",
    }
    parts = [
        {"name": name, "errors": _mean_differences(evidence.pulse, geometry)}
        for geometry, name in names.items()
    ]
    said: dict[str, Numbers] = {"text": {}, "pulse": {"parts": parts}}
    if evidence.smoother is not None:
        said["smoother"] = {"errors": _mean_differences(evidence.smoother, "low-top")}
    return said | {"end": {}}


_CONTACT = ("bullet", "vortex", "dem")


def _mean_differences(table: pd.DataFrame, geometry: str) -> Array:
    """Mean |ours / printed - 1| of Table 9 in each of the paper's contact programs [%]."""
    ours = peaks_of(table, "event", "displacement", geometry, "top", "chamfered")
    gaps = [np.abs(ours / read_printed("table9", column) - 1.0) for column in _CONTACT]
    return np.array([100.0 * np.nanmean(gap) for gap in gaps])


def _repeatability(evidence: StackEvidence) -> Parts:
    opening: dict[str, float] = {}
    for number in (9, 10):
        table = paper_columns(f"table{number}")
        peaks = np.array([table[column] for column in _CONTACT])
        factors = np.nanmax(peaks, axis=0) / np.nanmin(peaks, axis=0)
        opening |= {f"low_{number}": factors.min(), f"high_{number}": factors.max()}
    if evidence.places is None:
        return {"text": opening}
    parts = []
    for geometry, places in evidence.places.groupby("geometry", sort=False):
        inside = places["percentile"].between(5.0, 95.0)
        part: dict[str, Any] = {"geometry": geometry}
        for block in ("top", "bottom"):
            own = places["block"] == block
            part |= {f"inside_{block}": int(inside[own].sum()), f"of_{block}": int(own.sum())}
        parts.append(part)
    top = evidence.places[evidence.places["block"] == "top"]
    spread = top.loc[top["source"] == _CONTACT[0], "spread"]
    numbers = {"parts": parts, "ensembles": len(spread), "narrow": int((spread < 0.1).sum())}
    return {"text": opening, "places": numbers}


def _tests(evidence: StackEvidence) -> Parts:
    if evidence.tests is None:
        return {"text": {}}
    parts = []
    for block in ("top", "bottom"):
        analytical, bullet = evidence.tests[block]
        both = np.isfinite(analytical) & np.isfinite(bullet)
        both[rows_at(OVERTURNED)] = False
        apart = np.exp(np.abs(np.log(bullet[both] / analytical[both])).max())
        numbers = {"analytical": analytical[both], "bullet": bullet[both], "apart": apart}
        parts.append({"block": block, **numbers})
    return {"text": {}, "tests": {"parts": parts}}


def _overturned_rows(evidence: StackEvidence) -> Parts:
    where = rows_at(OVERTURNED)
    opening = {"ceiling": CEILING}
    for column in ("analytical", "bullet", "vortex"):
        left = 1.0 - 1e-2 * read_printed("table11", column)[where]
        opening[f"{column}_low"] = CEILING * (left - 0.5 * ROUGHLY)[0]
        opening[f"{column}_high"] = CEILING * (left + 0.5 * ROUGHLY)[0]
    if evidence.sine is None:
        return {"text": opening}
    ours = analytical_peaks(evidence.sine, "top")[where]
    stepping = peaks_of(evidence.sine, "event", "displacement", "low-top", "top", "chamfered")
    return {"text": opening, "sine": {"two_block": ours, "event": stepping[where]}}


def _collapse(evidence: StackEvidence) -> Parts:
    if evidence.collapse is None:
        return {"text": {}}
    cells = evidence.collapse
    as_printed = cells[cells["amplitude"] == "as printed"]
    beyond = 100 * cells[cells["amplitude"] == "doubled"]["collapsed_share"]
    numbers = {
        "fell": round(float((as_printed["collapsed_share"] * as_printed["members"]).sum())),
        "members": int(as_printed["members"].sum()),
        "low": beyond.min(),
        "high": beyond.max(),
    }
    return {"text": {}, "collapse": numbers}


def _units(_evidence: StackEvidence) -> Parts:
    angle = float(np.deg2rad(REFERENCE_DEGREES))
    numbers: dict[str, Array] = {}
    for block, name in (("top", "table9"), ("bottom", "table10")):
        most = np.array([np.nanmax(read_printed(name, c)) for c in ("analytical", *_CONTACT)])
        numbers |= {block: most, f"{block}_radians": most * angle}
    return {"text": numbers}


def _text_and_tables(_evidence: StackEvidence) -> Parts:
    analytical, dem = read_printed("table11", "analytical"), read_printed("table11", "dem")
    table9 = paper_columns("table9")
    same = table9["vortex"] == table9["dem"]
    bullet_off, vortex_off = (
        100.0 * np.abs(read_printed("table9", c) / read_printed("table9", "dem") - 1.0)
        for c in ("bullet", "vortex")
    )
    numbers = {
        "most": analytical.max(),
        "least": analytical.min(),
        "bullet": np.mean(read_printed("table11", "bullet")),
        "vortex": np.mean(read_printed("table11", "vortex")),
        "low_bullet": np.mean(read_printed("table12", "bullet")),
        "low_vortex": np.mean(read_printed("table12", "vortex")),
        "counted": float(np.nansum(dem)) / (np.isfinite(dem).sum() + len(OVERTURNED)),
        "dem": np.nanmean(dem),
        "same": " and ".join(
            f"{row['frequency_hz']:g}/{row['amplitude_mm']:g}"
            for row in table9.take(np.flatnonzero(same)).records
        ),
        "vortex_off": vortex_off.mean(),
        "bullet_off": bullet_off.mean(),
        "without": vortex_off[~same].mean(),
    }
    return {"text": numbers}


_ITEMS = (
    ("reference_angle", _reference_angle),
    ("analytical_columns", _analytical_columns),
    ("misfits", _misfits),
    ("depths", _depths),
    ("repeatability", _repeatability),
    ("tests", _tests),
    ("overturned_rows", _overturned_rows),
    ("collapse", _collapse),
    ("units", _units),
    ("stack_text_and_tables", _text_and_tables),
)
"""Name of each conflict, and what finds its numbers."""


def stack_conflicts_of(targets: Collection[str], evidence: StackEvidence) -> list[Conflict]:
    """The conflicts on stacks that concern one of the targets."""
    return conflicts_about(targets, _ITEMS, evidence)
