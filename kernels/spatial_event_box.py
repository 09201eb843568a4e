"""The contact law of one block in space with friction as a box along x and y, for one precision.

At a corner |p_x| and |p_y| are at most friction n; where it slides along x, p_x is all of that and
against the slip, likewise along y. `slip` has the bit k where corner k slides along x, 4 + k where
it slides along y. What is tried, in this order:

    1. all that touch stick (spatial_event_contact.py), but for corners that slide already;
    2. a flat block slides: what presses its corners is spread as where it sticks, their frictions
       make a convex function of its motion (v_x, v_y, w_z) least, found one friction at a time;
    3. nothing pushes;
    4. corner by corner, until nothing changes (block Gauss-Seidel). Of a corner, along each of x
       and y, it is tried whether it sticks or slides, to one side or the other: linear each time.
       First comes what it does already.

Steps end where the slip of a corner along x or y does, so that second order holds through that. It
does not where, of a turned block, a corner that slides beside one that sticks opens: friction
there ends with a jump that is not located.
"""

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module

real: Any
PRECISION: str
FRICTION: str

scalar = kernel_module("scalar", precision=PRECISION)
event = kernel_module("event", precision=PRECISION)
contact = kernel_module("spatial_event_contact", precision=PRECISION, friction=FRICTION)
wp.set_module_options(contact.OPTIONS)
larger, smaller, size = scalar.larger, scalar.smaller, scalar.size
first_root = event.first_root
Three, Matrix, Shares = contact.Three, contact.Matrix, contact.Shares
Corners, Body, Held = contact.Corners, contact.Body, contact.Held
mask_of, stance_of, corner_velocity = contact.mask_of, contact.stance_of, contact.corner_velocity
stuck, sinks, sticking = contact.stuck, contact.sinks, contact.sticking
face_shares, inside, corner_matrix = contact.face_shares, contact.inside, contact.corner_matrix
FLAT, FLYING, ALL = contact.FLAT, contact.FLYING, contact.ALL

HALF = real(0.5)
TWO = real(2.0)
TINY = contact.TINY
NEVER = real(1.0e30)
SWEEPS = 5000
"""Sweeps over the corners before they give up."""
ROUNDS = 60
"""Rounds in which the pressure under a face follows its friction."""
SETTLED = real({"float64": 1.0e-13, "float32": 1.0e-6}[PRECISION])
"""Change of the velocities in a sweep, as a part of the largest, at which it ends."""
ALIKE = real({"float64": 1.0e-14, "float32": 1.0e-6}[PRECISION])
"""Round-off of an impulse or a velocity, as a part of the largest."""
FULL = real({"float64": 1.0 - 1.0e-9, "float32": 1.0 - 1.0e-4}[PRECISION])
"""Part of its bound from which friction counts as used up."""


@wp.func
def directions(body: Body, v: Three, w: Three) -> Corners:
    """Sides, -1 or 1, to which the corners move along x and y; 0 where they do not."""
    dirs = Corners()
    for k in range(4):
        u = corner_velocity(body, v, w, k)
        dirs[k] = Three(side_of(u[0]), side_of(u[1]), real(0.0))
    return dirs


@wp.func
def side_of(u: real) -> real:
    """-1, 0 or 1 as a velocity is negative, none or positive."""
    one, zero = real(1.0), real(0.0)
    return wp.where(u > zero, one, wp.where(u < zero, -one, zero))


@wp.func
def slipping(slip: int, dirs: Corners, k: int) -> Three:
    """Sides to which corner k slides, 0 along x or y where it sticks."""
    zero = real(0.0)
    x = wp.where((slip & (1 << k)) != 0, dirs[k, 0], zero)
    y = wp.where((slip & (16 << k)) != 0, dirs[k, 1], zero)
    return Three(x, y, zero)


@wp.func
def slips_of(k: int, fx: real, fy: real, most_x: real, most_y: real, u: Three, dust: real) -> int:
    """Bits of `slip` of a corner: where its friction is used up and it moves."""
    x = size(fx) >= FULL * most_x and size(u[0]) > dust
    y = size(fy) >= FULL * most_y and size(u[1]) > dust
    return wp.where(x, 1 << k, 0) | wp.where(y, 16 << k, 0)


@wp.func
def told(m: Matrix, u: Three, mu: real, side: Three) -> Three:
    """Impulse of a corner that stays on the base and does along x and y what it is told to.

    Args:
        m: `corner_matrix` of the corner.
        u: Its velocity without that impulse [m/s].
        mu: Friction coefficient.
        side: Along x and y: -1 or 1, slides to that side; 0, sticks.
    """
    one, zero = real(1.0), real(0.0)
    rows = m
    right = -u
    if side[0] != zero:
        rows[0] = Three(one, zero, mu * side[0])
        right[0] = zero
    if side[1] != zero:
        rows[1] = Three(zero, one, mu * side[1])
        right[1] = zero
    return wp.inverse(rows) * right


