"""What a page says of what was asked, of what numbers depend on, and of what to cite."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from warprock.case.axes import LABEL
from warprock.case.columns import Table
from warprock.case.input_columns import columns_of
from warprock.case.round_base import round_base_note
from warprock.errors import InputError
from warprock.findings.digits import number_of
from warprock.findings.numbers import counted, listed, three
from warprock.model.response import Outcome, Status
from warprock.model.words import BLOCK, OUTCOMES, STATUSES, Thing
from warprock.units import relative_size, split_unit, unit_written

Facts = Mapping[str, Any]
Pairs = list[tuple[str, str]]

_APART = ("title", "source", "sweep", "check", "engines", "peers", "study", "sample", "ensemble")
"""Tables of a case that are not the inputs of its first lane."""

VALUES_SHOWN = 8
"""Values of an axis that are written out."""


def asked(facts: Facts, table: Table | None = None) -> Pairs:
    """What was asked, from the facts of a run.

    Args:
        facts: What `run.json` holds.
        table: The lane table, where it is at hand: what a box changes of a round base is told from
            its sizes.
    """
    case = facts.get("case", {})
    raw = case.get("resolved", {})
    pairs = [("Case", f"{case['name']} ({case['file']})")] if case else []
    pairs += [("Inputs", text)] if (text := _inputs(case)) else []
    # An override of the only key of an axis leaves it empty.
    if axes := [axis for axis in _axes(case) if axis]:
        pairs.append(("Sweep", "; crossed with ".join(map(_axis, axes))))
    pairs += [("Sample", _sample(raw["sample"]))] if "sample" in raw else []
    pairs += [("Ensemble", _ensemble(raw["ensemble"]))] if "ensemble" in raw else []
    pairs += [("Round base", text)] if (text := _round_base(case, table)) else []
    if "lanes" in facts:
        pairs.append(("Lanes", f"{facts['lanes']:,}"))
    pairs += [("Engine", _engine(facts))] if "engine" in facts else []
    tolerance = facts.get("tolerance")
    if facts.get("estimate") is False:
        pairs.append(("Tolerance", "none: errors were not estimated"))
    elif tolerance is not None:
        angle = f"{number_of('tolerance', tolerance)} of the slenderness angle"
        pairs.append(("Tolerance", f"{angle}, on the error of a rotation"))
    return pairs


def _round_base(case: Facts, table: Table | None) -> str:
    """What runs in the place of a cylinder; empty where there is none."""
    blocks = dict(_flat(case.get("resolved", {}).get("block", {}), "block"))
    if not any(key.endswith(".diameter") for key in [*blocks, *swept_keys(case)]):
        return ""
    plain = "run as a box as wide as the diameter and pi / 4 of it deep, of the same mass, base "
    plain += "area and slenderness angle; `warprock explain` says what its inertia changes"
    return plain if table is None else round_base_note(table)


def _inputs(case: Facts) -> str:
    """Inputs that all lanes share, as the case writes them."""
    swept = set(swept_keys(case))
    found = [
        f"{key} = {value}"
        for name, table in case.get("resolved", {}).items()
        if name not in _APART
        for key, value in _flat(table, name)
        if key not in swept
    ]
    return ", ".join(found)


def _flat(value: Any, key: str) -> list[tuple[str, str]]:
    if isinstance(value, Mapping) and not {"from", "to"} <= set(value):
        return [pair for name, inner in value.items() for pair in _flat(inner, f"{key}.{name}")]
    return [(key, _text(value))]


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        left = dict(value)
        count, how = left.pop("count", None), left.pop("distribution", "")
        parts = [f"{count} values" if count else str(how)]
        parts += [f"{name} {_text(inner)}" for name, inner in left.items()]
        return " ".join(part for part in parts if part)
    if isinstance(value, list):
        few = [str(each) for each in value[:VALUES_SHOWN]]
        more = f", ... ({len(value):,} values)" if len(value) > VALUES_SHOWN else ""
        return ", ".join(few) + more
    return str(value)


def _axes(case: Facts) -> list[dict[str, str]]:
    """The axes of a case's sweep: its keys, and their values in words."""
    of_files = {table["sweep"]: table for table in case.get("tables", [])}
    found = []
    for number, axis in enumerate(case.get("resolved", {}).get("sweep", [])):
        rows = of_files.get(number)
        if rows is not None:
            words = f"{rows['rows']:,} rows of {rows['file']}"
            found.append(dict.fromkeys(rows["keys"], words))
        else:
            found.append({k: text for name, t in axis.items() for k, text in _flat(t, name)})
    return found


def _axis(axis: Mapping[str, str]) -> str:
    """One axis of a sweep."""
    names = [key.removeprefix("label.") for key in axis]
    texts = list(axis.values())
    if len(names) > 1 and len(set(texts)) == 1:
        return f"{', '.join(names)}: {texts[0]}"
    return ", with ".join(f"{name}: {text}" for name, text in zip(names, texts, strict=True))


