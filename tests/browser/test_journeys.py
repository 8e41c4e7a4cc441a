"""What people do with the page of a server, in a real browser."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import chain
from pathlib import Path
from urllib.parse import quote

import numpy as np
import pytest
from playwright.sync_api import Browser, Position

import remanent as rm
from remanent.page.spec import read_spec
from remanent.web.explorer import Opened
from remanent.web.opening import open_source
from tests.browser import journeys as go
from tests.unit.web.server import Running, running

#: A damped block near its resonance: it has branches that are not stable, and basins.
DAMPED = "#preset=damped-resonance"


@pytest.fixture(scope="module")
def server() -> Iterator[Running]:
    """A server that was asked to open nothing."""
    with running(Opened()) as one:
        yield one


@pytest.fixture
def visit(browser: Browser, server: Running) -> Iterator[go.Watched]:
    """The page as it opens."""
    with go.watched_page(browser, f"{server.origin}/") as watched:
        yield watched


def test_slider_moves_curves(visit: go.Watched) -> None:
    """Curves follow a slider, and their error is in sight."""
    go.check_slider_moves_curves(visit.page)


def test_bad_values_are_refused_in_words(visit: go.Watched) -> None:
    """What a rule refuses is told beside the field, and nothing moves."""
    go.check_bad_values_are_refused_in_words(visit.page)


@pytest.mark.slow
def test_address_goes_back_and_forward(visit: go.Watched) -> None:
    """Every state is in the address: back, forward and reload give it again."""
    go.check_address_goes_back_and_forward(visit.page)


def test_click_starts_an_orbit(visit: go.Watched) -> None:
    """A click in the phase plane is the start of the next motion."""
    go.check_click_starts_an_orbit(visit.page)


def test_keyboard_reaches_a_section(visit: go.Watched) -> None:
    """Keys alone lead to a section of one's own parameters."""
    go.check_keyboard_reaches_a_section(visit.page)


def test_theme(visit: go.Watched) -> None:
    """Light and dark are chosen, and kept."""
    go.check_theme(visit.page)


def test_figure_files(visit: go.Watched, tmp_path: Path) -> None:
    """Figures are given out as SVG and PNG, with axes and units."""
    go.check_figure_files(visit.page, tmp_path)


def test_preset_and_shared_address(visit: go.Watched) -> None:
    """A preset shows its system; its address, opened elsewhere, shows the same curves."""
    page = visit.page
    page.select_option("#preset", "quasi-periodic")
    page.wait_for_function("() => location.hash.includes('quasi-periodic')")
    go.type_number(page, "temperature", "310")
    other = go.other_page(page.context, page.url)
    assert go.value(other, "temperature") == 310.0
    assert go.value(other, "omega") == 1.6
    page.reload()
    page.wait_for_selector("html[data-ready=true]")
    go.wait_for_pictures(page)
    assert go.picture(other, "phase") == go.picture(page, "phase")
    other.close()
    page.go_back()
    page.go_back()
    page.wait_for_function("() => !location.hash.includes('quasi-periodic')")
    page.wait_for_function(
        "() => document.querySelector('.control[data-name=omega] input.number').value === '1.25'"
    )


@pytest.mark.slow
def test_another_kind_of_part(visit: go.Watched) -> None:
    """Another material is another system of equations, with controls of its own."""
    page = visit.page
    before = go.picture(page, "history")
    page.select_option("[data-kind=material]", "Gent")
    go.control(page, "material.jm").wait_for()
    go.wait_for_pictures(page)
    assert go.picture(page, "history") != before
    page.select_option("[data-kind=dissipation]", "Rayleigh")
    go.control(page, "dissipation.0.eta").wait_for()
    assert "Rayleigh" in page.url
    page.select_option("[data-kind=drive]", "Constant")
    go.control(page, "m").wait_for()
    assert not page.is_visible("#response")


