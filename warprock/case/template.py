"""Case files to start from: a commented template, with a body, a record and sweeps of one's own.

The template keeps its comments: values are changed line by line, so that what a stranger reads
stays where it is.
"""

from __future__ import annotations

import dataclasses
import importlib.resources
import math
import pathlib
import re
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from warprock.case.case import Case
from warprock.case.keys import KEYS, general_key, rivals
from warprock.case.lanes import expand_lanes
from warprock.case.load import build_case
from warprock.case.sweep import axis_keys, several_values
from warprock.case.text import OVERRIDE, parse_case, read_override, template_text
from warprock.case.validation import KeyedError, refusing
from warprock.case.writing import toml_text
from warprock.errors import NOTHING, InputError, did_you_mean
from warprock.model.undecided import decided_after
from warprock.quantity import NumberKey
from warprock.recordings import load_record, record_names
from warprock.recordings.column_file import Reading
from warprock.recordings.loading import AS_WRITTEN
from warprock.recordings.record import Record
from warprock.recordings.writing import format_imported
from warprock.units import Dimension, parse_quantity

SIZES = ("width", "depth", "diameter", "height")
"""Keys of a body that are its sizes."""

MAP, DURATION = "map", "run.duration"
"""The kind of case whose runs have to decide, and the key of how long they last."""

LEDGE = 0.05
"""How far the pedestal below a body reaches beyond its base on each side [m]."""

RECORD_MOTION = (
    'waveform = "record"',
    'record = ""   # a name (`warprock records list`), or a file beside this one',
    "scale = 1.0   # factor on the record",
)
"""The motion of a case of a stack that is to follow a record."""

AFTERWARDS = 10.0
"""Time that a run lasts beyond a record of one's own [s]."""

_HEADER = re.compile(r"\[{1,2}[^\]]+\]{1,2}")


@dataclasses.dataclass(frozen=True)
class Start:
    """A case file to be written, and the files that it needs beside it.

    Attributes:
        text: The case file.
        lanes: Lanes that it makes.
        beside: Bytes of other files by their names.
    """

    text: str
    lanes: int
    beside: Mapping[str, bytes]


def bodies() -> dict[str, dict[str, Any]]:
    """The bodies that a case may begin with, by name."""
    file = importlib.resources.files("warprock.cases").joinpath("bodies.toml")
    return tomllib.loads(file.read_text(encoding="utf-8"))


def start_case(
    kind: str,
    *,
    body: str | None = None,
    record: str | None = None,
    reading: Reading,
    sweeps: Sequence[str] = (),
    overrides: Sequence[str] = (),
) -> Start:
    """A case file to start from.

    Args:
        kind: One of `case.text.template_kinds()`.
        body: Name of one of `bodies()`, or sizes: "WIDTH x HEIGHT x DEPTH", or "DIAMETER x HEIGHT"
            of a round base.
        record: Name of a shipped record, or a file.
        reading: What is said of that file besides its header.
        sweeps: Texts `key=values`; the axes of the template give way to them.
        overrides: Texts `key=value`.

    Raises:
        InputError: Something of that cannot be used, or has no place in a case of that kind.
    """
    draft = Draft(template_text(kind))
    beside: dict[str, bytes] = {}
    if body is not None:
        _put_body(draft, kind, body)
    if record is not None:
        beside = _put_record(draft, kind, record, reading)
    if sweeps:
        draft.drop_axes(None)
    keys = [_put(draft, text, "--sweep") for text in sweeps]
    keys += [_put(draft, text, OVERRIDE) for text in overrides]
    text = draft.text()
    raw = parse_case(text, "the case")
    case = build_case(kind, "the case", None, raw, frozenset(keys))
    if kind == MAP and DURATION not in keys:
        # Pulses and bodies of one's own may take longer than those of the template.
        lane_set = expand_lanes(case)
        least = float(decided_after(lane_set.lanes, lane_set.motions).max())
        if case.sample_times.duration < least:
            draft.give(DURATION, f"{math.ceil(least)} s")
            text = draft.text()
    return Start(text, case.lane_count, beside)


