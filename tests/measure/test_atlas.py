"""The atlas of extremes: its ranges, what it measures, that it goes on where it stopped."""

from __future__ import annotations

import dataclasses
import math
import pathlib
from collections.abc import Sequence

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.shared.blocks import make_lanes, sines, single_block_engines
from tests.shared.marks import all_but
from warprock.engines import ENGINES, engine_class
from warprock.engines.launching import Target
from warprock.figures import atlas as plots_stability
from warprock.figures.sheet import style
from warprock.measure import atlas as stability
from warprock.measure import atlas_summary as stability_summary
from warprock.measure.atlas import (
    GROWTH_BOUND,
    Part,
    all_parts,
    measure,
    run_atlas,
    supported_lanes,
)
from warprock.measure.atlas_lanes import (
    DEPTH,
    STACK_TURNS,
    STIFFNESS_WIDTH,
    AtlasSize,
    LaneGrid,
    stack_energy,
)
from warprock.measure.atlas_maps import LABELS, MAPS, AtlasMap, at_step, at_stiffness
from warprock.model import rocking
from warprock.model.motion import Control, StillBase
from warprock.model.response import USABLE, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.running.options import RunOptions
from warprock.settings.engines import SETTINGS, build_settings

BY_NAME = {each.name: each for each in MAPS}
TINY = AtlasSize(points=3, steps=150, duration=0.5, iterations=(10,))
THREE = ("housner", "impulse", "event")
SINGLE = tuple(each for each in MAPS if each.name != "mass")
"""Maps of single blocks; that of stacks, three kernels to compile, is for the thorough run."""


@pytest.mark.parametrize(
    ("name", "column", "ends"),
    [
        ("step", "slenderness", (0.3, 20.0)),
        ("step", "height_m", (0.05, 50.0)),
        ("step", "start_ratio", (1e-6, 0.9999)),
        ("mass", "mass_ratio", (1e-4, 1e4)),
        ("shaking", "frequency_hz", (0.1, 50.0)),
        ("shaking", "amplitude_g", (0.05, 5.0)),
        ("friction", "friction", (0.0, 10.0)),
        ("friction", "slenderness", (0.3, 20.0)),
    ],
)
def test_a_map_of_any_size_reaches_its_extremes(name: str, column: str, ends: tuple[float, float]):
    for size in (AtlasSize(points=3), AtlasSize()):
        values = BY_NAME[name].lanes(size).inputs[column]
        np.testing.assert_allclose([values.min(), values.max()], ends, rtol=1e-12)


def test_a_launch_of_the_whole_atlas_has_thousands_of_lanes():
    counts = {each.name: each.lanes(AtlasSize()).lanes.lane_count for each in MAPS}
    assert min(counts["step"], counts["shaking"], counts["friction"]) >= 1000


@pytest.mark.parametrize("engine", ENGINES)
def test_every_step_and_stiffness_is_within_the_bounds_of_the_settings(engine: str):
    assert set(ENGINES) == set(SETTINGS)
    for each in MAPS:
        for launch in each.launches(engine, AtlasSize()):
            build_settings(engine, dataclasses.asdict(launch.settings), each.name)
            step = launch.knobs.get("step_s", math.nan)
            if not math.isnan(step):
                assert launch.settings.time_step == pytest.approx(step, rel=1e-12)
    if hasattr(SETTINGS[engine](), "time_step"):
        steps = [launch.knobs["step_s"] for launch in BY_NAME["step"].launches(engine, AtlasSize())]
        assert [min(steps), max(steps)] == pytest.approx([1e-6, 0.1])


def test_a_stiffness_is_that_of_the_face_of_the_block():
    assert at_stiffness(SETTINGS["dem"](), 1e9).normal_stiffness == 1e9
    corner = 1e9 * 0.5 * STIFFNESS_WIDTH * DEPTH
    assert at_stiffness(SETTINGS["direct"](), 1e9).contact_stiffness == pytest.approx(corner)
    assert at_stiffness(SETTINGS["xpbd"](), 1e9).compliance == pytest.approx(1.0 / corner)
    assert at_stiffness(SETTINGS["housner"](), 1e9) is None
    assert at_step(SETTINGS["event"](), 1e-4).time_step == 1e-4


