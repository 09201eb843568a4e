"""The case of a body from a mesh: commented, and it runs as it is, on a pulse to be replaced."""

from __future__ import annotations

import math

import numpy as np

from warprock.bodies.body import Body
from warprock.case.load import build_case
from warprock.case.template import Start
from warprock.case.text import parse_case
from warprock.case.writing import toml_text
from warprock.errors import is_plain, shortened

CASE_FILE = "case.toml"

PULSE = 2.0
"""Circular frequency of the pulse over the body's frequency parameter: about where pulses of one
length overturn with the least acceleration of their own size."""
LOWEST, HIGHEST, STEPS = 0.5, 4.0, 8
"""Amplitudes of the pulse, over that which lifts the body, and how many."""
FRICTION = 0.7
DURATION = 10.0


def case_of(body: Body) -> Start:
    """The case of a body, judged as any case is.

    Raises:
        InputError: The body is beyond what a case may hold.
    """
    text = case_text(body)
    case = build_case(body.name, CASE_FILE, None, parse_case(text, CASE_FILE))
    return Start(text, case.lane_count, {})


def case_text(body: Body) -> str:
    """The case of a body.

    Args:
        body: The body.

    Returns:
        The text of a case file: the body, friction, a pulse in its direction, amplitudes from half
        of what lifts it.
    """
    asked, degrees = body.asked, math.degrees(body.direction)
    name = body.file.name if is_plain(body.file.name) else "a mesh"
    lift = math.tan(float(body.in_plane(body.direction)[0]))
    frequency = PULSE * body.frequency_parameter / (2.0 * math.pi)
    tops = ", ".join(f'"{_two(share * lift)} g"' for share in np.linspace(LOWEST, HIGHEST, STEPS))
    pose = "as scanned" if asked.pose == 0 else f"rest {asked.pose}"
    title = shortened(f"{body.name if is_plain(body.name) else 'A body'} on a pulse")
    source = f"Mesh {shortened(name)}, {pose}; mass, inertia and base by warprock body."
    lines = [
        f"# A body from a mesh, made by `warprock body`: what it is stands in [block]. {_LEGEND}",
        "",
        toml_text({"title": title, "source": source}).strip(),
        "# planar: rocking in the plane of motion.direction; spatial: free in space.",
        f'model = "{asked.model}"',
        "",
        *_block(body),
        "",
        "[contact]",
        f'friction = {FRICTION}   # yours: a coefficient, or a friction angle such as "35 deg"',
        "",
        '# Replace this pulse by the motion of your site: waveform = "record", record = "FILE.csv"',
        "# (warprock records import), without control, frequency, amplitude and cycles.",
        "[motion]",
        'waveform = "sine"',
        'control = "acceleration"',
        f'frequency = "{_two(frequency)} Hz"',
        f'amplitude = "{_two(2.0 * lift)} g"   # g tan(slenderness angle) is {_two(lift)} g',
        "cycles = 1",
        f'direction = "{round(degrees, 3) + 0.0:g} deg"   # {_direction_note(body)}',
        "",
        "[run]",
        f'duration = "{DURATION:g} s"',
        'sample_interval = "20 ms"',
        "",
        "# One lane for each amplitude; of a record, sweep motion.scale.",
        "[[sweep]]",
        f"motion.amplitude = [{tops}]",
    ]
    return "\n".join(lines) + "\n"


_LEGEND = "Lines after #\n# are comments; `warprock keys` says of every key what it may hold."


def _block(body: Body) -> list[str]:
    """The table [block]."""
    tolerance = f"{1e3 * body.asked.tolerance:.3g} mm"
    tensor = body.mass * body.inertia
    six = [tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    largest = max(abs(each) for each in six)
    texts = ", ".join(_six(each, largest) for each in six)
    points = [f"    [{x:.5f}, {y:.5f}, {z:.5f}]," for x, y, z in np.round(body.points, 5) + 0.0]
    return [
        "[block]",
        "# Axes: z upwards, x and y as in the mesh, origin on the ground below the centre of mass.",
        f'mass = "{body.mass:.6g} kg"      # {body.volume:.4g} m^3 at {body.density:.4g} kg/m^3',
        f'centre = ["0 m", "0 m", "{body.base.height:.5g} m"]   # centre of mass',
        "# About the centre of mass [kg m^2]: xx, yy, zz, xy, xz, yz (xy = -integral of x y dm).",
        f"inertia = [{texts}]",
        f"# Contact points [m]: what lies within {tolerance} of the ground, pressed flat.",
        "base = [",
        *points,
        "]",
        f'height = "{body.sizes[2]:.5g} m"   # for pictures and tables only',
    ]


def _direction_note(body: Body) -> str:
    """What the direction is."""
    angle = math.degrees(float(body.in_plane(body.direction)[0]))
    if body.asked.direction is None:
        return f"the weakest: slenderness angle {angle:.3g} deg; from x towards y"
    weakest = math.degrees(body.base.weakest)
    return f"slenderness angle {angle:.3g} deg; the weakest is {weakest:.3g} deg"


def _two(value: float) -> str:
    """A number with two digits, without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def _six(value: float, largest: float) -> str:
    """A number with six digits; what is round-off of the largest is zero."""
    return "0" if abs(value) < 1e-9 * largest else f"{value:.6g}"
