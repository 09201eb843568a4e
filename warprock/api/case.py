"""A case as a Python object: made of blocks, motions and sweeps, of a dict, a table or a file."""

from __future__ import annotations

import copy
import dataclasses
import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Self

from warprock.api.names import python_names
from warprock.api.plain import plain
from warprock.arguments import at_the_door
from warprock.case.axes import LABEL
from warprock.case.case import Case as JudgedCase
from warprock.case.lanes import expand_lanes
from warprock.case.load import Overrides, build_case, override_tables
from warprock.case.load import load_case as load_judged
from warprock.case.text import require_shallow

if TYPE_CHECKING:
    import pandas as pd

    from warprock.api.parts import Part
    from warprock.model.scene import SceneKind

Given = Mapping[str, Any]
"""A table of a case: one of `parts`, or a dict with the same keys."""

SOURCE = "Case"
"""What errors name as the source of a case that no file holds."""

NAME, TITLE, ORIGIN = "case", "A case made in Python", "made in Python"
"""Name, title and source of a case that has none."""


class Case(JudgedCase):
    """A case: what is simulated, from the sizes of the blocks to the sweep that makes its lanes.

    It has the tables and keys of a case file (`warprock keys` lists them) and is judged by the same
    model, in the same words. Quantities are text with a unit: "0.5 m", "0.35 g", "3 Hz", "10 deg".
    `load_case` reads one from a file, `Case.from_table` takes a pandas table, one row a lane, and
    `Case.from_dict` the tables of a file. A case does not change: `override` gives another one.

    Args:
        block: One `Block`; a list of them is a stack, the lowest first.
        assembly: `Assembly` of many blocks with joints, in the place of a block.
        contact: `Contact`: friction, and what an impact leaves.
        transverse_wall: `TransverseWall` that the block leans against; without, it has none.
        tie: One `Tie`, or a list of them.
        top_load: `TopLoad` that rests on the block; nothing rests on it without.
        frame: `Frame` of which the block is a column.
        strip: `Strip` of wall between two floors that the block is.
        ground: `Ground` below the block that gives way; rigid without.
        run: `Times`: length of the run, sampling of histories.
        motion: `Motion` of the base; still without.
        support: `Support`: a floor or an isolator between the motion and the block.
        start: `Start`: how a single block is released.
        sweep: A `Sweep`, or a list of sweeps that are crossed, the first one slowest; a sweep may
            be a pandas table.
        sample: `Sample`: lanes whose inputs are drawn.
        ensemble: `Ensemble`: every cell of the sweep many times over.
        spectrum: `Spectrum`: blocks of many sizes.
        study: `Study`: settings of engines, one away from the case's own at a time.
        model: "planar" or "spatial"; None lets the scene say.
        engines: Settings by engine: `{"event": {"time_step": 1e-3}}`.
        peers: Settings by program that `compare` runs beside the engines.
        check: What the case states of its own results, a list of tables.
        title: One line that says what the case is; its name where None.
        source: Where its numbers come from.
        name: What its results are called.
        folder: Folder that relative paths of records start from; None is where Python runs.

    Attributes:
        raw: The tables as they were written.
        shape: Lengths of the sweep's axes, first one slowest.
        lane_count: Lanes that the case makes.

    Raises:
        InputError: Something cannot be used: an unknown key, a number without its unit or out of
            its bounds, or values that do not fit together.

    Example:
        >>> import warprock as wr
        >>> case = wr.Case(
        ...     block=wr.Block(width="0.5 m", height="2 m", depth="0.5 m", density="2400 kg/m^3"),
        ...     contact=wr.Contact(friction=0.8),
        ...     motion=wr.Motion(
        ...         waveform="sine", control="acceleration", frequency="1 Hz", amplitude="0.4 g",
        ...         cycles=1,
        ...     ),
        ...     run=wr.Times(duration="5 s"),
        ...     sweep=wr.Sweep({"motion.amplitude": wr.Grid("0.2 g", "0.6 g", 3)}),
        ...     name="cabinet",
        ... )
        >>> case
        Case(cabinet: 3 lanes over motion.amplitude)
        >>> print(case.to_toml().splitlines()[-1])
        "motion.amplitude" = { from = "0.2 g", to = "0.6 g", count = 3 }
    """

    @at_the_door
    def __init__(
        self,
        *,
        block: Given | Sequence[Given] | None = None,
        assembly: Given | None = None,
        contact: Given | None = None,
        transverse_wall: Given | None = None,
        tie: Given | Sequence[Given] = (),
        top_load: Given | None = None,
        frame: Given | None = None,
        strip: Given | None = None,
        ground: Given | None = None,
        run: Given | None = None,
        motion: Given | None = None,
        support: Given | None = None,
        start: Given | None = None,
        sweep: Given | pd.DataFrame | Sequence[Given | pd.DataFrame] = (),
        sample: Given | None = None,
        ensemble: Given | None = None,
        spectrum: Given | None = None,
        study: Given | None = None,
        model: str | None = None,
        engines: Mapping[str, Given] | None = None,
        peers: Mapping[str, Given] | None = None,
        check: Sequence[Given] = (),
        title: str | None = None,
        source: str = ORIGIN,
        name: str = NAME,
        folder: str | os.PathLike[str] | None = None,
    ) -> None:
        with python_names():
            tables = {
                "title": title or _title(name),
                "source": source,
                "model": model,
                "block": block,
                "assembly": assembly,
                "contact": contact,
                "transverse_wall": transverse_wall,
                "top_load": top_load,
                "frame": frame,
                "strip": strip,
                "ground": ground,
                "tie": ([tie] if isinstance(tie, Mapping) else list(tie)) or None,
                "start": start,
                "motion": motion,
                "support": support,
                "run": run,
                "sample": sample,
                "ensemble": ensemble,
                "spectrum": spectrum,
                "engines": engines,
                "peers": peers,
                "study": study,
                "sweep": _sweeps(sweep) or None,
                "check": check or None,
            }
            self._hold(_judged(tables, name, folder))

    @classmethod
    @at_the_door
    def from_dict(
        cls,
        tables: Mapping[str, Any],
        *,
        name: str = NAME,
        folder: str | os.PathLike[str] | None = None,
    ) -> Self:
        """A case from the tables of a case file, as a dict.

        Args:
            tables: What a case file holds: `{"block": {"width": "0.5 m", ...}, ...}`; a title and
                a source may be left out.
            name: What its results are called.
            folder: Folder that relative paths of records start from; None is where Python runs.

        Raises:
            InputError: Something in it cannot be used.

        Example:
            >>> import warprock as wr
            >>> case = wr.load_case("free-b0")
            >>> wr.Case.from_dict(case.raw) == case
            True
        """
        with python_names():
            filled = {"title": _title(name), "source": ORIGIN, **tables}
            return cls.of(_judged(filled, name, folder))

    @classmethod
    @at_the_door
    def from_table(cls, table: pd.DataFrame, **tables: Any) -> Self:
        """A case with a lane for each row of a table.

        Args:
            table: One row a lane; columns as in `Sweep`. What it leaves out is the same for all.
            tables: The other arguments of `Case`.

        Raises:
            InputError: A column that is no key, an empty cell, or a value that cannot be used.

        Example:
            >>> import pandas as pd
            >>> import warprock as wr
            >>> blocks = pd.DataFrame({"width_m": [0.4, 0.5], "height_m": [1.0, 1.8]})
            >>> wr.Case.from_table(
            ...     blocks,
            ...     block=wr.Block(depth="0.5 m", density="1 t/m^3"),
            ...     contact=wr.Contact(friction=1.0),
            ...     start=wr.Start(rotation="2 deg"),
            ...     run=wr.Times(duration="5 s"),
            ... )
            Case(case: 2 lanes over block.width, block.height)
        """
        from warprock.api.parts import Sweep

        return cls(**{**tables, "sweep": [Sweep(table), *_sweeps(tables.get("sweep", ()))]})

    @at_the_door
    def override(self, changes: Overrides) -> Self:
        """Another case, some keys of which have other values.

        Args:
            changes: Values by dotted key, `{"block.height": "5.5 m"}`, or texts as of `-s`. One of
                a key that the case sweeps replaces the whole axis it lies on.

        Raises:
            InputError: A change that cannot be used.

        Example:
            >>> import warprock as wr
            >>> wr.load_case("free-b0").override({"block.height": "4 m"}).lane_count
            1
        """
        with python_names():
            raw = copy.deepcopy(dict(self.raw))
            changed = override_tables(raw, _values(changes))
            return self.of(
                build_case(self.name, self.file, self.folder, raw, self.overridden | changed)
            )

    @property
    def judged(self) -> JudgedCase:
        """The case as the rooms below take it."""
        fields = dataclasses.fields(JudgedCase)
        return JudgedCase(**{field.name: getattr(self, field.name) for field in fields})

    def lanes(self) -> pd.DataFrame:
        """The inputs of all lanes, one row a lane.

        Returns:
            Labels, then inputs with their units in the names of the columns.

        Raises:
            InputError: A combination of values that no engine could use.

        Example:
            >>> import warprock as wr
            >>> wr.load_case("free-b0").lanes()["height_m"].tolist()
            [5.0, 5.5]
        """
        with python_names():
            return expand_lanes(self).inputs

    def scene(self) -> SceneKind:
        """What the case requires of an engine: blocks, space, kind of motion."""
        with python_names():
            return expand_lanes(self, range(1)).scene

    @classmethod
    def of(cls, judged: JudgedCase) -> Self:
        """The case that the rooms below made."""
        case = cls.__new__(cls)
        case._hold(judged)
        return case

    def _hold(self, judged: JudgedCase) -> None:
        for field in dataclasses.fields(JudgedCase):
            object.__setattr__(self, field.name, getattr(judged, field.name))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, JudgedCase) and self.raw == other.raw

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        swept = [key for axis in self.axes for key in axis.columns if not key.startswith(LABEL)]
        lanes = f"{self.lane_count:,} lane{'s' * (self.lane_count != 1)}"
        return f"Case({self.name}: {lanes}{' over ' * bool(swept)}{', '.join(swept)})"

    def _repr_html_(self) -> str:
        """The case as a notebook shows it: its title, its lanes, and its file to unfold."""
        import html

        text = html.escape(self.to_toml())
        return (
            f"<p><b>{html.escape(self.title)}</b><br>{html.escape(repr(self))}</p>"
            f"<details><summary>case.toml</summary><pre>{text}</pre></details>"
        )


