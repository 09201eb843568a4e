"""Effect of impulses at one contact in space, and the impulses that obey its law.

K is the matrix of velocity per impulse at the contact, p = (f_x, f_y, n) its impulse, u its
velocity. The impulse p - K^-1 u stops it. If that pushes and its friction is within Coulomb's
bound, the contact sticks. Else n = max(n - u_z / K_zz, 0), and the friction follows from the slip
u_t. For the cone it is f - u_t / (largest eigenvalue of K_t), shortened to the bound. For the box
f_x and f_y are each limited to the bound. The fixed points for the cone are those of Coulomb's law:
f = - mu n u_t / |u_t| for a slip in any direction.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector
from warprock.kernels.shape_space.frame import parts_along
from warprock.kernels.shape_space.lanes import Symmetric, cofactors, product

CONE = FRICTION == "cone"
"""Whether friction is bound as a cone, else as a box along x and y."""

Gains = wp.types.vector(length=12, dtype=real)
"""Numbers of one contact; those below say which number is which."""
NORMAL = 0
"""The inverse of K_zz."""
SLIP_1, SLIP_2, SLIP_3 = 1, 2, 3
"""The numbers of `slip_gains`."""
STOP_XX, STOP_XY, STOP_XZ, STOP_YY, STOP_YZ, STOP_ZZ = 4, 5, 6, 7, 8, 9
"""The matrix of `stop_gains`."""
COUPLE_X, COUPLE_Y = 10, 11
"""K_xz and K_yz."""


@wp.func
def slip_gains(on: real, kxx: real, kxy: real, kyy: real):
    """Friction of a contact per slip velocity, from K_t: three numbers, see `drag`.

    For the cone the first is the inverse of the largest eigenvalue. For the box they are the
    inverse of K_xx, K_xy, and the inverse of K_yy. All but K_xy are zero if `on` is.
    """
    p1, p2, p3 = on / kxx, kxy, on / kyy
    if CONE:
        apart = HALF * (kxx - kyy)
        p1 = on / (HALF * (kxx + kyy) + wp.sqrt(dot(apart, kxy, apart, kxy)))
    return p1, p2, p3


@wp.func
def stop_gains(on: real, k: Symmetric) -> Symmetric:
    """Inverse of the matrix K of a contact, times `on`."""
    c = cofactors(k)
    over = on / product(k.xx, k.xy, k.xz, c.xx, c.xy, c.xz)
    return Symmetric(
        over * c.xx, over * c.xy, over * c.xz, over * c.yy, over * c.yz, over * c.zz
    )  # fmt: skip


@wp.func
def drag(bound: real, fx: real, fy: real, ux: real, uy: real, p1: real, p2: real, p3: real):
    """Friction of a contact for its slip (ux, uy) [m/s], within a bound; see `slip_gains`."""
    new_x = fused_less(p1, ux, fx)
    new_y = fused_less(p1, uy, fy)
    if CONE:
        short = bound / wp.sqrt(larger(dot(new_x, new_y, new_x, new_y), TINY))
        short = smaller(short, real(1.0))
        new_x = short * new_x
        new_y = short * new_y
    else:
        new_x = larger(smaller(new_x, bound), -bound)
        new_y = larger(smaller(fused_less(p3, fused(p2, new_x - fx, uy), fy), bound), -bound)
    return new_x, new_y


@wp.func
def holds(fx: real, fy: real, n: real, mu: real) -> bool:
    """Whether the impulses of a contact push and their friction is within its bound."""
    inside = dot(fx, fy, fx, fy) <= mu * mu * n * n
    if not CONE:
        inside = larger(fx, -fx) <= mu * n and larger(fy, -fy) <= mu * n
    return inside and n >= real(0.0)


@wp.func
def gains_of(both: real, e: Matrix, ju: Matrix, jl: Matrix, ru: Vector, rl: Vector) -> Gains:
    """Effect of impulses at a contact.

    Args:
        both: Sum of the inverse masses of its bodies [1/kg].
        e: Its directions, one a row.
        ju, jl: Inverse inertia of the upper body [1/(kg m^2)] and of the lower one.
        ru, rl: Levers from the upper and the lower centre of mass [m].
    """
    one = real(1.0)
    u1, u2, u3 = wp.cross(ru, e[0]), wp.cross(ru, e[1]), wp.cross(ru, e[2])
    l1, l2, l3 = wp.cross(rl, e[0]), wp.cross(rl, e[1]), wp.cross(rl, e[2])
    k11 = both + wp.dot(u1, ju * u1) + wp.dot(l1, jl * l1)
    k12 = wp.dot(u1, ju * u2) + wp.dot(l1, jl * l2)
    k13 = wp.dot(u1, ju * u3) + wp.dot(l1, jl * l3)
    k22 = both + wp.dot(u2, ju * u2) + wp.dot(l2, jl * l2)
    k23 = wp.dot(u2, ju * u3) + wp.dot(l2, jl * l3)
    k33 = both + wp.dot(u3, ju * u3) + wp.dot(l3, jl * l3)
    p1, p2, p3 = slip_gains(one, k11, k12, k22)
    h = stop_gains(one, Symmetric(k11, k12, k13, k22, k23, k33))
    return Gains(one / k33, p1, p2, p3, h.xx, h.xy, h.xz, h.yy, h.yz, h.zz, k13, k23)


@wp.func
def solve_contact(mu: real, least: real, gains: Gains, e: Matrix, p: Vector, u: Vector) -> Vector:
    """New impulses of a contact along its directions, by a Gauss-Seidel update [N s].

    Args:
        mu: Friction coefficient.
        least: Least normal impulse [N s].
        gains: Effect of its impulses, see `gains_of`.
        e: Its directions, one a row.
        p: Its impulses so far [N s].
        u: Velocity of the upper body relative to the lower one, see `relative_velocity` [m/s].
    """
    g = gains
    x, y, z = parts_along(e, u)
    stop_x = p[0] - product(g[STOP_XX], g[STOP_XY], g[STOP_XZ], x, y, z)
    stop_y = p[1] - product(g[STOP_XY], g[STOP_YY], g[STOP_YZ], x, y, z)
    stop_z = p[2] - product(g[STOP_XZ], g[STOP_YZ], g[STOP_ZZ], x, y, z)
    if stop_z >= least and holds(stop_x, stop_y, stop_z, mu):
        return Vector(stop_x, stop_y, stop_z)
    push = larger(fused_less(g[NORMAL], z, p[2]), least)
    # Slip velocity after the normal impulse.
    more = push - p[2]
    slip_x, slip_y = fused(more, g[COUPLE_X], x), fused(more, g[COUPLE_Y], y)
    fx, fy = drag(mu * push, p[0], p[1], slip_x, slip_y, g[SLIP_1], g[SLIP_2], g[SLIP_3])
    return Vector(fx, fy, push)
