"""The page in a real browser: nothing complains, keys work, it fits a phone, it prints."""

from __future__ import annotations

import pathlib
from collections.abc import Iterator

import pytest

from tests.shared.browser import Browser, browser_path
from tests.shared.case_texts import pulse_text
from tests.shared.commands import invoke, succeed
from tests.shared.meshes import l_profile, write

CASE = (
    pulse_text()
    + """
sample_interval = "20 ms"
[[sweep]]
motion.amplitude = ["0.25 g", "0.3 g", "0.4 g", "0.9 g"]
"""
)
PHONE = 360
NOW = "document.querySelector('.now').textContent"

HELD = """
[[tie]]
height = "0.9 m"
side = "left"
stiffness = "0.2 kN/mm"
slack = "1 mm"
yield_force = "300 N"
ultimate_elongation = "12 mm"
[transverse_wall]
side = "left"
rebound = "plastic"
[top_load]
weight = "500 N"
[support]
frequency = "30 Hz"
damping = 0.05
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    folder = tmp_path_factory.mktemp("page")
    (folder / "case.toml").write_text(CASE)
    arguments = ["run", str(folder / "case.toml"), "-e", "housner", "-o", str(folder / "out")]
    succeed(*arguments)
    return folder / "out" / "report.html"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    program = browser_path()
    if program is None:
        pytest.skip("no Chromium is installed here: apt-get install chromium")
    found = Browser(program, tmp_path_factory.mktemp("profile"))
    yield found
    found.close()


@pytest.fixture
def opened(browser: Browser, page: pathlib.Path) -> Browser:
    browser.open(page)
    return browser


@pytest.mark.thorough
def test_nothing_complains_and_nothing_is_fetched(opened: Browser):
    assert opened.run("document.title") == "A block under pulses"
    assert opened.complaints == []
    assert opened.asked == []


def test_every_figure_has_words_and_is_drawn(opened: Browser):
    images = opened.run(
        "Array.from(document.images).map(i => [i.alt, i.naturalWidth, i.src.slice(0, 18)])"
    )
    assert images
    for alt, width, source in images:
        assert len(alt) > 20
        assert width > 100
        assert source == "data:image/svg+xml"
    names = "[role=img], [role=region], [role=group], nav"
    assert opened.run(f"Array.from(document.querySelectorAll('{names}')).every(e => e.ariaLabel)")


def test_a_lane_is_picked_and_plays_by_keys(opened: Browser):
    clock = "parseFloat(document.querySelector('.scene .clock').textContent)"
    # At first the picture is that of the largest rotation.
    assert opened.run(clock) > 0.0
    opened.run("document.querySelector('.player .plot').focus()")
    opened.press("Home")
    assert opened.run(clock) == 0.0
    still = opened.run("document.querySelector('.block').getAttribute('points')")
    opened.press("End")
    assert opened.run(clock) == pytest.approx(3.0)
    opened.press("Home")
    opened.press(" ", " ")
    assert opened.run("document.querySelector('.play').textContent") == "Pause"
    opened.wait(f"{clock} > 0.3")
    opened.press(" ", " ")
    assert opened.run("document.querySelector('.play').textContent") == "Play"
    assert opened.run("document.querySelector('.block').getAttribute('points')") != still
    assert opened.run("Number(document.querySelector('.time').value)") == pytest.approx(
        opened.run(clock), abs=0.03
    )


EARLY_FRAMES = """
    const later = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (step) => later((now) => step(now - 40));
