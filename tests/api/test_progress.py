"""How far a command is: a bar in a notebook, nothing where nobody looks."""

import sys
import types

import warprock as wr
from warprock.api.progress import _Bar, shown
from warprock.running.waiting import TEXT


class Handle:
    def __init__(self) -> None:
        self.shown = []

    def update(self, bar) -> None:
        self.shown.append(bar._repr_html_())


def test_a_notebook_shows_a_bar_that_goes_when_the_work_is_done(monkeypatch, capsys):
    handle, first = Handle(), []

    def display(bar, display_id):
        assert display_id
        first.append(bar._repr_html_())
        return handle

    shell = types.SimpleNamespace(kernel=object())
    ipython = types.SimpleNamespace(get_ipython=lambda: shell)
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", types.SimpleNamespace(display=display))
    wr.run("free-b0", "housner")
    assert first == [
        'free-b0 <progress value="0" max="2" aria-label="free-b0"></progress> 0 of 2 lanes'
    ]
    assert "2 of 2 lanes" in handle.shown[-2]
    assert handle.shown[-1] == ""
    assert capsys.readouterr() == ("", "")


def test_a_bar_says_what_the_wait_is_for_until_it_moves_on():
    bar = _Bar("case", 4)
    bar.handle = Handle()
    bar.say(TEXT)
    bar(1)
    assert TEXT in bar.handle.shown[0]
    assert bar.handle.shown[1].endswith("1 of 4 lanes")


def test_a_function_is_called_with_the_lanes_finished_so_far():
    done = []
    wr.run("free-b0", "housner", progress=done.append)
    assert done[-1] == 2


def test_nothing_is_shown_where_nobody_looks(capsys):
    for progress in (True, False):
        with shown(progress, "text", None) as report:
            report(5)
    assert capsys.readouterr() == ("", "")