def _sample(sample: Facts) -> str:
    how = {"sobol": "Sobol' sequence", "lhs": "Latin hypercube"}.get(
        str(sample.get("sampling", "sobol")), str(sample.get("sampling"))
    )
    drawn = [f"{key} {_text(value)}" for key, value in sample.get("over", {}).items()]
    return f"{sample.get('lanes', 0):,} draws, {how}, seed {sample.get('seed', 0)}: " + "; ".join(
        drawn
    )


def _ensemble(ensemble: Facts) -> str:
    spread = [f"{key} {text}" for key, text in _flat(ensemble.get("spread", {}), "")]
    members = ensemble.get("members", 0)
    return f"{members:,} members in each cell, which differ by " + ", ".join(
        text.lstrip(".") for text in spread
    )


def _engine(facts: Facts) -> str:
    engine = facts["engine"]
    if not isinstance(engine, Mapping):
        return str(engine)
    settings = ", ".join(f"{name} {three(v)}" for name, v in engine.get("settings", {}).items())
    where = [facts[name] for name in ("precision", "device") if facts.get(name)]
    return f"{engine['name']}" + (f" ({settings})" if settings else "") + f"; {', '.join(where)}"


def swept_keys(case: Facts) -> list[str]:
    """Keys that a case sweeps or draws, labels included.

    Args:
        case: What `run.json` says of the case.
    """
    found = [key for axis in _axes(case) for key in axis]
    return found + list(case.get("resolved", {}).get("sample", {}).get("over", {}))


def units_given(case: Facts) -> dict[str, tuple[str, float]]:
    """Units in which a case gives what it sweeps or draws, where columns have another one.

    Args:
        case: What `run.json` says of the case.

    Returns:
        By column the unit, and the number in it over that in the column.
    """
    resolved = case.get("resolved", {})
    found = {}
    for axis in [*resolved.get("sweep", []), resolved.get("sample", {}).get("over", {})]:
        for key, value in _given(axis):
            unit = unit_written(_first_text(value))
            for column in columns_of(key) if unit else ():
                own = split_unit(column)[1]
                size = relative_size(own, unit)
                if size is not None and unit != own:
                    found[column] = unit, size
    return found


def _given(value: Mapping[str, Any], table: str = "") -> Iterator[tuple[str, Any]]:
    """Keys of an axis and what it gives for each, without labels."""
    for name, inner in value.items():
        key = f"{table}.{name}" if table else name
        plain = not isinstance(inner, Mapping) or {"from", "distribution"} & set(inner)
        if plain and not key.startswith(LABEL):
            yield key, inner
        elif not plain:
            yield from _given(inner, key)


def _first_text(value: Any) -> str:
    """The first text of what an axis gives, besides names of distributions; empty without one."""
    if isinstance(value, Mapping):
        texts = [_first_text(each) for name, each in value.items() if name != "distribution"]
        return next(filter(None, texts), "")
    if isinstance(value, list):
        return _first_text(value[0]) if value else ""
    return value if isinstance(value, str) else ""


def require_known_keys(facts: Facts, source: str) -> None:
    """Refuses facts whose case sweeps or draws what is no key of case files.

    Raises:
        InputError: It does.
    """
    case = facts.get("case", {})
    for key in swept_keys(case) if isinstance(case, Mapping) else ():
        try:
            columns_of(key)
        except (KeyError, IndexError):
            allowed = "must be a key of case files, or a label"
            raise InputError(source, "case.resolved", key, allowed) from None


def group_labels(facts: Facts, table: Table, *without: str) -> list[str]:
    """Labels of the lanes of a table, as `case.axes.crossed_labels` writes them: those of panels.

    Args:
        facts: What `run.json` holds.
        table: The lane table.
        without: Keys whose axes make no groups.
    """
    axes = [axis for axis in _axes(facts["case"]) if not set(without) & set(axis)]
    labels = [key.removeprefix(LABEL) for axis in axes for key in axis if key.startswith(LABEL)]
    rows = zip(*(map(str, np.asarray(table[name])) for name in labels), strict=True)
    return [", ".join(filter(None, row)) for row in rows] if labels else [""] * len(table)


def swept_columns(facts: Facts, table: Table) -> list[str]:
    """Columns of the lane table in which the inputs that vary stand, labels first."""
    keys = swept_keys(facts.get("case", {}))
    columns = [name for key in keys for name in sorted(columns_of(key))]
    columns += ["member"] if "member" in table else []
    varying = [name for name in dict.fromkeys(columns) if name in table and _varies(table[name])]
    return sorted(varying, key=lambda name: _numeric(table[name]))


def naming_columns(facts: Facts, table: Table) -> list[str]:
    """Columns that tell lanes apart: of an axis with labels that differ, the labels alone."""
    case, named = facts.get("case", {}), []
    of_files = {table["sweep"]: table for table in case.get("tables", [])}
    for number, axis in enumerate(case.get("resolved", {}).get("sweep", [])):
        labels = axis.get("label", {})
        texts = [values for values in labels.values() if isinstance(values, list)]
        together = list(zip(*texts, strict=False))
        told = bool(together) and len(set(together)) == len(together)
        told = of_files.get(number, {}).get("labelled", told)
        named += [key for key in _axes(case)[number] if told and not key.startswith("label.")]
    beside = {name for key in named for name in columns_of(key)}
    return [name for name in swept_columns(facts, table) if name not in beside]


