"""Springs at the contacts of an assembly: the soft law of distinct elements.

Where SPRINGS is true, a contact bears by a normal and a shear spring with dashpots, Coulomb's
slider, cohesion and tension until it fails: `solve_spring` of dem/stack.py. Each of the two
contacts of a joint stands for half of its area. Forces come from where the blocks are at the start
of a step and from their velocities half a step before (central differences). So all are known at
once, without sweeps.

The energy that springs hold for a while is no loss: the account of a lane takes its changes out.
"""

import warp as wp

from warprock.kernels.assembly.joint import Contact, Edges, opening_speed, sliding_speed
from warprock.kernels.dem.stack import Knobs as Stiffness
from warprock.kernels.dem.stack import Pace, Spring, solve_spring
from warprock.kernels.shape.interface import Velocity


@wp.struct
class Store:
    """Energy in the springs of a lane at the start of this step, and of the last one [J]."""

    now: real
    before: real


@wp.func
def press(
    stiffness: Stiffness, pace: Pace, edges: Edges, at: Contact, gap: real, va: Velocity,
    vb: Velocity, spring: wp.ref[Spring],
):  # fmt: skip
    """What the springs of a contact do in a step.

    Args:
        stiffness: The settings.
        pace: The clock of the lane.
        edges: The joint.
        at: The contact.
        gap: Its gap [m]; NEVER or more where the corner has left the other edge.
        va, vb: Velocities of the blocks.
        spring: Its springs; they move on.

    Returns:
        Impulses N and T [N s], energy in the springs [J].
    """
    overlap = -smaller(gap, NEVER)
    opens, slides = opening_speed(at, va, vb), sliding_speed(at, va, vb)
    normal, shear, energy = solve_spring(
        stiffness, pace, edges.friction, overlap, opens, slides, spring
    )
    scale = pace.dt * edges.area
    return scale * normal, scale * shear, HALF * edges.area * energy
