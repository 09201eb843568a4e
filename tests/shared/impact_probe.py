"""A kernel for tests: one impact of six blocks that touch one another and nothing else."""

from __future__ import annotations

import warp as wp

from warprock.kernels.instance import LOOPS_STAY, kernel_module, module_options

BLOCKS = 6
real = wp.float64

stack = kernel_module("shape/stack", precision="float64", blocks=BLOCKS)
wp.set_module_options(module_options() | LOOPS_STAY)
contact = kernel_module("event/stack_contact", precision="float64", blocks=BLOCKS)
Blocks, Pose, Values, Counts, Triples = (
    stack.Blocks,
    stack.Pose,
    stack.Values,
    stack.Counts,
    stack.Triples,
)
carried, between, all_rows, solve = (
    stack.carried,
    stack.between,
    stack.all_rows,
    contact.solve,
)
OPEN = stack.OPEN


@wp.kernel
def strike(
    blocks: wp.array(dtype=Blocks),
    theta: wp.array(dtype=Values),
    anchor: wp.array(dtype=Values),
    touch: wp.array(dtype=Counts),
    glide: wp.array(dtype=Counts),
    before: wp.array(dtype=Triples),
    place: wp.array2d(dtype=real),
    after: wp.array(dtype=Triples),
    settled: wp.array(dtype=int),
):
    """Velocities after the impact, and where each block stands on the one below.

    `glide`: directions of sliding that are given, 0 where friction finds its own.
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
            _s, _c, sd, cd = between(pose, k)
            along, above = carried(
                blocks[lane], k, touch[lane][k], anchor[lane][k], real(1.0), sd, cd
            )
            pose.along[k] = along
            pose.above[k] = above
        place[lane, k] = pose.along[k]
        place[lane, BLOCKS + k] = pose.above[k]
    touching = touch[lane]
    touching[0] = OPEN
    pose.touch = touching
    upper, lower, _plus, _minus = all_rows(blocks[lane], pose)
    mass = real(0.0)
    for k in range(BLOCKS):
        mass += real(1.0) / blocks[lane].inverse_mass[k]
    v, _p, _hold, _slip, done, _first, _left = solve(
        blocks[lane], upper, lower, touching, glide[lane], touching, glide[lane], before[lane],
        real(1.0e-12), mass,
    )  # fmt: skip
    after[lane] = v
    settled[lane] = wp.where(done, 1, 0)
