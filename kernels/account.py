"""Account of a lane's energy in the frame of its base, for one precision.

There the energy changes by the work of the base on the blocks, - mass x (change of the base
velocity) x (mean velocity of the block) in a step, and by that of the contacts. A velocity step of
the base is a change that is fast, no other: a block that it sets rocking about a corner that sticks
loses nothing. (Half of impulse x velocity step would be lost, as in an impact against the base, if
the base moved at its new velocity before the contacts pressed.)

Contacts are passive: together they only take, so that what they have taken, the loss, never falls,
but for what springs hold of it for a while; and there is no more to take or to hold than was there
at the start and came from the base. What they give back beyond that has come from nowhere.
"""

import warp as wp


@wp.func
def book(
    dv: real, work: real, loss: real,
    jolt: wp.ref[real], supplied: wp.ref[real], taken: wp.ref[real], returned: wp.ref[real],
):  # fmt: skip
    """Keeps the account of a lane after a step.

    Args:
        dv: Change of the base velocity in the step [m/s].
        work: Of the base on the blocks so far [J].
        loss: What the contacts have taken so far [J].
        jolt: The largest |dv| so far.
        supplied: The largest work so far.
        taken: The largest loss so far.
        returned: The most that the contacts have given back of a loss.
    """
    most = larger(loss, taken)
    jolt = larger(size(dv), jolt)
    supplied = larger(work, supplied)
    taken = most
    returned = larger(most - loss, returned)
