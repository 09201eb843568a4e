"""What `doctor` and `bench` print: this machine, and what steps and accuracy cost on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warprock.tables.terminal import measured, print_end, print_rows, wide_stdout


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
        f"{measured(1e-6 * cache['bytes'])} MB" + (f": {built}" if built else "")
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
    """Prints what `measure.bench.run_bench` and `measure.peers.compare` measured."""
    facts = found["machine"]
    flags = " ".join(facts["vector_flags"])
    print_rows(
        f"Measured here and now: {facts['cpu']}, {facts['cores']} cores, {flags}", found["rows"]
    )
    print_rows("Ratios", [{"ratio": k, "value": v} for k, v in found["ratios"].items()])
    print_rows("Block B0, free rocking over 5 s: error and its cost, one core", found["accuracy"])
    peers = found["peers"]
    if peers["rows"]:
        hidden = ("settings", "cpu_s")
        rows = [{k: v for k, v in row.items() if k not in hidden} for row in peers["rows"]]
        print_rows("The same block in peers, one core, beside event at no larger an error", rows)
        for name, settings in {row["peer"]: row["settings"] for row in peers["rows"]}.items():
            wide_stdout().print(f"{name}: {settings}")
    print_rows("Steps of a block in space in a CPU second, one core", [peers["space"]])
    for line in peers["missing"]:
        wide_stdout().print(f"peer not installed: {line}")
    print_rows("Commands", [{"command": k, "seconds": v} for k, v in found["commands"].items()])
    best = max(found["rows"], key=lambda row: float(row["block_steps_per_s"]))
    print_end(
        f"{best['engine']} makes {measured(best['block_steps_per_s'])} steps of a block a second "
        "on this machine.",
        "warprock trade",
    )


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
        f"{best['engine']} runs {measured(best['lanes_per_s'])} lanes a second there.",
        "warprock run CASE --device NAME",
    )
