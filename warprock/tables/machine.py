"""What `doctor` and `bench` print: this machine, and what steps and accuracy cost on it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from warprock.findings.numbers import three
from warprock.tables.terminal import print_end, print_rows, wide_stdout


def print_examination(found: Mapping[str, Any]) -> None:
    """Prints what `measure.doctor.examine` found."""
    out = wide_stdout()
    for name, version in found["versions"].items():
        out.print(f"{name}: {version or 'missing'}")
    out.print(f"cpu: {found['cpu']}, {found['cores']} cores")
    flags = ", ".join(found["vector_flags"]) or "not listed by this system"
    out.print(f"vector instructions: {flags}")
    for device in found["devices"]:
        out.print(f"device {device['device']}: {device['name']}")
    cache = found["kernel_cache"]
    built = ", ".join(f"{name} {count}" for name, count in cache["built_by_engine"].items())
    text = (
        f"kernel cache: {cache['folder']}, {cache['built_modules']} built kernels, "
        f"{three(1e-6 * cache['bytes'])} MB" + (f": {built}" if built else "")
    )
    out.print(text, soft_wrap=True)
    out.print(f"kernel sources: sha256 {found['kernel_sha256'][:16]}")
    for name, state in found["engines"].items():
        out.print(f"engine {name}: {state}")
    for note in found["notes"]:
        out.print(f"note: {note}")
    for thing in found["missing"]:
        out.print(f"missing: {thing}", style="bold red")
    if not found["missing"]:
        print_end("Nothing is missing.", "warprock run free-b0 -o results")


def print_bench(found: Mapping[str, Any]) -> None:
    """Prints what `measure.bench.run_bench` measured; `prices` is of `measure.peers.compare`."""
    facts = found["machine"]
    flags = " ".join(facts["vector_flags"])
    print_rows(
        f"Measured here and now: {facts['cpu']}, {facts['cores']} cores, {flags}", found["rows"]
    )
    print_rows("Ratios", [{"ratio": k, "value": v} for k, v in found["ratios"].items()])
    _print_prices(found["prices"])
    print_rows("Commands", [{"command": k, "seconds": v} for k, v in found["commands"].items()])
    best = max(found["rows"], key=lambda row: float(row["block_steps_per_s"]))
    print_end(
        f"{best['engine']} makes {three(best['block_steps_per_s'])} steps of a block a second "
        "on this machine.",
        "warprock trade",
    )


def _print_prices(found: Mapping[str, Any]) -> None:
    """Prints what `measure.peers.compare` measured."""
    out = wide_stdout()
    rows, left = [], []
    for row in found["rows"]:
        if "settings" not in row:
            left.append(f"{row['name']} at {row['error_met']:g}")
            continue
        shown = {"error met": f"{row['error_met']:g}"} | {k: row[k] for k in list(row)[1:]}
        rows.append({k: about(v) if "/" in k else v for k, v in shown.items()})
    print_rows(
        "Block B0, 5 s of free rocking, one core: the cheapest setting tried that meets an error "
        "(median over nine starts); costs over those of event are rounded",
        rows,
    )
    if left:
        out.print(f"met by no setting tried in its time: {', '.join(left)}", soft_wrap=True)
    tried = ", ".join(f"{name} {count}" for name, count in found["tried"].items())
    out.print(f"settings tried: {tried}; all of it took {found['took_s']:.0f} s")
    for line in found["missing"]:
        out.print(f"not installed: {line}")
    print_rows("Steps of a block in space in a CPU second, one core", [found["space"]])


def about(ratio: float) -> str:
    """A ratio of two costs to one digit, or two after a leading 1: times are no better known."""
    if not math.isfinite(ratio) or ratio <= 0.0:
        return "-"
    leading = math.floor(math.log10(ratio))
    digits = 1 - leading if ratio < 1.95 * 10.0**leading else -leading
    return f"{round(ratio, digits):,.{max(digits, 0)}f}"


def print_device_bench(found: Mapping[str, Any]) -> None:
    """Prints what `measure.device_bench.run_device_bench` measured: a row an engine and scene."""
    facts = found["machine"]
    rows: dict[tuple[str, str, str], dict[str, Any]] = {}
    for row in found["rows"]:
        key = (row["engine"], row["scene"], row["precision"])
        table = rows.setdefault(key, dict(zip(("engine", "scene", "precision"), key, strict=True)))
        table[f"{row['lanes']:.0e}".replace("e+0", "e")] = row["lanes_per_s"]
        table["kernel"] = row["kernel_lanes_per_s"]
        table["cpu"] = row["cpu_lanes_per_s"]
    counts = sorted({name for row in rows.values() for name in row if name[0].isdigit()})
    names = ("engine", "scene", "precision", *counts, "kernel", "cpu")
    print_rows(
        f"Lanes a second on {found['device']}, each {found['duration']:g} s of free rocking, by "
        f"the number of lanes; kernel: without what the host does; cpu: {facts['cpu']}, "
        f"{facts['cores']} cores",
        [{name: row.get(name) for name in names} for row in rows.values()],
    )
    best = max(found["rows"], key=lambda row: float(row["lanes_per_s"]))
    print_end(
        f"{best['engine']} runs {three(best['lanes_per_s'])} lanes a second there.",
        "warprock run CASE --device NAME",
    )


def print_assembly_bench(found: Mapping[str, Any]) -> None:
    """Prints what `measure.assembly_bench.run_assembly_bench` measured."""
    print_rows("Assemblies, measured here and now", found["rows"])
    known = ", ".join(
        f"{scene} {low:.4g}" + ("" if low == high else f" to {high:.4g}")
        for scene, (low, high) in found["expected"].items()
    )
    out = wide_stdout()
    out.print(f"Collapse loads by limit analysis [g]: {known}.", soft_wrap=True)
    for each in found["missing"]:
        out.print(each, soft_wrap=True)
    said = "No program ran beside ours."
    if found["cheaper"]:
        times = (
            f"{three(value)} times cheaper than {name}" for name, value in found["cheaper"].items()
        )
        said = f"At no more error a lane of assembly is at least {' and '.join(times)}."
    print_end(said, "warprock compare CASE -e assembly -e mujoco -e bullet")


def print_blocks_bench(rows: Sequence[Mapping[str, Any]]) -> None:
    """Prints what `measure.blocks_bench.run_blocks_bench` measured."""
    print_rows("Walls by their number of blocks, measured here and now", rows)
