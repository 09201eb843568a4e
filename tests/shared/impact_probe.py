"""A kernel for tests: one impact of six blocks that touch one another and nothing else."""

from __future__ import annotations

import warp as wp

from warprock.kernels.launch.instance import LOOPS_STAY, kernel_module, module_options

BLOCKS = 6
real = wp.float64

stack = kernel_module("shape/stack", precision="float64", blocks=BLOCKS)
wp.set_module_options(module_options() | LOOPS_STAY)
contact = kernel_module("event/stack/contact", precision="float64", blocks=BLOCKS, bounces=True)
bouncing = kernel_module("event/stack/bounce", precision="float64", blocks=BLOCKS, bounces=True)
Blocks, Pose, Values, Counts, Triples = (
    stack.Blocks,
    stack.Pose,
    stack.Values,
    stack.Counts,
    stack.Triples,
)
Anchor, Jacobian = stack.Anchor, stack.Jacobian
Contacts, RoundOff, Solution = contact.Contacts, contact.RoundOff, contact.Solution
place_block, fill_jacobian, solve = stack.place_block, stack.fill_jacobian, contact.solve
Rebound, bounce = bouncing.Rebound, bouncing.bounce
OPEN = stack.OPEN


@wp.kernel
def strike(
    blocks: wp.array(dtype=Blocks),
    theta: wp.array(dtype=Values),
    anchor: wp.array(dtype=Values),
    touch: wp.array(dtype=Counts),
    glide: wp.array(dtype=Counts),
    kept: wp.array(dtype=real),
    before: wp.array(dtype=Triples),
    place: wp.array2d(dtype=real),
    after: wp.array(dtype=Triples),
    settled: wp.array(dtype=int),
):
    """Velocities after the impact, and where each block stands on the one below.

    `glide`: directions of sliding that are given, 0 where friction finds its own. `kept`: the
    restitution; above 0 friction finds its own.
    `place` gets `along` of the interfaces, then `above`; the ground is out of reach.
    """
    lane = wp.tid()
    pose = Pose()
    pose.theta = theta[lane]
    for k in range(BLOCKS):
        pose.sine[k] = wp.sin(pose.theta[k])
        pose.cosine[k] = wp.cos(pose.theta[k])
    for k in range(BLOCKS):
        if k > 0:
            place_block(blocks[lane], pose, k, touch[lane][k], Anchor(anchor[lane][k], real(1.0)))
        place[lane, k] = pose.along[k]
        place[lane, BLOCKS + k] = pose.above[k]
    touching = touch[lane]
    touching[0] = OPEN
    pose.touch = touching
    mass = real(0.0)
    for k in range(BLOCKS):
        mass += blocks[lane].mass[k]
    dust = RoundOff(real(1.0e-12), real(1.0e-12) * mass)
    jacobian, found = Jacobian(), Solution()
    fill_jacobian(blocks[lane], pose, jacobian)
    found.contacts = Contacts(touching, glide[lane])
    v, none = before[lane], Triples()
    if kept[lane] > real(0.0):
        rebound = Rebound(kept[lane], real(0.0))
        bounce(blocks[lane], jacobian, rebound, touching, v, dust, found)
    else:
        solve(blocks[lane], jacobian, touching, glide[lane], v, dust, none, found)
    after[lane] = found.velocity
    settled[lane] = wp.where(found.solved, 1, 0)
