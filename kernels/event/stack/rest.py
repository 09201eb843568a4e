"""When the base lets go of a stack at rest; event/lift.py.

All forces on its interfaces are linear in the acceleration of the base and in the weight, so that
it is let go beyond one ratio of the two to either side, as a body is: that of the first interface
that opens at an end or slides.
"""

import warp as wp

from warprock.kernels.event.body.weight import nearest_lack
from warprock.kernels.event.lift import held_time, round_off
from warprock.kernels.event.stack.links import Chain, set_levers
from warprock.kernels.event.stack.rocking_end import Loads, face_load, reach_of
from warprock.kernels.event.stack.state import Limits, Shaking, State
from warprock.kernels.motion.kinds import Acceleration, expand
from warprock.kernels.shape.stack import Blocks, Pose


@wp.struct
class Bounds:
    """Accelerations of the base to -x and to +x / weight that let a stack go."""

    back: real
    ahead: real


@wp.func
def still_loads(
    blocks: wp.ref[Blocks], chain: wp.ref[Chain], pose: wp.ref[Pose], ax: real, az: real
) -> Loads:  # fmt: skip
    """Loads of a stack that moves with its base; its acceleration, upwards with gravity [m/s^2]."""
    loads = Loads()
    loads.sine = pose.sine
    loads.cosine = pose.cosine
    carried = real(0.0)
    above = real(0.0)
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        carried = carried + blocks.mass[k]
        above = above + wedge(ax, az, chain.px[k], chain.pz[k])
        loads.fx[k] = ax * carried
        loads.fz[k] = az * carried
        loads.moment[k] = above
    return loads


@wp.func
def tighten(bounds: wp.ref[Bounds], spare: real, rate: real):
    """Keeps within bounds a margin that is `spare` on a base at rest and grows by `rate`."""
    part = spare / size(rate)
    if rate < real(0.0):
        bounds.ahead = smaller(part, bounds.ahead)
    elif rate > real(0.0):
        bounds.back = smaller(part, bounds.back)


@wp.func(inline=False)
def rest_bounds(blocks: wp.ref[Blocks], pose: wp.ref[Pose]) -> Bounds:
    """Bounds of a stack at rest; the margins are those of `spare_of`."""
    chain = Chain()
    set_levers(blocks, pose, pose.touch, chain)
    weight = still_loads(blocks, chain, pose, real(0.0), real(1.0))
    push = still_loads(blocks, chain, pose, real(1.0), real(0.0))
    bounds = Bounds(NEVER, NEVER)
    for k in range(BLOCKS):
        normal0, along0 = face_load(blocks, chain.under, weight, k)
        normal1, along1 = face_load(blocks, chain.under, push, k)
        behind, ahead = reach_of(blocks, pose, k)
        moment0, moment1, mu = weight.moment[k], push.moment[k], blocks.friction[k]
        tighten(bounds, normal0, normal1)
        tighten(bounds, fused(mu, normal0, along0), fused(mu, normal1, along1))
        tighten(bounds, fused(mu, normal0, -along0), fused(mu, normal1, -along1))
        tighten(bounds, fused(ahead, normal0, moment0), fused(ahead, normal1, moment1))
        tighten(bounds, fused(behind, normal0, -moment0), fused(behind, normal1, -moment1))
    return bounds


@wp.func(inline=False)
def look_ahead(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], shaking: wp.ref[Shaking], s: wp.ref[State],
    d: real,
):  # fmt: skip
    """How long a stack at rest waits.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        shaking: The motion of the base.
        s: The state.
        d: Longest step [s].

    Returns:
        Whether the base surely holds it; longest step to where it does so no more, or again [s].
    """
    a = expand(shaking.motion, s.segment, s.time, shaking.value, shaking.slope)
    u = Acceleration()
    if VERTICAL:
        above = shaking.above
        u = expand(above.motion, above.segment, s.time, above.value, above.slope)
    bounds = rest_bounds(blocks, s.pose)
    lack, bound = nearest_lack(a, u, limits.gravity, bounds.back, bounds.ahead, d)
    slack = round_off(lack, bound, s.time)
    return lack.a0 > slack, smaller(held_time(lack, bound, slack, d), d)
