"""Runs of the impulse step over bodies in space that stand on points, LANES lanes a thread.

As impulse_space/block_run.py, with as many rows as the body with the most points needs.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ONLY, W, X, Y, Z
from warprock.kernels.impulse_space.block import (
    FAR,
    Contact,
    Gains,
    Gaps,
    Impulse,
    Knobs,
    Velocity,
    impulse_where,
    integrate,
    solve_contact,
    warm_start,
)
from warprock.kernels.impulse_space.block_run import attitude_at, place_at
from warprock.kernels.impulse_space.block_seen import observe_contacts
from warprock.kernels.impulse_space.body import (
    Stance,
    add_to_stance,
    find_contact,
    free_velocity,
    glides,
    lever_of,
    observe_body,
    observe_point,
    observe_stance,
    start_body,
    start_lane,
    weight_on,
)
from warprock.kernels.impulse_space.body_hold import (
    ROUNDS,
    Bed,
    Pressure,
    Sums,
    Turning,
    add_held,
    add_pressure,
    find_motion,
    find_turn,
    first_held,
    share_impulse,
    update_held,
)
from warprock.kernels.impulse_space.bounce import remove_gained_energy
from warprock.kernels.lane.modes import RUNNING
from warprock.kernels.launch.instance import ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import Found, Peaks, Result, block_result, start_peaks
from warprock.kernels.shape_space.body import (
    MOST_POINTS,
    Frame,
    Point,
    block_attitude,
    touches_as_lowest,
    turns_of_body,
)
from warprock.kernels.shape_space.lanes import State, Symmetric, Triple, Turn, inertia_of, turn_of

wp.set_module_options(ONE_VECTOR)

ROWS = MOST_POINTS + 1
"""Rows of points. An even number would map all rows of a point to the same places in the cache,
which is ten times slower."""
R = wp.types.vector(length=LANES, dtype=real)
"""A number a lane."""
Three = wp.types.matrix(shape=(3, LANES), dtype=real)
Marks = wp.types.matrix(shape=(ROWS, LANES), dtype=real)
"""A number a point."""
Counts = wp.types.vector(length=ROWS, dtype=int)


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), frames: wp.array(dtype=Frame),
    points: wp.array2d(dtype=Point), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    pack, _one = wp.tid()
    first, dt, zero, one = pack * LANES, knobs.time_step, real(0.0), real(1.0)
    state = rows(State)
    block = rows(Block)
    frame = rows(Frame)
    inverse = rows(Triple)
    moments = rows(Triple)
    turn = rows(Turn)
    inertia = rows(Symmetric)
    ease = rows(Symmetric)
    free = rows(Velocity)
    gaps = rows(Gaps)
    stance = rows(Stance)
    sums = rows(Sums)
    trial = rows(Velocity)
    bed = rows(Bed)
    pressure = rows(Pressure)
    turning = rows(Turning)
    seen = rows(Result)
    peaks = rows(Peaks)
    point = rows(Point, ROWS)
    contact = rows(Contact, ROWS)
    impulse = rows(Impulse, ROWS)
    part = rows(Impulse, ROWS)
    gains = rows(Gains, ROWS)
    held, apart, busy, base, dv = Marks(), Marks(), Counts(), Three(), Three()
    since, way, good = R(), R(), R()
    count, corners, time = int(0), points.shape[0], real(0.0)
    for i in range(LANES):
        block[i] = blocks[0, first + i]
        frame[i] = frames[first + i]
        s = start_body(block[i], frame[i], knobs)
        now = turns_of_body(block[i], frame[i], s.qx, s.qy, s.qz, s.qw)
        state[i] = s
        inverse[i] = Triple(block[i].inverse_x, block[i].inverse_y, block[i].inverse_z)
        moments[i] = Triple(one / inverse[i].x, one / inverse[i].y, one / inverse[i].z)
        seen[i] = start_lane(block[i], frame[i])
        peaks[i] = start_peaks(now.along, now.across, now.tilt)
    for c in range(corners):
        for i in range(LANES):
            own = points[c, first + i]
            point[c, i] = own
            impulse[c, i].n = weight_on(own.foot, knobs, frame[i])
            apart[c, i] = wp.where(own.foot > zero, zero, real(1.0))
    for sample in range(sample_times.shape[0]):
        while time < sample_times[sample]:
            count += 1
            time, half = real(count) * dt, (real(count) - HALF) * dt
            for d in range(3):
                if (knobs.moves >> d) % 2 == 1:
                    for i in range(LANES):
                        v = base_velocity(motions[d, first + i], half, pool)
                        dv[d, i] = v - base[d, i]
                        base[d, i] = v
            for i in range(LANES):
                change = Triple(dv[X, i], dv[Y, i], dv[Z, i])
                r = turn_of(state[i])
                j = inertia_of(r, inverse[i])
                turn[i] = r
                ease[i] = j
                inertia[i] = inertia_of(r, moments[i])
                free[i] = free_velocity(change, knobs, j, state[i])
                gaps[i] = Gaps(FAR, zero, zero)
                stance[i] = Stance(zero, zero, zero, zero, zero, zero, zero, zero, zero)
            for c in range(corners):
                for i in range(LANES):
                    at = lever_of(point[c, i], turn[i])
                    contact[c, i].x = at.x
                    contact[c, i].y = at.y
                    contact[c, i].h = at.z
                    gaps[i].lowest = smaller(gaps[i].lowest, state[i].z + at.z)
            for c in range(corners):
                for i in range(LANES):
                    gap = state[i].z + contact[c, i].h
                    n = impulse[c, i].n
                    lever = Triple(contact[c, i].x, contact[c, i].y, contact[c, i].h)
                    at_point = find_contact(knobs, gap, lever, free[i])
                    low = touches_as_lowest(gap, gaps[i].lowest, block[i].half_width)
                    stood, shows = stance[i], gaps[i]
                    add_to_stance(n > zero, low, at_point, point[c, i], state[i], stood)
                    observe_point(
                        knobs, gap, frame[i].reach, point[c, i].foot, free[i], n, apart[c, i], shows
                    )
                    stance[i] = stood
                    gaps[i] = shows
                    contact[c, i] = at_point
                    impulse[c, i] = impulse_where(at_point.on > zero, impulse[c, i])
            for i in range(LANES):
                shows = gaps[i]
                stays, slid = observe_stance(
                    seen[i].mode == RUNNING, time - dt, stance[i], shows, since[i], peaks[i]
                )
                gaps[i] = shows
                since[i] = stays
                peaks[i] = slid
            for c in range(corners):
                for i in range(LANES):
                    held[c, i] = first_held(knobs, since[i] == NEVER, contact[c, i], gaps[i].lowest)
            changes, turns = int(1), int(0)
            while changes > 0 and turns < ROUNDS:
                for i in range(LANES):
                    sums[i] = Sums(
                        zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero
                    )
                    good[i] = real(1.0)
                for c in range(corners):
                    for i in range(LANES):
                        held_sums = sums[i]
                        add_held(held[c, i], contact[c, i], held_sums)
                        sums[i] = held_sums
                for i in range(LANES):
                    stops, carries = find_motion(
                        frame[i].reach, free[i], state[i], inertia[i], sums[i]
                    )
                    trial[i] = stops
                    bed[i] = carries
                    pressure[i] = Pressure(zero, zero, zero)
                for c in range(corners):
                    for i in range(LANES):
                        update_held(knobs, contact[c, i], trial[i], bed[i], held[c, i], good[i])
                changes = int(0)
                for i in range(LANES):
                    changes += wp.where(good[i] > zero, 0, 1)
                turns += 1
            for c in range(corners):
                for i in range(LANES):
                    moments = pressure[i]
                    add_pressure(held[c, i], contact[c, i], bed[i], moments)
                    pressure[i] = moments
            for i in range(LANES):
                turning[i] = find_turn(bed[i], pressure[i])
            for c in range(corners):
                for i in range(LANES):
                    part[c, i] = share_impulse(
                        knobs, block[i].friction, held[c, i], contact[c, i], trial[i], bed[i],
                        turning[i], good[i],
                    )  # fmt: skip
            for i in range(LANES):
                free[i] = wp.where(good[i] > zero, trial[i], free[i])
            swept = int(0)
            for c in range(corners):
                busy[c] = 0
                for i in range(LANES):
                    stuck = good[i] > zero
                    impulse[c, i] = wp.where(stuck, part[c, i], impulse[c, i])
                    contact[c, i].on = wp.where(stuck, zero, contact[c, i].on)
                    busy[c] += wp.where(contact[c, i].on > zero, 1, 0)
                swept += busy[c]
                if busy[c] > 0:
                    for i in range(LANES):
                        u = free[i]
                        gains[c, i] = warm_start(contact[c, i], impulse[c, i], ease[i], u)
                        free[i] = u
            for step in range(wp.where(swept > 0, knobs.sweeps * corners, 0)):
                c = step % corners
                if (step // corners) % 2 == 1:
                    c = corners - 1 - c
                if busy[c] > 0:
                    for i in range(LANES):
                        p, u = impulse[c, i], free[i]
                        solve_contact(block[i].friction, contact[c, i], gains[c, i], ease[i], p, u)
                        impulse[c, i] = p
                        free[i] = u
            for i in range(wp.where(knobs.restitution > zero, LANES, 0)):
                change, u = Triple(dv[X, i], dv[Y, i], dv[Z, i]), free[i]
                remove_gained_energy(knobs, change, inverse[i], state[i], u)
                free[i] = u
            for i in range(LANES):
                live, sees, u = seen[i].mode == RUNNING, seen[i], free[i]
                change = Triple(dv[X, i], dv[Y, i], dv[Z, i])
                lowest = gaps[i].lowest
                s = integrate(live, knobs, inverse[i], change, u, lowest, state[i], sees.loss)
                slides = glides(frame[i], knobs, s.z, u)
                observe_contacts(live, time, gaps[i], slides, since[i], sees)
                peaks[i] = observe_body(time, block[i], frame[i], s, sees.mode, way[i], peaks[i])
                seen[i] = sees
                state[i] = s
        past = time - sample_times[sample]
        for i in range(wp.where(found.attitudes.shape[0] > 0, LANES, 0)):
            x, y, z, w = attitude_at(seen[i].mode == RUNNING, -past, inverse[i], state[i])
            qx, qy, qz, qw = block_attitude(frame[i], x, y, z, w)
            found.attitudes[sample, ONLY, X, first + i] = qx
            found.attitudes[sample, ONLY, Y, first + i] = qy
            found.attitudes[sample, ONLY, Z, first + i] = qz
            found.attitudes[sample, ONLY, W, first + i] = qw
        for i in range(wp.where(found.places.shape[0] > 0, LANES, 0)):
            spot = place_at(wp.where(seen[i].mode == RUNNING, past, zero), state[i])
            found.places[sample, ONLY, X, first + i] = spot.x
            found.places[sample, ONLY, Y, first + i] = spot.y
            found.places[sample, ONLY, Z, first + i] = spot.z
    for i in range(LANES):
        s = state[i]
        _x, _y, tz, tw = block_attitude(frame[i], s.qx, s.qy, s.qz, s.qw)
        found.results[first + i] = seen[i]
        found.blocks[0, first + i] = block_result(tz, tw, peaks[i])
