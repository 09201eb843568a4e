"""Arguments that several functions take together, each declared once: a hazard, and a ladder.

A record names them for type checkers (`Unpack`). The function below it takes them: its signature
has their defaults, and its docstring says what they are. `listing` shows them as arguments of each
function that takes the record; the options of the commands are made of them, too.
"""

from __future__ import annotations

import os
from typing import TypedDict, TypeVar, cast

import pandas as pd

from warprock.analysis.hazard import Hazard
from warprock.analysis.hazard_files import read_hazard, read_power_law
from warprock.analysis.incremental import Ladder
from warprock.api.values import Column, Quantity
from warprock.api.work import HowHeld
from warprock.arguments import at_the_door
from warprock.errors import NOTHING, InputError

File = pd.DataFrame | str | os.PathLike[str]
"""The path of a file, or its table."""

Record = TypeVar("Record")


class HazardAsked(TypedDict, total=False):
    """A hazard: a file or a table, or a power law; see `hazard_of`."""

    hazard: File | None
    k0: float | None
    k: float | None
    at: Quantity
    im: Column | None


@at_the_door
def hazard_of(
    *,
    hazard: File | None = None,
    k0: float | None = None,
    k: float | None = None,
    at: Quantity = "1 g",
    im: Column | None = None,
) -> Hazard:
    """The hazard that is asked for.

    Args:
        hazard: Hazard curve: a table, or a CSV file, one of OpenQuake or NRML; #2 behind it takes
            the second curve of a file. Or a shipped one: usgs-2008-los-angeles, ...
        k0: How often in a year the intensity `at` is exceeded, of a hazard that is a power law.
        k: Exponent of a hazard that is a power law [-].
        at: Intensity of `k0`, with its unit.
        im: Column of the hazard's intensity measure, or PGA, PGV [default: what the file says].

    Raises:
        InputError: Both or neither are asked for, or one cannot be used.
    """
    if k0 is None and k is None:
        if hazard is None:
            allowed = "must be a file, or have --k0 and --k instead"
            raise InputError("--hazard", "", NOTHING, allowed)
        return read_hazard(hazard, im)
    if hazard is not None:
        name, given = ("--k", k) if k0 is None else ("--k0", k0)
        raise InputError(name, "", given, "must be left out where --hazard is given")
    if k0 is None or k is None:
        raise InputError("--k0" if k0 is None else "--k", "", NOTHING, "must be given, too")
    return read_power_law(k0, k, at, im or "PGA")


class LadderAsked(TypedDict, total=False):
    """Factors on the motion that all lanes run at first; see `ladder_of`."""

    from_: float
    to: float
    count: int


@at_the_door
def ladder_of(accuracy: float, *, from_: float = 0.1, to: float = 10.0, count: int = 21) -> Ladder:
    """The factors on its motion at which each lane is tried.

    Args:
        accuracy: Width of a bracket over its least factor at which it is narrow enough [-].
        from_: Least factor on a motion [-].
        to: Greatest factor [-].
        count: Factors of the first stage.

    Raises:
        InputError: A number is out of bounds.
    """
    ladder = Ladder(from_, to, count, accuracy)
    ladder.judge()
    return ladder


class LadderHow(LadderAsked, HowHeld):
    """A ladder, and how its lanes are run."""


class HazardLadder(HazardAsked, LadderHow):
    """A hazard, a ladder, and how its lanes are run."""


def taken(asked: object, record: type[Record]) -> Record:
    """The arguments of one record among those of several.

    Args:
        asked: The arguments of several records.
        record: The one record.
    """
    names = record.__annotations__
    given = cast("dict[str, object]", asked)
    return cast("Record", {name: value for name, value in given.items() if name in names})
