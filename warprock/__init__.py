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

Cases: `Case`, `load_case`, `case_names`, and the tables of a case, `Block`, `Assembly`, `Contact`,
`TransverseWall`, `Tie`, `TopLoad`, `Frame`, `Strip`, `Ground`, `Start`, `Motion`, `Support`,
`Times`, `Sweep`, `Grid`, `Sample`, `Uniform`, `Loguniform`, `Lognormal`, `Ensemble`, `Spectrum`,
`Study`, `with_unit`. Records that are written: `save_record`, `import_records`, `generate_record`.
Commands: `run`, `verdict`, `brief`, `fragility`, `predictors`,
`risk`, `measures`, `map`, `spectrum`, `ida`, `sensitivity`, `capacity`, `limit`, `sweep`,
`compare`, `validate`, `study`, `body`, `identify`, `trade`, `stability`, `bench`, `list`, `keys`,
`explain`, `records`, `doctor`. Bad input is an `InputError`. Below them lie the functions that they
call: `expand_lanes`, `run_case`, `run_batch`, `lane_table`, `write_run`.

The names are imported when they are first used, so that `import warprock` is cheap.
"""

from __future__ import annotations

import importlib
import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    __version__: str
    from warprock.api.analyses.fragility import fragility as fragility
    from warprock.api.analyses.ida import ida as ida
    from warprock.api.analyses.map import map as map
    from warprock.api.analyses.predictors import predictors as predictors
    from warprock.api.analyses.risk import risk as risk
    from warprock.api.analyses.sensitivity import sensitivity as sensitivity
    from warprock.api.analyses.spectrum import spectrum as spectrum
    from warprock.api.bench import bench as bench
    from warprock.api.body import body as body
    from warprock.api.brief import brief as brief
    from warprock.api.capacity import capacity as capacity
    from warprock.api.case import Case as Case
    from warprock.api.case import load_case as load_case
    from warprock.api.choices import list as list
    from warprock.api.comparison import compare as compare
    from warprock.api.doctor import doctor as doctor
    from warprock.api.explanation import explain as explain
    from warprock.api.found import Found as Found
    from warprock.api.identification import identify as identify
    from warprock.api.keys import keys as keys
    from warprock.api.limit import limit as limit
    from warprock.api.measures import measures as measures
    from warprock.api.parts import Assembly as Assembly
    from warprock.api.parts import Block as Block
    from warprock.api.parts import Contact as Contact
    from warprock.api.parts import Ensemble as Ensemble
    from warprock.api.parts import Frame as Frame
    from warprock.api.parts import Grid as Grid
    from warprock.api.parts import Ground as Ground
    from warprock.api.parts import Lognormal as Lognormal
    from warprock.api.parts import Loguniform as Loguniform
    from warprock.api.parts import Motion as Motion
    from warprock.api.parts import Sample as Sample
    from warprock.api.parts import Spectrum as Spectrum
    from warprock.api.parts import Start as Start
    from warprock.api.parts import Strip as Strip
    from warprock.api.parts import Study as Study
    from warprock.api.parts import Support as Support
    from warprock.api.parts import Sweep as Sweep
    from warprock.api.parts import Tie as Tie
    from warprock.api.parts import Times as Times
    from warprock.api.parts import TopLoad as TopLoad
    from warprock.api.parts import TransverseWall as TransverseWall
    from warprock.api.parts import Uniform as Uniform
    from warprock.api.plain import with_unit as with_unit
    from warprock.api.record_files import generate_record as generate_record
    from warprock.api.record_files import import_records as import_records
    from warprock.api.records import records as records
    from warprock.api.records import save_record as save_record
    from warprock.api.run import Run as Run
    from warprock.api.run import run as run
    from warprock.api.stability import stability as stability
    from warprock.api.study import study as study
    from warprock.api.sweep import sweep as sweep
    from warprock.api.trade import trade as trade
    from warprock.api.validation import validate as validate
    from warprock.api.verdict import verdict as verdict
    from warprock.case.lanes import LaneSet as LaneSet
    from warprock.case.lanes import expand_lanes as expand_lanes
    from warprock.case.text import case_names as case_names
    from warprock.engines import ENGINES as ENGINES
    from warprock.errors import InputError as InputError
    from warprock.model.lanes import Lanes as Lanes
    from warprock.model.response import FIELDS as FIELDS
    from warprock.model.response import Outcome as Outcome
    from warprock.model.response import Response as Response
    from warprock.model.response import SampleTimes as SampleTimes
    from warprock.model.response import Status as Status
    from warprock.running.batch import run_batch as run_batch
    from warprock.running.case_run import CaseRun as CaseRun
    from warprock.running.case_run import run_case as run_case
    from warprock.running.lane_table import lane_table as lane_table
    from warprock.running.results import write_run as write_run

_HOME = {
    "ENGINES": "engines",
    "FIELDS": "model.response",
    "Assembly": "api.parts",
    "Block": "api.parts",
    "Case": "api.case",
    "CaseRun": "running.case_run",
    "Contact": "api.parts",
    "Ensemble": "api.parts",
    "Found": "api.found",
    "Frame": "api.parts",
    "Grid": "api.parts",
    "Ground": "api.parts",
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
    "Strip": "api.parts",
    "Study": "api.parts",
    "Support": "api.parts",
    "Sweep": "api.parts",
    "Tie": "api.parts",
    "Times": "api.parts",
    "TopLoad": "api.parts",
    "TransverseWall": "api.parts",
    "Uniform": "api.parts",
    "bench": "api.bench",
    "body": "api.body",
    "brief": "api.brief",
    "capacity": "api.capacity",
    "case_names": "case.text",
    "compare": "api.comparison",
    "doctor": "api.doctor",
    "expand_lanes": "case.lanes",
    "explain": "api.explanation",
    "fragility": "api.analyses.fragility",
    "ida": "api.analyses.ida",
    "generate_record": "api.record_files",
    "identify": "api.identification",
    "import_records": "api.record_files",
    "keys": "api.keys",
    "lane_table": "running.lane_table",
    "limit": "api.limit",
    "list": "api.choices",
    "load_case": "api.case",
    "map": "api.analyses.map",
    "measures": "api.measures",
    "predictors": "api.analyses.predictors",
    "records": "api.records",
    "risk": "api.analyses.risk",
    "run": "api.run",
    "run_batch": "running.batch",
    "run_case": "running.case_run",
    "save_record": "api.records",
    "sensitivity": "api.analyses.sensitivity",
    "spectrum": "api.analyses.spectrum",
    "stability": "api.stability",
    "study": "api.study",
    "sweep": "api.sweep",
    "trade": "api.trade",
    "validate": "api.validation",
    "verdict": "api.verdict",
    "with_unit": "api.plain",
    "write_run": "running.results",
}
"""Public name -> the module that has it, below `warprock`: all that a user may call.

The imports above say the same to editors and type checkers; `tests/test_public.py` holds both
together."""

__all__ = sorted(_HOME)

# The checkout bridge: an installed package holds kernels/ and cases/; a checkout keeps them next
# to warprock/, where `warprock.kernels` and `warprock.cases` are found through this path.
_PACKAGE = pathlib.Path(__file__).parent
if not (_PACKAGE / "kernels").is_dir():
    __path__.append(str(_PACKAGE.parent))


def _version() -> str:
    """The version that is installed, which is made of the tags; of a mere checkout nothing."""
    import importlib.metadata

    try:
        return importlib.metadata.version(__name__)
    except importlib.metadata.PackageNotFoundError:
        return "0+unknown"


def __getattr__(name: str) -> Any:
    if name == "__version__":
        globals()[name] = _version()
        return globals()[name]
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
    if getattr(found, "__module__", "").startswith(f"{__name__}."):
        # What users call is known to them, to help and to pickles by the name that they use.
        found.__module__ = __name__
    globals()[name] = found
    return found


def __dir__() -> Sequence[str]:
    return [*__all__]
