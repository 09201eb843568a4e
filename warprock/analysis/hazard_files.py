"""Files of hazard curves: tables with named columns, and what OpenQuake writes, CSV and NRML.

A table has a column of intensities and one that says how often they are exceeded:

    PGA [g],annual_rate
    0.05,2.1e-2
    0.10,6.4e-3

The heading of the first names an intensity measure, PGA, PGV, SA(1.0) with its period in seconds,
or a column of the lane table, with its unit in brackets or as its end: `peak_velocity_cm_s`. The
second is `annual_rate`, `return_period_years` or `chance_in_50_years`, whatever the number. Lines
that begin with # are remarks. Shipped curves are such tables, and known by their names.

OpenQuake's files tell chances within an investigation time, a row or an element a site; they are
recognised by what they hold. Where a file has several curves, `FILE#2` is the second, and
`FILE#PGV` the one over PGV.
"""

from __future__ import annotations

import csv
import dataclasses
import functools
import importlib.resources
import io
import os
import pathlib
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.hazard import Hazard, hazard_table, power_law
from warprock.analysis.lane_tables import MEASURES
from warprock.case.input_columns import SPECTRAL
from warprock.errors import NOTHING, InputError, Said, list_allowed
from warprock.reading import read_bytes, reason
from warprock.units import (
    ALIASES,
    UNITS,
    Dimension,
    ending,
    parse_any,
    parse_quantity,
    split_unit,
)

Array = npt.NDArray[np.float64]

CURVE = "#"
"""What stands between a file and which of its curves is meant."""
MOST_BYTES = 2**26

_OPENQUAKE_UNITS = {"PGA": "g", "PGV": "cm/s", "PGD": "cm", "SA": "g"}
"""Units that OpenQuake has for its measures."""
_RATES = (
    "annual_rate",
    "rate_per_year",
    "annual_frequency",
    "annual_rate_of_exceedance",
    "annual_frequency_of_exceedance",
)
_CHANCE = re.compile(r"(?:chance|poe|probability)_in_(\d+(?:\.\d+)?)_(?:years|year|a)")
_SPECTRAL = re.compile(r"SA\((\d*\.?\d+)\)", re.IGNORECASE)
_BRACKETS = re.compile(r"(?P<name>[^\[\]]+?)\s*\[(?P<unit>[^\[\]]*)\]")
_QUOTED = re.compile(r"(\w+)=(?:'([^']*)'|\"+([^\"]*)\"+|([^,\s\"']+))")
_DIMENSIONS = tuple(d for d in Dimension if d is not Dimension.AGE)


class Curve(NamedTuple):
    """A curve of a file.

    Attributes:
        measure: Name of its intensity measure, as the file has it.
        unit: Unit of its intensities; empty without.
        intensity: Intensities in this unit, shape [row].
        rate: Exceedances in a year, shape [row]; infinite where the file says that one is certain.
        place: Where it is for; empty where the file does not say.
    """

    measure: str
    unit: str
    intensity: Array
    rate: Array
    place: str = ""

    @property
    def name(self) -> str:
        """What errors call it."""
        return f"{self.measure} at {self.place}" if self.place else self.measure


@functools.cache
def _shipped() -> dict[str, pathlib.Path]:
    folder = importlib.resources.files("warprock.cases").joinpath("hazards")
    found = [pathlib.Path(str(file)) for file in folder.iterdir() if file.name.endswith(".csv")]
    return {file.stem: file for file in sorted(found)}


def hazard_names() -> list[str]:
    """Names of the shipped hazard curves."""
    return list(_shipped())


def read_hazard(asked: str | os.PathLike[str] | pd.DataFrame, measure: str | None = None) -> Hazard:
    """Reads a hazard curve.

    Args:
        asked: A file, with `#CURVE` behind it where it has several; the name of a shipped curve; or
            a table.
        measure: Column of the lane table that it is over, where the file does not say.

    Raises:
        InputError: It cannot be read, has no such curve, or none that is one.
    """
    if isinstance(asked, pd.DataFrame):
        heads, rows = list(map(str, asked.columns)), asked.to_numpy(dtype=object).tolist()
        return _hazard_of(_table_curve(heads, rows, "hazard"), "hazard", measure)
    text, _, chosen = os.fspath(asked).partition(CURVE)
    curves = _curves(text)
    return _hazard_of(_choose(curves, text, chosen), text, measure)