def test_tables_of_a_load_are_edited(visit: go.Watched) -> None:
    """Times and loads are a table in the panel; what is wrong with it is told beside it."""
    page = visit.page
    page.select_option("[data-kind=drive]", "Steps")
    page.click("[data-table=drive] summary")
    text, fault = "[data-table=drive] textarea", "[data-table=drive] .fault"
    for rows, words in (("0 0.1\n30 x", "no row"), ("0 0.1\n30 1e9", "between"),
                        ("0 0.1\n30 0.2\n9 0", "increase")):  # fmt: skip
        page.fill(text, rows)
        page.click("[data-apply=drive]")
        page.wait_for_function(
            "([place, words]) => document.querySelector(place).textContent.includes(words)",
            arg=[fault, words],
        )
        # A browser tells late that the table was opened.
        page.dispatch_event("[data-table=drive]", "toggle")
        assert words in page.inner_text(fault)
        assert page.input_value(text) == rows
    before = go.picture(page, "history")
    page.fill(text, "0 0.1\n40 0.3")
    page.click("[data-apply=drive]")
    page.wait_for_function("() => location.hash.includes('%5B0%2C40%5D')")
    go.wait_for_pictures(page)
    assert go.picture(page, "history") != before
    assert page.input_value(text) == "0  0.1\n40  0.3"
    visit.forgive_network()


def test_a_formula_is_edited(visit: go.Watched) -> None:
    """A strain energy of one's own is written in the panel, with its constants."""
    page = visit.page
    page.select_option("[data-kind=material]", "StrainEnergy")
    page.click("[data-table=material] summary")
    fields = page.locator("[data-table=material] textarea")
    fields.nth(0).fill("a*(I1 - 3) + d*(I1 - 3)**3")
    fields.nth(1).fill("a = 0.5\nd = 0.001")
    page.click("[data-apply=material]")
    go.control(page, "material.d").wait_for()
    assert go.value(page, "material.a") == 0.5


def test_own_system(visit: go.Watched) -> None:
    """The text of a study file becomes a system; its faults are told with their places."""
    page = visit.page
    page.click("#open-own")
    text = page.input_value("#study-text")
    page.fill("#study-text", text.replace("delta = 0.15", 'delta = "much"'))
    page.click("#load-study")
    page.wait_for_function("() => document.querySelector('#study-fault').textContent !== ''")
    assert "delta" in page.inner_text("#study-fault")
    page.fill("#study-text", text)
    page.click("#load-study")
    go.control(page, "delta").wait_for()
    assert not page.is_visible("#actuator")
    visit.forgive_network()


def test_regime_and_response_come_by_themselves(visit: go.Watched) -> None:
    """The engine tells the regime with its evidence, and the response with its error."""
    page = visit.page
    page.wait_for_function(
        "() => document.querySelector('#status-regime').textContent.includes('quasi-periodic')"
    )
    assert "Lyapunov exponent" in page.inner_text("#regime .evidence")
    assert "Largest at ω" in page.inner_text("#response .card-note")
    assert "error" in page.inner_text("#response .card-note")


@pytest.mark.slow
def test_zoom_and_finer_response(visit: go.Watched) -> None:
    """A drag zooms and starts no orbit; the response can be computed for what is shown."""
    page = visit.page
    page.wait_for_function(
        "() => document.querySelector('#response .card-note').textContent.includes('Largest at')"
    )
    for view in ("phase", "response", "history"):
        before, address = go.picture(page, view), page.url
        go.drag_in_plot(page, view, (0.4, 0.7), (0.8, 0.4))
        assert go.picture(page, view) != before
        assert page.url == address
        if view == "response":
            page.click("text=Compute this range")
            page.wait_for_selector("#response .plot-zoomed", state="hidden")
            page.wait_for_selector("#response:not([aria-busy])")
            assert "Largest at ω = 1.25" in page.inner_text("#response .card-note")
        else:
            page.click(f"#{view} >> text=Show all")
            assert go.picture(page, view) == before


@pytest.mark.slow
def test_response_with_unstable_branches(browser: Browser, server: Running) -> None:
    """Branches show what is stable and what is not, with the folds between them."""
    with go.watched_page(browser, f"{server.origin}/{DAMPED}") as watched:
        page = watched.page
        page.wait_for_function(
            "() => document.querySelector('#response .card-key').textContent.includes('from rest')"
        )
        before = go.picture(page, "response")
        page.check("#branches")
        page.wait_for_function(
            "() => document.querySelector('#response .card-key').textContent.includes('saddle')"
        )
        assert "fold" in page.inner_text("#response .card-note")
        assert go.picture(page, "response") != before
        page.uncheck("#branches")
        assert "saddle" not in page.inner_text("#response .card-key")


