"""Bonded joints of an assembly: cohesion and tensile strength, until they break once and for all.

While a joint is bonded its two ends neither open nor slide, whatever they bear. After every step
its force is held against its strength, as a section of area A and length d under a linear stress
(Navier) and in shear by Coulomb with cohesion (Mohr): with the normal forces N_1 and N_2 at its
ends, N = N_1 + N_2, and T = T_1 + T_2, it breaks where

    (2 N_1 - 4 N_2) / A > f_t     or  (2 N_2 - 4 N_1) / A > f_t     or  |T| > c A + friction N

The first two are the stresses -N / A +- 6 M / (A d) at its ends, M = (N_2 - N_1) d / 2. So a pair
of blocks that is pulled apart at a distance e from the middle tears at f_t A / (1 + 6 e / d). A
joint that breaks is dry from the next step on: brittle, without any softening. The forces of a step
are impulses over its length, so an impact on a bonded block breaks its joints the sooner the
shorter the step.

Bonds set once the joints, still dry, bear the weight: under it nothing pulls where these stand. Of
a pile of bonded blocks what single joints bear is not unique, nor then which of them breaks
first, as everywhere where rigid blocks have more joints than equations.
"""

import warp as wp

from warprock.kernels.assembly.joint import Edges, Impulse


@wp.struct
class Bond:
    """A joint from step to step: 1 while it is bonded, else 0."""

    holds: int


@wp.struct
class Breaks:
    """Bonds of a lane that broke: how many, and when the first one did [s]; NEVER before."""

    count: int
    first: real


@wp.func
def is_torn(edges: Edges, rate: real, one: Impulse, other: Impulse) -> bool:
    """Whether what a joint bore in a step is more than its strength.

    Args:
        edges: The joint.
        rate: 1 / time step [1/s].
        one, other: Impulses at its two ends.
    """
    two, four = real(2.0), real(4.0)
    first, second = rate * one.n, rate * other.n
    edge = larger(two * first - four * second, two * second - four * first)
    shear = rate * size(one.t + other.t)
    bears = larger(fused(edges.friction, first + second, edges.cohesion), real(0.0))
    return edge > edges.tension or shear > bears


@wp.func
def after_break(friction: real, held: Impulse) -> Impulse:
    """What a dry contact may keep of the impulses of a bonded one."""
    kept = Impulse()
    kept.n = larger(held.n, real(0.0))
    bound = friction * kept.n
    kept.t = smaller(larger(held.t, -bound), bound)
    return kept