def read_power_law(rate: float, slope: float, at: str, measure: str) -> Hazard:
    """The hazard lambda = k0 (x / at)^-k.

    Args:
        rate: k0, exceedances of `at` in a year.
        slope: k [-].
        at: An intensity with its unit.
        measure: Its column in the lane table, or one of its names.

    Raises:
        InputError: A number out of bounds, or a unit of another kind than the measure.
    """
    for name, value in (("--k0", rate), ("--k", slope)):
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(name, "", value, "must be finite and > 0")
    try:
        found = parse_any(at, _DIMENSIONS)
    except ValueError:
        allowed = 'must be an intensity with its unit, such as "1 g" or "10 cm/s"'
        raise InputError("--at", "", at, allowed) from None
    column = MEASURES.get(measure.strip().lower(), measure)
    _require_unit("--at", at, column, found.dimension)
    if not found.value > 0.0:
        raise InputError("--at", "", at, "must be > 0")
    return power_law(f"{rate:g} ({column} / {at})^-{slope:g}", column, rate, slope, found.value)


def _curves(path: str) -> list[Curve]:
    """The curves of a file."""
    place = _shipped().get(path, pathlib.Path(path))
    try:
        text = read_bytes(place, MOST_BYTES).decode("utf-8-sig")
    except OSError as error:
        known = list_allowed(path, hazard_names())
        allowed = f"must be a file ({reason(error)}) or a shipped curve: {known}"
        raise InputError("--hazard", "", path, allowed) from None
    except UnicodeDecodeError:
        raise InputError("--hazard", "", path, "must be a text file in UTF-8") from None
    if text.lstrip().startswith("<"):
        return _nrml_curves(text, path)
    if text.startswith("#") and "investigation_time" in text.partition("\n")[0]:
        return _openquake_curves(text, path)
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    heads, *rows = csv.reader(lines) if lines else [[]]
    return [_table_curve(heads, rows, path)]


def _choose(curves: Sequence[Curve], source: str, chosen: str) -> Curve:
    """The curve that is meant: by its number from 1, its measure, or the only one."""
    if chosen.isdigit() and 0 < int(chosen) <= len(curves):
        return curves[int(chosen) - 1]
    mine = [each for each in curves if not chosen or each.measure.lower() == chosen.lower()]
    if len(mine) == 1:
        return mine[0]
    names = [f"{number} ({each.name})" for number, each in enumerate(curves, start=1)]
    allowed = f"must name one of its curves, FILE{CURVE}NUMBER: {list_allowed(chosen, names)}"
    raise InputError("--hazard", "", f"{source}{CURVE}{chosen}" if chosen else source, allowed)


def _hazard_of(curve: Curve, source: str, measure: str | None) -> Hazard:
    """A curve in the unit of a column of the lane table."""
    unit = ALIASES.get(curve.unit, curve.unit)
    dimension = next((d for d in _DIMENSIONS if unit in UNITS[d]), None)
    if dimension is None:
        units = [each for d in _DIMENSIONS for each in UNITS[d] if each]
        allowed = f"must be a unit that is known: {list_allowed(unit, units)}"
        raise InputError(source, curve.measure, curve.unit, allowed)
    spectral = _SPECTRAL.fullmatch(curve.measure)
    column = measure or MEASURES.get(curve.measure.lower(), "")
    if not column and spectral:
        column = f"{SPECTRAL}{ending('m/s^2')}"
    elif not column:
        column = curve.measure.replace(" ", "_").replace("-", "_").lower()
        column += ending(next(iter(UNITS[dimension])))
    _require_unit(source, curve.unit, column, dimension)
    size = float(UNITS[dimension][unit])
    # Where an exceedance is certain within the investigation time the rate is not known.
    known = ~np.isposinf(curve.rate)
    found = hazard_table(source, column, curve.intensity[known] * size, curve.rate[known])
    return dataclasses.replace(found, period=float(spectral[1])) if spectral else found


