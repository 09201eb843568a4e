"""Figures of a run: which are written, what is on them, and that all of it can be read."""

from __future__ import annotations

import dataclasses
import itertools
import pathlib
import struct
from typing import Any

import numpy as np
import pytest

from tests.shared.case_texts import pulse_text
from warprock.case.load import load_case
from warprock.figures import histories
from warprock.figures import run as plots_run
from warprock.figures.drawing import Drawing, write_drawings
from warprock.figures.run import draw_run
from warprock.figures.sheet import style
from warprock.model.response import Outcome, Status
from warprock.running.case_run import CaseRun, run_case
from warprock.tables.swept import lanes_at, spread, swept_axes

BLOCK = pulse_text(
    title="Made up", width="0.4 m", height="2 m", friction=0.7, amplitude="0.7 g", duration="4 s"
)
SAMPLED = 'sample_interval = "10 ms"\n'
AMPLITUDES = '[[sweep]]\nmotion.amplitude = { from = "0.11 g", to = "1.9 g", count = %d }\n'
FREQUENCIES = '[[sweep]]\nmotion.frequency = { from = "1 Hz", to = "5 Hz", count = %d }\n'
LABELS = '[[sweep]]\nlabel.block = ["slender", "stocky"]\nblock.width = ["0.4 m", "0.8 m"]\n'
CONTINUOUS = "single-continuous-sine"

TEXTS = {
    "one lane": BLOCK + SAMPLED,
    "no interval": BLOCK + LABELS,
    "one axis": BLOCK + SAMPLED + AMPLITUDES % 1000,
    "map": BLOCK + AMPLITUDES % 20 + FREQUENCIES % 10,
    "panels": BLOCK + SAMPLED + LABELS + AMPLITUDES % 4 + FREQUENCIES % 2,
    "names": BLOCK
    + f"[[sweep]]\nlabel.site = {[f'site of number {n}' for n in range(9)]}\n"
    + f"motion.amplitude = {[f'{5 * n % 9 + 1} mm' for n in range(9)]}\n",
}
SAMPLES_MISSING = ("no interval", "map", "names")


pytestmark = pytest.mark.thorough


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, CaseRun]:
    folder = tmp_path_factory.mktemp("cases")
    found = {name: load_case(name) for name in ("free-b0", CONTINUOUS, "record-ridgecrest")}
    for name, text in TEXTS.items():
        file = folder / f"{name}.toml"
        file.write_text(text, encoding="utf-8")
        found[name] = load_case(file)
    return {name: run_case(case, "housner", histories=False) for name, case in found.items()}


@pytest.fixture(scope="module")
def drawings(runs: dict[str, CaseRun]) -> dict[str, Drawing]:
    """Every drawing of every run, by name of the run and of the drawing."""
    found = {f"{name}/{each.name}": each for name, run in runs.items() for each in draw_run(run)}
    for each in found.values():
        with style():
            each.figure.draw_without_rendering()
    return found


@pytest.fixture(scope="module")
def figures(drawings: dict[str, Drawing]) -> dict[str, Any]:
    """The figures of the drawings."""
    return {name: each.figure for name, each in drawings.items()}


def legend_texts(figure: Any) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def shown_axes(figure: Any) -> list[Any]:
    return [axes for axes in figure.axes if axes.get_visible()]


def titles(figure: Any) -> list[str]:
    return [axes.get_title(loc="left") for axes in shown_axes(figure)]


def test_the_files_are_whole_pngs_at_print_resolution(runs, tmp_path: pathlib.Path):
    files = write_drawings(draw_run(runs["one lane"]), tmp_path)
    assert files == [tmp_path / "histories.png", tmp_path / "peaks.png"]
    assert sorted(tmp_path.iterdir()) == files
    for file in files:
        head = file.read_bytes()[:24]
        assert head[:8] == b"\x89PNG\r\n\x1a\n"
        assert struct.unpack(">II", head[16:24])[0] >= 9.0 * 150


