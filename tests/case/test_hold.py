"""What holds a block: its tables, and what is refused of them."""

import numpy as np
import pytest

import warprock as wr
from tests.shared.case_texts import FREE, PULSE, refusal
from tests.shared.commands import succeed
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import ENGINES, engine_class
from warprock.running.case_run import run_case
from warprock.running.scene_motion import scene_motion

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


def test_a_case_loads_its_block(write):
    text = (
        FREE
        + """
[top_load]
weight = "20 kN"
eccentricity = "-10 cm"
point = "stays"
"""
    )
    lane_set = expand_lanes(load_case(write(text), ["top_load.thrust=1 kN, 2 kN"]))
    load = lane_set.lanes.hold.load
    assert lane_set.scene.held == ("top_load",)
    np.testing.assert_array_equal(load.weight, 2e4)
    np.testing.assert_array_equal(load.thrust, [1e3, 2e3])
    assert load.stays.all()
    assert lane_set.inputs["load_eccentricity_mm"].tolist() == [-100.0] * 2
    with pytest.raises(wr.InputError, match=r"must lie on the top of the block, at most 0\.25 m"):
        expand_lanes(load_case(write(text), ["top_load.eccentricity=30 cm"]))


def test_a_block_is_a_column_of_a_frame(write):
    text = FREE + '[frame]\ncolumns = 2\nbeam_mass = "534 kg"\n'
    lane_set = expand_lanes(load_case(write(text)))
    # Each column has 267 kg.
    np.testing.assert_allclose(lane_set.lanes.hold.frame.mass_ratio, 1.0)
    row = lane_set.inputs.iloc[0]
    assert row["beam_mass_kg"] == 534.0
    assert row["frequency_parameter_rad_s"] == lane_set.lanes.frequency_parameter[0]
    assert row["angular_restitution"] == lane_set.lanes.angular_restitution[0]
    with pytest.raises(wr.InputError, match="must be a whole number"):
        expand_lanes(load_case(write(text), ["frame.columns=2.5"]))
    with pytest.raises(wr.InputError, match=r"beside \[frame\], whose columns stand free"):
        expand_lanes(load_case(write(text), ["top_load.weight=1 kN"]))


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
        ("tie.1.height=0 m", "tie.1.height: got '0 m', must be more than 0 m"),
        ("tie.1.height=m", "tie.1.height: got 'm', must be a length with a unit (m, cm, "),
        ("tie.1.height=0.9", "tie.1.height: got 0.9, must be a length with a unit (m, cm, "),
        (
            "tie.height=0.9 m",
            "tie.height: got '0.9 m', must have the number of its tie, tie.1.heig",
        ),
        ("tie.2.yield_force=1 kN", "must be more than tie.2.prestress, 1000 N"),
        ('tie.1={ side = "left", slack = "1 m", prestress = "1 N" }', "tie.1.height"),
        (
            "tie.2={ height='1 m', side='left', stiffness='1 N/m', slack='1 m', acts='both' }",
            "tie.2.slack: got 1 m, must be 0 m where tie.2.acts is both",
        ),
        ("tie.1.side=top", "must be the side of the block that the tie pulls to"),
        ("tie.4.height=1 m", "tie.3: got nothing, must be given: ties are numbered from 1"),
        ("tie.1.ultimate_elongation=0 m", "tie.1.ultimate_elongation"),
        (
            "tie.1.stiffness=5 m",
            "tie.1.stiffness: got '5 m', must be a stiffness with a unit (N/m, ",
        ),
        ("transverse_wall.rebound=1.1", "got 1.1, must be at least 0 and at most 1"),
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
    sweep = '\n[[sweep]]\ntie.height = ["0.5 m", "1 m"]\n'
    assert "did you mean tie.N.height?" in str(refusal(write(HELD + sweep)))


@pytest.mark.parametrize("engine", ENGINES)
def test_other_engines_say_what_runs_it(write, engine):
    scene = expand_lanes(load_case(write(HELD))).scene
    reason = engine_class(engine).supports(scene)
    if engine in ("housner", "event"):
        assert reason is None
    else:
        assert "free-standing" in reason
        assert "(transverse_wall and tie); housner and event run it" in reason


HINGED = '[strip]\nhinge_height = 0.5\nweight = "5 kN"\n'
STRIP = FREE.replace("0.5 m", "0.1 m") + HINGED


GROUND = (
    PULSE.replace('"displacement"', '"acceleration"').replace('"8 mm"', '"0.4 g"')
    + """
[ground]
stiffness = "50 MN/m^3"
damping = "200 kN s/m^3"
"""
)


def test_a_block_stands_on_ground_that_gives_way(write):
    swept = ["ground.stiffness=20 MN/m^3, 50 MN/m3, 1e9 N/m^3", "ground.damping=20 kNs/m³"]
    lane_set = expand_lanes(load_case(write(GROUND), swept))
    lanes, row = lane_set.lanes, lane_set.inputs
    assert lane_set.scene.held == ("ground",)
    np.testing.assert_array_equal(lanes.hold.bed.stiffness, [2e7, 5e7, 1e9])
    np.testing.assert_array_equal(row["ground_stiffness_N_m3"], [2e7, 5e7, 1e9])
    np.testing.assert_array_equal(row["ground_damping_N_s_m3"], 2e4)
    # Its weight over what a metre of the whole face takes.
    weight = 9.81 * lanes.density * lanes.height
    np.testing.assert_allclose(row["ground_depth_m"], weight / lanes.hold.bed.stiffness)
    np.testing.assert_array_equal(lanes.take(np.array([2])).hold.bed.stiffness, [1e9])
    made = wr.Ground(stiffness="50 MN/m^3", damping="200 kN s/m^3")
    assert dict(made) == load_case(write(GROUND)).raw["ground"]


