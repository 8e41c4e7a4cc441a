"""The page as one file: the same journeys, from a disk and with the network off.

Those that lead through the same modules as in the page of the server are slow tests here.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from playwright.sync_api import Browser

import remanent as rm
from remanent.page.assemble import saved_page
from remanent.page.model import page_model
from remanent.page.presets import presets
from remanent.web.jobs import job_result
from remanent.web.subjects import Subject
from tests.browser import journeys as go

#: Jobs whose results are kept in the page, with options that take little time.
OPTIONS: dict[str, dict[str, Any]] = {
    "frequency_response": {"range": [0.8, 1.8], "count": 60},
    "response_diagram": {"range": [1.1, 1.4]},
    "classify": {"periods": 200},
    "basins": {"grid": {"stretch": [0.7, 1.3], "stretch_rate": [-0.5, 0.5]}, "count": 6},
}


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A saved page of a damped block near its resonance."""
    subject = Subject(
        rm.Actuator(temperature=350.0, dissipation=rm.Rayleigh(0.05)),
        rm.SineSquared(0.4, 1.25),
        {},
    )
    results = {name: job_result(name, subject, one) for name, one in OPTIONS.items()}
    file = tmp_path_factory.mktemp("page") / "page.html"
    model = page_model(subject.system, subject.drive)
    chosen = [one for one in presets() if one["id"] in ("figure-6", "two-wells")]
    file.write_text(saved_page(model, results, presets=chosen), encoding="utf-8")
    return file.as_uri()


@pytest.fixture
def visit(browser: Browser, address: str) -> Iterator[go.Watched]:
    """The page as it opens, with nothing that it could ask."""
    with go.watched_page(browser, address, offline=True) as watched:
        yield watched


def test_slider_moves_curves(visit: go.Watched) -> None:
    """Curves follow a slider, and their error is in sight."""
    go.check_slider_moves_curves(visit.page)


@pytest.mark.slow
def test_bad_values_are_refused_in_words(visit: go.Watched) -> None:
    """What a rule refuses is told beside the field, and nothing moves."""
    go.check_bad_values_are_refused_in_words(visit.page)


@pytest.mark.slow
def test_address_goes_back_and_forward(visit: go.Watched) -> None:
    """Every state is in the address: back, forward and reload give it again."""
    go.check_address_goes_back_and_forward(visit.page)


@pytest.mark.slow
def test_click_starts_an_orbit(visit: go.Watched) -> None:
    """A click in the phase plane is the start of the next motion."""
    go.check_click_starts_an_orbit(visit.page)


@pytest.mark.slow
def test_keyboard_reaches_a_section(visit: go.Watched) -> None:
    """Keys alone lead to a section of one's own parameters."""
    go.check_keyboard_reaches_a_section(visit.page)


@pytest.mark.slow
def test_theme(visit: go.Watched) -> None:
    """Light and dark are chosen, and kept."""
    go.check_theme(visit.page)


@pytest.mark.slow
def test_figure_files(visit: go.Watched, tmp_path: Path) -> None:
    """Figures are given out as SVG and PNG, with axes and units."""
    go.check_figure_files(visit.page, tmp_path)


def test_results_stand_in_for_the_server(visit: go.Watched) -> None:
    """What the server would compute is there as it was saved, and one line says so."""
    page = visit.page
    assert "A saved page" in page.inner_text("#saved")
    assert "periodic" in page.inner_text("#status-regime")
    assert "Lyapunov exponent" in page.inner_text("#regime .evidence")
    assert "saddle" in page.inner_text("#response .card-key")
    assert "period 1" in page.inner_text("#basins .card-key")
    assert not page.is_visible("#regime_chart")
    for control in ("#open-own", "#branches", "[data-kind]", "#data-netcdf"):
        assert page.locator(control).count() == 0
    go.drag_slider(page, "temperature", [0.5, 0.3])
    assert "as saved" in page.inner_text("#response .card-key")
    assert "old" in (page.get_attribute("#status-regime", "class") or "")


@pytest.mark.slow
def test_presets_and_addresses_need_no_server(visit: go.Watched, address: str) -> None:
    """A preset shows its system without results of another; the address says which it is."""
    page = visit.page
    first = go.picture(page, "history")
    page.select_option("#preset", "two-wells")
    go.control(page, "delta").wait_for()
    go.wait_for_pictures(page)
    assert go.picture(page, "history") != first
    assert "of the system that it was saved with" in page.inner_text("#saved")
    for view in ("response", "regime", "basins"):
        assert not page.is_visible(f"#{view}")
    page.click("#open-take-away")
    assert "rm.LagrangianSystem" in page.inner_text("pre[aria-label='motion.py']")
    page.click("#take-away header button")
    other = go.other_page(page.context, page.url)
    assert go.value(other, "delta") == 0.25
    other.close()
    page.go_back()
    go.control(page, "temperature").wait_for()
    go.wait_for_pictures(page)
    assert go.picture(page, "history") == first
    assert "Largest at" in page.inner_text("#response .card-note")
    go.type_number(page, "b", "0.5")
    assert "spec=%7B%22actuator" in page.url
    page.goto("about:blank")
    foreign = quote('{"actuator":{},"drive":{"kind":"Constant","m":1}}')
    go.open_page(page, f"{address}#spec={foreign}")
    assert "saved with other equations" in page.inner_text("#banner")


def test_lines_and_equations_are_in_the_file(visit: go.Watched) -> None:
    """The lines that make the page, and its equations in other languages, need no server."""
    page = visit.page
    page.click("#open-take-away")
    assert "rm.Rayleigh" in page.inner_text("pre[aria-label='motion.py']")
    page.select_option("#language", "python")
    page.click("#show-equations")
    assert "def rates" in page.inner_text("pre[aria-label='system.py']")


@pytest.mark.slow
@pytest.mark.parametrize("width", [360, 1440])
def test_no_sideways_scroll(browser: Browser, address: str, width: int) -> None:
    """A phone shows the file as a screen does."""
    viewport = {"width": width, "height": 800}
    with go.watched_page(browser, address, offline=True, viewport=viewport) as watched:
        assert go.has_no_sideways_scroll(watched.page)
