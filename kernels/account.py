"""The energy account of a lane, in the frame of its base.

In that frame energy changes in two ways. The base works on the blocks: in a step
- mass x (change of the base velocity) x (mean velocity of the block). And the contacts work on
them. A velocity step of the base is only a fast change: a block that it sets rocking about a
corner that sticks loses no energy. (In an impact against the base, half of impulse x velocity step
would be lost. That would hold if the base moved at its new velocity before the contacts pressed.)

Contacts only take energy. So the loss, the energy that they have taken so far, never falls, except
by what springs hold for a while; and it never exceeds the energy at the start plus the work of the
base. A run that breaks this has made energy out of nothing.
"""

import warp as wp


@wp.struct
class Account:
    """The energy account of a lane.

    Attributes:
        work: Of the base on the blocks so far [J].
        loss: What the contacts have taken so far [J].
        jolt: Largest change of the base velocity in a step so far [m/s].
        supplied: Largest work so far [J].
        taken: Largest loss so far [J].
        returned: The most that the contacts have given back of a loss [J].
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

    Its work and its loss are those after the step.
    """
    taken = larger(account.loss, account.taken)
    return Account(
        account.work, account.loss,
        larger(size(dv), account.jolt), larger(account.work, account.supplied),
        taken, larger(taken - account.loss, account.returned),
    )  # fmt: skip