@pytest.mark.slow
def test_chart_is_cancelled_and_computed(browser: Browser, server: Running) -> None:
    """A chart that goes on can be cancelled; one that is done starts motions by a click."""
    with go.watched_page(browser, f"{server.origin}/{DAMPED}") as watched:
        page = watched.page
        page.wait_for_function(
            "() => document.querySelector('#status-regime').textContent.includes('periodic')"
        )
        page.select_option("#basins select", "64")
        page.click("#basins button:has-text('Compute')")
        page.click("#basins button:has-text('Cancel')")
        assert "Cancelled" in page.inner_text("#basins .card-note")
        page.select_option("#basins select", "16")
        page.click("#basins button:has-text('Compute')")
        page.wait_for_selector("#basins .heatmaplayer image")
        assert "A, period 1" in page.inner_text("#basins .card-key")
        edges = page.locator("#basins .nsewdrag").bounding_box()
        assert edges is not None
        page.locator("#basins .nsewdrag").click(position={"x": 30, "y": edges["height"] / 2})
        page.wait_for_function("() => location.hash.includes('y.stretch=')")
        clicked = page.url
        page.focus("#basins .plotly-host")
        for key in ("ArrowRight", "ArrowRight", "ArrowUp"):
            page.keyboard.press(key)
        assert "period 1" in page.inner_text("#live")
        page.keyboard.press("Enter")
        page.wait_for_function("(before) => location.href !== before", arg=clicked)


DRAW = """
async () => {
  const { drawFigure } = await import("/assets/app/heat.js");
  const host = document.querySelector("#basins .plotly-host");
  const said = [];
  const figure = { data: [{ x: [1], y: [2] }], layout: {} };
  await drawFigure(host, figure, () => {}, (words) => said.push(words));
  const isDrawn = host.querySelector("svg") !== null;
  return [host.innerText.includes("still running"), isDrawn, said.length];
}
"""


def test_a_chart_whose_library_does_not_come_says_so(visit: go.Watched) -> None:
    """Then it is asked for again, and the chart stands where the words were."""
    visit.page.route("**/plotly.js", lambda route: route.abort())
    assert visit.page.evaluate(DRAW) == [True, False, 1]
    visit.page.unroute("**/plotly.js")
    assert visit.page.evaluate(DRAW) == [False, True, 0]
    visit.forgive_network()


@pytest.mark.slow
def test_a_busy_machine_is_asked_again(browser: Browser) -> None:
    """What another page computes is waited for, in words, and then it is one's own turn."""
    told = (
        "() => document.querySelector('#response .job-words').textContent.includes('other pages')"
    )
    with running(Opened()) as server, go.watched_page(browser, f"{server.origin}/") as first:
        first.page.wait_for_function(
            "() => document.querySelector('#status-regime').textContent.includes(':')"
        )
        first.page.select_option("#regime_chart select", "64")
        first.page.click("#regime_chart button:has-text('Compute')")
        first.page.wait_for_selector("#regime_chart button:has-text('Cancel')")
        with go.watched_page(browser, f"{server.origin}/") as second:
            second.page.wait_for_function(told)
            first.page.click("#regime_chart button:has-text('Cancel')")
            second.page.wait_for_function(
                "() => document.querySelector('#response .card-note').textContent"
                ".includes('Largest at')"
            )


@pytest.mark.slow
def test_server_goes_and_comes_back(browser: Browser) -> None:
    """Without a server curves still follow the sliders; with one again the rest comes back."""
    with ExitStack() as servers:
        first = servers.enter_context(running(Opened()))
        with go.watched_page(browser, f"{first.origin}/") as watched:
            page = watched.page
            servers.close()
            page.select_option("#preset", "figure-6")
            page.wait_for_selector("#retry")
            page.select_option("#basins select", "16")
            page.click("#basins button:has-text('Compute')")
            page.wait_for_selector("#basins .card-note.bad")
            assert "server" in page.inner_text("#status-server")
            before = go.picture(page, "history")
            go.type_number(page, "temperature", "280")
            assert go.picture(page, "history") != before
            page.wait_for_function(
                "() => document.querySelector('#live').textContent.startsWith('Error')"
            )
            page.click("#retry")
            assert page.is_visible("#retry")
            servers.enter_context(running(Opened(), port=first.port))
            page.wait_for_selector("#retry", state="hidden")  # it is found without being asked
            assert not page.is_visible("#banner")
            assert "does not answer" not in page.inner_text("#basins .card-note")
            page.wait_for_selector("#basins[aria-busy], #basins .heatmaplayer image")
            page.evaluate(  # the chart goes on; what waits behind it need not wait for its end
                "() => [...document.querySelectorAll('#basins button')]"
                ".find((one) => one.textContent.includes('Cancel'))?.click()"
            )
            page.wait_for_function(
                "() => document.querySelector('#response .card-note').textContent"
                ".includes('Largest at')"
            )
            watched.forgive_network()


