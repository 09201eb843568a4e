"""What impacts that bounce share: none makes energy.

With friction Newton's law of restitution may create energy (Kane and Levinson 1985). An impact
without rebound never does. So where the one would, the velocity after the impact lies between both,
as near to that of Newton's law as keeps the energy. Corners still do not sink, for they do not in
either, and the impulses stay within the cone of friction, which is convex.

References:
    Kane and Levinson (1985), Dynamics: Theory and Applications.
"""

import warp as wp


@wp.func
def kept_part(square: real, slope: real, room: real) -> real:
    """Largest part s of the way, 0 to 1, on which the energy grows by no more than there is room.

    Args:
        square, slope: Energy at s, less that at 0: square s^2 + slope s [J/kg]. The square is >= 0.
        room: Energy before the impact, less that at 0 [J/kg].
    """
    zero, one, four = real(0.0), real(1.0), real(4.0)
    spare = larger(room, zero)
    root = wp.sqrt(slope * slope + four * square * spare)
    # Both forms are the larger root; each is used where it does not cancel.
    rising = TWO * spare / larger(slope + root, TINY)
    falling = (root - slope) / larger(TWO * square, TINY)
    part = smaller(wp.where(slope > zero, rising, falling), one)
    return wp.where(square + slope <= spare, one, part)
