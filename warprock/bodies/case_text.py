"""The case of a body from a mesh: commented, and it runs as it is, on a pulse to be replaced."""

from __future__ import annotations

import math

import numpy as np

from warprock.bodies.body import Body
from warprock.case.load import build_case
from warprock.case.template import Start, TakenRecord, take_record
from warprock.case.text import CASE_FILE, parse_case
from warprock.case.writing import toml_text
from warprock.errors import is_plain, shorten

PULSE = 2.0
"""Circular frequency of the pulse over the body's frequency parameter: about where pulses of one
length overturn with the least acceleration of their own size."""
LOWEST, HIGHEST, STEPS = 0.5, 4.0, 8
"""Amplitudes of the pulse, over that which lifts a flat base as safe, and how many."""
STRONGEST, SCALES = 8.0, 16
"""Peak acceleration of the strongest record over the same, and how many there are: a record falls
below its peak sooner than a pulse."""
FRICTION = 0.7
DURATION = 10.0


def case_of(body: Body, record: str | None = None) -> Start:
    """The case of a body, judged as any case is.

    Args:
        body: The body.
        record: Name of a shipped record, or a file; None shakes it by a pulse.

    Raises:
        InputError: The body is beyond what a case may hold, or the record is none.
    """
    taken = None if record is None else take_record(record)
    text = _case_text(body, taken)
    case = build_case(body.name, CASE_FILE, None, parse_case(text, CASE_FILE))
    return Start(text, case.lane_count, {} if taken is None else taken.beside)


def _case_text(body: Body, taken: TakenRecord | None) -> str:
    """The text of the case: the body, friction, and a motion from half of what lifts it."""
    asked = body.asked
    name = body.file.name if is_plain(body.file.name) else "a mesh"
    pose = f"pose {asked.pose}" if asked.pose else "as scanned"
    shaken = "a pulse" if taken is None else "a record"
    title = shorten(f"{body.name if is_plain(body.name) else 'A body'} on {shaken}")
    source = f"Mesh {shorten(name)}, {pose}; mass, inertia and base by warprock body."
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
        *(_pulse(body) if taken is None else _record(body, taken)),
    ]
    return "\n".join(lines) + "\n"


def _pulse(body: Body) -> list[str]:
    """The tables of a motion that its user replaces."""
    lift = _strength(body)
    frequency = PULSE * body.frequency_parameter / (2.0 * math.pi)
    tops = ", ".join(f'"{_two(share * lift)} g"' for share in np.linspace(LOWEST, HIGHEST, STEPS))
    return [
        '# Replace this pulse by the motion of your site: waveform = "record", record = "FILE.csv"',
        "# (warprock records import), without control, frequency, amplitude and cycles.",
        "[motion]",
        'waveform = "sine"',
        'control = "acceleration"',
        f'frequency = "{_two(frequency)} Hz"',
        f'amplitude = "{_two(2.0 * lift)} g"',
        "cycles = 1",
        _direction(body),
        "",
        "[run]",
        f'duration = "{DURATION:g} s"',
        'sample_interval = "20 ms"',
        "",
        "# One lane for each amplitude; of a record, sweep motion.scale.",
        "[[sweep]]",
        f"motion.amplitude = [{tops}]",
    ]


def _record(body: Body, taken: TakenRecord) -> list[str]:
    """The tables of a record, scaled to peak accelerations."""
    lift = _strength(body)
    ends = f'from = "{_two(LOWEST * lift)} g", to = "{_two(STRONGEST * lift)} g"'
    return [
        "[motion]",
        'waveform = "record"',
        toml_text({"record": taken.name}).strip(),
        f'target_pga = "{_two(lift)} g"   # scaled to this peak acceleration',
        _direction(body),
        "",
        "[run]",
        f'duration = "{taken.duration}"',
        'sample_interval = "20 ms"',
        "",
        "# One lane for each peak acceleration.",
        "[[sweep]]",
        f"motion.target_pga = {{ {ends}, count = {SCALES} }}",
    ]


def _strength(body: Body) -> float:
    """Base acceleration over g that lifts a body on a flat base whose centre has to rise as much.

    Of a flat base it is tan(slenderness angle): the centre rises from h to h / cos of that angle.
    """
    rise = body.turns_over(body.direction)[0].rise
    return math.sqrt((1.0 + rise / body.base.height) ** 2 - 1.0)


_LEGEND = "Lines after #\n# are comments; `warprock keys` says of every key what it may hold."


def _block(body: Body) -> list[str]:
    """The table [block]."""
    tolerance = f"{1e3 * body.tolerance:.3g} mm"
    raised = (body.contacts[:, 2] > -body.base.height).any()
    more = "; of others their height" if raised else ""
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
        f"# Contact points [m]: what lies within {tolerance} of the ground, pressed to it{more}.",
        "base = [",
        *points,
        "]",
        f'height = "{body.sizes[2]:.5g} m"   # for pictures and tables only',
    ]


def _direction(body: Body) -> str:
    """The key of the direction, and what it is."""
    lean = math.degrees(body.turns_over(body.direction)[0].lean)
    note = f"it turns over at a lean of {lean:.3g} deg"
    if body.asked.direction is None:
        note = f"from x towards y, the weakest: {note}"
    else:
        note += f"; the weakest direction is {math.degrees(body.weakest):.3g} deg"
    return f'direction = "{round(math.degrees(body.direction), 3) + 0.0:g} deg"   # {note}'


def _two(value: float) -> str:
    """A number with two digits, without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def _six(value: float, largest: float) -> str:
    """A number with six digits; what is round-off of the largest is zero."""
    return "0" if abs(value) < 1e-9 * largest else f"{value:.6g}"
