"""Drawings as files and as parts of a page."""

from __future__ import annotations

import contextlib
import pathlib
import xml.etree.ElementTree

import PIL.Image
import pytest

from warprock.figures import drawing as drawing_file
from warprock.figures.drawing import Drawing, write_drawings
from warprock.figures.sheet import headline, legend_below, style, subplots


@pytest.fixture(scope="module")
def drawing() -> Drawing:
    with style():
        figure, grid = subplots(1, 2, (6.0, 2.0))
        for axes in grid.flat:
            axes.plot([1.0, 2.0], [1.0, 3.0], "o-", label="$x_$")
        headline(figure, "5 of 12 lanes <overturn>", "first line\nsecond line")
    return Drawing("peaks", figure, "5 of 12 lanes <overturn>", 'Twelve lanes & "five" fell.')


def test_a_file_is_whole_and_says_what_it_shows(drawing, tmp_path: pathlib.Path):
    (file,) = write_drawings([drawing], tmp_path)
    assert [each.name for each in tmp_path.iterdir()] == ["peaks.png"] == [file.name]
    with PIL.Image.open(file) as image:
        # The figure grew by its title: a line of 11 points, two of 9, and a margin.
        assert image.size[0] == 6 * 160
        assert image.size[1] == pytest.approx((2.0 + (11 + 9 + 9) * 1.3 / 72 + 0.16) * 160, abs=1)
        assert image.info["Title"] == drawing.title
        assert image.info["Description"] == drawing.alt


def test_parts_of_a_page_have_names_of_their_own_and_are_the_same_every_time(drawing):
    text = drawing.svg()
    root = xml.etree.ElementTree.fromstring(text)
    assert root.tag.endswith("svg")
    names = [each.get("id") for each in root.iter() if each.get("id")]
    assert len(names) == len(set(names))
    assert all(name.startswith("peaks-") for name in names)
    for each in root.iter():
        for key, value in each.items():
            if key.endswith("href"):
                assert value.removeprefix("#") in names
            if value.startswith("url("):
                assert value[5:-1] in names
    assert drawing.svg() is text
    drawing._rendered.clear()
    again = drawing.svg()
    assert again is not text
    assert again == text


def test_the_style_of_a_users_own_figures_is_left_alone():
    import matplotlib

    before = dict(matplotlib.rcParams)
    with style():
        assert matplotlib.rcParams["axes.grid"] is True
    assert dict(matplotlib.rcParams) == before


def test_a_users_script_can_take_the_style_by_its_name():
    import matplotlib.style

    with matplotlib.style.context("warprock.figures.sheet"):
        assert matplotlib.rcParams["image.cmap"] == "cividis"


def test_ticks_that_are_kept_change_no_byte(monkeypatch):
    """Panels that share an axis, a second scale, a logarithm, limits that change."""

    def drawn() -> tuple[bytes, str]:
        with style():
            figure, (panels,) = subplots(1, 2, (3.0, 1.5), sharex=True)
            for axes in panels:
                axes.plot([1.0, 2e3], [1e-3, 7.0])
            panels[0].set_yscale("log")
            panels[1].twinx().plot([1.0, 2e3], [3e5, 4e5])
            made = Drawing("ticks", figure, "said", "alt")
            first = made.png()
            panels[1].set_ylim(-6.0, 1e2)
            return first, made.svg()

    kept = drawn()
    monkeypatch.setattr(drawing_file, "_ticks_kept", lambda _figure: contextlib.nullcontext())
    assert drawn() == kept


def test_panels_are_laid_out_again_only_where_something_has_changed(drawing, monkeypatch):
    """Laying out is the dearer half of saving: a page takes the drawing that a file took before."""
    drawing.png()
    engine = drawing.figure.get_layout_engine()
    laid_out = []
    monkeypatch.setattr(engine, "execute", lambda figure: laid_out.append(figure))
    drawing.svg()
    assert not laid_out
    assert drawing.figure.get_layout_engine() is engine
    drawing.figure.axes[0].set_ylabel("what follows makes room for")
    drawing.svg()
    assert laid_out
    drawing.figure.axes[0].set_ylabel("")


@pytest.mark.parametrize(("letters", "columns"), [(4, 4), (40, 1)])
def test_a_legend_is_not_wider_than_its_figure(letters: int, columns: int):
    with style():
        figure, grid = subplots(1, 1, (5.0, 2.0))
        axes = grid.flat[0]
        for name in "abcd":
            axes.plot([1.0, 2.0], label=name * letters)
        legend_below(figure, axes)
    (legend,) = figure.legends
    assert legend.get_window_extent().width <= figure.bbox.width
    assert legend._ncols == columns