"""
"""A frame that began before Play was pressed, as the first one often does."""


def test_every_lane_plays_without_a_complaint(opened: Browser):
    clock = "parseFloat(document.querySelector('.scene .clock').textContent)"
    opened.run(EARLY_FRAMES)
    for lane in range(4):
        opened.run(f"document.querySelectorAll('.show-lane')[{lane}].click()")
        opened.run("document.querySelector('.play').click()")
        opened.wait(f"{clock} > 0.2")
        opened.run("document.querySelector('.play').click()")
    assert opened.complaints == []


def test_a_row_of_the_table_plays_its_lane(opened: Browser):
    opened.run("document.querySelectorAll('.show-lane')[3].click()")
    assert "lane 3" in opened.run("document.querySelector('.lane').selectedOptions[0].text")
    assert "overturned" in opened.run("document.querySelector('.about').textContent")


def test_a_table_is_sorted_by_a_key(opened: Browser):
    rows = "Array.from(document.querySelectorAll('.sheet tbody tr'))"
    column = f"{rows}.map(r => r.cells[0].innerText)"
    first = [text.split()[-1] for text in opened.run(column)]
    assert first == ["0", "1", "2", "3"]
    opened.run("document.querySelector('.sheet thead button').focus()")
    opened.press("Enter", "\r")
    opened.press("Enter", "\r")
    assert [text.split()[-1] for text in opened.run(column)] == first[::-1]
    assert opened.run("document.querySelector('.sheet thead th').ariaSort") == "descending"


def test_it_fits_a_phone(opened: Browser):
    opened.size(PHONE, 740)
    opened.wait(f"window.innerWidth === {PHONE}")
    assert opened.run("document.documentElement.scrollWidth") <= PHONE
    opened.wait(f"document.querySelector('.scene').viewBox.baseVal.width < {PHONE}")
    small = "Array.from(document.querySelectorAll('button.play, .lane')).map(b => b.offsetHeight)"
    assert min(opened.run(small)) >= 30


def test_it_prints(opened: Browser):
    content = opened.pdf()
    assert content[:5] == b"%PDF-"
    pages = content.count(b"/Type /Page\n") + content.count(b"/Type /Page ")
    assert 1 <= pages <= 6


def test_a_page_written_again_keeps_its_drawings_and_its_lanes(page: pathlib.Path):
    before = page.read_text(encoding="utf-8")
    succeed("report", page.parent)
    after = page.read_text(encoding="utf-8")
    assert after.count("data:image/svg+xml") == before.count("data:image/svg+xml") > 0
    marks = ('class="scenes"', "</script>")
    scenes = [text.partition(marks[0])[2].partition(marks[1])[0] for text in (before, after)]
    assert scenes[0] == scenes[1] != ""


def test_a_folder_without_results_is_refused(tmp_path: pathlib.Path):
    for folder in (tmp_path, tmp_path / "none"):
        result = invoke("report", folder)
        assert result.exit_code == 2
        assert "DIR" in result.stderr
        assert result.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.thorough
def test_a_fallen_stack_says_that_its_model_ended(browser: Browser, tmp_path: pathlib.Path):
    change = ["-s", "motion.amplitude=6 mm, 60 mm", "-s", "run.duration=2 s"]
    arguments = ["run", "stack-sine-pulse", *change, "-o", str(tmp_path)]
    assert invoke(*arguments).exit_code == 0
    browser.open(tmp_path / "report.html")
    lane = "JSON.parse(document.querySelector('script[type=\"application/json\"]').textContent)"
    fallen = browser.run(f"{lane}.lanes.findIndex((each) => each.fell !== undefined)")
    browser.run(
        f"""var choice = document.querySelector('.player .lane');
        choice.value = '{fallen}'; choice.dispatchEvent(new Event('change'));"""
    )
    seek = "var slider = document.querySelector('.player .time'); slider.value = {}; "
    seek += "slider.dispatchEvent(new Event('input'));"
    for time, count in (("0", 0), ("slider.max", 2)):
        browser.run(seek.format(time))
        assert browser.run("document.querySelectorAll('.scene .fallen').length") == count
        said = browser.run("document.querySelector('.scene .clock').textContent")
        assert ("what follows is not modelled" in said) == (count > 0)
    assert browser.complaints == []


@pytest.mark.thorough
def test_every_button_of_a_body_is_pressed(browser: Browser, tmp_path: pathlib.Path):
    mesh, out = write(l_profile(), tmp_path, "corbel.stl"), tmp_path / "out"
    arguments = ["body", str(mesh), "--density", "2700 kg/m^3", "-o", str(out)]
    succeed(*arguments)
    browser.open(out / "report.html")
    titles = (
        "Array.from(document.querySelectorAll('.sheet figcaption strong')).map(e => e.innerText)"
    )
    assert [text.split(";")[0] for text in browser.run(titles)] == [
        "corbel",
        "Poses in which it stands",
    ]
    pressed = browser.run(
        """Array.from(document.querySelectorAll('.sheet thead button')).map((button) => {
        button.click(); return button.parentElement.ariaSort; })"""
    )
    assert pressed == ["ascending"] * 5
    poses = "Array.from(document.querySelectorAll('.sheet')).at(-1)"
    heights = (
        f"Array.from({poses}.querySelectorAll('tbody tr')).map(r => r.lastElementChild.innerText)"
    )
    found = [float(text) for text in browser.run(heights)]
    assert len(found) > 1
    assert found == sorted(found)
    assert browser.complaints == []
    assert browser.asked == []


@pytest.mark.thorough
def test_what_holds_a_block_is_drawn_and_moves(browser: Browser, tmp_path: pathlib.Path):
    (tmp_path / "case.toml").write_text(pulse_text(amplitude="0.8 g") + HELD)
    succeed("run", str(tmp_path / "case.toml"), "-e", "housner", "-o", str(tmp_path / "out"))
    browser.size(900, 900)
    browser.open(tmp_path / "out" / "report.html")

    def show(time: float) -> None:
        slider = "document.querySelector('.time')"
        browser.run(f"{slider}.value = {time}; {slider}.dispatchEvent(new Event('input'))")

    def count(kind: str) -> int:
        return int(browser.run(f"document.querySelectorAll('.scene {kind}').length"))

    ties = []
    for time in (0.0, 0.32, 2.9):
        show(time)
        kind = "document.querySelector('.scene .tie')?.getAttribute('class') ?? 'gone'"
        ties.append((browser.run(kind), "tie" in browser.run(NOW)))
    assert [kind for kind, _ in ties][::2] == ["tie slack", "gone"]
    assert ties[1][0] in ("tie taut", "tie yields")
    assert all(said for _, said in ties)
    # The wall, the far end of the tie, the weight, and two plates with what is between them.
    shown = [count(kind) for kind in (".wall", ".anchor", "line.load", ".base", ".link")]
    assert shown == [1, 1, 1, 2, 2]
    inside = """
        Array.from(document.querySelectorAll('.scene polygon, .scene line')).every((e) => {
            const [box, view] = [e.getBBox(), e.ownerSVGElement.viewBox.baseVal];
            return box.x >= -1 && box.x + box.width <= view.width + 1 && box.y >= -1;
        })
    """
    assert browser.run(inside)
    assert browser.complaints == []
