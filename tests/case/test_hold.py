"""What holds a block: its tables, and what is refused of them."""

import numpy as np
import pytest

import warprock as wr
from tests.shared.case_texts import FREE, refusal
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import ENGINES, engine_class

HELD = (
    FREE
    + """
[transverse_wall]
side = "left"
rebound = "plastic"
[[tie]]
height = "0.9 m"
side = "left"
stiffness = "2 kN/mm"
[[tie]]
height = "0.5 m"
side = "right"
stiffness = "1 kN/mm"
prestress = "1 kN"
yield_force = "3 kN"
ultimate_elongation = "2 cm"
acts = "both"
"""
)


def test_a_case_holds_its_block(write):
    lane_set = expand_lanes(load_case(write(HELD)))
    hold = lane_set.lanes.hold
    assert lane_set.scene.held == ("transverse_wall", "tie")
    assert (hold.wall, hold.rebound) == ([-1.0], [0.0])
    ties = hold.ties
    np.testing.assert_array_equal(ties.side, [[-1.0, 1.0]])
    np.testing.assert_allclose(ties.stiffness, [[2e6, 1e6]])
    np.testing.assert_allclose(ties.free_length, [[0.0, -1e-3]])
    np.testing.assert_array_equal(ties.yield_force, [[np.inf, 3e3]])
    np.testing.assert_array_equal(ties.pushes, [[False, True]])
    inputs = lane_set.inputs.iloc[0]
    assert inputs["tie_stiffness_1_N_m"] == 2e6
    assert inputs["tie_ultimate_elongation_2_mm"] == 20.0
    assert (inputs["wall_side"], inputs["tie_side_2"]) == ("left", "right")


def test_ties_and_walls_are_swept_drawn_and_overridden(write):
    file = write(HELD)
    case = load_case(
        file, ["tie.1.slack=1 mm to 5 mm, 5", "transverse_wall.rebound=0.1, three-impacts"]
    )
    lanes = expand_lanes(case).lanes
    assert lanes.lane_count == 10
    np.testing.assert_allclose(lanes.hold.ties.slack[:, 0] * 1e3, np.repeat([1, 2, 3, 4, 5], 2))
    assert lanes.hold.rebound[0] == 0.1
    # sin^2(a) = 1/5: 0.7^2 x 0.2.
    np.testing.assert_allclose(lanes.hold.rebound[1], 0.098)
    np.testing.assert_array_equal(lanes.take(np.array([3])).hold.ties.slack[0, 0], 2e-3)
    drawn = (
        HELD
        + """
[sample]
lanes = 8
seed = 1
[sample.over]
tie.2.stiffness = { distribution = "uniform", from = "1 kN/mm", to = "2 kN/mm" }
"""
    )
    stiffness = expand_lanes(load_case(write(drawn))).lanes.hold.ties.stiffness[:, 1]
    assert ((stiffness > 1e6) & (stiffness < 2e6)).all()
    assert len(set(stiffness)) == 8


def test_a_case_of_python_is_the_same(write):
    file = load_case(write(HELD))
    made = wr.Case(
        block=wr.Block(**file.raw["block"]),
        contact=wr.Contact(friction=1.0),
        run=wr.Times(duration="5 s"),
        transverse_wall=wr.TransverseWall(side="left", rebound="plastic"),
        tie=[wr.Tie(**tie) for tie in file.raw["tie"].values()],
        title="t",
        source="s",
    )
    assert made.raw == file.raw
    assert load_case(write(made.to_toml())).raw == file.raw


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("tie.1.height=1.1 m", "tie.1.height: got 1.1 m, must be at most the height of the block"),
        ("tie.1.height=0 m", "tie.1.height"),
        ("tie.2.yield_force=1 kN", "must be more than tie.2.prestress, 1000 N"),
        ('tie.1={ side = "left", slack = "1 m", prestress = "1 N" }', "tie.1.height"),
        ("tie.1.side=top", "must be the side of the block that the tie pulls to"),
        ("tie.4.height=1 m", "tie.3: got nothing, must be given: ties are numbered from 1"),
        ("tie.1.ultimate_elongation=0 m", "tie.1.ultimate_elongation"),
        (
            "tie.1.stiffness=5 m",
            "tie.1.stiffness: got '5 m', must be a stiffness with a unit (N/m, ",
        ),
        ("transverse_wall.rebound=1.1", "must be the angular velocity"),
        ("transverse_wall.rebound=elastic", '"plastic", "three-impacts" or a number from 0 to 1'),
        ("start.rotation=-2 deg", "must lean away from the wall at its left"),
        ("model=spatial", "must be left out: it holds a single box in the plane"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(write, override, said):
    with pytest.raises(wr.InputError) as caught:
        expand_lanes(load_case(write(HELD), [override]))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_must_be_given_and_what_not_beside_it(write):
    both = HELD.replace("prestress =", 'slack = "1 mm"\nprestress =')
    assert "must not be given beside" in str(refusal(write(both)))
    assert "must be the stiffness of the tie" in str(
        refusal(write(HELD.replace('stiffness = "2 kN/mm"\n', 'yield_force = "1 kN"\n')))
    )
    assert "must be the angular velocity" in str(
        refusal(write(HELD.replace('rebound = "plastic"\n', "")))
    )
    assert "must be [[tie]] tables" in str(refusal(write("tie = 3\n" + FREE)))


@pytest.mark.parametrize("engine", ENGINES)
def test_other_engines_say_what_runs_it(write, engine):
    scene = expand_lanes(load_case(write(HELD))).scene
    reason = engine_class(engine).supports(scene)
    if engine == "housner":
        assert reason is None
    else:
        assert "free-standing" in reason
        assert "(transverse_wall and tie); housner runs it" in reason