@pytest.mark.slow
def test_store_shows_the_motion_of_a_point(browser: Browser, tmp_path: Path) -> None:
    """A click in the chart of a store shows the motion behind it, under the point's numbers."""
    actuator = rm.Actuator(temperature=350.0, dissipation=rm.Rayleigh(0.1))
    omega, b = np.array([0.9, 1.2, 1.5, 1.8]), np.array([0.2, 0.4, 0.6])
    store = tmp_path / "<b>chart.zarr"
    rm.sweep(
        actuator, rm.SineSquared(0.4, 1.25), {"b": b, "omega": omega}, "classify",
        store=store, periods=100,
    )  # fmt: skip
    with (
        running(open_source(store)) as server,
        go.watched_page(browser, f"{server.origin}/") as watched,
    ):
        page = watched.page
        page.wait_for_selector("#store .heatmaplayer image")
        assert page.inner_text("#store h2") == "Study: <b>chart.zarr"
        assert "12 points" in page.inner_text("#store .card-note")
        cells = page.locator("#store .nsewdrag")
        edges = cells.bounding_box()
        assert edges is not None
        place: Position = {"x": edges["width"] * 2.5 / 4, "y": edges["height"] * 0.5 / 3}
        cells.hover(position=place)
        page.wait_for_selector("#store .hoverlayer text")
        cells.click(position=place)
        page.wait_for_function("() => location.hash.includes('spec=')")
        go.wait_for_pictures(page)
        assert (go.value(page, "omega"), go.value(page, "b")) == (1.5, 0.6)
        text = page.evaluate(
            "async () => (await import('/assets/app/heat.js')).cellText([['<b>', '<img src=x>']])"
        )
        assert text == "&lt;b&gt;: &lt;img src=x&gt;"
        title = page.evaluate(
            "async () => (await import('/assets/app/titles.js'))"
            ".titleForPlotly({ text: '<b>text</b>', symbol: '<i>', unit: '<a href=x>unit</a>' })"
        )
        assert "<b>" not in title
        assert "<a" not in title
        assert title.endswith("(&lt;a href=x&gt;unit&lt;/a&gt;)")


def test_files_of_the_engine(visit: go.Watched, tmp_path: Path) -> None:
    """Data come as netCDF and CSV, and the lines, the study and the equations as text."""
    page = visit.page
    go.type_number(page, "periods", "20")
    go.type_number(page, "b", "0.45")
    page.click("#open-take-away")
    motion = rm.load(go.downloaded(page, "#data-netcdf", tmp_path))
    assert float(motion.time[-1]) > 0.0
    assert "stretch" in go.downloaded(page, "#data-csv", tmp_path).read_text(encoding="utf-8")
    page.wait_for_selector("pre[aria-label='motion.py']")
    assert "rm.SineSquared(b=0.45, omega=1.25)" in page.inner_text("pre[aria-label='motion.py']")
    assert "periods=20" in page.inner_text("pre[aria-label='motion.py']")
    assert "periods = 20" in page.inner_text("pre[aria-label='study.toml']")
    assert "[drive]" in page.inner_text("pre[aria-label='study.toml']")
    page.select_option("#language", "c")
    page.wait_for_selector("pre[aria-label='system.c']")
    assert "remanent_rates" in page.inner_text("pre[aria-label='system.c']")


def test_curves_are_those_of_the_package(visit: go.Watched, tmp_path: Path) -> None:
    """After sliders have moved, the curves of the page are the motion under their numbers."""
    page = visit.page
    for name, text in (("periods", "20"), ("b", "0.7"), ("temperature", "310")):
        go.type_number(page, name, text)
    page.click("#open-take-away")
    file = go.downloaded(page, "#data-curves", tmp_path)
    curves = np.genfromtxt(file, delimiter=",", names=True)[1::97]
    motion = rm.simulate(
        rm.Actuator(temperature=310.0), rm.SineSquared(0.7, 1.25), times=curves["time"]
    )
    size = float(np.abs(motion.stretch).max())
    allowed = curves["error_share"] * size + float(motion.error)
    assert (np.abs(curves["stretch"] - motion.stretch.values) <= allowed).all()
    assert allowed.max() < 1e-4