def test_every_run_has_peaks_and_every_sampled_run_has_histories(runs, figures):
    wanted = {f"{name}/peaks" for name in runs}
    wanted |= {f"{name}/histories" for name in runs if name not in SAMPLES_MISSING}
    assert set(figures) == wanted


def test_text_is_8_points_and_legends_cover_no_curve(figures):
    assert sum(bool(figure.legends) for figure in figures.values()) > 8
    for figure in figures.values():
        texts = figure.findobj(match=lambda artist: hasattr(artist, "get_fontsize"))
        assert min(text.get_fontsize() for text in texts if text.get_text()) >= 8.0
        assert not any(axes.get_legend() for axes in figure.axes)
        for legend in figure.legends:
            box = legend.get_window_extent()
            for axes in shown_axes(figure):
                assert not box.overlaps(axes.get_window_extent())
                assert not box.overlaps(axes.xaxis.label.get_window_extent())


def test_no_title_or_name_below_an_axis_runs_into_another(figures):
    for name, figure in figures.items():
        for axes in shown_axes(figure):
            texts = [text for text in axes.get_xticklabels() if text.get_text()]
            slanted = any(text.get_rotation() for text in texts)
            boxes = [text.get_window_extent() for text in texts]
            for one, other in itertools.pairwise(boxes):
                assert slanted or one.x1 <= other.x0, name
            head = axes.title if axes.title.get_text() else axes._left_title
            assert head.get_window_extent().x1 <= figure.bbox.x1, name


def test_axes_carry_their_units(figures):
    for name, figure in figures.items():
        up = name != "one lane/peaks"
        labels = [axes.get_ylabel() if up else axes.get_xlabel() for axes in figure.axes]
        labels.append(figure.get_supylabel())
        assert any(label.endswith("[-]") for label in labels), name
        if name.endswith("histories"):
            assert {axes.get_xlabel() for axes in figure.axes} - {""} == {"time [s]"}
            still = name.startswith("free")
            assert any(label == "base [g]" for label in labels) is not still
    assert figures["one axis/peaks"].axes[0].get_xlabel() == "amplitude [g]"
    assert figures["map/peaks"].axes[0].get_xlabel() == "amplitude [g]"
    assert figures["map/peaks"].get_supylabel() == "frequency [Hz]"
    assert figures["record-ridgecrest/peaks"].axes[0].get_xlabel() == "scale of the record [-]"


def test_labels_are_colours_and_other_inputs_are_panels(drawings, figures):
    figure = figures["panels/peaks"]
    assert legend_texts(figure)[:2] == ["slender", "stocky"]
    assert titles(figure) == ["frequency 1 Hz", "frequency 5 Hz"]
    figure = figures["panels/histories"]
    assert legend_texts(figure)[:2] == ["slender", "stocky"]
    assert "amplitude 0.11 g, frequency 5 Hz - lanes 1, 9 (peaks 0 / 0)" in [
        title.replace("\n", " ") for title in titles(figure)
    ]
    assert "evenly spaced" not in drawings["panels/histories"].alt


def test_few_enough_histories_are_drawn_and_their_choice_is_said(drawings, figures):
    figure = figures["one axis/histories"]
    assert "12 of 1000 lanes, evenly spaced" in drawings["one axis/histories"].alt
    panels = [title for title in titles(figure) if title.startswith("amplitude")]
    assert len(panels) == 12
    assert panels[0].endswith("lane 0 (peak 0)")
    assert panels[-1].endswith("lane 999 (overturned)")


def test_a_history_is_that_of_its_lane(runs, figures):
    run = runs["record-ridgecrest"]
    figure = figures["record-ridgecrest/histories"]
    slenderness = run.lane_set.lanes.slenderness_angle
    whole = [axes for axes in shown_axes(figure) if "rotation" in axes.get_ylabel()]
    assert len(whole) == 7
    for lane, axes in enumerate(whole):
        if run.response["outcome"][lane] != Outcome.OVERTURNED:
            drawn = np.nanmax(np.abs(axes.lines[0].get_ydata()))
            peak = run.response["peak_rotation"][lane] / slenderness[lane]
            # The peak lies between two samples, 10 ms apart, of a swing of a second or so.
            assert drawn == pytest.approx(peak, rel=5e-3, abs=1e-4)