def case_of_record(body: str | None, record: str | None) -> Case:
    """A case of a body under a record, one lane, that no file holds.

    Args:
        body: Name of one of `bodies()`, or sizes, as in `start_case`.
        record: Name of a shipped record, or a file.

    Raises:
        InputError: One of them is missing, or cannot be used.
    """
    for option, given in (("--body", body), ("--record", record)):
        if given is None:
            allowed = "must be given, and so must --body and --record, where no CASE is"
            raise InputError(option, "", NOTHING, allowed)
    draft = Draft(template_text("record"))
    _put_body(draft, "record", str(body))
    taken = take_record(str(record))
    draft.drop_axes(None)
    draft.give("title", f"{body} under {record}")
    draft.give("run.duration", taken.duration)
    draft.give(
        "motion.record", str(pathlib.Path(str(record)).resolve()) if taken.beside else record
    )
    raw = parse_case(draft.text(), "the case")
    return build_case("body", "--body, --record", None, raw)


class Draft:
    """A case file as lines, by its sections; what stands above a header belongs to it."""

    def __init__(self, text: str) -> None:
        self._sections: list[list[str]] = [[]]
        for line in text.splitlines():
            if _HEADER.match(line):
                above = self._sections[-1]
                own = [line]
                while above and above[-1].startswith("#"):
                    own.insert(0, above.pop())
                self._sections.append(own)
            else:
                self._sections[-1].append(line)

    def text(self) -> str:
        """The file."""
        lines = [line for section in self._sections for line in section]
        return "\n".join(lines).rstrip("\n") + "\n"

    def give(self, key: str, value: object) -> None:
        """Gives a dotted key a value; other keys that say the same thing go, and axes it is on."""
        self.drop_axes({key, *rivals(key)})
        for rival in rivals(key):
            self._drop(rival)
        table, _, name = key.rpartition(".")
        line = toml_text({name: value}).strip()
        section = self._section(table)
        at = self._place(section, name)
        if at is None:
            section.insert(self._end(section), line)
        else:
            section[at] = line

    def sweep(self, key: str, values: object) -> None:
        """Adds an axis."""
        self.drop_axes({key, *rivals(key)})
        for rival in rivals(key):
            self._drop(rival)
        nested: object = values
        for part in reversed(key.split(".")):
            nested = {part: nested}
        self._sections.append(["", *toml_text({"sweep": [nested]}).strip().splitlines()])

    def drop_axes(self, keys: set[str] | None) -> None:
        """Takes out the axes on which some keys lie, and what draws these; None takes out all."""
        kept = []
        for section in self._sections:
            found = tomllib.loads("\n".join(section)).get("sweep", [])
            on = {key for entry in found for key in axis_keys(entry)}
            if not found or (keys is not None and not on & keys):
                kept.append(section)
        self._sections = kept
        for key in keys or ():
            drawn = self._find("sample.over")
            at = None if drawn is None else self._place(drawn, key)
            if drawn is not None and at is not None:
                del drawn[at]

    def replace(self, table: str, lines: Sequence[str]) -> None:
        """Gives a table other lines, and takes out the axes on its keys."""
        section = self._section(table)
        found = tomllib.loads("\n".join(section)).get(table, {})
        self.drop_axes({f"{table}.{name}" for name in found})
        section[:] = ["", f"[{table}]", *lines, ""]

    def _drop(self, key: str) -> None:
        table, _, name = key.rpartition(".")
        section = self._find(table)
        at = None if section is None else self._place(section, name)
        if section is not None and at is not None:
            del section[at]

    def _find(self, table: str) -> list[str] | None:
        return next((s for s in self._sections if _header(s) == table), None)

    def _section(self, table: str) -> list[str]:
        found = self._find(table) if table else self._sections[0]
        if found is None:
            found = ["", f"[{table}]"]
            self._sections.append(found)
        return found

    @staticmethod
    def _place(section: Sequence[str], name: str) -> int | None:
        start = re.compile(rf"{re.escape(name)}\s*=")
        return next((at for at, line in enumerate(section) if start.match(line)), None)

    @staticmethod
    def _end(section: Sequence[str]) -> int:
        """Where a line may be added: behind the last one that is not empty."""
        return max((at + 1 for at, line in enumerate(section) if line.strip()), default=0)


def _header(section: Sequence[str]) -> str:
    """The table that a section is, without brackets; empty for the top of the file."""
    line = next((line for line in section if _HEADER.match(line)), "")
    return line.partition("#")[0].strip().strip("[]")


def _put(draft: Draft, text: str, option: str) -> str:
    """Puts one KEY=VALUE into a draft, as a value or as an axis; gives the key."""
    key, value = read_override(text, option)
    declared = KEYS.get(general_key(key))
    values = None
    if declared is not None and declared.swept:
        with refusing(lambda _key: option):
            try:
                values = several_values(value, words=isinstance(declared, NumberKey))
            except KeyedError as fault:
                raise fault.below(key) from None
    if values is not None:
        draft.sweep(key, values)
    elif option == OVERRIDE:
        draft.give(key, value)
    else:
        allowed = (
            'must be several values of a key that may be swept: "0.1 g to 2 g, 20", "1 m, 2 m"'
        )
        raise InputError(option, key, str(value), allowed)
    return key


