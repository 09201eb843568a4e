"""Modes of a lane: numbers for how it stands, the same in all schemes.

A lane runs while its mode is below OVERTURNED. Every other mode says how it ended.
"""

RUNNING = 0
"""The lane runs; for schemes that distinguish no more."""

RESTING, ROCKING = 0, 1
"""Modes of a lane that runs, in Housner's model."""

FLYING, PIVOTING, FLAT = 0, 1, 2
"""Modes of a single block that runs, in the event-driven scheme in the plane."""

OVERTURNED = 3
SLID_OFF = 4
"""A block no longer has a support below it."""
BROKEN = 5
"""A number of the state is not finite."""
STALLED = 6
"""The lane has used all its steps before its end."""
UNSOLVED = 7
"""No contact forces that obey the contact law were found."""
