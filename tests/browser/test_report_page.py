"""The report in Chromium, opened from the disk: the slider moves the pictures, nothing overflows or complains."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from crackgrow.results.report.page import write_report
from tests.browser.conftest import Chromium
from tests.scenes import HOSTILE, make_run, paint

pytestmark = pytest.mark.browser

GROWN = """return document.querySelectorAll("#scene [id^='step-']:not([hidden], #step-0)").length"""
NOW = "return document.getElementById('now').textContent"


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of a run of three growth steps, with pictures, whose title is a script."""
    folder = make_run(tmp_path_factory.mktemp("run"), [f"title='{HOSTILE}'"])
    paint(folder, range(4))
    return write_report(folder)


@pytest.fixture(scope="module")
def failed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    told = "contact: no solution for 'flaw'; " + "a_long_word" * 20
    return make_run(tmp_path_factory.mktemp("failed"), failing=told) / "report.html"


@pytest.mark.parametrize("width", [400, 1400])
@pytest.mark.parametrize("kind", ["report", "failed"])
def test_page_fits_its_window_and_complains_of_nothing(
    chromium: Chromium, request: pytest.FixtureRequest, kind: str, width: int
) -> None:
    page: Path = request.getfixturevalue(kind)
    chromium.open(page, width)
    assert chromium.run("return [document.documentElement.scrollWidth, innerWidth]") == [width, width]
    assert chromium.run("return document.querySelectorAll('.chart svg').length") >= 4
    assert chromium.messages() == []
    wide = "return [...document.querySelectorAll('.card')].filter((card) => card.scrollWidth > card.clientWidth).length"
    assert chromium.run(wide) == 0
    heights = "[...document.querySelectorAll('.chart svg text')].map((text) => text.getBoundingClientRect().height)"
    assert min(chromium.run(f"return {heights}")) >= 10  # pixels


def test_arrow_keys_move_everything_to_the_step(chromium: Chromium, report: Path) -> None:
    chromium.open(report, 1400)
    assert chromium.run("return document.querySelector('h1').textContent") == HOSTILE
    assert chromium.run(NOW).startswith("step 3 of 3:")
    assert chromium.run(GROWN) == 3
    picture = "return document.getElementById('picture').src"
    cursor = "return document.querySelector('#chart-0 .cursor').getAttribute('d')"
    contact = "return document.getElementById('contact').innerHTML"
    tips = "return document.getElementById('tips-body').textContent"
    circles = """return document.querySelector("#scene [id^='tips-']:not([hidden])").id"""
    looks = (picture, cursor, contact, tips, GROWN, NOW, circles)
    seen = [[chromium.run(look) for look in looks]]
    for _ in range(3):
        chromium.press("#step", "left")
        seen.append([chromium.run(look) for look in looks])
    assert chromium.run(NOW).startswith("step 0 of 3:")
    assert chromium.run(GROWN) == 0
    for of_look in zip(*seen, strict=True):
        assert len(set(of_look)) == 4
    assert chromium.run("return document.getElementById('step').getAttribute('aria-valuetext')") == chromium.run(NOW)


def test_play_goes_through_the_steps_and_stops_at_the_last(chromium: Chromium, report: Path) -> None:
    chromium.open(report, 1400)
    chromium.press("#play", "enter")
    assert chromium.run("return document.getElementById('play').textContent") == "Pause"
    assert chromium.run("return Number(document.getElementById('step').value)") < 3
    end = time.monotonic() + 60.0
    while chromium.run("return document.getElementById('play').textContent") == "Pause":
        assert time.monotonic() < end
        time.sleep(0.1)
    assert chromium.run(NOW).startswith("step 3 of 3:")


@pytest.mark.parametrize("kind", ["report", "failed"])
def test_paper_has_all_that_the_page_has(chromium: Chromium, request: pytest.FixtureRequest, kind: str) -> None:
    chromium.open(request.getfixturevalue(kind), 700)  # A4 within its margins
    chromium.media("print")
    chromium.run("window.dispatchEvent(new Event('beforeprint'))")
    boxes = "[...document.querySelectorAll('.card, .card div, .card pre, .card ul')]"
    assert chromium.run(f"return {boxes}.filter((box) => getComputedStyle(box).overflow !== 'visible').length") == 0
    right = "[...document.querySelectorAll('.card *')].map((part) => part.getBoundingClientRect().right)"
    assert chromium.run(f"return Math.max(...{right})") <= 700
    case = "return document.querySelector('pre').getBoundingClientRect().height"
    assert chromium.run(case) > 200
    assert chromium.run("return getComputedStyle(document.getElementById('play')).display") == "none"
    chromium.run("window.dispatchEvent(new Event('afterprint'))")
    assert not chromium.run("return document.querySelector('details').open")
    chromium.media("screen")
