"""Steps in which a corner lands: forces before the landing, the impact, forces after it.

A step x' = x + h v' takes its velocity v' for that of the middle of the step: velocities lag half
a step behind. Let a corner land at the part tau of a step of length h. What the contacts before the
landing bear, (N1, T1) a step, acts on the velocities until then, over (1/2 + tau) h. What bears
after it acts from there on. One solve of the whole step lets those contacts that leave in the
impact bear nothing in it. A rocking block, of which an impact leaves the part r of its angular
velocity, then loses (1 + r) A (1/2 + tau) h too much of it, with the angular acceleration A by
which gravity slows it down. So a step in which a corner lands is solved three times:

    LANDS    without that corner: N1 and T1 of all others
    STRIKES  the impact, on top of these, of all contacts
    LEAVES   contacts that bore, take nothing of the impact and open fast have borne
             (1/2 + tau) (N1, T1) instead; once more the impact of the others

Of several corners the first one counts. What touches where no joint has it lands in one solve.

A corner that lands at the very end of a step would take so little of its impact in it that nothing
leaves, and of the rest of the impact the next step would know nothing. It lands at the start of
that one instead (`comes_down`), up to STILL g h^2 deep.
"""

import warp as wp

from warprock.kernels.assembly.joint import Impulse

LANDS, STRIKES, LEAVES = 1, 2, 3
"""The solves of a step in which a corner lands; 0 is that of any other step."""

FAST, STILL = real(10.0), real(0.1)
"""Least speed of a corner that lands, and of one that leaves, over gravity times step. A slower one
may land in one solve: that takes at most some 1 / FAST of its speed. In a lane that is slower than
STILL nothing has slid off since the last step."""


@wp.struct
class Borne:
    """What a contact bore in a step before a corner landed, N1 and T1 [N s]."""

    n: real
    t: real


@wp.func
def may_land(weighs: real, b: real, carried: real, opening: real) -> bool:
    """Whether a contact may land in a step, by the velocities before it.

    Args:
        weighs: Gravity times step [m/s]; what lands that much late may land within the step.
        b: Velocity b of the contact [m/s].
        carried: Its normal impulse in the last step [N s].
        opening: Its velocity u_n before the step [m/s].
    """
    return carried == real(0.0) and -opening > FAST * weighs and b < weighs - opening


@wp.func
def landing_part(b: real, opening: real) -> real:
    """The part of a step after which a contact lands, by b and u_n before the step; 1 if later."""
    return b / larger(-opening, b)


@wp.func
def comes_down(weighs: real, b: real, opening: real) -> bool:
    """Whether a contact lands within a step, and not at the very end of it.

    Args:
        weighs: Gravity times step [m/s].
        b: Velocity b of the contact [m/s].
        opening: Velocity u_n with which it would open without the impact [m/s].
    """
    return b + opening < -STILL * weighs


@wp.func
def leaves_by(weighs: real, borne: Borne, impulse: Impulse, opening: real) -> bool:
    """Whether a contact bore before the landing and leaves in the impact.

    Args:
        weighs: Gravity times step [m/s].
        borne: What it bore.
        impulse: What it takes of the impact.
        opening: Velocity with which it opens after that [m/s].
    """
    return borne.n > real(0.0) and impulse.n == real(0.0) and opening > STILL * weighs
