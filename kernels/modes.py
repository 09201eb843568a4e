"""Modes of a lane: the number by which a kernel tells how a lane stands, the same in all schemes.

A lane runs as long as its mode is below OVERTURNED; every other mode is how it ended.
"""

RUNNING = 0
"""The lane runs, and its scheme tells no more of it."""

RESTING, ROCKING = 0, 1
"""Modes of a lane that runs, in Housner's model."""

FLYING, PIVOTING, FLAT = 0, 1, 2
"""Modes of a single block that runs, in the event-driven scheme in the plane."""

OVERTURNED = 3
SLID_OFF = 4
"""A block has no support below it any more."""
BROKEN = 5
"""A number of the state is not finite."""
STALLED = 6
"""The lane took all the steps that it may take, and has not come to its end."""
UNSOLVED = 7
"""No contact forces were found that obey the law."""
