"""The [study] table of a case: settings of engines that its lanes are run with, one at a time.

The case's own settings of an engine are its baseline. Every run of a study changes one setting of
one engine away from it; all other settings stay.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from warprock.case.case_file import CaseFile
from warprock.case.settings import ENGINES, read_settings
from warprock.case.validation import KeyedError, SourceOf, Table, below, validated
from warprock.case.value_kinds import OtherKey
from warprock.errors import NOTHING, Said, did_you_mean, list_allowed
from warprock.settings.engines import SETTINGS, declared_settings

Number = float | int

_FEWEST = 2
"""Values of a setting in a list: the baseline and another."""


@dataclasses.dataclass(frozen=True)
class Variation:
    """One run of a study.

    Attributes:
        engine: Name of the engine.
        setting: Field of its settings.
        value: Value of that field, in the field's unit.
        baseline: Whether that is the case's own value.
        settings: All settings of the run, the engine's dataclass.
    """

    engine: str
    setting: str
    value: Number
    baseline: bool
    settings: Any

    @property
    def unit(self) -> str:
        """Unit of the setting."""
        return setting_unit(self.engine, self.setting)


@dataclasses.dataclass(frozen=True)
class Study:
    """What a case says about the settings of its engines.

    Attributes:
        baseline: Engine -> the case's own settings of it, in the order of the case.
        values: Engine -> setting -> its values, in the order of the case; a setting that an engine
            does not have is not there.
    """

    baseline: Mapping[str, Any]
    values: Mapping[str, Mapping[str, tuple[Number, ...]]]

    @property
    def engines(self) -> tuple[str, ...]:
        """Engines that the study is for."""
        return tuple(self.values)

    def lacks(self, engine: str) -> list[str]:
        """Settings of the study that an engine does not have."""
        every = dict.fromkeys(name for values in self.values.values() for name in values)
        return [name for name in every if name not in self.values[engine]]

    def variations(self, engine: str) -> list[Variation]:
        """The runs of one engine, setting by setting; the baseline is among those of each."""
        own = self.baseline[engine]
        return [
            Variation(
                engine=engine,
                setting=name,
                value=value,
                baseline=value == getattr(own, name),
                settings=dataclasses.replace(own, **{name: value}),
            )
            for name, values in self.values[engine].items()
            for value in values
        ]

    def plan(self, engine: str) -> dict[str, Any]:
        """What will be run of one engine, ready for JSON."""
        return {
            "engine": engine,
            "runs": len({variation.settings for variation in self.variations(engine)}),
            "vary": [
                {
                    "setting": name,
                    "unit": setting_unit(engine, name),
                    "values": list(values),
                    "baseline": getattr(self.baseline[engine], name),
                }
                for name, values in self.values[engine].items()
            ],
            "lacks": self.lacks(engine),
        }


def setting_unit(engine: str, name: str) -> str:
    """Unit of a setting of an engine."""
    return declared_settings(SETTINGS[engine])[name].unit


_ENGINES_MUST = f"must be a list of engines ({', '.join(SETTINGS)})"
_VARY_MUST = "must be a table: a list of values for each setting that is varied"


def _read_engines(got: object) -> tuple[str, ...]:
    if not isinstance(got, list) or not got:
        raise KeyedError((), got, _ENGINES_MUST)
    for number, engine in enumerate(got):
        if not isinstance(engine, str) or engine not in SETTINGS:
            allowed = f"must be one of {', '.join(SETTINGS)}{did_you_mean(engine, SETTINGS)}"
            raise KeyedError(number, engine, allowed)
        if engine in got[:number]:
            raise KeyedError(number, engine, "must not be there twice")
    return tuple(got)


def _read_vary(got: object) -> Mapping[str, object]:
    if not isinstance(got, Mapping) or not got:
        raise KeyedError((), got, _VARY_MUST)
    return got


class StudyTable(Table):
    """The engines of a study, and the settings that are varied."""

    place: ClassVar[str] = "study"

    engines: Annotated[
        tuple[str, ...],
        OtherKey("the engines that are run", "list of engines", _read_engines, _ENGINES_MUST),
    ]
    vary: Annotated[
        dict[str, Any],
        OtherKey(
            "the values of each setting, the case's own among them",
            "table of settings and lists",
            _read_vary,
            _VARY_MUST,
        ),
    ]


def read_study(
    table: object, tables: CaseFile, *, ensemble: bool, file: str, source_of: SourceOf
) -> Study:
    """Reads and judges the [study] table of a case.

    A list in the file must hold the case's own value. One that an override set, or whose own value
    an override set, is completed with it, so that `-s` can ask for other values alone.

    Args:
        table: The table as it was written.
        tables: The other tables of the case.
        ensemble: Whether it has an ensemble as well.
        file: The case file.
        source_of: What errors name as their source: the file, or -s.

    Raises:
        KeyedError: An unknown key, engine or setting, a value that its engine would refuse, fewer
            than two values, a list without the case's own value, or a case whose lanes cannot be
            held against Housner's.
    """
    with below("study"):
        read = validated(StudyTable, table)
    _refuse_scene(tables, ensemble=ensemble)
    for name, got in read.vary.items():
        _refuse_setting(read.engines, name, got)
    baseline = {
        engine: read_settings(ENGINES, tables.engines, engine, source_of) for engine in read.engines
    }
    values = {}
    for engine, own in baseline.items():
        varied = [name for name in read.vary if name in declared_settings(type(own))]
        values[engine] = {name: _read_values(engine, own, name, read.vary[name]) for name in varied}
        if not varied:
            allowed = f"must have a setting that is varied ({', '.join(read.vary)})"
            raise KeyedError(("study", "engines"), engine, allowed)
    for engine, own in baseline.items():
        for name, listed_values in values[engine].items():
            value, key = getattr(own, name), f"study.vary.{name}"
            own_key = f"engines.{engine}.{name}"
            if value in listed_values:
                continue
            if source_of(key) == source_of(own_key) == file:
                allowed = f"must hold the case's own value, {value:g} ({own_key})"
                raise KeyedError(key, read.vary[name], allowed)
            values[engine][name] = (*listed_values, value)
    return Study(baseline, values)


def _refuse_scene(tables: CaseFile, *, ensemble: bool) -> None:
    """Refuses lanes that cannot be held against Housner's, sample by sample."""
    if ensemble:
        raise KeyedError("study", Said("a study"), "must not be beside [ensemble]")
    if tables.stacked:
        allowed = "must not be on a stack: runs are held against Housner's single block"
        raise KeyedError("study", Said("a study"), allowed)
    if tables.run.sample_interval is None:
        raise KeyedError("run.sample_interval", NOTHING, "must be given for [study]")