def _numeric(values: Any) -> bool:
    return np.asarray(values).dtype.kind in "biuf"


def _varies(values: Any) -> bool:
    if _numeric(values):
        return bool(np.ptp(np.asarray(values, dtype=float)) > 0.0)
    return len({value for value in np.asarray(values) if value == value}) > 1


def words(facts: Facts) -> list[tuple[str, int, str]]:
    """Outcomes and statuses that lanes have, how many, and what they mean."""
    meanings = [
        ("outcome", {code.name.lower(): text for code, text in OUTCOMES.items()}, Outcome),
        ("status", {code.name.lower(): text for code, text in STATUSES.items()}, Status),
    ]
    return [
        (f"{kind}: {word.replace('_', ' ')}", int(count), texts.get(word, ""))
        for kind, texts, _ in meanings
        for word, count in facts.get(kind, {}).items()
        if count
    ]


def provenance_pairs(facts: Facts) -> Pairs:
    """What numbers depend on: versions, machine, records, time."""
    pairs: Pairs = []
    if "versions" in facts:
        pairs.append(
            ("Versions", ", ".join(f"{name} {text}" for name, text in facts["versions"].items()))
        )
    if "kernel_sha256" in facts:
        pairs.append(("Kernels", f"SHA-256 {facts['kernel_sha256']}"))
    machine = facts.get("machine")
    if machine:
        flags = "".join(f", {flag}" for flag in machine["vector_flags"])
        pairs.append(("Machine", f"{machine['cpu']}, {counted(machine['cores'], 'core')}{flags}"))
    for record in facts.get("records", []):
        parts = [record["source"], record["licence"] and f"licence: {record['licence']}"]
        parts += [f"SHA-256 {record['sha256']}"]
        pairs.append((f"Record {record['name']}", "; ".join(text for text in parts if text)))
    if "finished" in facts:
        pairs.append(
            ("Finished", str(facts["finished"]).replace("T", " ").replace("+00:00", " UTC"))
        )
    if "wall_time_s" in facts:
        pairs.append(("Wall time", f"{three(float(facts['wall_time_s']))} s"))
    return pairs


_HOUSNER = (
    "G. W. Housner (1963), The behavior of inverted pendulum structures during earthquakes, "
    "Bulletin of the Seismological Society of America 53(2), 403-417."
)
_PAIRS = (
    "I. N. Psycharis (1990), Dynamic behaviour of rocking two-block assemblies, Earthquake "
    "Engineering and Structural Dynamics 19; P. D. Spanos, P. C. Roussis and N. P. A. Politis "
    "(2001), Soil Dynamics and Earthquake Engineering 21; A. N. Kounadis (2015), Meccanica 50."
)
BENCHMARK = (
    "Discontinuum rocking of rigid masonry macro-blocks using physics engines: analytical, "
    "numerical and experimental benchmarking."
)


def citations(facts: Facts, extra: Sequence[str] = ()) -> list[str]:
    """What to cite, the version of warprock first.

    Args:
        facts: What `run.json` holds.
        extra: What a kind of result adds.
    """
    version = facts.get("versions", {}).get("warprock", "")
    year = str(facts.get("finished", ""))[:4]
    kernels = facts.get("kernel_sha256", "")[:12]
    named = [f"warprock{' ' + version if version else ''}"]
    named += [f"({year})"] if year else []
    own = " ".join(named) + ", batched simulation of rocking rigid blocks"
    own += f"; kernels {kernels}." if kernels else "."
    raw = facts.get("case", {}).get("resolved", {})
    stacked = any(str(key).isdigit() for key in raw.get("block", {}))
    records = [
        f"Record {record['name']}: {record['source']}"
        for record in facts.get("records", [])
        if record["source"]
    ]
    return [own, _HOUSNER, *([_PAIRS] if stacked else []), *extra, *dict.fromkeys(records)]


def outcome_words(
    counts: Mapping[str, int],
    duration: float | None = None,
    falling: int = 0,
    thing: Thing = BLOCK,
) -> str:
    """What became of lanes, in one clause: `12 came to rest and 6 still moved`.

    Args:
        counts: Lanes by the word of their outcome.
        duration: Length of the run [s]; None leaves it out.
        falling: Lanes that still moved far beyond the slenderness angle.
        thing: What they are of.
    """
    ends = {
        "at_rest": "came to rest",
        "rocking": "still moved"
        + (f" when the run ended after {three(duration)} s" if duration else ""),
        "overturned": thing.fallen,
        "slid_off": "slid off",
    }
    if falling:
        ends["rocking"] += f" ({falling:,} of them beyond twice the slenderness angle)"
    found = [f"{count:,} {ends[word]}" for word, count in counts.items() if count and word in ends]
    if not counts.get("overturned"):
        found.append(f"none {thing.fallen}")
    return listed(found)
