"""How a run of an assembly is asked for, where it is in time, and what it leaves behind."""

import warp as wp

if BONDS:
    from warprock.kernels.assembly.bond import Breaks
if SPRINGS:
    from warprock.kernels.dem.stack import Knobs as Stiffness

SETTLING = 0 if SPRINGS else 3
"""Solves before the run; blocks on springs start in equilibrium."""

SAME = real(1.0e-6)
"""Part of a step up to which the end of a step is a sample's time: round-off."""

ROOM, FIRST = 20, 20
"""Times the most sweeps of a step that solves before the run, which start from nothing, and its
first steps may take: what the former leave of high columns the latter have to find."""


DRIFT = real(1.0e-5)
"""How far solves that do not settle may move blocks in a run, over the half diagonal of the
smallest block: of blocks of half a metre 3 micrometres, a twentieth of what a standing wall may
creep. Where the forces between blocks are not unique, sweeps may circle in a few steps of a run."""


@wp.struct
class Knobs:
    """Settings.

    Attributes:
        time_steps: Time step of each pack [s].
        gravity: [m/s^2].
        settled: Velocity below which a step is settled [m/s].
        after_collapse: How long a lane goes on after its collapse [s].
        sweeps: Most sweeps of a step.
        stiffness: Of springs, dashpots and what they hold, see dem/stack.py.
    """

    time_steps: wp.array(dtype=real)
    gravity: real
    settled: real
    after_collapse: real
    sweeps: int
    if SPRINGS:
        stiffness: Stiffness


@wp.struct
class Clock:
    """A lane in time.

    Attributes:
        count: Steps done, negative while contacts settle.
        sample: Samples stored.
        goes: 1 where it ends a step, if it had begun one, and begins the next; else 0.
        ended: 1 where it ends one.
        keeps: 1 where what it ends is a step of the run; 0 of a solve before it.
        base: Velocity of its base [m/s].
        gain: What that gained in the step.
        phase: Which solve of a step it is in, see landing.py.
        strikes: 1 where the next one of a step in which a corner lands begins, else 0.
        part: The part of the step after which the first corner lands.
        lands: 1 where one lands before the end of the step, else 0.
        drift: How far what steps have left unsettled has moved blocks [m].
    """

    count: int
    sample: int
    goes: int
    ended: int
    keeps: int
    base: real
    gain: real
    phase: int
    strikes: int
    part: real
    lands: int
    drift: real


@wp.struct
class Result:
    """What a lane leaves behind."""

    mode: int
    steps: int
    impacts: int
    sweeps: int
    astray: int
    uplift_time: real
    moved: real
    deepest: real
    peak: real
    peak_time: real
    collapse_time: real
    still: real
    residual: real
    loss: real
    supplied: real
    returned: real


@wp.struct
class BlockResult:
    """What a block leaves behind: its largest rotation [rad] and displacement [m], its last one."""

    theta: real
    moved: real
    last: real


@wp.struct
class ContactResult:
    """What a contact leaves behind: its widest gap, its largest |slide|, its last slide [m]."""

    opening: real
    most: real
    slide: real


@wp.struct
class Found:
    """Where the kernel leaves what it finds.

    Attributes:
        results: Of every lane, shape [lane].
        blocks: Of every block, shape [block, lane].
        contacts: Of every contact, shape [contact, lane].
        rotations: At the samples [rad], positive counterclockwise, shape [sample, block, lane];
            empty if not asked for.
        places: Centres x and z at the samples [m], shape [sample, block, 2, lane]; likewise.
        breaks: Bonds that broke, shape [lane].
        bonds: 1 where the joint of a contact is bonded at the end, shape [contact, lane].
    """

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    contacts: wp.array2d(dtype=ContactResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)
    if BONDS:
        breaks: wp.array(dtype=Breaks)
        bonds: wp.array2d(dtype=int)
