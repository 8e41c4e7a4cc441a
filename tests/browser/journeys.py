"""What a person does with the page, one step a function; the tests put them together."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Locator, Page

#: Milliseconds after which a step is given up.
PATIENCE_MS = 60_000
#: What the browser itself says where a server refuses or has gone; tests that expect it say so.
OF_THE_NETWORK = re.compile(r"Failed to load resource|WebSocket connection|ERR_CONNECTION")


class Watched:
    """A page, and everything that went wrong in it."""

    def __init__(self, page: Page) -> None:
        self.page = page
        self.faults: list[str] = []
        page.set_default_timeout(PATIENCE_MS)
        page.on("console", self._hear)
        page.on("pageerror", lambda error: self.faults.append(str(error)))

    def _hear(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") or "Content Security Policy" in message.text:
            self.faults.append(f"{message.type}: {message.text}")

    def forgive_network(self) -> None:
        """Forget what the browser says of a server that refuses or has gone."""
        self.faults = [one for one in self.faults if not OF_THE_NETWORK.search(one)]


@contextmanager
def watched_page(browser: Browser, address: str, **options: Any) -> Iterator[Watched]:
    """A page in a context of its own; no message of the console and no exception is left over.

    Parameters
    ----------
    browser : Browser
    address : str
    **options
        Of the context: ``viewport``, ``color_scheme`` ...
    """
    context = browser.new_context(
        **{"viewport": {"width": 1440, "height": 900}, "reduced_motion": "reduce", **options}
    )
    try:
        watched = Watched(context.new_page())
        open_page(watched.page, address)
        yield watched
        assert not watched.faults, watched.faults
    finally:
        context.close()


def open_page(page: Page, address: str) -> None:
    """Go to an address, and wait until the page has its curves."""
    page.goto(address)
    page.wait_for_selector("html[data-ready=true]")
    wait_for_pictures(page)


def other_page(context: BrowserContext, address: str) -> Page:
    """One more page in the same context."""
    page = context.new_page()
    page.set_default_timeout(PATIENCE_MS)
    open_page(page, address)
    return page


def wait_for_pictures(page: Page) -> None:
    """Wait until what was changed has been painted."""
    page.evaluate(
        "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
    )


def control(page: Page, name: str) -> Locator:
    """The control of a number by its name in a study file."""
    return page.locator(f'.control[data-name="{name}"]')


def field(page: Page, name: str) -> Locator:
    """The field to type a number into."""
    return control(page, name).locator("input.number")


def slider(page: Page, name: str) -> Locator:
    return control(page, name).locator("input[type=range]")


def value(page: Page, name: str) -> float:
    """The number in a field."""
    return float(field(page, name).input_value())


def type_number(page: Page, name: str, text: str) -> None:
    """Type into a field and leave it."""
    field(page, name).fill(text)
    field(page, name).press("Tab")
    wait_for_pictures(page)


def picture(page: Page, view: str) -> str:
    """What a view has painted, as text that is equal for equal pictures."""
    text: str = page.evaluate(
        "(view) => [...document.querySelectorAll(`#${view} canvas`)].slice(0, 2)"
        ".map((one) => one.toDataURL()).join()",
        view,
    )
    return text


def pictures(page: Page) -> dict[str, str]:
    """What the views that follow a slider have painted."""
    return {view: picture(page, view) for view in ("history", "phase")}


def drag_slider(page: Page, name: str, shares: list[float]) -> None:
    """Drag the thumb of a slider through places along it, each a share of its length."""
    edges = slider(page, name).bounding_box()
    assert edges is not None
    middle = edges["y"] + edges["height"] / 2
    page.mouse.move(edges["x"] + shares[0] * edges["width"], middle)
    page.mouse.down()
    for share in shares:
        page.mouse.move(edges["x"] + share * edges["width"], middle)
        wait_for_pictures(page)
    page.mouse.up()
    wait_for_pictures(page)


def click_in_plot(page: Page, view: str, across: float, up: float) -> None:
    """Click in a figure at shares of its width and height."""
    body = page.locator(f"#{view} .card-body")
    body.scroll_into_view_if_needed()
    edges = body.bounding_box()
    assert edges is not None
    place = {"x": across * edges["width"], "y": (1.0 - up) * edges["height"]}
    body.click(position={"x": place["x"], "y": place["y"]})
    wait_for_pictures(page)


def drag_in_plot(
    page: Page, view: str, start: tuple[float, float], end: tuple[float, float]
) -> None:
    """Drag a box in a figure between two places, each shares of its width and height."""
    body = page.locator(f"#{view} .card-body")
    body.scroll_into_view_if_needed()
    edges = body.bounding_box()
    assert edges is not None
    places = [
        (edges["x"] + across * edges["width"], edges["y"] + (1.0 - up) * edges["height"])
        for across, up in (start, end)
    ]
    page.mouse.move(*places[0])
    page.mouse.down()
    page.mouse.move(*places[1], steps=4)
    page.mouse.up()
    wait_for_pictures(page)


def downloaded(page: Page, button: str, folder: Path) -> Path:
    """Press a button of the dialog and keep the file that comes."""
    with page.expect_download() as waiting:
        page.click(button)
    file = folder / waiting.value.suggested_filename
    waiting.value.save_as(file)
    return file


def has_no_sideways_scroll(page: Page) -> bool:
    """Whether all of the page lies within its width."""
    inside: bool = page.evaluate(
        "() => document.scrollingElement.scrollWidth <= document.scrollingElement.clientWidth"
    )
    return inside


# Journeys that the page of a server and a saved one share -----------------------------------


def check_slider_moves_curves(page: Page) -> None:
    """A slider that moves changes every curve, and the error stands beside them all the time.

    The load moves, since the temperature has a colour too.
    """
    before, start = pictures(page), value(page, "b")
    assert page.inner_text("#status-error").startswith("Error ≤")
    drag_slider(page, "b", [0.2, 0.21, 0.22])
    after = pictures(page)
    assert value(page, "b") != start
    assert all(before[view] != after[view] for view in before)
    assert page.inner_text("#status-error").startswith("Error ≤")
    assert f"p.b={value(page, 'b'):g}" in page.url


def check_bad_values_are_refused_in_words(page: Page) -> None:
    """What breaks a rule, or is no number, is told beside its field, and the curves stay."""
    before = pictures(page)
    type_number(page, "temperature", "-3")
    fault = control(page, "temperature").locator(".fault")
    assert "greater than 0" in fault.inner_text()
    assert field(page, "temperature").get_attribute("aria-invalid") == "true"
    type_number(page, "omega", "fast")
    assert "not a number" in control(page, "omega").locator(".fault").inner_text()
    assert pictures(page) == before
    type_number(page, "temperature", "300")
    assert fault.inner_text() == ""
    assert pictures(page) != before


def check_address_goes_back_and_forward(page: Page) -> None:
    """Every rest of a slider is a place in the history of the browser, and a reload keeps it."""
    first = value(page, "b")
    type_number(page, "b", "0.5")
    type_number(page, "b", "0.6")
    page.go_back()
    page.wait_for_function("() => location.hash.includes('p.b=0.5')")
    wait_for_pictures(page)
    assert value(page, "b") == 0.5
    page.go_back()
    wait_for_pictures(page)
    assert value(page, "b") == first
    page.go_forward()
    wait_for_pictures(page)
    assert value(page, "b") == 0.5
    page.reload()
    page.wait_for_selector("html[data-ready=true]")
    assert value(page, "b") == 0.5


def check_click_starts_an_orbit(page: Page) -> None:
    """A click in the phase plane starts the motion there."""
    click_in_plot(page, "phase", 0.62, 0.55)
    assert value(page, "stretch") != 1.0
    assert "y.stretch=" in page.url
    page.click("text=Start at rest")
    wait_for_pictures(page)
    assert value(page, "stretch") == 1.0


def check_keyboard_reaches_a_section(page: Page) -> None:
    """From the top of the page to another section and another start, without a pointer."""
    page.keyboard.press("Tab")
    assert page.evaluate("() => document.activeElement.className") == "skip-link"
    for _ in range(80):
        page.keyboard.press("Tab")
        if page.evaluate(
            "() => document.activeElement.closest('.control')?.dataset.name === 'omega'"
        ):
            break
    before = picture(page, "phase")
    page.keyboard.press("ArrowUp")
    wait_for_pictures(page)
    assert picture(page, "phase") != before
    for _ in range(80):
        page.keyboard.press("Tab")
        if page.evaluate("() => document.activeElement.closest('#phase .plot') !== null"):
            break
    outline = page.evaluate("() => getComputedStyle(document.activeElement).outlineStyle")
    assert outline != "none"
    for key in ("ArrowRight",) * 12 + ("ArrowUp",) * 4:
        page.keyboard.press(key)
    assert page.inner_text("#live") != ""
    page.keyboard.press("Enter")
    wait_for_pictures(page)
    assert "y.stretch=" in page.url


def check_theme(page: Page) -> None:
    """The switch turns the page and its figures dark, and back."""
    light = picture(page, "history")
    page.select_option("#theme", "dark")
    wait_for_pictures(page)
    assert page.get_attribute("html", "data-theme") == "dark"
    assert picture(page, "history") != light
    page.select_option("#theme", "light")
    wait_for_pictures(page)
    assert picture(page, "history") == light


def check_figure_files(page: Page, folder: Path) -> None:
    """Figures come as SVG with titles and units, and as PNG."""
    page.click("#phase [data-save]")
    text = downloaded(page, "#save-svg", folder).read_text(encoding="utf-8")
    assert text.startswith("<svg")
    assert "thickness stretch" in text
    assert downloaded(page, "#save-png", folder).read_bytes().startswith(b"\x89PNG")
    rows = downloaded(page, "#data-curves", folder).read_text(encoding="utf-8").splitlines()
    assert rows[0].startswith("time,stretch,stretch_rate,")
    assert len(rows) > 500
    page.click("#take-away header button")
