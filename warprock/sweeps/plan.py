"""The plan of a sweep: everything that its results depend on, written down before it runs.

A plan holds the resolved case, the engine with all of its settings, the hashes of records and
kernels and the versions of what computes. Its id is the SHA-256 of that content, in the order in
which it is written: the order of the keys of a case numbers its lanes and its samples. How the
lanes are cut into chunks is no part of the content, for it changes no number.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import json
import pathlib
from collections.abc import Iterator, Mapping
from typing import Any

from warprock.case.case import Case
from warprock.case.lanes import expand_lanes
from warprock.case.load import build_case
from warprock.case.text import MOST_CASE_BYTES, require_shallow
from warprock.errors import NOTHING, InputError, Said
from warprock.reading import read_bytes, reason
from warprock.running import machine
from warprock.running.case_run import require_options, require_support
from warprock.running.files import replacing, require_writable
from warprock.running.options import DEFAULT_OPTIONS, Progress, RunOptions
from warprock.running.provenance import PACKAGES, drawing_facts, record_rows, table_facts

PLAN = "plan.json"
FORMAT = 2

CHUNK_LANES = 50_000
"""Lanes of a chunk: seconds of work, a few tens of megabytes."""
MOST_CHUNK_LANES = 10_000_000
MOST_CHUNKS = 1_000_000
"""Chunks of a plan: each is a file."""
MOST_LANES = 10**10
"""Lanes of a plan, at most: at a million lanes a minute they take a week."""

PACKAGES_OF_BYTES = (*PACKAGES, "pyarrow")
"""Distributions that the bytes of a result depend on."""


@dataclasses.dataclass(frozen=True)
class Plan:
    """A fully resolved sweep.

    Attributes:
        content: What the results depend on, ready for JSON.
        chunk_lanes: Lanes in a chunk; the last one may have fewer.
        case_folder: Folder that relative paths of records start from; None for a shipped case.
        file: Where the plan was read from, as errors name it.
    """

    content: Mapping[str, Any]
    chunk_lanes: int
    case_folder: str | None
    file: str = PLAN

    @functools.cached_property
    def id(self) -> str:
        """SHA-256 of the content."""
        return hashlib.sha256(self.content_text.encode()).hexdigest()

    @property
    def content_text(self) -> str:
        """The content as JSON, the same characters for the same content."""
        return json.dumps(self.content, ensure_ascii=False, separators=(",", ":"))

    @property
    def lane_count(self) -> int:
        """Lanes of the sweep."""
        return int(self.content["lanes"])

    @property
    def chunk_count(self) -> int:
        """Chunks of the sweep."""
        return -(-self.lane_count // self.chunk_lanes)

    def lanes_of(self, chunk: int) -> range:
        """Numbers of the lanes of a chunk."""
        first = chunk * self.chunk_lanes
        return range(first, min(first + self.chunk_lanes, self.lane_count))

    @property
    def engine(self) -> str:
        """Name of the engine."""
        return str(self.content["engine"]["name"])

    @property
    def tolerance(self) -> float | None:
        """Largest error over the slenderness angle; None where no error is estimated."""
        tolerance = self.content.get("tolerance")
        return None if tolerance is None else float(tolerance)

    def options(self, workers: int | None, progress: Progress | None) -> RunOptions:
        """How its lanes are run, by as many worker threads as whoever runs them has."""
        precision, device = (str(self.content[name]) for name in ("precision", "device"))
        return RunOptions(precision, device, workers, self.tolerance, progress)

    @functools.cached_property
    def case(self) -> Case:
        """The case, read from the plan alone.

        Raises:
            InputError: It cannot be read, so the plan was not written by this version.
        """
        written = self.content["case"]
        folder = None if self.case_folder is None else pathlib.Path(self.case_folder)
        return build_case(written["name"], self.file, folder, written["resolved"])


def make_plan(
    case: Case,
    engine: str,
    options: RunOptions = DEFAULT_OPTIONS,
    *,
    chunk_lanes: int = CHUNK_LANES,
) -> Plan:
    """Plans a sweep, and refuses it if any of its lanes could not be run.

    Args:
        case: The case.
        engine: Name of the engine.
        options: How its lanes are to be run; the progress is that of the look at every lane.
        chunk_lanes: Lanes in a chunk.

    Raises:
        InputError: An option out of bounds, a lane that no engine could run, or a scene that this
            engine cannot do.
    """
    require_options(engine, options)
    if not 1 <= chunk_lanes <= MOST_CHUNK_LANES:
        allowed = f"must be a number of lanes from 1 to {MOST_CHUNK_LANES}"
        raise InputError("--chunk", "", chunk_lanes, allowed)
    if case.study is not None:
        allowed = "must not be given: a study compares settings, and a sweep has one set of them"
        raise InputError(case.source_of("study"), "study", Said("a table"), allowed)
    if not 1 <= case.lane_count <= MOST_LANES:
        allowed = f"must make 1 to {MOST_LANES:,} lanes"
        raise InputError(case.file, "sweep", Said(f"{case.lane_count:,} lanes"), allowed)
    if case.lane_count > MOST_CHUNKS * chunk_lanes:
        least = -(-case.lane_count // MOST_CHUNKS)
        allowed = f"must be at least {least:,} lanes: a sweep has at most {MOST_CHUNKS:,} chunks"
        raise InputError("--chunk", "", chunk_lanes, allowed)
    content = _content(case, engine, options)
    folder = None if case.folder is None else str(case.folder)
    plan = Plan(content, chunk_lanes, folder)
    for chunk in range(plan.chunk_count):
        lanes = plan.lanes_of(chunk)
        require_support(case, expand_lanes(case, lanes), engine, lanes.start)
        if options.progress is not None:
            options.progress(lanes.stop)
    return plan


def _content(case: Case, engine: str, options: RunOptions) -> dict[str, Any]:
    """What the numbers of a sweep depend on."""
    versions = machine.package_versions(PACKAGES_OF_BYTES)
    # Python itself computes nothing here.
    del versions["python"]
    content = {
        "format": FORMAT,
        "case": {
            "name": case.name,
            "title": case.title,
            "source": case.source_text,
            # Nothing is checked in a sweep, and overrides may have taken a check's lanes away.
            "resolved": {key: value for key, value in case.raw.items() if key != "check"},
            **table_facts(case),
            **drawing_facts(case),
        },
        "lanes": case.lane_count,
        "engine": {
            "name": engine,
            "settings": dataclasses.asdict(case.engine_settings(engine)),
        },
        "precision": options.precision,
        "device": options.device,
        "estimate": options.tolerance is not None,
        "tolerance": options.tolerance,
        "records": record_rows(case),
        "versions": versions,
        "kernel_sha256": machine.kernel_hash(),
    }
    # As it will be read: tuples become lists.
    read: dict[str, Any] = json.loads(json.dumps(content))
    return read


def write_plan(plan: Plan, folder: pathlib.Path) -> bool:
    """Writes a plan to the folder of its sweep.

    Args:
        plan: The plan.
        folder: Where to; made if it does not exist.

    Returns:
        Whether it was written; false where the folder holds this very plan already.

    Raises:
        InputError: The folder holds another plan, or cannot be written to.
    """
    require_writable(folder)
    if (folder / PLAN).exists():
        there = read_plan(folder)
        if (there.id, there.chunk_lanes) == (plan.id, plan.chunk_lanes):
            return False
        allowed = f"must be another folder: it holds another plan, {there.id[:12]}, in chunks of "
        raise InputError("--output", "", str(folder), f"{allowed}{there.chunk_lanes} lanes")
    folder.mkdir(parents=True, exist_ok=True)
    text = {
        "id": plan.id,
        "chunk_lanes": plan.chunk_lanes,
        "case_folder": plan.case_folder,
        "content": plan.content,
    }
    with replacing(folder / PLAN) as temporary:
        written = json.dumps(text, indent=2, ensure_ascii=False) + "\n"
        temporary.write_text(written, encoding="utf-8")
    return True


def read_plan(folder: pathlib.Path) -> Plan:
    """The plan of a sweep.

    Args:
        folder: Folder of the sweep.

    Raises:
        InputError: There is none, or it is not as it was written.
    """
    path = folder / PLAN
    try:
        text = json.loads(read_bytes(path, MOST_CASE_BYTES))
    except OSError as error:
        allowed = "must be the plan of a sweep: write one with warprock sweep plan CASE -o DIR"
        raise InputError(str(path), "", Said(reason(error)), allowed) from None
    except ValueError as error:
        raise InputError(str(path), "", Said(error), "must be JSON, as it was written") from None
    except RecursionError:
        got = Said("lists or tables inside one another without end")
        raise InputError(str(path), "", got, "must be a plan as it was written") from None
    _require_form(text, str(path))
    plan = Plan(text["content"], text["chunk_lanes"], text["case_folder"], str(path))
    if plan.id != text["id"]:
        allowed = (
            f"must be {plan.id}, that of the content: the file was changed after it was written"
        )
        raise InputError(str(path), "id", text["id"], allowed)
    return plan


_FORM: dict[str, tuple[type, ...]] = {
    "": (dict,),
    "id": (str,),
    "chunk_lanes": (int,),
    "case_folder": (str, type(None)),
    "content": (dict,),
    "content.format": (int,),
    "content.case": (dict,),
    "content.case.name": (str,),
    "content.case.resolved": (dict,),
    "content.lanes": (int,),
    "content.engine": (dict,),
    "content.engine.name": (str,),
    "content.engine.settings": (dict,),
    "content.precision": (str,),
    "content.device": (str,),
    "content.estimate": (bool,),
    "content.records": (list,),
    "content.versions": (dict,),
    "content.kernel_sha256": (str,),
}
"""Dotted keys of a plan's file, outer ones first, and what they hold."""

