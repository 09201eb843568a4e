"""The pool of samples of records, the same for kernels and for their launches."""

ACCELERATION, SLOPE, VELOCITY, PEAK = 0, 1, 2, 3
"""Rows of the pool: acceleration at a sample [m/s^2], its slope up to the next sample [m/s^3], the
velocity [m/s], and the largest |acceleration| of the sample and the AHEAD after it [m/s^2]."""

AHEAD = 31
"""Number of samples that a block at rest may pass at once, if all are too weak to move it."""
