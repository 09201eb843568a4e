"""Fragility functions in the layouts that programs for losses and risks read.

- Component tables after FEMA P-58, as pelicun and the Damage and Loss Model Library (DLML) have
  them: `Theta_0` is the median in the unit of `Demand-Unit`, `Theta_1` the dispersion.
- NRML of the OpenQuake engine: `logncdf` takes the mean and the standard deviation of a lognormal
  capacity, mean = median exp(s^2 / 2) and deviation = mean (exp(s^2) - 1)^1/2. Its intensities are
  in g and cm/s.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
import pandas as pd

from warprock.analysis.fragility import INTENSITY
from warprock.analysis.limits import Limit
from warprock.analysis.lognormal import Fit, Verdict
from warprock.case.input_columns import SPECTRAL
from warprock.units import GRAVITY, split_unit

NRML = "http://openquake.org/xmlns/nrml/0.5"
LONGEST_ID = 75
"""Letters that OpenQuake takes of the name of a function."""
SCORES = 6.0
"""Standard scores of the intensities between which OpenQuake evaluates a function: beyond them the
probability is within 1e-9 of 0 and 1."""


class Exported(Protocol):
    """A function with what tells it from others, and its limit state."""

    @property
    def group_text(self) -> str:
        """What tells it from others."""

    @property
    def limit(self) -> Limit:
        """Its limit state."""

    @property
    def fit(self) -> Fit:
        """The function."""


class Demand(NamedTuple):
    """An intensity measure, as others call it.

    Attributes:
        component: In component tables, `Demand-Type`.
        nrml: In NRML.
        size: Values of the column in one unit of NRML.
    """

    component: str
    nrml: str
    size: float


_DEMANDS = {
    INTENSITY: Demand("Peak Ground Acceleration", "PGA", GRAVITY),
    "peak_velocity_m_s": Demand("Peak Ground Velocity", "PGV", 0.01),
}
_SPECTRAL_COLUMN = f"{SPECTRAL}_m_s2"
_SPECTRAL_DEMAND = "Spectral Acceleration|"
_UNITS = {"m/s^2": "mps2", "m/s": "mps", "m": "m", "rad": "rad"}
"""Unit of a column -> its name in component tables; others have none."""
COMPONENT_UNITS = {
    **{theirs: ours for ours, theirs in _UNITS.items()},
    "g": "g",
    "cmps2": "cm/s^2",
    "cmps": "cm/s",
    "unitless": "",
    "ea": "",
}
"""Names of units in component tables -> ours."""


def demand_of(intensity: str, period: float = np.nan) -> Demand | None:
    """An intensity measure as others call it; None where they have no name for it.

    Args:
        intensity: Its column in the lane table.
        period: Period of a spectral acceleration [s].
    """
    if intensity == _SPECTRAL_COLUMN and np.isfinite(period):
        return Demand(f"{_SPECTRAL_DEMAND}{period:g}", f"SA({period:g})", GRAVITY)
    return _DEMANDS.get(intensity)


def intensity_of(demand: str) -> str:
    """The column of the lane table that `Demand-Type` means; the text itself where it is none."""
    if demand.startswith(_SPECTRAL_DEMAND):
        return _SPECTRAL_COLUMN
    return next((name for name, each in _DEMANDS.items() if each.component == demand), demand)


def component_rows(
    curves: Sequence[Exported], intensity: str, period: float = np.nan
) -> pd.DataFrame:
    """One row a group in the layout of component tables, see the head of this file.

    Where one intensity parts what reaches a limit state from what does not, the function is
    deterministic. Limit states without any leave their cells empty and mark the row as incomplete,
    so that readers leave it out. Readers split the names of groups at hyphens: these become
    underscores.

    Args:
        curves: The functions.
        intensity: Column of the intensity measure.
        period: Period of a spectral acceleration [s].
    """
    demand = demand_of(intensity, period)
    rows: dict[str, dict[str, object]] = {}
    for curve in curves:
        name = (curve.group_text or "block").replace("-", "_")
        row = rows.setdefault(
            name,
            {
                "ID": name,
                "Incomplete": 0,
                "Demand-Type": intensity if demand is None else demand.component,
                "Demand-Unit": _UNITS.get(split_unit(intensity)[1], "unitless"),
                "Demand-Offset": 0,
                "Demand-Directional": 0,
            },
        )
        number = 1 + sum(1 for key in row if key.endswith("-Family"))
        parted = curve.fit.verdict is Verdict.SEPARATED
        fitted = _is_fitted(curve)
        row["Incomplete"] = int(bool(row["Incomplete"]) or not (fitted or parted))
        row[f"LS{number}-Name"] = curve.limit.text
        row[f"LS{number}-Family"] = "lognormal" if fitted else "deterministic" if parted else ""
        row[f"LS{number}-Theta_0"] = curve.fit.median
        row[f"LS{number}-Theta_1"] = curve.fit.dispersion if fitted else np.nan
    return pd.DataFrame(list(rows.values()))


def _is_fitted(curve: Exported) -> bool:
    return curve.fit.verdict is Verdict.FITTED


def nrml_text(curves: Sequence[Exported], intensity: str, period: float = np.nan) -> str:
    """A fragility model of NRML 0.5, a function a group; empty where it could hold none.

    NRML knows PGA, PGV and spectral accelerations, and a function of it has all limit states. Limit
    states that no group has a lognormal function of are left out, and so are groups without one of
    the others.

    Args:
        curves: The functions.
        intensity: Column of the intensity measure.
        period: Period of a spectral acceleration [s].
    """
    demand = demand_of(intensity, period)
    known = {curve.limit.name for curve in curves if _is_fitted(curve)}
    groups: dict[str, list[Exported]] = {}
    for curve in curves:
        mine = groups.setdefault(curve.group_text or "block", [])
        mine += [curve] if curve.limit.name in known else []
    whole = {name: mine for name, mine in groups.items() if all(map(_is_fitted, mine))}
    if demand is None or not known or not whole:
        return ""
    limits = [_identifier(curve.limit) for curve in next(iter(whole.values()))]
    model = ElementTree.Element(
        "fragilityModel", id="warprock", assetCategory="contents", lossCategory="contents"
    )
    left = len(groups) - len(whole)
    said = "Rocking blocks; lognormal functions of greatest likelihood"
    said += f"; left out for want of a function: {left} groups" if left else ""
    ElementTree.SubElement(model, "description").text = said
    ElementTree.SubElement(model, "limitStates").text = " ".join(limits)
    for name, mine in zip(_function_ids(whole), whole.values(), strict=True):
        function = ElementTree.SubElement(
            model, "fragilityFunction", id=name, format="continuous", shape="logncdf"
        )
        ends = [
            [curve.fit.median / demand.size * np.exp(sign * SCORES * curve.fit.dispersion)
             for curve in mine]
            for sign in (-1.0, 1.0)
        ]  # fmt: skip
        ElementTree.SubElement(
            function,
            "imls",
            imt=demand.nrml,
            minIML=repr(float(min(ends[0]))),
            maxIML=repr(float(max(ends[1]))),
        )
        for limit, curve in zip(limits, mine, strict=True):
            mean = curve.fit.median / demand.size * np.exp(0.5 * curve.fit.dispersion**2)
            deviation = mean * np.sqrt(np.expm1(curve.fit.dispersion**2))
            texts = {"mean": repr(float(mean)), "stddev": repr(float(deviation))}
            ElementTree.SubElement(function, "params", {"ls": limit, **texts})
    root = ElementTree.Element("nrml", xmlns=NRML)
    root.append(model)
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode", xml_declaration=False)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'


def _function_ids(names: Iterable[str]) -> list[str]:
    """Names of functions as OpenQuake takes them: letters, digits, _, - and :, each once."""
    found: list[str] = []
    for name in names:
        text = re.sub(r"[^A-Za-z0-9_:-]+", "_", name)[:LONGEST_ID]
        if text in found:
            end = f"_{len(found) + 1}"
            text = text[: LONGEST_ID - len(end)] + end
        found.append(text)
    return found


def _identifier(limit: Limit) -> str:
    """A limit state as a name without blanks and dots: `rotation_0_15`, `slide_10_mm`."""
    name = limit.name if limit.ratio is None else f"rotation_{limit.name}"
    return re.sub(r"\W+", "_", name)
