"""Limit states of a block: which lanes have reached one, and for which lanes that is in doubt.

A lane is in doubt where its own numbers do not tell on which side of the limit it lies:

- its estimated error reaches over the limit: |peak rotation / slenderness angle - limit|, or
  |slide - limit|, is not above the estimate of its error;
- it is `sensitive` (its numbers depend on the time step), and its error reaches over a ratio of 1
  where the limit is overturning, over zero where it is uplift;
- it is `sensitive`, and the table has no estimate of what the limit asks for;
- it has another reservation (`outside_model`, `ambiguous`): its engine left out something that may
  have changed what became of it. Whether it lifted is not in doubt then;
- it had not reached the limit, and its run ended before it had decided (`undecided`): it still
  rocked, or its motion went on.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.errors import NOTHING, InputError
from warprock.model.response import FALLEN_NAMES, Status
from warprock.units import Dimension, allowed_text, parse_quantity

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

UPLIFT, OVERTURNING = "uplift", "overturning"
DEFAULT_LIMITS = (UPLIFT, "0.15", "0.35", OVERTURNING)
"""Limit states of a block: it has lifted, its peak rotation / slenderness angle, it has fallen."""

_RATIO = re.compile(r"peak_rotation_ratio((?:_[1-9])?)$")
_SLIDE = re.compile(r"peak_slide((?:_[1-9])?)_m$")
_OK, _SENSITIVE = (status.name.lower() for status in (Status.OK, Status.SENSITIVE))


@dataclasses.dataclass(frozen=True)
class Limit:
    """A limit state.

    Attributes:
        name: As asked for: uplift, overturning, the ratio, or slide and a length.
        ratio: Peak rotation / slenderness angle that reaches it; None for the others.
        slide: Peak slide that reaches it [m]; None for the others.
    """

    name: str
    ratio: float | None = None
    slide: float | None = None

    @property
    def text(self) -> str:
        """The limit state in words."""
        return self.name if self.ratio is None else f"rotation ratio {self.name}"


def read_limits(texts: Sequence[str], slides: Sequence[str] = ()) -> list[Limit]:
    """Limit states as they were asked for.

    Args:
        texts: Of `--limit`: uplift, overturning, or a peak rotation / slenderness angle.
        slides: Of `--limit-slide`: lengths with a unit, such as "10 mm".

    Raises:
        InputError: One that is none, or asked for twice.
    """
    limits: list[Limit] = []
    for option, text in [("--limit", t) for t in texts] + [("--limit-slide", t) for t in slides]:
        limit = _read_slide(text) if option == "--limit-slide" else _read_limit(text)
        if limit in limits:
            raise InputError(option, "", text, "must be asked for once")
        limits.append(limit)
    return limits


def _read_limit(text: str) -> Limit:
    name = text.strip().lower()
    if name in (UPLIFT, OVERTURNING):
        return Limit(name)
    try:
        ratio = float(name)
    except ValueError:
        ratio = math.nan
    if not 0.0 < ratio < 100.0:
        allowed = (
            f"must be {UPLIFT}, {OVERTURNING} or a peak rotation / slenderness angle above "
            "0 and below 100"
        )
        raise InputError("--limit", "", text, allowed)
    return Limit(name, ratio)


def _read_slide(text: str) -> Limit:
    try:
        slide = parse_quantity(text, Dimension.LENGTH)
    except ValueError:
        slide = math.nan
    if not slide > 0.0:
        allowed = f"must be {allowed_text([Dimension.LENGTH])}, above 0"
        raise InputError("--limit-slide", "", text, allowed)
    return Limit(f"slide {' '.join(text.split())}", slide=slide)


def require_slides(table: pd.DataFrame, source: str, limits: Sequence[Limit]) -> None:
    """Refuses a table without the slides that limit states need.

    Raises:
        InputError: They are missing, or hold something else than numbers.
    """
    if all(limit.slide is None for limit in limits):
        return
    there = _columns(table, _SLIDE)
    if not there:
        allowed = "must be a column: a limit state is a slide"
        raise InputError(source, "peak_slide_m", NOTHING, allowed)
    for name in there:
        if not pd.api.types.is_numeric_dtype(table[name]):
            raise InputError(source, name, str(table[name].dtype), "must be a column of numbers")


def find_reached(lanes: pd.DataFrame, limit: Limit) -> Mask:
    """Whether every lane reached a limit state by its own numbers, shape [lane]."""
    fell = np.asarray(lanes["outcome"].isin(FALLEN_NAMES), dtype=np.bool_)
    if limit.name == OVERTURNING:
        return np.asarray(lanes["outcome"] == "overturned", dtype=np.bool_)
    if limit.name == UPLIFT:
        return np.asarray(np.isfinite(lanes["uplift_time_s"]) | fell, dtype=np.bool_)
    if limit.slide is not None:
        return np.asarray(fell | (_values(lanes, _columns(lanes, _SLIDE)) >= limit.slide).any(1))
    ratios = _values(lanes, _columns(lanes, _RATIO))
    return np.asarray(fell | (ratios.max(axis=1) >= limit.ratio))


def in_doubt(lanes: pd.DataFrame, limit: Limit) -> Mask:
    """Whether a lane's numbers leave open if it reached a limit state, shape [lane].

    See the head of this file.
    """
    doubt = _unsure(lanes, limit)
    if "undecided" in lanes:
        doubt = doubt | (lanes["undecided"].to_numpy(dtype=np.bool_) & ~find_reached(lanes, limit))
    return np.asarray(doubt)


def _unsure(lanes: pd.DataFrame, limit: Limit) -> Mask:
    """Whether a lane's errors and status leave open if it reached a limit state, shape [lane]."""
    fell = np.asarray(lanes["outcome"].isin(FALLEN_NAMES), dtype=np.bool_)
    sensitive = np.asarray(lanes["status"] == _SENSITIVE, dtype=np.bool_)
    other = np.asarray(~lanes["status"].isin([_OK, _SENSITIVE]), dtype=np.bool_)
    if limit.slide is not None:
        value, error = _values(lanes, _columns(lanes, _SLIDE)), slide_errors(lanes)
        return _over(value, error, limit.slide, sensitive, fell) | other
    value, error = _values(lanes, _columns(lanes, _RATIO)), ratio_errors(lanes)
    if limit.name == UPLIFT:
        lifted = np.isfinite(lanes["uplift_time_s"].to_numpy(dtype=np.float64))
        small = ~(value.max(axis=1, initial=0.0) > error.max(axis=1, initial=0.0))
        return np.asarray(sensitive & lifted & ~fell & small)
    if limit.name == OVERTURNING:
        sure = np.where(fell, (value - error > 1.0).any(1), (value + error < 1.0).all(1))
        return np.asarray((sensitive & ~sure) | other)
    assert limit.ratio is not None
    return _over(value, error, limit.ratio, sensitive, fell) | other


