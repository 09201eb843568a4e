"""Batched simulation of rocking rigid blocks: a case becomes lanes, an engine answers for each.

    import warprock as wr

    case = wr.Case(
        block=wr.Block(width="0.5 m", height="2 m", depth="0.5 m", density="2400 kg/m^3"),
        contact=wr.Contact(friction=0.8),
        motion=wr.Motion(
            waveform="sine", control="acceleration", frequency="1 Hz", amplitude="0.4 g", cycles=1
        ),
        run=wr.Times(duration="5 s"),
        sweep=wr.Sweep({"motion.amplitude": wr.Grid("0.2 g", "0.6 g", 21)}),
    )
    run = wr.run(case)
    run.table

Cases: `Case`, `load_case`, `case_names`, and the tables of a case, `Block`, `Contact`, `Start`,
`Motion`, `Times`, `Sweep`, `Grid`, `Sample`, `Uniform`, `Loguniform`, `Lognormal`, `Ensemble`,
`Spectrum`, `Study`, `with_unit`, `save_record`. Commands: `run`, `fragility`, `map`, `spectrum`,
`ida`, `sensitivity`, `sweep`, `compare`, `validate`, `study`, `body`. Bad input is an `InputError`.
Below them lie the functions that they call: `expand_lanes`, `run_case`, `run_batch`, `lane_table`,
`write_run`.

The names are imported when they are first used, so that `import warprock` is cheap.
"""

from __future__ import annotations

import importlib
import pathlib
import sys
import types
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import inspect

    from warprock.api.analyses import fragility, ida, map, sensitivity, spectrum
    from warprock.api.body import body
    from warprock.api.case import Case, load_case
    from warprock.api.comparison import compare
    from warprock.api.found import Found
    from warprock.api.parts import (
        Block,
        Contact,
        Ensemble,
        Grid,
        Lognormal,
        Loguniform,
        Motion,
        Sample,
        Spectrum,
        Start,
        Study,
        Sweep,
        Times,
        Uniform,
    )
    from warprock.api.plain import with_unit
    from warprock.api.record import save_record
    from warprock.api.run import Run, run
    from warprock.api.study import study
    from warprock.api.sweep import sweep
    from warprock.api.validation import validate
    from warprock.case.lanes import LaneSet, expand_lanes
    from warprock.case.text import case_names
    from warprock.engines import ENGINES
    from warprock.errors import InputError
    from warprock.model.lanes import Lanes
    from warprock.model.response import FIELDS, Outcome, Response, SampleTimes, Status
    from warprock.running.batch import run_batch
    from warprock.running.case_run import CaseRun, run_case
    from warprock.running.lane_table import lane_table
    from warprock.running.results import write_run

__version__ = "0.1.0"

_HOME = {
    "ENGINES": "engines",
    "FIELDS": "model.response",
    "Block": "api.parts",
    "Case": "api.case",
    "CaseRun": "run.case_run",
    "Contact": "api.parts",
    "Ensemble": "api.parts",
    "Found": "api.found",
    "Grid": "api.parts",
    "InputError": "errors",
    "LaneSet": "case.lanes",
    "Lanes": "model.lanes",
    "Lognormal": "api.parts",
    "Loguniform": "api.parts",
    "Motion": "api.parts",
    "Outcome": "model.response",
    "Response": "model.response",
    "Run": "api.run",
    "Sample": "api.parts",
    "SampleTimes": "model.response",
    "Spectrum": "api.parts",
    "Start": "api.parts",
    "Status": "model.response",
    "Study": "api.parts",
    "Sweep": "api.parts",
    "Times": "api.parts",
    "Uniform": "api.parts",
    "body": "api.body",
    "case_names": "case.text",
    "compare": "api.comparison",
    "expand_lanes": "case.lanes",
    "fragility": "api.analyses",
    "ida": "api.analyses",
    "lane_table": "run.lane_table",
    "load_case": "api.case",
    "map": "api.analyses",
    "run": "api.run",
    "run_batch": "run.batch",
    "run_case": "run.case_run",
    "save_record": "api.record",
    "sensitivity": "api.analyses",
    "spectrum": "api.analyses",
    "study": "api.study",
    "sweep": "api.sweep",
    "validate": "api.validation",
    "with_unit": "api.plain",
    "write_run": "run.results",
}
"""Public name -> the module that has it, below `warprock`."""

__all__ = [
    "ENGINES",
    "FIELDS",
    "Block",
    "Case",
    "CaseRun",
    "Contact",
    "Ensemble",
    "Found",
    "Grid",
    "InputError",
    "LaneSet",
    "Lanes",
    "Lognormal",
    "Loguniform",
    "Motion",
    "Outcome",
    "Response",
    "Run",
    "Sample",
    "SampleTimes",
    "Spectrum",
    "Start",
    "Status",
    "Study",
    "Sweep",
    "Times",
    "Uniform",
    "body",
    "case_names",
    "compare",
    "expand_lanes",
    "fragility",
    "ida",
    "lane_table",
    "load_case",
    "map",
    "run",
    "run_batch",
    "run_case",
    "save_record",
    "sensitivity",
    "spectrum",
    "study",
    "sweep",
    "validate",
    "with_unit",
    "write_run",
]

# The checkout bridge: an installed package holds kernels/ and cases/; a checkout keeps them next
# to warprock/, where `warprock.kernels` and `warprock.cases` are found through this path.
_PACKAGE = pathlib.Path(__file__).parent
if not (_PACKAGE / "kernels").is_dir():
    __path__.append(str(_PACKAGE.parent))


class _RoomAndCommand(types.ModuleType):
    """A room that has the name of a command: called, it is the command.

    `warprock.run` holds the modules of the room `run`, and `warprock.run(case)` runs a case.
    """

    def _command(self) -> Any:
        name = self.__name__.rpartition(".")[2]
        return getattr(importlib.import_module(f"warprock.{_HOME[name]}"), name)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self._command()(*args, **kwargs)

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]
        import inspect

        return inspect.getdoc(self._command())

    @property
    def __signature__(self) -> inspect.Signature:
        import inspect

        return inspect.signature(self._command())


class _Front(types.ModuleType):
    """This module: where Python binds a room to it that has the name of a command, both are one."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _HOME and isinstance(value, types.ModuleType):
            value.__class__ = _RoomAndCommand
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Front


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if (_PACKAGE / name).is_dir():
        return importlib.import_module(f"{__name__}.{name}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