def test_energy_of_a_stack_is_that_of_single_blocks_where_there_is_a_closed_form():
    grid = BY_NAME["mass"].lanes(AtlasSize(points=3))
    lanes, turned = grid.lanes, grid.inputs["turned"].to_numpy(str)
    assert set(turned) == set(STACK_TURNS)
    even = dataclasses.replace(lanes, density=np.full_like(lanes.density, 2000.0))
    width, height = lanes.width[:, 0], lanes.height[:, 0]
    whole = rocking.energy(width, 2.0 * height, DEPTH, 2000.0, lanes.rotation_start[:, 0], 0.0)
    alone = rocking.energy(width, height, DEPTH, 2000.0, lanes.rotation_start[:, 1], 0.0)
    found = stack_energy(even)
    both, upper = turned == "both", turned == "upper"
    # Differences of heights, of which 1e-16 is round-off and 1e-4 what is left.
    np.testing.assert_allclose(found[both], whole[both], rtol=1e-9)
    np.testing.assert_allclose(found[upper], alone[upper], rtol=1e-9)
    against = stack_energy(even)[turned == "against"]
    assert np.all(against > alone[turned == "against"])


def test_lanes_are_those_that_an_engine_supports():
    grid = BY_NAME["friction"].lanes(TINY)
    chosen = supported_lanes("housner", grid)
    holds = grid.lanes.friction >= grid.lanes.width / grid.lanes.height
    # A block wider than sqrt(2) times its height does not rock over.
    holds &= grid.lanes.width < np.sqrt(2.0) * grid.lanes.height
    np.testing.assert_array_equal(chosen, np.flatnonzero(holds))
    assert 0 < len(chosen) < grid.lanes.lane_count
    assert len(supported_lanes("two-block", grid)) == 0
    assert len(supported_lanes("event", grid)) == grid.lanes.lane_count


def sound_answer() -> tuple[LaneGrid, Response]:
    """Four released blocks and Housner's answer for them."""
    lanes = make_lanes(np.full(4, 0.5), 1.0, np.full(4, 0.5), friction=10.0)
    held = rocking.energy(0.5, 1.0, 0.5, 2000.0, lanes.rotation_start, 0.0)
    grid = LaneGrid(lanes, StillBase(4), pd.DataFrame(index=range(4)), np.full(4, True), held)
    return grid, run_batch("housner", lanes, grid.motions, SampleTimes(1.0, 0.05))


def spoiled(response: Response, name: str, values: np.ndarray) -> Response:
    return dataclasses.replace(response, fields={**response.fields, name: values})


def test_sound_numbers_are_sound():
    grid, answer = sound_answer()
    found = measure(grid, answer, np.arange(4), answer)
    assert found["usable"].all()
    assert found["finite"].all()
    assert found["compared"].all()
    assert not found["grew"].any()
    assert not found["absurd"].any()
    np.testing.assert_array_equal(found["error"], 0.0)
    # Nothing was gained: what a swing does not lose it keeps.
    assert np.all(found["growth"] <= 1e-9)


@pytest.mark.parametrize(
    ("name", "bad"),
    [("peak_rotation", math.nan), ("energy_lost", math.inf), ("peak_rotation", 2.0)],
)
def test_numbers_that_cannot_be_are_absurd_unless_the_status_says_so(name: str, bad: float):
    grid, answer = sound_answer()
    values = answer[name].copy()
    values[[1, 2]] = bad
    status = answer["status"].copy()
    status[2] = Status.NONFINITE
    wrong = spoiled(spoiled(answer, name, values), "status", status)
    found = measure(grid, wrong, np.arange(4), answer)
    np.testing.assert_array_equal(found["absurd"], [False, True, False, False])
    np.testing.assert_array_equal(found["usable"], [True, True, False, True])
    assert np.isnan(found["error"][2])


def test_energy_from_nothing_is_seen_in_the_account_and_in_the_peaks():
    grid, answer = sound_answer()
    lost = np.array([-0.5, -2.0, -4.0, 100.0]) * grid.held
    lost[0] = -0.5 * GROWTH_BOUND * grid.held[0]
    found = measure(grid, spoiled(answer, "energy_lost", lost), np.arange(4), answer)
    np.testing.assert_array_equal(found["grew"], [False, True, True, False])
    np.testing.assert_array_equal(found["absurd"], [False, True, True, False])
    # It turned to 0.8 of its slenderness angle, let go from half of it.
    peak = np.where(np.arange(4) == 3, 0.8 * grid.lanes.slenderness_angle, answer["peak_rotation"])
    higher = spoiled(answer, "peak_rotation", peak)
    found = measure(grid, higher, np.arange(4), answer)
    np.testing.assert_array_equal(found["grew"], np.arange(4) == 3)
    reached = rocking.energy(0.5, 1.0, 0.5, 2000.0, peak[3], 0.0) / grid.held[3] - 1.0
    assert found["growth"][3] == pytest.approx(reached, rel=1e-12)
    soft = measure(grid, higher, np.arange(4), answer, rigid=False)
    assert not soft["grew"].any()


