"""The pool of samples of records, the same for kernels and for their launches.

Its rows are the acceleration at a sample, its slope up to the next, the velocity, and the largest
|acceleration| of the sample and the AHEAD after it.
"""

AHEAD = 31
"""Number of samples that a block at rest may pass at once, if all are too weak to move it."""