_SAID = {dict: "a table", str: "text", int: "a whole number", bool: "true or false", list: "a list"}


def _require_form(text: Any, file: str) -> None:
    """Refuses what cannot be the text of a plan.

    Raises:
        InputError: Too deep, a key is missing or of another kind, or a number is out of bounds.
    """
    require_shallow({"plan": text}, file)
    for key, kinds in _FORM.items():
        found: Any = text
        for name in key.split(".") if key else ():
            found = found.get(name, NOTHING)
        if type(found) not in kinds:
            words = " or ".join(_SAID.get(kind, "null") for kind in kinds)
            raise InputError(file, key, found, f"must be {words}, as it was written")
    if text["content"]["format"] != FORMAT:
        found, allowed = text["content"]["format"], f"must be {FORMAT}, that of this version"
        raise InputError(file, "content.format", found, allowed)
    for key, number, most in (
        ("content.lanes", text["content"]["lanes"], MOST_LANES),
        ("chunk_lanes", text["chunk_lanes"], MOST_CHUNK_LANES),
    ):
        if not 1 <= number <= most:
            raise InputError(file, key, number, f"must be from 1 to {most}, as it was written")


def require_same_software(plan: Plan) -> None:
    """Refuses to run a plan with anything else than what it was made with.

    Raises:
        InputError: A record, the kernels, a version, or a default of the engine is another one.
    """
    planned = plan.content
    options = plan.options(None, None)
    here = _content(plan.case, plan.engine, options)
    require_options(plan.engine, options)
    wanted, found = dict(_leaves(planned)), dict(_leaves(here))
    for key in wanted | found:
        if wanted.get(key, NOTHING) != found.get(key, NOTHING):
            allowed = f"must be {wanted.get(key, NOTHING)!r}, with which the sweep was planned: "
            raise InputError(
                plan.file, key, found.get(key, NOTHING), f"{allowed}run it there, or plan it anew"
            )


def _leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Dotted keys and values of nested JSON."""
    inner: Iterator[tuple[Any, Any]]
    if isinstance(value, Mapping) and value:
        inner = iter(value.items())
    elif isinstance(value, list) and value:
        inner = iter(enumerate(value))
    else:
        yield path, value
        return
    for name, part in inner:
        yield from _leaves(part, f"{path}.{name}" if path else str(name))


def plan_facts(plan: Plan) -> dict[str, Any]:
    """The summary of a plan, ready for JSON."""
    content = plan.content
    return {
        "plan": plan.id,
        "case": content["case"]["name"],
        "engine": plan.engine,
        "settings": content["engine"]["settings"],
        "precision": content["precision"],
        "device": content["device"],
        "estimate": content["estimate"],
        "tolerance": content["tolerance"],
        "lanes": plan.lane_count,
        "chunks": plan.chunk_count,
        "chunk_lanes": plan.chunk_lanes,
        "records": content["records"],
    }
