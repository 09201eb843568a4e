"""The [study] table of a case: settings of engines that its lanes are run with, one at a time.

The case's own settings of an engine are its baseline. Every run of a study changes one setting of
one engine away from it; all other settings stay.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from warprock.settings.engines import SETTINGS

if TYPE_CHECKING:
    pass

Number = float | int


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
    fields = {field.name: field for field in dataclasses.fields(SETTINGS[engine])}
    return str(fields[name].metadata["unit"])
