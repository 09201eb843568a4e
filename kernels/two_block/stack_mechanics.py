"""Two stacked blocks in one pattern: equations of motion and contact forces.

Rotations theta_1 (lower block) and theta_2 are absolute, clockwise positive. A *pattern* is the
pair of signs (ground, interface) of the corners on which the blocks pivot: ground = sign(theta_1),
interface = sign(theta_2 - theta_1), 0 where a contact is closed (lower block flat; upper block
glued to the lower one). No contact slides and none parts, so four patterns follow: both rock, the
stack rocks as one, the upper block rocks alone, rest (Psycharis 1990; Spanos, Roussis and Politis
2001; Kounadis 2015).

With half heights h, half widths b of the ground contact and c of the interface, D = s2 c - s1 b,
K = 2 h1 h2 - s2 c D, S = D h2 + 2 h1 s2 c, d = theta_1 - theta_2 and the base's acceleration a:

    M11 theta_1'' + M12 theta_2'' + C theta_2'^2 = Q1
    M12 theta_1'' + M22 theta_2'' - C theta_1'^2 = Q2
    M11 = I1 + m1 (b^2 + h1^2) + m2 (D^2 + 4 h1^2),   M22 = I2 + m2 (c^2 + h2^2)
    M12 = m2 (K cos d - S sin d),                      C = m2 (K sin d + S cos d)
    Q1 = g (-A cos theta_1 + B sin theta_1) - a (A sin theta_1 + B cos theta_1)
    Q2 = m2 [g (-s2 c cos theta_2 + h2 sin theta_2) - a (s2 c sin theta_2 + h2 cos theta_2)]
    A = m1 s1 b - m2 D,                                B = (m1 + 2 m2) h1

M22 loses c where the interface is closed. A glued pair obeys the sum of both equations, with
d = 0; above a flat lower block only the second one is left.
"""

import warp as wp

Pair = wp.types.vector(length=2, dtype=real)
"""One value a block, lower first."""
Places = wp.types.vector(length=4, dtype=real)
"""x and z of the lower block's centre, then of the upper one's."""

Inverse = wp.types.vector(length=3, dtype=real)
"""Inverse of a symmetric matrix: 11, 12 and 22."""

LARGE = real(1.0e30)
ROUND_OFF = by_precision(1.0e-12, 1.0e-5)
"""Moment that counts as zero, as a part of the largest moment of a reaction."""


@wp.struct
class Block:
    """One block of a stack; lengths in m, mass in kg, moment of inertia about the centre."""

    mass: real
    inertia: real
    half_height: real
    rotation_start: real
    rest_rotation: real


@wp.struct
class Lane:
    """Data of a lane besides its blocks.

    Attributes:
        gravity: [m/s^2].
        ground, interface: Half widths of the contacts [m].
        reach: Size of the stack [m].
        upper_narrower: 1 if the upper block has the narrower face of the interface, else 0.
        step_length: Longest step [s].
        step_limit: Most steps.
    """

    gravity: real
    ground: real
    interface: real
    reach: real
    upper_narrower: int
    step_length: real
    step_limit: int


@wp.struct
class Stack:
    """Two blocks, and what a lane has besides."""

    lower: Block
    upper: Block
    lane: Lane


@wp.struct
class Equations:
    """Coefficients of the equations of motion in a pattern; `even` and `odd` give M12 and C."""

    m11: real
    m22: real
    even: real
    odd: real
    arm_1: real
    height_1: real
    arm_2: real
    height_2: real


@wp.func
def equations(stack: Stack, s1: real, s2: real) -> Equations:
    """Coefficients in the pattern (s1, s2): m2 K, m2 S, A, B, m2 s2 c and m2 h2 among them."""
    foot = s1 * stack.lane.ground
    corner = s2 * stack.lane.interface
    across = corner - foot
    h1 = stack.lower.half_height
    h2 = stack.upper.half_height
    m1 = stack.lower.mass
    m2 = stack.upper.mass
    eq = Equations()
    rise = real(4.0) * h1 * h1
    eq.m11 = stack.lower.inertia + m1 * (foot * foot + h1 * h1) + m2 * (across * across + rise)
    eq.m22 = stack.upper.inertia + m2 * (corner * corner + h2 * h2)
    eq.even = m2 * (real(2.0) * h1 * h2 - corner * across)
    eq.odd = m2 * (across * h2 + real(2.0) * h1 * corner)
    eq.arm_1 = m1 * foot - m2 * across
    eq.height_1 = (m1 + real(2.0) * m2) * h1
    eq.arm_2 = m2 * corner
    eq.height_2 = m2 * h2
    return eq