@pytest.mark.parametrize(
    ("width", "height"),
    [
        (360, 800),
        pytest.param(820, 1180, marks=pytest.mark.slow),
        pytest.param(1440, 900, marks=pytest.mark.slow),
        pytest.param(3840, 2160, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_size_fits(
    browser: Browser, server: Running, width: int, height: int, scheme: str
) -> None:
    """From a phone to 4K nothing lies beside the page, and the curves are painted."""
    with go.watched_page(
        browser, f"{server.origin}/", viewport={"width": width, "height": height},
        color_scheme=scheme,
    ) as watched:  # fmt: skip
        page = watched.page
        assert page.get_attribute("html", "data-theme") == scheme
        assert go.has_no_sideways_scroll(page)
        assert page.locator("#history canvas").first.bounding_box()
        if width == 360:
            page.click("#controls-toggle")
            go.type_number(page, "temperature", "300")
            assert go.has_no_sideways_scroll(page)


@pytest.mark.slow
def test_motion_stands_still_where_that_is_preferred(browser: Browser, server: Running) -> None:
    """The animation waits for its button where people ask for less motion, and runs elsewhere."""
    for preference, words in (("reduce", "Play"), ("no-preference", "Pause")):
        address = f"{server.origin}/"
        with go.watched_page(browser, address, reduced_motion=preference) as watched:
            assert watched.page.inner_text("#play") == words
            before = watched.page.inner_text("#actuator .card-note")
            watched.page.click("#play")
            watched.page.wait_for_timeout(300)
            after = watched.page.inner_text("#actuator .card-note")
            if preference == "reduce":
                assert after != before


@pytest.mark.slow
def test_units_turn_to_si(browser: Browser) -> None:
    """An actuator with sizes shows hertz, millitesla and milliseconds, and takes them typed."""
    spec = {
        "actuator": {
            "si": {
                "shear_modulus": "100 kPa",
                "density": "2000 kg/m^3",
                "half_length": "5 mm",
                "half_thickness": "2 mm",
                "remanence": "143 mT",
            }
        },
        "drive": {"kind": "SineSquared", "b": 0.4, "omega": 1.25},
    }
    actuator, _, _ = read_spec(spec)
    assert isinstance(actuator, rm.Actuator)
    with (
        running(Opened(spec)) as server,
        go.watched_page(browser, f"{server.origin}/") as watched,
    ):
        page = watched.page
        page.click("[data-value=yes]")
        go.wait_for_pictures(page)
        assert go.value(page, "omega") == pytest.approx(hertz(actuator, 1.25), rel=1e-4)
        assert "Hz" in go.control(page, "omega").inner_text()
        assert "mT" in go.control(page, "b").inner_text()
        assert "ms" in page.inner_text("#status-error")
        page.select_option("[data-kind=drive]", "Sine")
        go.control(page, "mean").wait_for()
        labels = page.locator(".control .symbol").all_inner_texts()
        assert len(set(labels)) == len(labels), labels
        page.wait_for_function(
            "() => document.querySelector('#response .card-note').textContent.includes(' ms')"
        )
        assert "Hz" in page.inner_text("#response .card-note")
        assert "τ" not in page.inner_text("#response .card-note")
        page.click("[data-value=no]")
        go.wait_for_pictures(page)
        assert "up to τ = 100" in page.inner_text("#response .card-note")
        page.click("[data-value=yes]")
        go.type_number(page, "omega", "300")
        page.click("[data-value=no]")
        go.wait_for_pictures(page)
        assert hertz(actuator, go.value(page, "omega")) == pytest.approx(300.0, rel=1e-5)


def hertz(actuator: rm.Actuator, omega: float) -> float:
    """A frequency of an actuator with sizes."""
    scales = actuator.scales
    assert scales is not None
    return omega / (2.0 * math.pi * scales.si_factors()["time_s"])


def test_a_broken_address_is_told(browser: Browser, server: Running) -> None:
    """What cannot be read of an address is left out, in words."""
    address = f"{server.origin}/#preset=figure-6&p.temperature=warm&nonsense=1"
    with go.watched_page(browser, address) as watched:
        assert "could not be read" in watched.page.inner_text("#banner")
        assert go.value(watched.page, "prestress") == 1.0


#: Parts of addresses that no field takes, in two lists without a name twice.
REFUSED = [
    ["p.temperature=-5", "p.c=0", "p.omega=0", "y.stretch=-1", "periods=1e9", "p.none=1",
     "span=middle", "units=imperial"],
    ["p.temperature=1e308", "periods=3.7", "y.__proto__=1&p.constructor=1"],
]  # fmt: skip


@pytest.mark.parametrize(
    "words",
    [
        *map("&".join, REFUSED),
        *(pytest.param(one, marks=pytest.mark.slow) for one in chain(*REFUSED)),
    ],
)
def test_an_address_keeps_the_rules_of_its_fields(
    browser: Browser, server: Running, words: str
) -> None:
    """Law: what could not be typed does not come by an address either; the rest of it does."""
    shown = {"temperature": 350.0, "c": 1.0, "omega": 1.25, "stretch": 1.0, "periods": 500.0}
    with go.watched_page(browser, f"{server.origin}/#p.b=0.6&{words}") as watched:
        assert "could not be read" in watched.page.inner_text("#banner")
        for name, value in shown.items():
            assert go.value(watched.page, name) == value
        assert go.value(watched.page, "b") == 0.6


@pytest.mark.parametrize(
    "spec",
    [
        pytest.param("[1]", marks=pytest.mark.slow),
        '{"actuator":{},"drive":{"kind":"Other"}}',
        pytest.param("[" * 2000 + "]" * 2000, marks=pytest.mark.slow),
    ],
)
def test_a_refused_system_of_an_address_is_told(
    browser: Browser, server: Running, spec: str
) -> None:
    """What the server refuses of an address is told, and the page shows what it begins with."""
    with go.watched_page(browser, f"{server.origin}/#spec={quote(spec)}") as watched:
        assert "cannot be shown" in watched.page.inner_text("#banner")
        assert go.value(watched.page, "omega") == 1.25
        watched.forgive_network()


@pytest.mark.slow
def test_at_rest_a_motion_is_known_longer(visit: go.Watched) -> None:
    """A chaotic motion is followed with more steps when nothing has moved for a moment."""
    page = visit.page
    page.select_option("#preset", "two-wells")
    page.wait_for_function("() => location.hash.includes('two-wells')")
    until = (
        "() => Number(/τ = ([0-9.]+)/.exec(document.querySelector('#status-error').textContent)[1])"
    )
    page.wait_for_function(f"() => ({until})() > 200")
    go.type_number(page, "delta", "0.26")
    first = page.evaluate(until)
    page.wait_for_function(f"(first) => ({until})() > first", arg=first)


@pytest.mark.slow
def test_enormous_numbers_break_nothing(visit: go.Watched) -> None:
    """Numbers that no motion stands are refused in words; nothing is thrown or drawn wrong."""
    page = visit.page
    before = go.pictures(page)
    for name, text in (
        ("b", "1e200"), ("omega", "1e-9"), ("stretch", "1e200"), ("stretch_rate", "1e300"),
        ("prestress", "-1e10"), ("temperature", "1e308"), ("c", "1e300"),
    ):  # fmt: skip
        usual = go.field(page, name).input_value()
        go.type_number(page, name, text)
        assert go.control(page, name).locator(".fault").inner_text().startswith("Got ")
        assert "NaN" not in page.inner_text("body")
        go.type_number(page, name, usual)
    assert go.pictures(page) == before


def test_from_slider_to_curves_is_measured(
    visit: go.Watched, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each move of a slider has its times in the page; the median is printed, not judged."""
    page = visit.page
    page.evaluate("() => { window.remanentTimings.length = 0; }")
    go.drag_slider(page, "temperature", [0.3 + 0.01 * k for k in range(40)])
    timings = page.evaluate("() => window.remanentTimings")
    taken = [one["drawn"] - one["asked"] for one in timings]
    assert len(taken) > 20
    assert all(
        one["asked"] <= one["started"] <= one["integrated"] <= one["drawn"] for one in timings
    )
    with capsys.disabled():
        print(f"\nslider to curves, 500 periods: median {statistics.median(taken):.1f} ms")
