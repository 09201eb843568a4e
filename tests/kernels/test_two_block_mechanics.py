"""Accelerations and impacts of two stacked blocks in the kernels, against numbers by hand."""

from typing import Any

import numpy as np
import warp as wp

from warprock.kernels.launch.instance import kernel_module, module_options
from warprock.oracle.pair_mechanics import TwoBlocks
from warprock.units import GRAVITY

PAIR = TwoBlocks(width=(0.2, 0.15), height=(0.6, 0.6), density=(128.16 / 0.12, 132.165 / 0.09))
"""Masses of 128.16 kg and 132.165 kg."""

mechanics: Any = kernel_module("two_block/stack_mechanics", precision="float64")
contact: Any = kernel_module("two_block/stack_contact", precision="float64")
wp.set_module_options(module_options())


@wp.kernel
def known(
    stack: mechanics.Stack,
    found: wp.array(dtype=mechanics.Pair),
):
    """The accelerations in one state, and the rates after one impact with its pattern."""
    one = wp.float64(1.0)
    found[0] = mechanics.accelerations(
        stack,
        one,
        one,
        mechanics.Pair(wp.float64(0.05), wp.float64(0.12)),
        mechanics.Pair(wp.float64(0.3), wp.float64(-0.4)),
        wp.float64(1.5),
    )
    hit = contact.after_impulse(
        stack,
        one,
        one,
        True,
        False,
        mechanics.Pair(wp.float64(0.0), wp.float64(0.1)),
        mechanics.Pair(wp.float64(-0.5), wp.float64(0.3)),
        wp.float64(0.0),
    )
    found[1] = hit.motion
    found[2] = mechanics.Pair(hit.ground, hit.interface)


def test_the_known_accelerations_and_the_known_impact() -> None:
    # Worked out by hand from the closed equations, to nine digits.
    lower, upper, lane = mechanics.Block(), mechanics.Block(), mechanics.Lane()
    for block, place in ((lower, 0), (upper, 1)):
        block.mass = PAIR.mass[place]
        block.inertia = block.mass * (PAIR.width[place] ** 2 + PAIR.height[place] ** 2) / 12.0
        block.half_height = 0.5 * PAIR.height[place]
    lane.gravity, lane.reach, lane.upper_narrower = GRAVITY, 1.2, 1
    lane.ground, lane.interface = 0.1, 0.075
    stack = mechanics.Stack()
    stack.lower, stack.upper, stack.lane = lower, upper, lane
    found = wp.zeros(3, dtype=mechanics.Pair, device="cpu")
    wp.launch(known, dim=1, inputs=[stack, found], device="cpu")
    np.testing.assert_allclose(found.numpy()[0], (-4.00917638, -0.77064208), atol=5e-9)
    np.testing.assert_allclose(found.numpy()[1], (-0.37983683, 0.09930024), atol=5e-9)
    np.testing.assert_array_equal(found.numpy()[2], (-1.0, 1.0))