def _put_body(draft: Draft, kind: str, body: str) -> None:
    """Puts a body into [block]; of a stack on block 1, the pedestal, which it makes wide enough."""
    tables = tomllib.loads(draft.text())
    if "spectrum" in tables or "assembly" in tables:
        allowed = f"must be left out with {kind}, which makes its own sizes: change them with -s"
        raise InputError("--body", "", body, allowed)
    on = "block.2" if "2" in tables["block"] else "block"
    known = bodies()
    found = dict(known[body]) if body in known else _own_body(body, known)
    for name in SIZES:
        if name in found:
            draft.give(f"{on}.{name}", found[name])
    friction = "contact.friction" if on == "block" else f"{on}.friction"
    for key, name in ((f"{on}.density", "density"), (friction, "friction")):
        if name in found:
            draft.give(key, found[name])
    title = f"{found['text'][0].upper()}{found['text'][1:]}"
    if on == "block":
        draft.give("title", title)
        return
    for side in ("width", "depth"):
        across = parse_quantity(found.get(side) or found["diameter"], Dimension.LENGTH)
        draft.give(f"block.1.{side}", f"{across + 2.0 * LEDGE:g} m")
    draft.give("title", f"{title}, on a pedestal")


def _own_body(body: str, known: Mapping[str, object]) -> dict[str, Any]:
    """A body from its sizes."""
    sizes = [part.strip() for part in re.split(r"\s+x\s+", body)]
    names = {2: ("diameter", "height"), 3: ("width", "height", "depth")}.get(len(sizes))
    try:
        if names is None:
            raise ValueError
        for size in sizes:
            parse_quantity(size, Dimension.LENGTH)
    except ValueError:
        allowed = (
            f'must be one of {", ".join(known)}, or sizes with units: "WIDTH x HEIGHT x DEPTH", '
            f'"DIAMETER x HEIGHT"{did_you_mean(body, known)}'
        )
        raise InputError("--body", "", body, allowed) from None
    what = "cylinder" if len(sizes) == 2 else "block"
    return {"text": f"a {what} of {' x '.join(sizes)}", **dict(zip(names, sizes, strict=True))}


def _put_record(draft: Draft, kind: str, name: str, reading: Reading) -> dict[str, bytes]:
    """Puts a record into [motion]; gives the file that has to lie beside the case."""
    motion = tomllib.loads(draft.text()).get("motion", {})
    if kind == "stack":
        draft.replace("motion", RECORD_MOTION)
    elif motion.get("waveform") != "record":
        allowed = f"must be left out with {kind}, which follows no record: warprock init record"
        raise InputError("--record", "", name, allowed)
    taken = take_record(name, reading)
    draft.give("run.duration", taken.duration)
    draft.give("motion.record", taken.name)
    return taken.beside


class TakenRecord(NamedTuple):
    """A record as a case takes it.

    Attributes:
        name: `motion.record`.
        duration: `run.duration`: it lasts beyond the record.
        beside: Bytes of the file that has to lie beside the case, by its name; empty of a shipped
            record.
    """

    name: str
    duration: str
    beside: dict[str, bytes]


def take_record(name: str, reading: Reading = AS_WRITTEN) -> TakenRecord:
    """A record for a case.

    Args:
        name: Name of a shipped record, or a file.
        reading: What is said of that file besides its header.

    Raises:
        InputError: There is no such record, or the file is none.
    """
    try:
        record: Record = load_record(name, asked=reading)
    except InputError as error:
        if (error.source, error.key) != (name, "record"):
            raise
        raise InputError("--record", "", name, error.allowed) from None
    duration = f"{math.ceil(record.duration + AFTERWARDS):g} s"
    if name in record_names():
        return TakenRecord(name, duration, {})
    stem = re.sub(r"[^A-Za-z0-9._-]+", "-", pathlib.Path(record.name).stem)
    # The case may lie in the folder of the file asked for.
    file = f"{stem}-si.csv" if f"{stem}.csv" == pathlib.Path(name).name else f"{stem}.csv"
    content = format_imported(record, (), name=pathlib.Path(file).stem)
    return TakenRecord(file, duration, {file: content})