def test_fallen_blocks_squash_no_curve(runs, figures):
    for name in ("record-ridgecrest", "one lane", "one axis", "panels"):
        fallen = runs[name].response["outcome"] == Outcome.OVERTURNED
        assert fallen.any()
        figure = figures[f"{name}/histories"]
        assert any("overturned" in text for text in legend_texts(figure))
        for axes in shown_axes(figure):
            if "rotation" in axes.get_ylabel():
                assert axes.get_ylim()[1] < 1.4
        figure = figures[f"{name}/peaks"]
        if name == "one lane":
            assert figure.axes[0].patches[0].get_width() < 1.4
            continue
        assert any(text == "overturned (drawn at the top)" for text in legend_texts(figure))
        ticks = [text.get_text() for text in figure.axes[0].get_yticklabels()]
        assert ticks[-1] in ("overturned", "fallen")
        low, high = figure.axes[0].get_ylim()
        marks = [line for line in figure.axes[0].lines if line.get_marker() == "^"]
        points = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in marks])
        assert len(points)
        assert np.all((points > 1.0) & (points < high))
        assert len(set(points)) == 1
        assert low <= 0.0
        assert high < 3.0


def test_a_block_still_falling_when_its_run_ends_squashes_no_curve(runs, figures):
    response = runs["one axis"].response
    ratio = response["peak_rotation"] / runs["one axis"].lane_set.lanes.slenderness_angle
    falling = (response["outcome"] == Outcome.ROCKING) & (ratio > 2.0)
    assert falling.any()
    figure = figures["one axis/peaks"]
    assert any(text.startswith("beyond 2, not overturned") for text in legend_texts(figure))
    assert figure.axes[0].get_ylim()[1] < 3.0


def test_every_lane_has_its_mark(runs, figures):
    for name in ("free-b0", CONTINUOUS, "one axis", "panels", "names", "no interval"):
        lines = [line for axes in figures[f"{name}/peaks"].axes for line in axes.lines]
        marks = sum(len(line.get_xdata()) for line in lines if line.get_marker() != "None")
        assert marks == runs[name].response.lane_count


def test_a_map_shows_each_peak_at_its_inputs(runs, figures):
    run = runs["map"]
    mesh = figures["map/peaks"].axes[0].collections[1]
    peaks = run.response["peak_rotation"] / run.lane_set.lanes.slenderness_angle
    stands = run.response["outcome"] != Outcome.OVERTURNED
    assert stands.any()
    assert not stands.all()
    # Amplitude, the first and slower axis of the case, lies across.
    drawn = np.ma.asarray(mesh.get_array()).reshape(10, 20)
    np.testing.assert_array_equal(~np.ma.getmaskarray(drawn), stands.reshape(20, 10).T)
    np.testing.assert_array_equal(drawn.compressed(), peaks.reshape(20, 10).T[~drawn.mask])
    assert "overturned" in legend_texts(figures["map/peaks"])


def test_dense_runs_are_outlined_and_enlarged(figures):
    figure = figures[f"{CONTINUOUS}/histories"]
    assert any("largest and smallest in every" in text for text in legend_texts(figure))
    assert any(title.startswith("enlarged: 0 s to") for title in titles(figure))
    assert "after a velocity step of 0.151 / 0 m/s" in titles(figure)[0].replace("\n", "")
    assert len(shown_axes(figures["free-b0/histories"])) == 1


def test_an_outline_holds_the_extremes_and_ignores_what_is_missing():
    ratio = np.sin(np.linspace(0.0, 100.0, 1001))
    ratio[500:] = np.nan
    times, values = histories._outline(np.linspace(0.0, 1.0, 1001), ratio, 10)
    upper, lower = values[:10], values[11:]
    np.testing.assert_array_equal(times[:10], times[11:])
    assert upper[0] == ratio[:100].max()
    assert lower[3] == ratio[300:400].min()
    assert np.isnan(upper[6:]).all()