AnyCase = JudgedCase | Mapping[str, Any] | str | os.PathLike[str]
"""A case, the tables of one, the name of a shipped one, or the path of a file or folder."""


@at_the_door
def load_case(name_or_path: str | os.PathLike[str], overrides: Overrides = ()) -> Case:
    """Reads a case file and judges every value in it.

    Args:
        name_or_path: Name of a shipped case (`case_names` lists them), or path of a case file or
            of its folder.
        overrides: Values by dotted key, `{"block.height": "5.5 m"}`, or texts as of `-s`. One of a
            key that the case sweeps replaces the whole axis it lies on.

    Raises:
        InputError: No such case, or something in it cannot be used.

    Example:
        >>> import warprock as wr
        >>> wr.load_case("free-b0", {"start.rotation_ratio": 0.3})
        Case(free-b0: 2 lanes over block.height)
    """
    with python_names():
        return Case.of(load_judged(name_or_path, _values(overrides)))


def any_case(case: AnyCase, overrides: Overrides = ()) -> Case:
    """The case that is meant, with overrides.

    Raises:
        InputError: There is no such case, or something in it cannot be used.
    """
    if isinstance(case, str | os.PathLike):
        return load_case(case, overrides)
    if isinstance(case, JudgedCase):
        found = case if isinstance(case, Case) else Case.of(case)
    else:
        found = Case.from_dict(case)
    return found.override(overrides) if overrides else found


def _title(name: str) -> str:
    return TITLE if name == NAME else name


def _values(overrides: Overrides) -> Overrides:
    return plain(overrides) if isinstance(overrides, Mapping) else overrides


def _sweeps(given: Any) -> list[Part]:
    """The sweeps of a case, whether one or several were given."""
    from warprock.api.parts import Part, Sweep

    several = isinstance(given, list | tuple)
    each = given if several else [given]
    return [one if isinstance(one, Part) else Sweep(one) for one in each]


def _judged(
    tables: Mapping[str, Any], name: str, folder: str | os.PathLike[str] | None
) -> JudgedCase:
    raw: dict[str, Any] = plain(tables)
    blocks = raw.get("block")
    if isinstance(blocks, list):
        raw["block"] = {str(number): block for number, block in enumerate(blocks, 1)}
    require_shallow(raw, SOURCE)
    start = pathlib.Path.cwd() if folder is None else pathlib.Path(folder).resolve()
    return build_case(name, SOURCE, start, raw)