@wp.func
def inverse(s1: real, s2: real, m11: real, m12: real, m22: real) -> Inverse:
    """Inverse of the mass matrix of a pattern; rows of blocks that do not turn are zero."""
    zero, one = real(0.0), real(1.0)
    both = one / (m11 + m12 + m12 + m22)
    over = one / fused_less(m12, m12, m11 * m22)
    flat = wp.where(s2 == zero, zero, one / m22)
    i11 = wp.where(s2 == zero, both, m22 * over)
    i12 = wp.where(s2 == zero, both, -m12 * over)
    i22 = wp.where(s2 == zero, both, m11 * over)
    return Inverse(
        wp.where(s1 == zero, zero, i11), wp.where(s1 == zero, zero, i12),
        wp.where(s1 == zero, flat, i22),
    )  # fmt: skip


@wp.func
def solve(over: Inverse, r1: real, r2: real) -> Pair:
    """Solution for the right sides of both equations; a glued pair has two equal numbers."""
    return Pair(fused(over[0], r1, over[1] * r2), fused(over[1], r1, over[2] * r2))


@wp.func
def cross_terms(eq: Equations, rotation: Pair) -> Pair:
    """M12 and C of a pattern at the rotations of both blocks."""
    sin1 = sine(rotation[0])
    cos1 = cosine(rotation[0])
    sin2 = sine(rotation[1])
    cos2 = cosine(rotation[1])
    sind = sin1 * cos2 - cos1 * sin2
    cosd = cos1 * cos2 + sin1 * sin2
    return Pair(eq.even * cosd - eq.odd * sind, eq.even * sind + eq.odd * cosd)


@wp.func
def accelerations(stack: Stack, s1: real, s2: real, rotation: Pair, rate: Pair, a: real) -> Pair:
    """Second derivatives of both rotations [rad/s^2] in a pattern."""
    eq = equations(stack, s1, s2)
    mixed = cross_terms(eq, rotation)
    sin1 = sine(rotation[0])
    cos1 = cosine(rotation[0])
    sin2 = sine(rotation[1])
    cos2 = cosine(rotation[1])
    g = stack.lane.gravity
    q1 = g * (eq.height_1 * sin1 - eq.arm_1 * cos1) - a * (eq.arm_1 * sin1 + eq.height_1 * cos1)
    q2 = g * (eq.height_2 * sin2 - eq.arm_2 * cos2) - a * (eq.arm_2 * sin2 + eq.height_2 * cos2)
    q1 = q1 - mixed[1] * rate[1] * rate[1]
    q2 = q2 + mixed[1] * rate[0] * rate[0]
    return solve(inverse(s1, s2, eq.m11, mixed[0], eq.m22), q1, q2)


@wp.func
def kinetic_energy(stack: Stack, s1: real, s2: real, rotation: Pair, rate: Pair) -> real:
    """Kinetic energy in the frame of the base [J]."""
    eq = equations(stack, s1, s2)
    m12 = cross_terms(eq, rotation)[0]
    twice = eq.m11 * rate[0] * rate[0] + eq.m22 * rate[1] * rate[1]
    return real(0.5) * twice + m12 * rate[0] * rate[1]


@wp.func
def spins(stack: Stack, rate: Pair) -> Pair:
    """Moments of inertia times rates [N m s], or times accelerations [N m], of both blocks."""
    return Pair(stack.lower.inertia * rate[0], stack.upper.inertia * rate[1])


