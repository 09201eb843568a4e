"""The energy account of a lane, in the frame of its base.

In that frame energy changes in two ways. The base does the work
- mass x (change of the base velocity) x (mean velocity of the block) on a block in a step. And the
contacts do work. A velocity step of the base is a fast change of this kind: if it makes a block
rock about a sticking corner, no energy is lost. (If the base had its new velocity before the
contacts pressed, half of impulse x velocity step would be lost in the impact.)

Contacts only take energy. So the loss, the energy that they have taken so far, never decreases,
except by the energy that springs store for a while. It never exceeds the energy at the start plus
the work of the base. A run that breaks this has created energy.
"""

import warp as wp


@wp.struct
class Account:
    """The energy account of a lane.

    Attributes:
        work: Work of the base on the blocks so far [J].
        loss: Energy that the contacts have taken so far [J].
        jolt: Largest change of the base velocity in a step so far [m/s].
        supplied: Largest work so far [J].
        taken: Largest loss so far [J].
        returned: Largest decrease of the loss below its maximum so far [J].
    """

    work: real
    loss: real
    jolt: real
    supplied: real
    taken: real
    returned: real


@wp.func
def keep_account(dv: real, account: Account) -> Account:
    """The account after a step in which the base velocity changes by dv [m/s].

    `account` holds the work and the loss after the step.
    """
    taken = larger(account.loss, account.taken)
    return Account(
        account.work, account.loss,
        larger(size(dv), account.jolt), larger(account.work, account.supplied),
        taken, larger(taken - account.loss, account.returned),
    )  # fmt: skip