def _over(value: Array, error: Array, limit: float, sensitive: Mask, fell: Mask) -> Mask:
    """Where the error of the deciding block reaches over a limit, shape [lane].

    A lane whose error nobody estimated (NaN) is in doubt where it is sensitive.
    """
    sure_above = (value - error > limit).any(axis=1) | (fell & ~sensitive)
    sure_below = (value + error < limit).all(axis=1) & ~fell
    unknown = ~np.isfinite(value + error).all(axis=1)
    doubt = np.where(unknown & ~np.isinf(error).any(axis=1), sensitive, ~(sure_above | sure_below))
    return np.asarray(doubt & ~(fell & ~sensitive))


def ratio_errors(lanes: pd.DataFrame) -> Array:
    """Estimated error of every peak rotation / slenderness angle, shape [lane, block].

    NaN where there is none.
    """
    ends = [match[1] for name in _columns(lanes, _RATIO) if (match := _RATIO.match(name))]
    names = [f"peak_rotation_error{end}_rad" for end in ends]
    angles = [f"slenderness_angle{end}_rad" for end in ends]
    return _values(lanes, names) / _values(lanes, angles)


def slide_errors(lanes: pd.DataFrame) -> Array:
    """Estimated error of every peak slide [m], shape [lane, block]; NaN where there is none."""
    ends = [match[1] for name in _columns(lanes, _SLIDE) if (match := _SLIDE.match(name))]
    return _values(lanes, [f"peak_slide_error{end}_m" for end in ends])


def _columns(lanes: pd.DataFrame, pattern: re.Pattern[str]) -> list[str]:
    return [str(name) for name in lanes.columns if pattern.match(str(name))]


def _values(lanes: pd.DataFrame, names: Sequence[str]) -> Array:
    """Columns side by side, shape [lane, column]; NaN in those that are not there."""
    missing = np.full(len(lanes), np.nan)
    parts = [lanes[n].to_numpy(dtype=np.float64) if n in lanes else missing for n in names]
    return np.stack(parts, axis=1) if parts else np.empty((len(lanes), 0))
