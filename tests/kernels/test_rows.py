"""Rows of structs are the local variables that they stand for."""

import sys
import types

import numpy as np
import pytest
import warp as wp

from warprock.kernels.launch import rows as rows_module

TEXT = """
import warp as wp
from warprock.kernels.launch.rows import kernel, rows

LANES = 4
real = wp.float64

@wp.struct
class State:
    theta: wp.float64
    count: int

@wp.func
def after(s: State, dt: wp.float64) -> State:
    n = State()
    n.theta = s.theta + dt
    n.count = s.count + 1
    return n

@wp.func
def double(x: wp.ref[wp.float64]):
    x = x + x

@kernel
def run(found: wp.array2d(dtype=wp.float64)):
    state = rows(State)
    slab = rows(State, 3)
    place = rows(State, lanes=2 * LANES)
    for i in range(LANES):
        state[i].theta = wp.float64(i)
    for k in range(3):
        for i in range(LANES):
            live = i < 2
            state[i] = wp.where(live, after(state[i], wp.float64(0.5)), state[i])
            slab[k, i] = state[i]
            double(slab[k, i].theta)
    for i in range(2 * LANES):
        place[i] = slab[2, i // 2]
    for i in range(LANES):
        found[0, i] = state[i].theta
        found[1, i] = wp.float64(state[i].count)
        found[2, i] = slab[2, i].theta
        found[3, i] = place[i + LANES].theta
{more}
"""


def module_of(tmp_path, name, more=""):
    path = tmp_path / f"{name}.py"
    path.write_text(TEXT.format(more=more))
    module = types.ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module
    wp.set_module_options({"enable_backward": False}, module=module)
    exec(compile(path.read_text(), str(path), "exec"), vars(module))
    return module


@pytest.mark.thorough
def test_rows_hold_a_struct_a_lane(tmp_path):
    module = module_of(tmp_path, "rows_of_lanes")
    found = wp.zeros((4, 4), dtype=wp.float64, device="cpu")
    wp.launch(module.run, 1, [found], device="cpu")
    expected = [[1.5, 2.5, 2.0, 3.0], [3.0, 3.0, 0.0, 0.0], [3.0, 5.0, 4.0, 6.0]]
    np.testing.assert_array_equal(found.numpy(), [*expected, [4.0, 4.0, 6.0, 6.0]])


def test_text_has_a_variable_a_field(tmp_path):
    module_of(tmp_path, "rows_in_text")
    text = rows_module.TEXTS["rows_in_text"]
    assert "state_theta = RealRows()" in text
    assert "slab_count = IntRows3()" in text
    assert "place_theta = RealRowsOf8()" in text
    assert "double(slab_theta[k, i])" in text


VECTORS = """
Three = wp.types.vector(length=3, dtype=real)
Two = wp.types.vector(length=2, dtype=int)

@wp.struct
class Flight:
    place: Three
    knots: Two
    lands: bool

@wp.func
def fly(s: Flight, dt: real) -> Flight:
    n = s
    n.place = s.place + Three(dt, dt, dt)
    n.knots[1] = s.knots[1] + 1
    n.lands = s.place[0] > real(1.5)
    return n

@kernel
def fly_all(found: wp.array2d(dtype=wp.float64)):
    flight = rows(Flight)
    for i in range(LANES):
        flight[i].place = Three(real(i), real(0.0), real(1.0))
        flight[i].knots[0] = int(i)
    for step in range(2):
        for i in range(LANES):
            flight[i] = wp.where(i > 0, fly(flight[i], real(0.25)), flight[i])
    for i in range(LANES):
        flight[i].place[1] = flight[i].place[1] + real(4.0)
        found[0, i] = flight[i].place[0]
        found[1, i] = wp.length_sq(flight[i].place)
        found[2, i] = real(flight[i].knots[0] + 10 * flight[i].knots[1])
        found[3, i] = wp.where(flight[i].lands, real(1.0), real(0.0))
"""


def test_a_vector_has_a_variable_a_component(tmp_path):
    module_of(tmp_path, "rows_of_vectors", VECTORS)
    text = rows_module.TEXTS["rows_of_vectors"]
    assert "flight_place_2 = RealRows()" in text
    assert "flight_knots_1 = IntRows()" in text
    assert "flight_place_1[i] = flight_place_1[i] + real(4.0)" in text


@pytest.mark.thorough
def test_vectors_have_the_numbers_of_their_components(tmp_path):
    module = module_of(tmp_path, "numbers_of_vectors", VECTORS)
    found = wp.zeros((4, 4), dtype=wp.float64, device="cpu")
    wp.launch(module.fly_all, 1, [found], device="cpu")
    x, y, z = [0.0, 1.5, 2.5, 3.5], [4.0, 4.5, 4.5, 4.5], [1.0, 1.5, 1.5, 1.5]
    lengths = np.square(x) + np.square(y) + np.square(z)
    expected = [x, lengths, [0.0, 21.0, 22.0, 23.0], [0.0, 0.0, 1.0, 1.0]]
    np.testing.assert_array_equal(found.numpy(), expected)


WITHIN = """
@wp.struct
class Mass:
    m: real
    j: real

@kernel
def weigh(held: wp.array(dtype=wp.float64)):
    mass_a = rows(Mass, within=held)
    mass_b = rows(Mass, within=held, first=2)
    for i in range(LANES):
        at = mass_a[i]
        mass_b[i] = Mass(at.j, real(2.0) * mass_a[i].m)
"""


def test_rows_within_an_array_are_its_numbers(tmp_path):
    module_of(tmp_path, "rows_within", WITHIN)
    text = rows_module.TEXTS["rows_within"]
    assert "at = Mass(held[i], held[i + 4])" in text
    assert "held[i + 12] = mass_b_after.j" in text


@pytest.mark.thorough
def test_rows_within_an_array_hold_a_struct_a_lane(tmp_path):
    module = module_of(tmp_path, "numbers_within", WITHIN)
    held = wp.array(np.arange(16.0), dtype=wp.float64, device="cpu")
    wp.launch(module.weigh, 1, [held], device="cpu")
    expected = [*range(8), 4.0, 5.0, 6.0, 7.0, 0.0, 2.0, 4.0, 6.0]
    np.testing.assert_array_equal(held.numpy(), expected)


def test_what_lies_within_an_array_has_numbers_alone(tmp_path):
    with pytest.raises(SyntaxError, match="all fields within an array are numbers"):
        module_of(tmp_path, "no_numbers", WITHIN.replace("j: real", "j: int"))


BRANCHES = """
ROUND = False

@kernel
def of_boxes(found: wp.array(dtype=wp.float64)):
    if ROUND:
        ring = rows(Ring)
        found[0] = ring[0].radius
    else:
        state = rows(State)
        found[0] = state[0].theta
"""


def test_the_branch_that_no_instance_takes_is_not_written_out(tmp_path):
    """It may name a struct that is not there."""
    module_of(tmp_path, "rows_of_branches", BRANCHES)
    text = rows_module.TEXTS["rows_of_branches"]
    assert "found[0] = state_theta[0]" in text
    assert "ring" not in text
    assert "ROUND" not in text


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("state[i].omega = wp.float64(0.0)", "state has no field omega"),
        ("state[i] = wp.where(True, state[0], state[1])", "a row keeps itself"),
    ],
)
def test_what_has_no_meaning_is_refused(tmp_path, line, message):
    with pytest.raises(SyntaxError, match=message):
        module_of(tmp_path, "rows_refused", f"    for i in range(LANES):\n        {line}\n")