def test_an_error_is_the_largest_difference_where_the_reference_answers():
    grid, answer = sound_answer()
    rotation = answer["rotation"].copy()
    rotation[1, 7] += 0.03 * grid.lanes.slenderness_angle[1]
    rotation[2, 5] = math.nan
    found = measure(
        grid,
        spoiled(answer, "rotation", rotation),
        np.array([0, 1, 2]),
        dataclasses.replace(answer, fields={k: v[:3] for k, v in answer.fields.items()}),
    )
    assert found["error"][1] == pytest.approx(0.03, rel=1e-12)
    assert found["error"][0] == 0.0
    assert np.isnan(found["error"][[2, 3]]).all()
    np.testing.assert_array_equal(found["compared"], [True, True, True, False])
    np.testing.assert_array_equal(found["absurd"], [False, False, True, False])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    return tmp_path_factory.mktemp("atlas")


@pytest.fixture(scope="module")
def table(folder: pathlib.Path) -> pd.DataFrame:
    """Every map of single blocks, run with three engines."""
    return run_atlas(folder, TINY, engines=THREE, maps=SINGLE, precisions=("float64",))


@pytest.fixture(scope="module")
def stacks(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """The map of stacks, run with the same engines."""
    options = {"engines": THREE, "maps": [BY_NAME["mass"]], "precisions": ("float64",)}
    return run_atlas(tmp_path_factory.mktemp("stacks"), TINY, **options)


def test_every_part_has_its_lanes(table: pd.DataFrame, folder: pathlib.Path):
    parts = all_parts(THREE, SINGLE, precisions=("float64",))
    assert {path.name for path in (folder / stability.FOLDER).iterdir()} == {p.file for p in parts}
    counts = table.groupby(["map", "engine"]).size()
    grids = {each.name: each.lanes(TINY).lanes for each in MAPS}
    lanes = {name: grid.lane_count for name, grid in grids.items()}
    assert counts["step", "impulse"] == 3 * lanes["step"]
    # A block wider than sqrt(2) times its height does not rock over: housner declines it.
    rocks = grids["step"].width < np.sqrt(2.0) * grids["step"].height
    assert 0 < counts["step", "housner"] == np.sum(rocks) < lanes["step"]
    assert counts["friction", "event"] == lanes["friction"]
    assert 0 < counts["friction", "housner"] < lanes["friction"]
    assert ("stiffness", "event") not in counts.index


def test_no_launch_takes_more_steps_than_it_may(table: pd.DataFrame):
    stepping = table[(table["engine"] == "impulse") & (table["map"] == "step")]
    assert stepping["step_count"].max() <= TINY.steps + 1
    assert stepping["duration_s"].max() <= TINY.duration
    assert stepping["duration_s"].min() == pytest.approx(TINY.steps * 1e-6)


def test_quick_lanes_do_not_end_the_runs_of_slow_ones():
    size, part = AtlasSize(points=4, steps=500), Part(BY_NAME["mass"], "dem", "float64")
    grid = part.map.lanes(size)
    (launch,) = part.map.launches("dem", size)
    steps = engine_class("dem")(launch.settings).longest_step(grid.lanes, grid.motions)
    assert steps.max() > 100.0 * steps.min()
    batches = stability._batches(part, size, grid, launch)
    numbers = np.concatenate([each for _, each in batches])
    np.testing.assert_array_equal(np.sort(numbers), np.arange(grid.lanes.lane_count))
    for duration, lanes in batches:
        allowed = np.minimum(part.map.longest, size.steps * steps[lanes])
        assert np.all(duration <= allowed)
        assert np.all(duration * stability.STEP_SPAN >= allowed)


def test_located_events_gain_no_energy_at_any_extreme(table: pd.DataFrame):
    located = table[table["engine"].isin(["housner", "event"])]
    assert located["growth"].notna().sum() > 60
    assert_no_energy_is_gained(located)


def assert_no_energy_is_gained(located: pd.DataFrame) -> None:
    assert located["usable"].all()
    assert not located["grew"].any()
    assert not located["absurd"].any()


@pytest.mark.thorough
def test_stacks_of_any_masses_gain_no_energy_and_their_map_can_be_read(stacks: pd.DataFrame):
    counts = stacks.groupby("engine").size()
    assert counts["event"] == BY_NAME["mass"].lanes(TINY).lanes.lane_count
    assert_no_energy_is_gained(stacks[stacks["engine"] == "event"])
    assert not stacks["absurd"].any()
    assert_maps_can_be_read(stacks, [BY_NAME["mass"]])


def test_an_exploding_block_of_impulse_says_so(table: pd.DataFrame):
    """A step of 0.1 s lets a block of 5 cm fall by its own height."""
    stepping = table[(table["engine"] == "impulse") & (table["map"] == "step")]
    coarse = stepping["step_s"] > 0.01
    assert (stepping["status"][coarse] == "unstable").sum() > 3
    assert (stepping["status"][stepping["step_s"] < 1e-3] == "ok").all()
    assert not table["absurd"].any()


def test_an_engine_agrees_with_its_reference_on_small_steps(table: pd.DataFrame):
    fine = table[(table["map"] == "step") & (table["step_s"] <= 1e-6 * (1 + 1e-9))]
    assert set(fine["engine"]) == {"impulse", "event"}
    # First order in a step of 1e-6 s, over 150 of them, in which few blocks come down.
    assert 0 < fine["compared"].sum() < len(fine)
    assert fine["error"].max() < 1e-5
    own = table[(table["engine"] == "housner") & table["compared"]]
    assert own["error"].max() == 0.0


def test_a_second_run_reads_what_is_there_and_runs_the_rest(
    table: pd.DataFrame, folder: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    ran: list[str] = []
    run_part = stability.run_part

    def watched(part: Part, *options) -> pd.DataFrame:
        ran.append(part.file)
        return run_part(part, *options)

    monkeypatch.setattr(stability, "run_part", watched)
    again = run_atlas(folder, TINY, engines=THREE, maps=SINGLE, precisions=("float64",))
    pd.testing.assert_frame_equal(again, table)
    assert ran == []
    lost, cut = "friction--event--float64.parquet", "friction--housner--float64.parquet"
    (folder / stability.FOLDER / lost).unlink()
    half = (folder / stability.FOLDER / cut).read_bytes()[:-100]
    (folder / stability.FOLDER / cut).write_bytes(half)
    done: list[int] = []
    again = run_atlas(
        folder,
        TINY,
        engines=THREE,
        maps=SINGLE,
        precisions=("float64",),
        options=RunOptions(progress=done.append),
    )
    pd.testing.assert_frame_equal(again, table)
    assert sorted(ran) == [lost, cut]
    assert done == list(range(1, len(all_parts(THREE, SINGLE, ("float64",))) + 1))
    # Another size is another atlas.
    other = dataclasses.replace(TINY, steps=TINY.steps - 1)
    run_atlas(folder, other, engines=["housner"], maps=[BY_NAME["step"]], precisions=("float64",))
    assert ran[2:] == ["step--housner--float64.parquet"]


@pytest.mark.thorough
def test_figures_can_be_read_without_a_caption(table: pd.DataFrame):
    # The others differ in the names of their inputs.
    assert_maps_can_be_read(table, [BY_NAME["step"]])


@pytest.mark.thorough
def test_figures_of_all_maps_can_be_read_without_a_caption(table: pd.DataFrame):
    # None of these engines has the springs of the other maps.
    assert_maps_can_be_read(table, [BY_NAME["shaking"], BY_NAME["friction"]])


def assert_maps_can_be_read(table: pd.DataFrame, chosen: Sequence[AtlasMap]) -> None:
    maps = [(m.name, m.title, m.x, up) for m in chosen for up in (m.y, m.other_y) if up]
    drawings = plots_stability.draw_maps(table, maps, LABELS)
    assert len({each.name for each in drawings}) == len(drawings) == 2 * len(maps)
    assert sum(each.name.endswith("-penetration") for each in drawings) == len(maps)
    for each in drawings:
        figure = each.figure
        with style():
            figure.draw_without_rendering()
        assert any("lanes a cell" in text.get_text() for text in figure.texts)
        assert each.title in each.alt
        assert figure.get_supylabel().endswith("]")
        assert all(axes.get_xlabel().endswith("]") for axes in figure.axes[-1:])
        assert all("lanes" in axes.get_title(loc="left") for axes in figure.axes)
        texts = figure.findobj(match=lambda artist: hasattr(artist, "get_fontsize"))
        assert min(text.get_fontsize() for text in texts if text.get_text()) >= 8.0
        legend = figure.legends[0].get_window_extent()
        assert not any(legend.overlaps(axes.get_window_extent()) for axes in figure.axes)


def test_cells_show_what_nine_lanes_in_ten_stay_below(table: pd.DataFrame):
    rows = pd.DataFrame({"step_s": 1e-3, "slenderness": np.repeat([2.0, 3.0], 10)})
    rows["penetration"] = [*np.geomspace(1e-9, 1e-1, 10), *np.full(9, 1e-5), np.nan]
    rows = rows.assign(grew=False, usable=True, absurd=False)
    places = [np.array([1e-3]), np.array([2.0, 3.0])]
    found = plots_stability.cells(
        rows, ("step_s", "slenderness"), places, plots_stability.PENETRATION
    )
    sizes = np.sort(rows["penetration"][:10])
    np.testing.assert_array_equal(found["penetration"][:, 0], [sizes[9], 1e-5])
    # Over the height of the block, and of every engine but those without gaps.
    of_engine = table.groupby("engine")["penetration"].max()
    assert of_engine["housner"] == 0.0
    assert np.all(table["penetration"].dropna() >= 0.0)
    deep = table[(table["engine"] == "impulse") & (table["map"] == "step")]
    by_step = deep.groupby("step_s")["penetration"].median()
    # At the longest of the three steps corners go through the ground, and no lane is usable.
    assert 0.0 < 1e4 * by_step.iloc[0] < by_step.iloc[1]


def test_the_summary_says_how_deep_corners_go(table: pd.DataFrame):
    said = {
        entry["engine"]: next(text for text in entry["sentences"] if "enetrat" in text)
        for entry in stability_summary.summarise(table)["engines"]
    }
    assert said["housner"] == "Nothing penetrates: it has no gaps."
    worst = table[table["engine"] == "impulse"]["penetration"].max()
    assert f"{worst:.1e}" in said["impulse"]


def log(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers between two ends, evenly in their logarithm."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


LANE = st.tuples(
    log(0.05, 50.0),
    log(0.3, 20.0),
    st.one_of(log(1e-6, 0.9999), log(1e-6, 0.9999).map(lambda ratio: -ratio), st.just(0.0)),
    st.one_of(log(1e-3, 10.0), st.just(0.0)),
    log(0.01, 5.0),
    log(0.1, 50.0),
)


@pytest.mark.parametrize(
    ("engine", "precision"),
    [
        *(
            pytest.param(*engine.values, "float64", marks=engine.marks)
            for engine in all_but(("direct", "xpbd", "dem"), single_block_engines())
        ),
        *(pytest.param(e, "float32", marks=pytest.mark.thorough) for e in ("event", "xpbd")),
    ],
)
@settings(max_examples=12, derandomize=True)
@given(
    picks=st.lists(LANE, min_size=8, max_size=8),
    step=log(1e-6, 0.1),
    control=st.sampled_from([Control.ACCELERATION, Control.VELOCITY, Control.DISPLACEMENT]),
)
def test_no_extreme_raises_hangs_or_passes_a_number_that_cannot_be(
    engine: str, precision: str, picks: list[tuple[float, ...]], step: float, control: Control
):
    height, slenderness, ratio, friction, amplitude, frequency = np.array(picks).T
    if engine == "housner":
        friction = np.full(8, 10.0)
    lanes = make_lanes(height / slenderness, height, ratio, friction)
    rate = 2.0 * np.pi * frequency
    power = {Control.ACCELERATION: 0, Control.VELOCITY: 1, Control.DISPLACEMENT: 2}[control]
    motions = sines(control, amplitude * 9.81 / rate**power, frequency, cycles=2.0)
    chosen = SETTINGS[engine]()
    if hasattr(chosen, "time_step"):
        chosen = at_step(chosen, step)
    built = engine_class(engine)(chosen, Target(precision))
    duration = 5.0
    if built.order is not None:
        duration = min(duration, 200.0 * float(built.longest_step(lanes, motions).min()))
    response = run_batch(
        engine,
        lanes,
        motions,
        SampleTimes(duration, duration / 10.0),
        settings=chosen,
        precision=precision,
    )
    usable = np.isin(response["status"], USABLE)
    for name in ("peak_rotation", "peak_slide", "residual_slide", "energy_lost"):
        assert np.isfinite(response[name][usable]).all(), name
    assert np.isfinite(response["rotation"][usable]).all()
    assert np.all(response["peak_rotation"][usable] <= 0.5 * np.pi + stability.ROTATION_SLACK)
