"""The pool of samples of records, the same for kernels and for what launches them.

Its rows are the acceleration at a sample, its slope up to the next, the velocity, and the largest
|acceleration| of the sample and the AHEAD after it.
"""

AHEAD = 31
"""Samples that a block at rest may pass at once which are all too weak to move it."""
