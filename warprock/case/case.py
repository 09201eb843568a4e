"""A case as the rest of warprock takes it: judged, in SI units and rad."""

from __future__ import annotations

import dataclasses
import math
import pathlib
from collections.abc import Mapping
from typing import Any

from warprock.case.axes import LABEL, Axis, Numbers, axis_shape
from warprock.case.case_file import CaseFile
from warprock.case.check import CheckSpec, PosesCheck
from warprock.case.ensemble import Ensemble
from warprock.case.run import DURATION
from warprock.case.settings import ENGINES, PEERS, read_settings
from warprock.case.study import Study
from warprock.case.text import source_name
from warprock.case.writing import toml_text
from warprock.model.response import SampleTimes
from warprock.model.words import lane_count_text


@dataclasses.dataclass(frozen=True, repr=False)
class Case:
    """A case whose every value has been judged.

    Attributes:
        name: Name of the shipped case, or of the folder (or file) it was read from.
        file: The case file, as errors name it.
        folder: Folder that relative paths in the case start from; None for a shipped case.
        raw: The case as written, overrides included; JSON can hold it.
        tables: The tables of the case, in SI units and rad.
        axes: Its sweep, first axis slowest.
        overridden: Keys that overrides changed.
        ensemble: What the members of every cell of the sweep differ by; None without members.
        study: Settings that the case asks its engines to be run with; None without a study.
    """

    name: str
    file: str
    folder: pathlib.Path | None
    raw: Mapping[str, Any]
    tables: CaseFile
    axes: tuple[Axis, ...]
    overridden: frozenset[str] = frozenset()
    ensemble: Ensemble | None = None
    study: Study | None = None

    def __repr__(self) -> str:
        return f"<case {self.name}: {lane_count_text(self.lane_count)}>"

    def to_toml(self) -> str:
        """The text of a case file that reads as this case.

        Relative paths in it start from the folder of the case.
        """
        return toml_text(self.raw)

    @property
    def title(self) -> str:
        """One line that says what the case is."""
        return self.tables.title

    @property
    def source_text(self) -> str:
        """Where the case's numbers come from."""
        return self.tables.source

    @property
    def checks(self) -> tuple[CheckSpec, ...]:
        """What the case expects of its engines."""
        return self.tables.check

    @property
    def sample_times(self) -> SampleTimes:
        """Length of the longest run and sampling of its histories."""
        interval = self.tables.run.sample_interval
        places = self.observed_poses is not None and interval is not None
        return SampleTimes(max(self.durations), interval, places=places)

    @property
    def observed_poses(self) -> str | None:
        """Path of the file with poses that were observed; None of a case without such a check."""
        files = (check.file for check in self.checks if isinstance(check, PosesCheck))
        return next(files, None)

    @property
    def durations(self) -> tuple[float, float]:
        """Length of the shortest and of the longest run of a lane [s]."""
        for axis in self.axes:
            column = axis.columns.get(DURATION)
            if isinstance(column, Numbers):
                return float(column.values.min()), float(column.values.max())
        return self.tables.run.duration, self.tables.run.duration

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the sweep's axes, first one slowest; their product is the number of cells."""
        return axis_shape(self.axes)

    @property
    def members(self) -> int:
        """Lanes in a cell of the sweep: 1 without an ensemble."""
        return 1 if self.ensemble is None else self.ensemble.members

    @property
    def lane_count(self) -> int:
        """Number of lanes that the case expands to: its cells times their members."""
        return math.prod(self.shape) * self.members

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the label columns."""
        keys = (key for axis in self.axes for key in axis.columns)
        return tuple(key.removeprefix(LABEL) for key in keys if key.startswith(LABEL))

    def engine_settings(self, engine: str) -> Any:
        """Settings of an engine: the case's own, defaults otherwise.

        Args:
            engine: Name of the engine.

        Returns:
            The engine's settings dataclass.

        Raises:
            InputError: No engine has that name, or the case's table is wrong.
        """
        return read_settings(ENGINES, self.tables.engines, engine, self.source_of)

    def peer_settings(self, program: str) -> Any:
        """Settings of a program beside the engines, as `engine_settings` gives an engine's."""
        return read_settings(PEERS, self.tables.peers, program, self.source_of)

    def source_of(self, key: str) -> str:
        """What an error about a key names as its source: the file, or -s for an override."""
        return source_name(key, self.file, self.raw, self.overridden)