def _require_unit(source: str, got: str, column: str, dimension: Dimension) -> None:
    """Refuses intensities in a unit that the column of the lane table does not have."""
    unit = split_unit(column)[1]
    wanted = next((d for d in _DIMENSIONS if unit and unit in UNITS[d]), Dimension.DIMENSIONLESS)
    if wanted is not dimension:
        units = ", ".join(each or "none" for each in UNITS[wanted])
        raise InputError(source, column, got, f"must be in a unit of this column: {units}")


def _table_curve(heads: Sequence[str], rows: Sequence[Sequence[object]], source: str) -> Curve:
    """The curve of a table with named columns."""
    names = [head.strip() for head in heads]
    kinds = [_rate_kind(name) for name in names]
    known = [at for at, kind in enumerate(kinds) if kind]
    if len(names) != 2 or len(known) != 1:
        allowed = (
            "must be two columns, an intensity measure with its unit, such as PGA [g], and one of "
            "annual_rate, return_period_years and chance_in_50_years"
        )
        raise InputError(source, "header", ",".join(names), allowed)
    (rate,) = known
    numbers = np.array([_numbers(row, number, source) for number, row in enumerate(rows, start=1)])
    if not len(numbers):
        raise InputError(source, "", Said("0 rows"), "must have at least 2")
    measure, unit = _measure_of(names[1 - rate])
    found = _annual(kinds[rate], numbers[:, rate], source, names[rate])
    return Curve(measure, unit, numbers[:, 1 - rate], found)


def _rate_kind(name: str) -> str:
    """What a column says of exceedances: `rate`, `period` or years; empty where it does not."""
    bare = re.sub(r"\s*\[[^\]]*\]", "", name).strip().lower().replace(" ", "_")
    if bare in _RATES:
        return "rate"
    if bare in ("return_period_years", "return_period"):
        return "period"
    chance = _CHANCE.fullmatch(bare)
    return chance[1] if chance else ""


def _annual(kind: str, values: Array, source: str, name: str) -> Array:
    """Exceedances in a year, of rates, return periods or chances within some years."""
    if kind == "rate":
        return values
    if kind == "period":
        good = values > 0.0
        _require_all(good, values, source, name, "must be above 0 years")
        return np.asarray(1.0 / values)
    years = float(kind)
    good = (values >= 0.0) & (values <= 1.0)
    _require_all(good, values, source, name, "must be a chance from 0 to 1")
    with np.errstate(divide="ignore"):
        return np.asarray(-np.log1p(-values) / years)


def _require_all(
    good: npt.NDArray[np.bool_], values: Array, source: str, name: str, allowed: str
) -> None:
    if not good.all():
        row = int(np.argmin(good))
        raise InputError(source, name, float(values[row]), f"{allowed} (row {row + 1})")


def _numbers(row: Sequence[object], number: int, source: str) -> tuple[float, float]:
    """The two numbers of a row."""
    try:
        first, second = (float(str(cell)) for cell in row)
    except ValueError:
        text = ",".join(map(str, row))
        raise InputError(source, f"row {number}", text, "must be two numbers") from None
    return first, second


def _measure_of(name: str) -> tuple[str, str]:
    """The measure of a heading and its unit: of `PGA [g]`, `pga_g` or `peak_velocity_cm_s`."""
    bracketed = _BRACKETS.fullmatch(name)
    if bracketed is not None:
        unit = bracketed["unit"].strip()
        return bracketed["name"], "" if unit == "-" else unit
    units = sorted((u for d in _DIMENSIONS for u in UNITS[d] if u), key=len, reverse=True)
    for unit in units:
        end = "_" + unit.lower().translate({ord("/"): "_", ord(" "): "_", ord("^"): None})
        if name.lower().endswith(end):
            return name[: -len(end)], unit
    return name, ""


