"""What `list` and `explain` print: what there is to choose from, and what a case requires."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.findings.digits import quantity_of
from warprock.findings.numbers import three
from warprock.findings.sheets import heading
from warprock.tables.terminal import (
    cell_text,
    print_rows,
    say,
    wide_stdout,
)


def print_listing(found: Mapping[str, Any]) -> None:
    """Prints what `running.choices.list_all` found."""
    print_rows("Cases", found["cases"])
    print_rows("Engines", found["engines"])
    print_rows("Programs of others, for compare", found["programs"])


def _duration_text(found: Mapping[str, Any]) -> str:
    least, most = found["shortest_duration_s"], found["duration_s"]
    ends = [quantity_of("duration_s", end) for end in (least, most)]
    return " to ".join(dict.fromkeys(ends))


def print_explanation(found: Mapping[str, Any]) -> None:
    """Prints what `running.catalogue.explain_case` found."""
    out = wide_stdout()
    case, scene = found["case"], found["scene"]
    out.print(f"{case['name']}: {case['title']}", style="bold")
    out.print(case["source"].strip())
    say(out, f"\nScene: {scene['why']}.")
    restitution = "given by the case" if scene["restitution_given"] else "Housner's closed form"
    if scene["held"] in (("frame",), ("strip",)) and not scene["restitution_given"]:
        restitution = "from the momentum that its motion after an impact keeps"
    if scene["held"] == ("ground",):
        restitution = "what the dampers of the ground leave"
    if scene["stacked"] or scene["spatial_because"] or scene["assembly"]:
        restitution = "from the contact laws of the engine"
    sampling = found["sample_interval_s"]
    blocks, waveform = (found["inputs"].get(name) for name in ("blocks", "waveform"))
    facts = [
        ("blocks", _spread_text(blocks) if blocks else scene["block_count"]),
        ("contact points", scene["contact_point_count"]),
        ("ground motion", _spread_text(waveform) if waveform else "none"),
        ("angular restitution", restitution),
        ("lanes", f"{found['lanes']:,}"),
        ("duration", _duration_text(found)),
        (
            "histories",
            "not asked for" if sampling is None else f"every {quantity_of('interval_s', sampling)}",
        ),
    ]
    for name, value in facts:
        say(out, f"  {name}: {cell_text(value)}")
    if scene["touching"] is None:
        say(out, f"  friction: {_friction_text(scene)}")
    else:
        for fact in scene["laid"]:
            say(out, f"  of lane 0: {fact}")
        say(out, f"  joints: {scene['touching']}")
    for note in (
        found["scene"]["replaced"],
        found["motion_cut_short"],
        found["drift"],
        scene["friction_note"],
    ):
        if note:
            say(out, f"  note: {note}")
    for axis in found["sweep"]:
        keys = ", ".join(axis["keys"])
        out.print(f"  sweep: {keys} ({axis['length']} values)")
    if scene["left_out"]:
        _print_list(out, "Left out, because nothing here needs it", scene["left_out"])
    _print_list(out, "Not modelled (warprock keys WORD says more)", found["not_modelled"])
    if found["study"]:
        _print_study_plan(out, found["study"])
    part = found["inputs_of_lanes"] < found["lanes"]
    first = f" (of the first {found['inputs_of_lanes']:,} lanes)" if part else ""
    out.print(f"\nInputs{first}:")
    for name, spread in found["inputs"].items():
        say(out, f"  {heading(name).label}: {_spread_text(spread)}")
    engine = found["engine"]
    able = any(not each["declines"] for each in found["engines"])
    if able:
        say(out, f"\nWhere no engine is named, {engine['engine']} runs: {engine['why']}.")
    out.print("\nEngines:")
    for engine in found["engines"]:
        _print_engine(out, engine)
    if any(engine["estimate"] for engine in found["engines"]):
        say(out, f"\n{next(e['estimate'] for e in found['engines'] if e['estimate'])}")


def _print_list(out: Console, heading: str, texts: Sequence[str]) -> None:
    """Prints texts below a heading, one a line."""
    out.print(f"\n{heading}:")
    for text in texts:
        say(out, f"  {text}")


def _friction_text(scene: Mapping[str, Any]) -> str:
    """Whether blocks rock or slide, in words."""
    if scene["held"] == ("strip",):
        return "asked of base and hinge while the strip rocks; the floor lets no top slide"
    ratio = scene["friction_ratio"]
    if ratio >= 1.0:
        return (
            f"at least {three(ratio)} times what a block needs to rock instead of sliding "
            "(friction / the base acceleration in g that lifts it)"
        )
    return (
        f"in some lanes only {three(ratio)} of what a block needs to rock: there it slides "
        "instead (friction / the base acceleration in g that lifts it)"
    )


def _print_engine(out: Console, engine: Mapping[str, Any]) -> None:
    if engine["declines"]:
        say(out, f"  {engine['name']}: declines: {engine['declines']}")
        return
    say(out, f"  {engine['name']}: {engine['kernel']}")
    for name, value in engine["settings"].items():
        unit = engine["units"][name]
        suffix = "" if unit == "-" else f" {unit}"
        out.print(f"    {name} = {cell_text(value)}{suffix}")


def _print_study_plan(out: Console, study: Sequence[Mapping[str, Any]]) -> None:
    """What `run` will run of a study."""
    out.print("\nStudy: `run` varies one setting at a time; check and compare run the case's own.")
    for plan in study:
        out.print(f"  {plan['engine']}: {plan['runs']} runs")
        for row in plan["vary"]:
            unit = "" if row["unit"] == "-" else f" [{row['unit']}]"
            values = ", ".join(cell_text(value) for value in row["values"])
            own = cell_text(row["baseline"])
            out.print(f"    {row['setting']}{unit}: {values} (the case's own: {own})")
        if plan["lacks"]:
            out.print(f"    it has no {', no '.join(plan['lacks'])}")


def _spread_text(spread: Mapping[str, Any]) -> str:
    if "values" in spread:
        shown = spread["values"]
        rest = spread.get("count", len(shown)) - len(shown)
        texts = dict.fromkeys(map(cell_text, shown))
        return ", ".join(texts) + (f" and {rest:,} more" if rest else "")
    return f"{cell_text(spread['from'])} to {cell_text(spread['to'])}, {spread['count']} values"
