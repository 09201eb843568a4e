"""What `doctor`, `bench assembly` and `bench blocks` print."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from warprock.findings.digits import number_of
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


def _range_of(column: str, low: float, high: float) -> str:
    """Two numbers of a column as a range, and one where they are equal."""
    return " to ".join(dict.fromkeys(number_of(column, end) for end in (low, high)))


def print_assembly_bench(found: Mapping[str, Any]) -> None:
    """Prints what `measure.assembly_bench.run_assembly_bench` measured."""
    print_rows("Assemblies, measured here and now", found["rows"])
    known = ", ".join(
        f"{scene} {_range_of('collapse_load_g', low, high)}"
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