def test_lanes_without_a_usable_number_are_left_out_and_counted(runs, monkeypatch):
    run = runs["panels"]
    fields = {name: values.copy() for name, values in run.response.fields.items()}
    fields["status"][:8] = Status.NONFINITE
    fields["peak_rotation"][:8] = np.nan
    broken = dataclasses.replace(run.response, fields=fields)
    monkeypatch.setattr(plots_run, "run_lanes", lambda _, lanes: nan_histories(len(lanes)))
    drawn = draw_run(dataclasses.replace(run, response=broken))
    over_time, peaks = (each.figure for each in drawn)
    assert "8 have no usable number" in drawn[1].title
    assert any(
        "0: nonfinite, numbers not usable" in title.replace("\n", " ")
        for title in titles(over_time)
    )
    marks = [line for axes in peaks.axes for line in axes.lines if line.get_marker() != "None"]
    assert sum(len(line.get_xdata()) for line in marks) == 8


def nan_histories(count: int) -> Any:
    from warprock.model.response import Response

    fields = {
        "rotation": np.full((count, 401), np.nan),
        "outcome": np.full(count, Outcome.ROCKING),
        "status": np.full(count, Status.NONFINITE),
        "peak_time": np.full(count, np.nan),
    }
    return Response("housner", fields, np.linspace(0.0, 4.0, 401))


def test_a_selection_is_even_keeps_the_ends_and_never_exceeds_its_limit():
    for lengths in ([20, 20], [1000], [2, 3, 50], [1, 1], [], [5]):
        chosen = spread(lengths, 12)
        assert np.prod([len(each) for each in chosen]) <= 12
        for length, each in zip(lengths, chosen, strict=True):
            assert each[0] == 0
            if len(each) > 1:
                assert each[-1] == length - 1
                assert np.ptp(np.diff(each)) <= 1
    assert [len(each) for each in spread([20, 20], 12)] == [3, 4]


def test_lanes_at_agrees_with_the_table_of_inputs(runs):
    run = runs["panels"]
    _, amplitudes, frequencies = swept_axes(run.case)
    lanes = lanes_at(run.case, {amplitudes.number: 3, frequencies.number: 1})
    rows = run.lane_set.inputs.iloc[lanes]
    assert list(rows["block"]) == ["slender", "stocky"]
    assert set(rows["frequency_hz"]) == {5.0}
    assert frequencies.name(1) == "frequency 5 Hz"
    assert amplitudes.coordinates[3] * 9.81 == pytest.approx(rows["amplitude_m_s2"].iloc[0])


def test_each_lane_has_its_own_base_and_small_rotations_a_scale_of_their_own(runs, figures):
    figure = figures["record-ridgecrest/histories"]
    strips = [axes for axes in shown_axes(figure) if axes.get_ylabel() == "base [g]"]
    largest = [np.abs(axes.lines[0].get_ydata()).max() for axes in strips]
    scales = runs["record-ridgecrest"].lane_set.inputs["scale"].to_numpy()
    # A record is sampled at 4001 times over 80 s: its peaks lie beside them.
    np.testing.assert_allclose(largest / largest[-1], scales / scales[-1], rtol=1e-9)
    panels = [axes for axes in shown_axes(figure) if "rotation" in axes.get_ylabel()]
    limits = [axes.get_ylim()[1] for axes in panels]
    assert limits[0] == pytest.approx(1.1e-3)
    assert limits[-1] == pytest.approx(1.1 * 1.2)


def test_messages_are_made_from_the_numbers(runs, drawings):
    for name, run in runs.items():
        fell = int(np.sum(run.response["outcome"] == Outcome.OVERTURNED))
        title = drawings[f"{name}/peaks"].title
        assert "\n" not in title
        if run.response.lane_count > 1 and fell:
            assert f"{fell} overturn" in title
        if not fell:
            ratio = run.response["peak_rotation"] / run.lane_set.lanes.slenderness_angle
            largest = f"{ratio.max():.3g} of the slenderness angle"
            assert title.endswith(largest if ratio.any() else "none rotates")
