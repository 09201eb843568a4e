"""What runs of the event step in space know of lanes, blocks or stacks."""

import warp as wp


@wp.struct
class Knobs:
    """What the lanes have in common."""

    gravity: real


@wp.struct
class Lane:
    """One lane: its longest step [s], the rise it rests from [m], its largest number of steps."""

    longest_step: real
    rest_gap: real
    step_limit: int
