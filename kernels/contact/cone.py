"""Coulomb's law at a single contact, solved exactly.

Impulses n >= 0 and |f| <= mu n change the normal velocity by nn n + nt f and the slip by
nt n + tt f. Sweeps that find n from f and f from n in turn do not converge if the contact slides
and mu |nt| > nn: n alternates between zero and too large a value, and a sliding corner with high
friction hops.
"""

import warp as wp


@wp.func
def solve_single_contact(mu: real, r: real, q: real, u: real, s: real):
    """Impulses n and f of the contact. If sticking and leaving both obey the law, it sticks.

    un is the normal velocity without contact, less the wanted one, and us the slip without contact.

    Args:
        mu: Friction coefficient.
        r: nt / nn.
        q: nt / tt.
        u: -un / nn, the normal impulse in the absence of friction.
        s: -us / tt, the friction impulse in the absence of a normal impulse.
    """
    one = real(1.0)
    # The impulses that stop both velocities, times 1 - r q > 0.
    n = fused_less(r, s, u)
    f = fused_less(q, u, s)
    sticks = size(f) <= mu * n
    side = sign_of(f)
    # If friction lifts the contact more than its normal impulse presses it, it cannot slide.
    bound = mu * r
    side = wp.where(fused(side, bound, one) > real(0.0), side, -side)
    over = one / wp.where(sticks, fused_less(r, q, one), fused(side, bound, one))
    n = over * larger(wp.where(sticks, n, u), real(0.0))
    return n, wp.where(sticks, over * f, side * mu * n)
