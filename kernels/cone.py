"""Coulomb's law at a single contact, solved exactly.

Impulses n >= 0 and |f| <= mu n change the normal velocity by nn n + nt f and the slip by
nt n + tt f. Sweeps that find n from f and f from n in turn do not converge where the contact slides
and mu |nt| > nn: n jumps between zero and too much, and a sliding corner with high friction hops.
"""

import warp as wp


@wp.func
def alone(mu: real, r: real, q: real, u: real, s: real):
    """Impulses n and f of the contact. Where sticking and leaving both obey the law, it sticks.

    With un and us the normal velocity above what is wanted and the slip, without contact:

    Args:
        mu: Friction coefficient.
        r: nt / nn.
        q: nt / tt.
        u: -un / nn, the normal impulse that would do without friction.
        s: -us / tt, the friction that would do without a normal impulse.
    """
    one = real(1.0)
    # Both at once, times 1 - r q > 0.
    n = fused_less(r, s, u)
    f = fused_less(q, u, s)
    sticks = size(f) <= mu * n
    side = sign_of(f)
    # Friction that lifts the contact more than its normal impulse presses it cannot be sliding.
    bound = mu * r
    side = wp.where(fused(side, bound, one) > real(0.0), side, -side)
    over = one / wp.where(sticks, fused_less(r, q, one), fused(side, bound, one))
    n = over * larger(wp.where(sticks, n, u), real(0.0))
    return n, wp.where(sticks, over * f, side * mu * n)
