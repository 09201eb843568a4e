"""The reference of all keys of a case file, made of what their tables declare."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from pydantic.fields import FieldInfo

from warprock.case.assembly import Assembly
from warprock.case.block import Block, StackedBlock
from warprock.case.body import Body, StackedBody
from warprock.case.case_file import CaseFile
from warprock.case.check import CHECKS
from warprock.case.contact import Contact
from warprock.case.ensemble import EnsembleTable
from warprock.case.hold import Frame, Ground, Strip, Tie, TopLoad, TransverseWall
from warprock.case.keys import general_key
from warprock.case.motion import Motion
from warprock.case.run import Run
from warprock.case.sample import DISTRIBUTIONS, SampleTable
from warprock.case.settings import ENGINES, PEERS
from warprock.case.spectrum import SpectrumTable
from warprock.case.start import Start
from warprock.case.study import StudyTable
from warprock.case.support import Support
from warprock.case.sweep import Grid
from warprock.case.sweep_file import TableEntry
from warprock.case.validation import Table
from warprock.case.waveforms import FAMILIES, Family
from warprock.errors import InputError, did_you_mean, list_allowed
from warprock.quantity import InputKey, Key
from warprock.settings.engines import SETTINGS, declared_settings
from warprock.settings.programs import PEER_SETTINGS
from warprock.unmodelled import unmodelled_text


class KeyRow(NamedTuple):
    """One key of the reference.

    Attributes:
        key: Its dotted name.
        unit: What it measures, or its unit.
        holds: Bounds or choices.
        default: What it is where the case does not give it, as text; None where that is nothing.
        required: Whether it must be given.
        text: Meaning.
        needed_by: Waveforms with which it must be given.
        allowed_with: Waveforms with which it may be given; none where all may.
        swept: Whether it may differ from lane to lane.
        needs_space: What a case with it does that only blocks in space can do; mostly nothing.
        instead_of: Key that it may be given in the place of; mostly nothing.
        columns: Columns of the lane table that show it.
    """

    key: str
    unit: str
    holds: str
    default: str | None
    required: bool
    text: str
    needed_by: tuple[str, ...] = ()
    allowed_with: tuple[str, ...] = ()
    swept: bool = False
    needs_space: str = ""
    instead_of: str = ""
    columns: tuple[str, ...] = ()


class Section(NamedTuple):
    """One table of a case file.

    Attributes:
        title: The table as it is written in a case file.
        text: What it says.
        keys: Its keys.
    """

    title: str
    text: str
    keys: tuple[KeyRow, ...]

    def as_json(self) -> dict[str, Any]:
        """Ready for JSON."""
        return self._asdict() | {"keys": [row._asdict() for row in self.keys]}


def sections() -> Iterator[Section]:
    """Every table of a case file."""
    yield _section("the file itself", CaseFile)
    yield _section("[block]", Block)
    yield _section("[block] of a body", Body)
    yield _section("[block.N]", StackedBlock)
    yield _section("[block.N] of a body", StackedBody)
    yield _section("[assembly]", Assembly)
    yield _section("[contact]", Contact)
    yield _section("[transverse_wall]", TransverseWall)
    yield _section("[[tie]]", Tie)
    yield _section("[top_load]", TopLoad)
    yield _section("[frame]", Frame)
    yield _section("[strip]", Strip)
    yield _section("[ground]", Ground)
    yield _section("[start]", Start)
    yield _section("[motion], [motion.y], [motion.z]", Motion)
    yield _section("[support]", Support)
    yield _section("[run]", Run)
    yield _section("[[sweep]] KEY = { ... }", Grid)
    yield _section('[[sweep]] table = "FILE"', TableEntry)
    yield _section("[sample]", SampleTable)
    for shape, distribution in DISTRIBUTIONS.items():
        yield _section(f'[sample.over] KEY = {{ distribution = "{shape}", ... }}', distribution)
    yield _section("[ensemble]", EnsembleTable)
    yield _section("[spectrum]", SpectrumTable)
    yield _section("[study]", StudyTable)
    for kind, check in CHECKS.items():
        yield _section(f'[[check]] kind = "{kind}"', check)
    for place, types in ((ENGINES, SETTINGS), (PEERS, PEER_SETTINGS)):
        for name, settings in types.items():
            yield _settings_section(f"{place}.{name}", settings)


def _section(title: str, table: type[Table]) -> Section:
    prefix = f"{table.place}." if table.place else ""
    fields = dict(zip(table.names(), table.model_fields.values(), strict=False))
    rows = tuple(
        _row(f"{prefix}{name}", declared, _default(fields[name]), fields[name].is_required())
        for name, declared in table.declared().items()
    )
    return Section(title, _first_line(table), rows)


def _settings_section(place: str, settings: type[Any]) -> Section:
    defaults = {field.name: field.default for field in dataclasses.fields(settings)}
    rows = tuple(
        _row(f"{place}.{name}", declared, f"{defaults[name]:g}", required=False)
        for name, declared in declared_settings(settings).items()
    )
    return Section(f"[{place}]", _first_line(settings), rows)


def _first_line(table: type[Any]) -> str:
    return (inspect.getdoc(table) or "").splitlines()[0]


def _default(field: FieldInfo) -> str | None:
    if field.is_required() or field.default in (None, ()) or field.default_factory is not None:
        return None
    return f"{field.default:g}" if isinstance(field.default, float | int) else str(field.default)


def _row(key: str, declared: Key, default: str | None, required: bool) -> KeyRow:
    table, _, name = key.rpartition(".")
    row = KeyRow(
        key=key,
        unit=declared.unit,
        holds=declared.bounds_text,
        default=default,
        required=required,
        needed_by=_waveforms(family for family in FAMILIES if name in family.needs),
        allowed_with=_waveforms(family for family in FAMILIES if name in family.may),
        text=declared.text,
    )
    if table != Motion.place or row.needed_by + row.allowed_with == _waveforms(FAMILIES):
        row = row._replace(needed_by=(), allowed_with=())
    if not isinstance(declared, InputKey):
        return row
    number = "_N" if table in (StackedBlock.place, Tie.place) else ""
    return row._replace(
        swept=declared.swept,
        needs_space=declared.needs_space,
        instead_of=" or ".join(f"{table}.{other}" for other in declared.others),
        columns=tuple(column.named(number) for column in declared.columns),
    )


def _waveforms(families: Iterable[Family]) -> tuple[str, ...]:
    return tuple(str(waveform) for family in families for waveform in family.waveforms)


def find_sections(wanted: str | None = None) -> list[Section]:
    """Tables of a case file, or those keys of them that are asked for.

    Args:
        wanted: A table, such as `block`, or a key, such as `block.height`; None is all.

    Raises:
        InputError: There is no such table or key.
    """
    every = list(sections())
    if wanted is None:
        return every
    name = general_key(f"{wanted.strip('[]')}.").rstrip(".")
    found = [
        section._replace(keys=keys)
        for section in every
        if (keys := tuple(k for k in section.keys if f"{k.key}.".startswith(f"{name}.")))
    ]
    if not found:
        found_out = unmodelled_text(wanted)
        if found_out:
            raise InputError("TABLE", "", wanted, f"no key of a case file{found_out}")
        known = [row.key for section in every for row in section.keys]
        tables = dict.fromkeys(key.rpartition(".")[0] for key in known if "." in key)
        allowed = (
            f"must be a table or a key of a case file ({list_allowed(name, [*tables, *known])})"
        )
        raise InputError("TABLE", "", wanted, f"{allowed}{did_you_mean(name, [*tables, *known])}")
    return found


def facts(row: KeyRow) -> str:
    """What there is to say of a key besides its unit and its meaning, in one line."""
    said = (
        row.holds,
        row.required and "must be given",
        row.needed_by and f"must be given with {', '.join(row.needed_by)}",
        row.allowed_with and f"may be given with {', '.join(row.allowed_with)}",
        row.instead_of and f"instead of {row.instead_of}",
        row.default is not None and f"default {row.default}",
        row.swept and "may be swept",
        row.needs_space and "in space only",
        row.columns and f"column {', '.join(row.columns)}",
    )
    return "; ".join(str(each) for each in said if each)


def reference_page(found: Iterable[Section]) -> str:
    """Tables and their keys as Markdown."""
    lines = [
        "# Keys of a case file",
        "",
        'A quantity is text with its unit, such as `"8 mm"`. N is the number of a block or a tie.',
    ]
    for section in found:
        lines += ["", f"## {section.title}", "", section.text, ""]
        lines += ["| key | unit | holds | meaning |", "| --- | --- | --- | --- |"]
        for row in section.keys:
            cells = (f"`{row.key}`", row.unit, facts(row), row.text)
            lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return "\n".join(lines)