@pytest.mark.parametrize(
    ("override", "said"),
    [
        (
            "ground.stiffness=50",
            "ground.stiffness: got 50, must be a stiffness a unit of area",
        ),
        ("ground.stiffness=50 kN/m", "must be a stiffness a unit of area with a unit (N/m^3, kN/m"),
        ("ground.stiffness=0 N/m^3", "at least 1e4 N/m^3 and at most 1e13 N/m^3"),
        ("ground.damping=-1 N s/m^3", "at least 0 N s/m^3 and at most 1e12 N s/m^3"),
        ("ground.stiffness=0.5 MN/m^3", "or the block falls by itself"),
        ("contact.angular_restitution=0.9", "must be left out beside [ground], which says what an"),
        ("transverse_wall={ side = 'left', rebound = 0 }", "must be left out beside [ground], on "),
        ("model=spatial", "must be left out: it holds a single box in the plane"),
        ("ground.depth=1 m", "unknown key (allowed: stiffness, damping)"),
    ],
)
def test_what_does_not_fit_a_ground_is_refused_in_one_line(write, override, said):
    with pytest.raises(wr.InputError) as caught:
        expand_lanes(load_case(write(GROUND), [override]))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("engine", ENGINES)
def test_other_engines_say_what_runs_a_block_on_ground_that_gives_way(write, engine):
    reason = engine_class(engine).supports(expand_lanes(load_case(write(GROUND))).scene)
    assert reason is None if engine == "housner" else "(ground); housner runs it" in reason


def test_explain_says_what_an_impact_on_such_ground_leaves(write):
    told = succeed("explain", write(GROUND)).stdout
    assert "one planar block on compliant ground" in told
    assert "angular restitution: what the dampers of the ground leave" in told


def test_a_block_is_a_strip_of_wall(write):
    lane_set = expand_lanes(
        load_case(write(STRIP), ["strip.hinge_height=0.3 to 0.7, 3", "start.rotation_ratio=0.5"])
    )
    strip = lane_set.lanes.hold.strip
    assert lane_set.scene.held == ("strip",)
    np.testing.assert_allclose(strip.lower, [0.3, 0.5, 0.7])
    np.testing.assert_array_equal(strip.arm, [[0.1, 0.1]] * 3)
    inputs = lane_set.inputs
    np.testing.assert_allclose(inputs["hinge_height"], [0.3, 0.5, 0.7])
    assert (inputs["floor_weight_N"] == 5e3).all()
    assert "floor_eccentricity_mm" not in inputs
    np.testing.assert_allclose(inputs["slenderness_angle_rad"], strip.critical[:, 0])
    np.testing.assert_allclose(inputs["rotation_start_rad"], 0.5 * strip.critical[:, 0])
    np.testing.assert_allclose(inputs["angular_restitution"], strip.angular_restitution)
    beside = expand_lanes(load_case(write(STRIP), ["strip.eccentricity=2 cm"]))
    np.testing.assert_allclose(beside.lanes.hold.strip.arm, [[0.03, 0.07]])
    assert beside.inputs["floor_eccentricity_mm"].tolist() == [20.0]
    np.testing.assert_allclose(lane_set.lanes.take(np.array([2])).hold.strip.lower, [0.7])


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (
            ["strip.hinge_height=0.95"],
            "strip.hinge_height: got 0.95, must be at least 0.1",
        ),
        (["strip.eccentricity=30 cm"], "must lie on the top of the block, at most 0.05 m"),
        (["top_load.weight=1 kN"], "top_load: got a table, must be left out beside [strip]"),
        (["strip.hinge_height=0.1"], "strip.hinge_height: got 0.1, must be higher, or contact"),
        (["start.rotation=60 deg"], "must be less than the lean at which the strip is in balance"),
        (["model=spatial"], "must be left out: it holds a single box in the plane"),
        (["strip.load=1 kN"], "unknown key (allowed: hinge_height, weight, eccentricity)"),
    ],
)
def test_what_does_not_fit_a_strip_is_refused_in_one_line(write, overrides, said):
    with pytest.raises(wr.InputError) as caught:
        expand_lanes(load_case(write(STRIP), overrides))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("engine", ENGINES)
def test_other_engines_say_what_runs_a_strip(write, engine):
    reason = engine_class(engine).supports(expand_lanes(load_case(write(STRIP))).scene)
    assert reason is None if engine == "housner" else "(strip); housner runs it" in reason


def test_a_strip_is_drawn_in_two_pieces(write):
    # A pulse at the end, of no size: kernels of pulses are those that other tests compile.
    pulse = PULSE.replace("0.5 m", "0.1 m").replace("8 mm", "1e-12 mm") + 'start = "1.9 s"\n'
    file = write(
        (pulse + HINGED).replace('duration = "5 s"', 'duration = "2 s"\nsample_interval = "0.1 s"')
    )
    run = run_case(load_case(file, ["start.rotation_ratio=0.5"]), "housner")
    seen = scene_motion(run, 0, 0.1)
    assert seen.sizes[:, 2].tolist() == [0.5, 0.5]
    corners = seen.corners()
    leans = run.response["rotation"][0] > 0.0
    # One base edge stays, the bodies share the hinge, and the top stays below its floor.
    np.testing.assert_allclose(corners[0, leans, 1], [[0.05, 0.0]] * leans.sum(), atol=1e-12)
    np.testing.assert_allclose(corners[0, leans, 3], corners[1, leans, 0], atol=1e-12)
    np.testing.assert_allclose(corners[1, leans, 2, 0], 0.05, atol=1e-12)
