"""Bonded joints of an assembly in space, until they break once and for all.

The law of the plane (assembly/bond.py), for a joint that is a polygon. With its area A, its middle
c, J the second moments of its area about c and I_p their sum, and the forces N_i n + T_i of its
contacts at r_i from c,

    N = sum N_i,   m = sum N_i r_i,   T = sum T_i,   M = n . sum r_i x T_i

    stress at r       N / A + r . J^-1 m              (Navier)
    shear at r        T / A + (M / I_p) n x r

A joint breaks where, at one of its corners, the stress is below -f_t, or where the shear is above
c + friction N / A (Mohr and Coulomb). Extruded from the plane, and without a moment about the
normal, both are the plane's.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.assembly_space.contact import add_part, cross, inner, times
from warprock.kernels.assembly_space.meeting import Laid


@wp.func
def is_torn(laid: Laid, lane: int, joint: int, old: int, dt: real) -> bool:
    """Whether what a joint bore in a step is more than its strength.

    Args:
        laid: Where the blocks are, at the start of the step.
        lane: The lane.
        joint: The joint.
        old: Where the list of contacts of the step begins.
        dt: Length of the step [s].
    """
    link, joined = laid.links[lane, joint], laid.joined[lane, joint]
    place = laid.places[lane, link.a]
    middle = times(place.r, link.middle)
    over = real(1.0) / (link.area * dt)
    stress, twist = real(0.0), real(0.0)
    bends, shear, normal = Vector(), Vector(), Vector()
    for i in range(joined.count):
        at = laid.contacts[lane, old + joined.first + i]
        held = laid.impulses[lane, old + joined.first + i]
        r = at.ra - middle
        drag = held.t * at.t + held.s * at.s
        stress = fused(over, held.n, stress)
        bends = add_part(held.n, r, bends)
        shear = add_part(over, drag, shear)
        twist = twist + inner(at.n, cross(r, drag))
        normal = at.n
    # J^-1 is kept in the axes of the first block.
    slope = times(place.r, times(link.bending, wp.transpose(place.r) * bends))
    bears = larger(fused(link.friction, stress, link.cohesion), real(0.0))
    torn = bool(False)
    for i in range(joined.count):
        r = laid.contacts[lane, old + joined.first + i].ra - middle
        least = stress + inner(r, slope) / dt
        drag = add_part(twist * link.twisting / dt, cross(normal, r), shear)
        torn = torn or least < -link.tension or inner(drag, drag) > bears * bears
    return torn and joined.count > 0
