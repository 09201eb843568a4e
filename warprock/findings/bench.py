"""What steps and accuracy cost on this machine, and lanes a second on a device."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from warprock.findings.digits import value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.numbers import about, three
from warprock.findings.plain import plain
from warprock.findings.sheets import Heading, Sheet, heading, sheet_of

TABLE, DEVICE_TABLE = "bench", "bench-device"
_COSTS = (
    "Block B0, 5 s of free rocking, one core: the cheapest setting tried that meets an error "
    "(median over nine starts); costs over those of event are rounded"
)


def find_bench(found: Mapping[str, Any]) -> Finding:
    """What a benchmark came to.

    Args:
        found: What `measure.bench.run_bench` measured, and as `prices` what
            `measure.peers.compare` did.
    """
    facts = {key: plain(found[key]) for key in ("machine", "ratios", "commands", "prices")}
    return tell_bench(facts, {TABLE: pd.DataFrame(found["rows"])})


def tell_bench(facts: Facts, tables: Tables) -> Finding:
    """What a benchmark came to, of its facts and table."""
    table, prices, machine = tables[TABLE], facts["prices"], facts["machine"]
    best = table.iloc[int(table["block_steps_per_s"].argmax())]
    tried = ", ".join(f"{name} {count}" for name, count in prices["tried"].items())
    short = [row for row in prices["rows"] if "settings" not in row]
    unmet = [f"{row['name']} at {value_of(row, 'error_met')}" for row in short]
    flags = " ".join(machine["vector_flags"])
    return Finding(
        kind="Bench",
        title="What steps and accuracy cost on this machine",
        facts=facts,
        tables=tables,
        sentences=[
            f"{best['engine']} makes {three(best['block_steps_per_s'])} steps of a block a second "
            "on this machine.",
            *([f"Met by no setting tried in its time: {', '.join(unmet)}."] if unmet else []),
            f"Settings tried: {tried}; all of it took {three(float(prices['took_s']))} s.",
            *(f"Not installed: {line}" for line in prices["missing"]),
        ],
        sheets=[
            sheet_of(
                f"Measured here and now: {machine['cpu']}, {machine['cores']} cores, {flags}", table
            ),
            _pairs("Ratios", "ratio", "value", facts["ratios"]),
            _price_sheet(prices["rows"]),
            sheet_of(
                "Steps of a block in space in a CPU second, one core",
                pd.DataFrame([prices["space"]]),
            ),
            _pairs("Commands", "command", "wall time_s", facts["commands"]),
        ],
        rows={"rows": TABLE},
        then="warprock trade",
    )


BENCH = Kind(
    (TABLE,),
    tell_bench,
    "prices",
    {
        "machine": {"cpu": str, "cores": int, "vector_flags": [str]},
        "ratios": {...: (float, None)},
        "commands": {...: (float, None)},
        "prices": {
            "rows": [{"error_met": float, "name": str, ...: (float, str, None)}],
            "space": {...: (float, str, None)},
            "missing": [str],
            "tried": {...: int},
            "took_s": float,
        },
    },
)


def find_device_bench(found: Mapping[str, Any]) -> Finding:
    """What a benchmark on a device came to.

    Args:
        found: What `measure.device_bench.run_device_bench` measured.
    """
    facts = {key: plain(found[key]) for key in ("device", "machine", "duration")}
    return tell_device_bench(facts, {DEVICE_TABLE: pd.DataFrame(found["rows"])})


def tell_device_bench(facts: Facts, tables: Tables) -> Finding:
    """What a benchmark on a device came to, of its facts and table."""
    table, machine = tables[DEVICE_TABLE], facts["machine"]
    best = table.iloc[int(table["lanes_per_s"].argmax())]
    return Finding(
        kind="Bench on a device",
        title=f"Lanes a second on {facts['device']}",
        facts=facts,
        tables=tables,
        sentences=[f"{best['engine']} runs {three(best['lanes_per_s'])} lanes a second there."],
        sheets=[
            Sheet(
                f"Lanes a second on {facts['device']}, each {three(facts['duration'])} s of free "
                "rocking, by the number of lanes; kernel: without what the host does; cpu: "
                f"{machine['cpu']}, {machine['cores']} cores",
                *_by_count(table),
            )
        ],
        rows={"rows": DEVICE_TABLE},
        then="warprock run CASE --device NAME",
    )


DEVICE_BENCH = Kind(
    (DEVICE_TABLE,),
    tell_device_bench,
    "duration",
    {
        "device": str,
        "machine": {"cpu": str, "cores": int},
        "duration": float,
    },
)


def _pairs(title: str, name: str, value: str, found: Mapping[str, Any]) -> Sheet:
    """A table of names and numbers."""
    return Sheet(
        title,
        [Heading(name), heading(value)],
        [[key, three(number)] for key, number in found.items()],
    )


def _price_sheet(rows: Sequence[Mapping[str, Any]]) -> Sheet:
    """What each error costs, of all that meet it."""
    met = [row for row in rows if "settings" in row]
    names = list(dict.fromkeys(name for row in met for name in row))
    cells = [
        [about(row.get(name)) if "/" in name else three(row.get(name)) for name in names]
        for row in met
    ]
    return Sheet(_COSTS, [heading(name) for name in names], cells)


def _by_count(table: pd.DataFrame) -> tuple[list[Heading], list[list[str]]]:
    """Headings and rows, one an engine, scene and precision: lanes a second by their number."""
    counts = sorted(int(count) for count in table["lanes"].unique())
    names = ("engine", "scene", "precision")
    heads = [*names, *(three(count) for count in counts), "kernel", "cpu"]
    rows = []
    for key, mine in table.groupby(list(names), sort=False):
        rates = dict(zip(mine["lanes"], mine["lanes_per_s"], strict=True))
        last = mine.iloc[-1]
        numbers = [rates.get(count) for count in counts]
        numbers += [last["kernel_lanes_per_s"], last["cpu_lanes_per_s"]]
        rows.append([*map(str, key), *map(three, numbers)])
    return [Heading(name) for name in heads], rows
