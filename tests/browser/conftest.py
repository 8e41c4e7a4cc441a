"""The browser of the system, one at a time in each worker of the tests."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser

#: Names under which the browser is looked for.
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
#: It is to show pages, and to ask nobody for anything else.
ARGUMENTS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


def browser_path() -> str | None:
    """Where the browser of the system is; None where there is none."""
    return next((path for name in BROWSERS if (path := shutil.which(name))), None)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Chromium; without it tests are skipped, but in continuous integration.

    It is closed after each module of tests: while it runs, Playwright keeps a loop of asyncio in
    this thread, where other tests may want to start one of their own.
    """
    path = browser_path()
    if path is None:
        if os.environ.get("CI"):
            pytest.fail("No Chromium is installed, and these tests are to run.")
        pytest.skip("No Chromium is installed.")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        try:
            yield started
        finally:
            started.close()
