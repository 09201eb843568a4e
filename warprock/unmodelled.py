"""Words for what warprock does not model, and what is nearest to each: README lists the same.

A stranger looks for an anchor, a hazard model or a wall. `warprock keys WORD`, errors about unknown
keys and the function behind both say here what there is instead.
"""

from __future__ import annotations

from typing import NamedTuple


class Unmodelled(NamedTuple):
    """Something that warprock does not model.

    Attributes:
        what: What it is, in the words of README's list.
        words: Words that people use for it, lower case, singular, parts joined by a space.
        nearest: What is nearest in warprock.
    """

    what: str
    words: tuple[str, ...]
    nearest: str


UNMODELLED = (
    Unmodelled(
        "Ties, anchors and restraints, but for the horizontal [[tie]] of a single box in the plane",
        (
            *("tie rod", "rod", "tendon", "cable", "strap", "bracket", "brace", "dowel"),
            *("anchor", "anchorage", "anchor bolt", "bolt", "restraint", "restrainer", "tether"),
            *("post tension", "fixing", "hook"),
        ),
        "[[tie]] and [transverse_wall] of a single [block]; joints with cohesion of dem: "
        "engines.dem.cohesion",
    ),
    Unmodelled(
        "Springs and dampers under a block, but for the [support] that moves sideways and the "
        "[ground] below a single box in the plane",
        ("isolator", "isolation", "base isolation", "damper", "spring", "bearing", "tmd"),
        "[support], a linear oscillator between motion and block; [ground], stiffness and damping "
        "a unit of area below a [block]; "
        "contact stiffness and damping of the engines dem and direct: warprock keys engines.dem",
    ),
    Unmodelled(
        "Neighbours and other obstacles that a block strikes, but for the [transverse_wall] that a "
        "single box leans against",
        (
            *("wall", "neighbour", "neighbor", "obstacle", "pounding", "corner wall"),
            *("vault", "facade", "building"),
        ),
        "a [transverse_wall] beside one [block], or a stack of up to six (twenty in event in the "
        "plane), [block.1], [block.2], ...; an [assembly], a wall or an arch of many blocks; "
        "motion of a floor as the record of the base",
    ),
    Unmodelled(
        "Hazard models: how often a motion comes is read from a hazard curve, not computed",
        (
            *("hazard", "hazard curve", "risk", "return period", "annual rate", "psha", "loss"),
            *("collapse rate", "design spectrum", "response spectrum"),
        ),
        "warprock risk, which takes a hazard curve as a file or as k0 and k",
    ),
    Unmodelled(
        "Soil, but for the [ground]: the base is rigid and does not rotate",
        ("soil", "soil structure interaction", "ssi", "foundation", "tilt of the base"),
        "[ground] below a [block] in the plane, stiffness and damping a unit of area; compliant "
        "contact in dem and direct",
    ),
    Unmodelled(
        "Crushed and cracked corners, and mortar: blocks are rigid",
        (
            *("crushing", "crack", "cracking", "damage", "fracture", "mortar", "elasticity"),
            *("young modulus", "youngs modulus", "elastic modulus", "strength", "flexibility"),
        ),
        "a chamfer or rounded edge in [block], angular_restitution in [contact]; joints with "
        "cohesion in engines.dem",
    ),
    Unmodelled(
        "Wind, water, blows and liquids inside: only the base moves a block, or one push on all",
        (
            *("wind", "tsunami", "flood", "push", "force", "pushover", "blast"),
            *("liquid", "sloshing", "fluid", "content", "tank"),
        ),
        'start velocities in [start], and the motion of the base in [motion], with waveform "push"',
    ),
)
"""What strangers look for, and do not find."""


def unmodelled(word: str) -> Unmodelled | None:
    """What a word means that warprock does not model; None for any other word.

    Args:
        word: As somebody writes it: `tie_rod`, `Anchors`, or one of these as a key of a table.
    """
    bare = " ".join(word.rpartition(".")[2].replace("_", " ").replace("-", " ").lower().split())
    bare = bare.replace("'", "")
    forms = {bare, bare.removesuffix("s"), bare.removesuffix("es")}
    forms |= {bare.partition(" ")[0].removesuffix("s"), bare.rpartition(" ")[2].removesuffix("s")}
    return next((each for each in UNMODELLED if forms & set(each.words)), None)


def unmodelled_text(word: str) -> str:
    """The end of an error about an unknown word: that it is not modelled, and what is nearest."""
    found = unmodelled(word)
    return "" if found is None else f"; not modelled: {found.what}; nearest: {found.nearest}"
