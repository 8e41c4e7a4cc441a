"""The site of the documentation: without a network, on a phone and on a screen, light and dark."""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from matplotlib.image import imread
from playwright.sync_api import Browser, Page

from tests.browser.site import HtmlPage, addresses_loaded, is_elsewhere

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[2] / "docs"

#: What may be wider than the page, each in a frame of its own that is moved under the finger.
FRAMES = "pre, .table-wrapper, .math-wrapper, a:has(> img.wide)"

#: Elements of the page that reach beyond its right edge, but for what is in such a frame.
BEYOND = """frames => [...document.querySelectorAll('html, .content, article *')]
  .filter(one => one.getBoundingClientRect().right > innerWidth + 1 ||
                 (one.matches('html, .content') && one.scrollWidth > one.clientWidth + 1))
  .filter(one => !one.closest(frames) && getComputedStyle(one).position !== 'absolute')
  .map(one => one.tagName + ' ' + one.textContent.trim().slice(0, 60))"""

#: Lines of code that do not fit.
CUT_LINES = """() => [...document.querySelectorAll('pre')]
  .filter(one => one.scrollWidth > one.clientWidth + 1)
  .map(one => one.textContent.split('\\n').reduce((a, b) => b.length > a.length ? b : a))"""

#: Formulas that are not laid out: without a size, or with a fraction that is one line of text.
FLAT = """() => [...document.querySelectorAll('math, mfrac')]
  .filter(one => {
    const box = one.getBoundingClientRect();
    const [above, below] = [...one.children].map(part => part.getBoundingClientRect());
    return !box.width || !box.height ||
           (one.matches('mfrac') && above.bottom > below.top + 1);
  })
  .map(one => one.textContent)"""

FONT_OF_FORMULAS = """async () => {
  await document.fonts.ready;
  return [...document.fonts].filter(one => /Math/.test(one.family)).map(one => one.status);
}"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built as `make docs` builds it."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "--quiet", "-b", "html"]
    subprocess.run([*command, str(DOCS), str(folder)], check=True)
    return folder


@pytest.fixture(scope="module")
def pages(site: Path) -> list[HtmlPage]:
    """Every page of it."""
    found = [HtmlPage(file) for file in sorted(site.rglob("*.html"))]
    assert len(found) > 40
    return found


@pytest.fixture
def reader(browser: Browser) -> Iterator[Page]:
    """A reader without a network; that nothing was asked of one is seen in the end."""
    context = browser.new_context(offline=True, reduced_motion="reduce")
    page = context.new_page()
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    yield page
    context.close()
    assert asked
    assert not [url for url in asked if not url.startswith(("file:", "data:"))]


def is_for_readers(page: HtmlPage) -> bool:
    """Whether it is text, not the source of a module or an index."""
    return "_modules" not in page.file.parts and page.file.name != "genindex.html"


def test_pages_load_nothing_from_elsewhere(pages: list[HtmlPage], site: Path) -> None:
    """Law: styles, scripts, fonts and pictures of every page are files of the site."""
    loaded = [(file, one) for file, one in addresses_loaded(pages, site) if one[:5] != "data:"]
    assert any(address.endswith(".ttf") for _, address in loaded)
    assert not [(file.name, address) for file, address in loaded if is_elsewhere(address)]
    missing = [
        (file.name, address)
        for file, address in loaded
        if not (file.parent / address.partition("?")[0].partition("#")[0]).is_file()
    ]
    assert not missing


def test_links_lead_somewhere(pages: list[HtmlPage]) -> None:
    """Law: every link within the site leads to a page, and to a place on it."""
    anchors = {page.file.resolve(): page.anchors for page in pages}
    within = [(page, one) for page in pages for one in page.links if not is_elsewhere(one)]
    broken = []
    for page, address in within:
        file, anchor = page.place(address)
        is_there = file.is_file() and (not anchor or anchor in anchors[file])
        if not is_there:
            broken.append((page.file.name, address))
    assert len(within) > 1000
    assert not broken


def test_pictures_are_enlarged_and_described(pages: list[HtmlPage]) -> None:
    """Law: each picture is a link to its file, and some words say what is seen.

    A small picture beside words leads to the place on its page where it is large; the words of
    that link are its description.
    """
    every = [(page.file.name, *one) for page in pages for one in page.pictures]
    small = [one for one in every if (one[2] or "").startswith("#") and not one[3]]
    pictures = [one for one in every if one not in small]
    assert len(pictures) > 10
    large = {(page, source) for page, source, _, _ in pictures}
    assert {(page, source) for page, source, _, _ in small} <= large
    assert not [(page, source) for page, source, link, _ in pictures if link != source]
    assert not [(page, source) for page, source, _, text in pictures if len(text.split()) < 4]


def test_pages_fit_and_formulas_are_drawn(reader: Page, pages: list[HtmlPage]) -> None:
    """Law: no page moves sideways on a phone, no line of code is cut on a screen."""
    faults: list[object] = []
    formulas = 0
    for page in filter(is_for_readers, pages):
        reader.set_viewport_size({"width": 390, "height": 800})
        reader.goto(page.file.as_uri())
        found = {"beyond": reader.evaluate(BEYOND, FRAMES), "flat": reader.evaluate(FLAT)}
        if count := reader.locator("math").count():
            found["font is missing"] = reader.evaluate(FONT_OF_FORMULAS) != ["loaded"]
            formulas += count
        reader.set_viewport_size({"width": 1280, "height": 800})
        found |= {"cut": reader.evaluate(CUT_LINES), "beyond too": reader.evaluate(BEYOND, FRAMES)}
        faults += [(page.file.name, key, value) for key, value in found.items() if value]
    assert formulas > 100
    assert not faults


def test_figures_are_dark_in_the_dark(reader: Page, pages: list[HtmlPage]) -> None:
    """Law: most of a figure is light on a light page, and dark on a dark one."""
    schemes: list[tuple[Literal["light", "dark"], bool]] = [("light", True), ("dark", False)]
    with_pictures = [page for page in pages if page.pictures]
    assert with_pictures
    for page in with_pictures:
        reader.goto(page.file.as_uri())
        for scheme, is_light in schemes:
            reader.emulate_media(color_scheme=scheme)
            picture = imread(io.BytesIO(reader.locator("article img").first.screenshot()))
            assert (np.median(picture[..., :3]) > 0.5) == is_light, (page.file.name, scheme)