@wp.func
def obeyed(m: Matrix, u: Three, mu: real, side: Three, p: Three) -> bool:
    """Whether the impulse of a corner obeys the law, having been told what to do."""
    zero = real(0.0)
    after = u + m * p
    fits = p[2] >= zero
    for axis in range(2):
        if side[axis] == zero:
            fits = fits and size(p[axis]) <= mu * p[2] + ALIKE * wp.length(p)
        else:
            fits = fits and side[axis] * after[axis] >= -ALIKE * wp.length(u)
    return fits


@wp.func
def corner_law(m: Matrix, u: Three, mu: real, now: Three) -> Three:
    """Impulse of one corner that obeys the contact law, given its velocity without it.

    What it does `now` along x and y is tried first.
    """
    p = Three()
    if u[2] < real(0.0):
        p = told(m, u, mu, now)
        fits = obeyed(m, u, mu, now, p)
        for number in range(9):
            if not fits:
                x, y = number % 3, number // 3
                side = Three(real(x - 3 * (x // 2)), real(y - 3 * (y // 2)), real(0.0))
                p = told(m, u, mu, side)
                fits = obeyed(m, u, mu, side, p)
        # What can neither stick nor slide jams.
        if not fits:
            p = told(m, u, mu, Three())
    return p


@wp.func
def swept(body: Body, mask: int, slip: int, start: Corners, v: Three, w: Three, dust: real) -> Held:
    """The motion that obeys the contact law at some corners, found by Gauss-Seidel sweeps."""
    h = Held()
    h.v = v
    h.w = w
    impulses = Corners()
    speed = wp.length(v) + wp.length(w) * wp.length(body.corners[0])
    change = speed
    tries = int(0)
    while change > SETTLED * speed and tries < SWEEPS:
        change = real(0.0)
        for k in range(4):
            if (mask & (1 << k)) != 0:
                m = corner_matrix(body, k)
                u = corner_velocity(body, h.v, h.w, k) - m * impulses[k]
                p = corner_law(m, u, body.friction, slipping(slip, start, k))
                more = p - impulses[k]
                impulses[k] = p
                h.v = h.v + more
                h.w = h.w + body.inverse * wp.cross(body.corners[k], more)
                change = larger(change, wp.length(m * more))
        tries += 1
    held = int(0)
    for k in range(4):
        u = corner_velocity(body, h.v, h.w, k)
        p = impulses[k]
        most = body.friction * p[2]
        if (mask & (1 << k)) != 0 and u[2] <= dust and p[2] > real(0.0):
            held = held | (1 << k)
            h.slip = h.slip | slips_of(k, p[0], p[1], most, most, u, dust)
        h.work -= u[0] * p[0] + u[1] * p[1]
    h.stance = stance_of(held)
    h.fits = tries < SWEEPS
    return h


@wp.func
def flat_velocity(body: Body, z: Three, k: int) -> Three:
    """Velocity of corner k in a flat block's motion (v_x, v_y, w_z)."""
    return Three(z[0] - z[2] * body.corners[k, 1], z[1] + z[2] * body.corners[k, 0], real(0.0))


@wp.func
def dragged(body: Body, most: Corners, free: Three):
    """What friction leaves of a flat block's motion (v_x, v_y, w_z).

    Args:
        body: The block.
        most: Largest friction of each corner along x and y [m/s].
        free: The motion without friction.

    Returns:
        The motion; the friction of each corner; whether the search for it has settled.
    """
    one = real(1.0)
    z = free
    f = Corners()
    lighter = one / body.inertia[2, 2]
    reach = wp.length(body.corners[0])
    speed = size(z[0]) + size(z[1]) + size(z[2]) * reach
    change = speed
    tries = int(0)
    while change > ALIKE * speed and tries < SWEEPS:
        change = real(0.0)
        for k in range(4):
            for axis in range(2):
                arm = wp.where(axis == 0, -body.corners[k, 1], body.corners[k, 0])
                u = z[axis] + arm * z[2]
                new = f[k, axis] - u / (one + lighter * arm * arm)
                new = larger(smaller(new, most[k, axis]), -most[k, axis])
                more = new - f[k, axis]
                f[k, axis] = new
                z[axis] = z[axis] + more
                z[2] = z[2] + lighter * arm * more
                change += size(more)
        tries += 1
    return z, f, tries < SWEEPS


@wp.func
def sliding(body: Body, v: Three, w: Three, dust: real) -> Held:
    """The motion of a flat block that slides, or stops; whether it obeys the contact law."""
    zero = real(0.0)
    h = Held()
    h.stance = FLAT
    push = -v[2]
    spin = body.inertia * w
    low = -body.corners[0, 2]
    free = Three(v[0], v[1], w[2])
    n = Shares(real(0.25), real(0.25), real(0.25), real(0.25)) * larger(push, zero)
    z = free
    f = Corners()
    most = Corners()
    x = real(0.0)
    y = real(0.0)
    good = bool(True)
    enough = real(10.0) * ALIKE * (wp.length(v) + size(w[2]) * wp.length(body.corners[0]))
    change = larger(push, zero)
    tries = int(0)
    while change > enough and tries < ROUNDS:
        total = Three()
        for k in range(4):
            bound_k = body.friction * larger(n[k], zero)
            most[k] = Three(bound_k, bound_k, zero)
        z1, f1, settled1 = dragged(body, most, free)
        z = z1
        f = f1
        good = settled1
        for k in range(4):
            total = total + f1[k]
        x = (spin[1] - low * total[0]) / larger(push, TINY)
        y = (-spin[0] - low * total[1]) / larger(push, TINY)
        next = push * face_shares(body, x, y)
        change = wp.length(next - n)
        n = next
        tries += 1
    h.v = Three(z[0], z[1], zero)
    h.w = Three(zero, zero, z[2])
    for k in range(4):
        u = flat_velocity(body, z, k)
        h.slip = h.slip | slips_of(k, f[k, 0], f[k, 1], most[k, 0], most[k, 1], u, dust)
        h.work -= u[0] * f[k, 0] + u[1] * f[k, 1]
    h.fits = push >= zero and good and tries < ROUNDS and inside(body, x, y)
    return h


@wp.func
def guessed(
    body: Body, stance: int, slip: int, start: Corners, v: Three, w: Three, dust: real
) -> Held:
    """The motion if what sticks goes on to; whether it obeys the law. Of what slides, none."""
    h = Held()
    if stance != FLYING and slip == 0:
        h = sticking(body, stance, mask_of(stance), v, w, dust)
    return h


@wp.func
def settled(
    body: Body, stance: int, slip: int, start: Corners, v: Three, w: Three, dust: real
) -> Held:
    """The motion that obeys the contact law; see `settled` in spatial_event_law.py."""
    mask = mask_of(stance)
    slides = (slip | (slip >> 4)) & ALL
    first = guessed(body, stance, slip, start, v, w, dust)
    best = first
    for number in range(9):
        c = 8 - number
        part = mask_of(c)
        if not best.fits and (part & mask) == part and (part & slides) == 0:
            best = sticking(body, c, mask, v, w, dust)
    if not best.fits and stance == FLAT:
        best = sliding(body, v, w, dust)
    if not best.fits:
        best = Held()
        best.v = v
        best.w = w
        best.stance = FLYING
        best.fits = not sinks(body, v, w, mask, real(0.0))
    if not best.fits:
        best = swept(body, mask, slip, start, v, w, dust)
    best.turns = first.turns
    best.spare = first.spare
    return best


@wp.func
def bound(body: Body, stance: int, slip: int, v: Three, w: Three):
    """Velocities projected on the contacts, along their force."""
    v1 = v
    w1 = w
    dirs = directions(body, v, w)
    if stance != FLYING and slip == 0:
        v1, w1 = stuck(body, stance, v, w)
    elif stance == FLAT:
        most = Corners()
        for k in range(4):
            x = wp.where((slip & (1 << k)) != 0, real(0.0), NEVER)
            y = wp.where((slip & (16 << k)) != 0, real(0.0), NEVER)
            most[k] = Three(x, y, real(0.0))
        z, _f, _good = dragged(body, most, Three(v[0], v[1], w[2]))
        v1 = Three(z[0], z[1], real(0.0))
        w1 = Three(real(0.0), real(0.0), z[2])
    elif stance < FLAT:
        mask = mask_of(stance)
        speed = wp.length(v) + wp.length(w) * wp.length(body.corners[0])
        change = speed
        tries = int(0)
        while change > SETTLED * speed and tries < SWEEPS:
            change = real(0.0)
            for k in range(4):
                if (mask & (1 << k)) != 0:
                    u = corner_velocity(body, v1, w1, k)
                    p = told(corner_matrix(body, k), u, body.friction, slipping(slip, dirs, k))
                    v1 = v1 + p
                    w1 = w1 + body.inverse * wp.cross(body.corners[k], p)
                    change = larger(change, wp.length(p))
            tries += 1
    return v1, w1


@wp.func
def loose(mask: int) -> int:
    """`slip` where all that some corners can do is slide."""
    return mask | (mask << 4)


@wp.func
def grips(stance: int, slip: int) -> bool:
    """Whether an edge holds both of its ends."""
    return slip == 0


@wp.func
def slip_after(
    k: int, mu: real, gravity: real, longest: real, near: real, s: int, n: int, stance: int,
    u0: Three, u1: Three, d: real,
):  # fmt: skip
    """What becomes of a touching corner's slip in a step; see spatial_event_law.py.

    Slip along x or y that was there and is none in the mean of the step ends inside, nobody knows
    where: half of the step is tried.
    """
    cut = real(NEVER)
    slip = n
    for axis in range(2):
        bit = (1 << k) << (4 * axis)
        reach = near * size(u1[axis] - u0[axis]) / larger(d, TINY)
        e0 = size(u0[axis])
        e1 = u1[axis] * side_of(u0[axis])
        if (s & bit) != 0 and (n & bit) == 0:
            if e0 > reach and d > TWO * near:
                cut = smaller(cut, HALF * d)
        elif (s & bit) != 0:
            if e0 > reach and e1 < -reach and d > near:
                cut = smaller(cut, first_root(e0, (e1 - e0) / d, e1, d))
            elif e1 <= reach and size(e1) <= real(10.0) * reach:
                slip = slip - bit
    return cut, slip