def _refuse_setting(engines: tuple[str, ...], name: str, got: object) -> None:
    """Refuses a setting that no engine of the study has, and values that are no list."""
    declared = {engine: declared_settings(SETTINGS[engine]) for engine in SETTINGS}
    known = tuple(dict.fromkeys(field for engine in engines for field in declared[engine]))
    if name not in known:
        others = [engine for engine in SETTINGS if name in declared[engine]]
        verb = "has" if len(others) == 1 else "have"
        hint = f"; {', '.join(others)} {verb} it" if others else did_you_mean(name, known)
        allowed = f"must be a setting of {' or '.join(engines)} ({list_allowed(name, known)}){hint}"
        raise KeyedError(("study", "vary", name), got, allowed)
    if not isinstance(got, list) or len(got) < _FEWEST:
        allowed = f"must be a list of at least {_FEWEST} values"
        raise KeyedError(("study", "vary", name), got, allowed)


def _read_values(engine: str, own: Any, name: str, got: list[object]) -> tuple[Number, ...]:
    """The values of one setting of one engine as they are listed."""
    declared, values = declared_settings(type(own))[name], []
    for number, each in enumerate(got):
        try:
            value = declared.value(each)
        except ValueError as error:
            raise KeyedError(("study", "vary", name, number), each, f"{error} ({engine})") from None
        if value in values:
            raise KeyedError(("study", "vary", name, number), each, "must not be there twice")
        values.append(value)
    return tuple(values)
