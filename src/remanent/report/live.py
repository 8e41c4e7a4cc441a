"""The motions of figures 5 and 6 alive: a page beside the report that follows sliders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final
from urllib.parse import urlencode

from remanent._errors import RemanentError
from remanent.page.assemble import saved_page
from remanent.page.files import plotly_script
from remanent.page.model import page_model
from remanent.report.settings import (
    MOTION_FREQUENCIES,
    PRESTRESSES,
    REFERENCE_SETTING,
    TEMPERATURES,
)

#: The name of the page, beside the report.
LIVE_PAGE_NAME: Final = "explore.html"


def live_page() -> str | None:
    """The page of the published block under the periodic load; None without plotly.js."""
    try:
        plotly_script()
    except RemanentError:
        return None
    drive = REFERENCE_SETTING.build_drive(MOTION_FREQUENCIES[0])
    return saved_page(page_model(REFERENCE_SETTING.actuator, drive))


def live_links() -> Sequence[tuple[str, str]]:
    """A text and an address within the page for each motion of figures 5 and 6."""
    motions = [
        {"temperature": temperature, "prestress": prestress, "omega": omega}
        for prestress, omega in zip(PRESTRESSES, MOTION_FREQUENCIES, strict=True)
        for temperature in TEMPERATURES
    ]
    return [(_text(motion), f"{LIVE_PAGE_NAME}#{_address(motion)}") for motion in motions]


def _text(motion: Mapping[str, float]) -> str:
    return f"S = {motion['prestress']:g}, T = {motion['temperature']:g} K"


def _address(motion: Mapping[str, float]) -> str:
    """What stands after # in the address of the page: numbers by their names."""
    return urlencode({f"p.{name}": repr(value) for name, value in motion.items()})