@wp.func
def centre_motion(
    stack: Stack, s1: real, s2: real, rotation: Pair, rate: Pair, square: Pair
) -> Places:
    """J rate - levers x square, the velocities or accelerations of both centres.

    With rates and squares of zero these are velocities [m/s]. With angular accelerations for the
    rates and squared rates for the squares they are accelerations [m/s^2].
    """
    foot = s1 * stack.lane.ground
    corner = s2 * stack.lane.interface
    across = corner - foot
    h1 = stack.lower.half_height
    h2 = stack.upper.half_height
    sin1 = sine(rotation[0])
    cos1 = cosine(rotation[0])
    sin2 = sine(rotation[1])
    cos2 = cosine(rotation[1])
    w1 = rate[0]
    w2 = rate[1]
    q1 = square[0]
    q2 = square[1]
    rise = h1 + h1
    x1 = w1 * (h1 * cos1 + foot * sin1) - q1 * (h1 * sin1 - foot * cos1)
    z1 = w1 * (foot * cos1 - h1 * sin1) - q1 * (h1 * cos1 + foot * sin1)
    x2 = w1 * (rise * cos1 - across * sin1) - q1 * (rise * sin1 + across * cos1)
    z2 = w1 * (-across * cos1 - rise * sin1) - q1 * (rise * cos1 - across * sin1)
    x2 = x2 + w2 * (h2 * cos2 + corner * sin2) - q2 * (h2 * sin2 - corner * cos2)
    z2 = z2 + w2 * (corner * cos2 - h2 * sin2) - q2 * (h2 * cos2 + corner * sin2)
    return Places(x1, z1, x2, z2)


@wp.func
def reactions(
    stack: Stack, s1: real, s2: real, rotation: Pair, rate: Pair, bend: Pair, a: real
) -> Places:
    """Contact forces: mass times acceleration, less gravity [N]."""
    square = Pair(rate[0] * rate[0], rate[1] * rate[1])
    at = centre_motion(stack, s1, s2, rotation, bend, square)
    g = stack.lane.gravity
    return Places(
        stack.lower.mass * (at[0] + a),
        stack.lower.mass * (at[1] + g),
        stack.upper.mass * (at[2] + a),
        stack.upper.mass * (at[3] + g),
    )


@wp.func
def least_margin(
    stack: Stack, s1: real, s2: real, rotation: Pair, force: Places, turn: Pair
) -> real:
    """Smallest of N (c -+ e) over the closed contacts [N m], plus round-off.

    A closed contact stays closed while its normal force N acts at an eccentricity e within its half
    width c. The margin is a moment, since N may be zero. `force` holds forces or impulses [N s] of
    `reactions`; `turn` is moment of inertia times angular acceleration, or times the change of
    angular velocity.
    """
    zero = real(0.0)
    sin2 = sine(rotation[1])
    cos2 = cosine(rotation[1])
    moment = turn[1] + stack.upper.half_height * (cos2 * force[2] - sin2 * force[3])
    normal = sin2 * force[2] + cos2 * force[3]
    upper_size = size(force[2]) + size(force[3]) + size(turn[1])
    slack = ROUND_OFF * stack.lane.reach
    held = stack.lane.interface * normal - size(moment) + slack * upper_size
    from_above = wp.where(s2 == zero, moment, -s2 * stack.lane.interface * force[3])
    rise = stack.lower.half_height + stack.lower.half_height
    tilt = turn[0] + stack.lower.half_height * force[0] + rise * force[2] + from_above
    total_size = upper_size + size(force[0]) + size(force[1]) + size(turn[0])
    stands = stack.lane.ground * (force[1] + force[3]) - size(tilt) + slack * total_size
    return smaller(wp.where(s2 == zero, held, LARGE), wp.where(s1 == zero, stands, LARGE))


@wp.func
def ground_pulls(force: Places) -> bool:
    """Whether the ground would have to pull the stack down."""
    total = size(force[0]) + size(force[1]) + size(force[2]) + size(force[3])
    return force[1] + force[3] < -ROUND_OFF * total


@wp.func
def interface_pulls(stack: Stack, rotation: Pair, force: Places) -> bool:
    """Whether the lower block would have to pull the upper one.

    The corner of the narrower face stands on the other face, whose normal counts.
    """
    face = wp.where(stack.lane.upper_narrower == 1, rotation[0], rotation[1])
    across = force[2] * sine(face) + force[3] * cosine(face)
    return across < -ROUND_OFF * (size(force[2]) + size(force[3]))