def _openquake_curves(text: str, source: str) -> list[Curve]:
    """The curves of OpenQuake's CSV, a row a site.

    The first line is a remark with `investigation_time` and `imt`; a column `poe-0.1` has the
    chance that 0.1 is exceeded within that time.
    """
    remark, _, rest = text.partition("\n")
    said = {m[1]: next(filter(None, m.groups()[1:]), "") for m in _QUOTED.finditer(remark)}
    years = _investigation_time(said.get("investigation_time", ""), source)
    if not said.get("imt"):
        raise InputError(source, "imt", NOTHING, "must name the measure in the first line")
    rows = list(csv.DictReader(io.StringIO(rest)))
    levels = [name for name in (rows[0] if rows else ()) if str(name).startswith("poe-")]
    if not levels:
        raise InputError(source, "header", rest[:80], "must have columns poe-INTENSITY, and a row")
    found = []
    for number, row in enumerate(rows, start=1):
        place = " ".join(str(row[name]) for name in ("lon", "lat") if name in row)
        poes = " ".join(str(row[name]) for name in levels)
        imls = " ".join(name.removeprefix("poe-") for name in levels)
        found.append(
            _openquake_curve(said["imt"], imls, poes, years, place, f"row {number}", source)
        )
    return found


def _nrml_curves(text: str, source: str) -> list[Curve]:
    """The curves of NRML: elements `hazardCurve` in `hazardCurves`."""
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(source, "", Said("the file"), f"must be XML ({error})") from None
    found: list[Curve] = []
    for group in root.iterfind(".//{*}hazardCurves"):
        imt = group.get("IMT", "")
        if imt == "SA" and group.get("saPeriod"):
            imt = f"SA({group.get('saPeriod')})"
        years = _investigation_time(group.get("investigationTime", ""), source)
        imls = group.findtext("{*}IMLs", "")
        for curve in group.iterfind("{*}hazardCurve"):
            place = curve.findtext("{*}Point/{*}pos", "").strip()
            poes = curve.findtext("{*}poEs", "")
            where = f"hazardCurve {len(found) + 1}"
            found.append(_openquake_curve(imt, imls, poes, years, place, where, source))
    if not found:
        raise InputError(source, "hazardCurves", NOTHING, "must hold hazard curves of NRML")
    return found


def _investigation_time(text: str, source: str) -> float:
    try:
        years = float(text)
    except ValueError:
        years = np.nan
    if not (np.isfinite(years) and years > 0.0):
        raise InputError(source, "investigation time", text, "must be a number of years above 0")
    return years


def _openquake_curve(
    imt: str, imls: str, poes: str, years: float, place: str, where: str, source: str
) -> Curve:
    """A curve of OpenQuake: its intensities and chances as texts."""
    kind = imt.partition("(")[0]
    if kind not in _OPENQUAKE_UNITS:
        allowed = f"must be a measure whose unit is known: {', '.join(_OPENQUAKE_UNITS)}"
        raise InputError(source, "IMT", imt, allowed)
    try:
        intensity, chance = (np.array(list(map(float, each.split()))) for each in (imls, poes))
    except ValueError:
        raise InputError(source, where, poes, "must be numbers") from None
    if len(intensity) != len(chance):
        allowed = f"must be as many as there are intensities, {len(intensity)}"
        raise InputError(source, where, Said(f"{len(chance)} chances"), allowed)
    rate = _annual(str(years), chance, source, where)
    return Curve(imt, _OPENQUAKE_UNITS[kind], intensity, rate, place)


def parse_age(option: str, text: str) -> float:
    """An age in years, of a text such as "10 ka".

    Raises:
        InputError: It is none, or not above 0.
    """
    try:
        years = parse_quantity(text, Dimension.AGE)
    except ValueError as error:
        raise InputError(option, "", text, str(error)) from None
    if not years > 0.0:
        raise InputError(option, "", text, "must be above 0 years")
    return years
