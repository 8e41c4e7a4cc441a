"""What the page may load: nothing from elsewhere, no script in the page, no style but a few."""

from __future__ import annotations

import base64
import hashlib
import re

from remanent.page.files import PLOTLY_STYLES, assets_folder, plotly_script
from remanent.web.policy import content_security_policy


def test_nothing_comes_from_elsewhere() -> None:
    """Law: no rule names another server, and none lets text of the page run."""
    for kind, sources in content_security_policy().items():
        words = set(sources.split())
        assert not words & {"*", "'unsafe-inline'", "'unsafe-eval'", "http:", "https:", "ws:"}
        assert not [word for word in words if "//" in word or "." in word], kind
    assert content_security_policy()["default-src"] == "'self'"


def test_only_the_styles_of_the_library_are_allowed() -> None:
    """Law: the digests are those of the listed texts, and what these say is in plotly.js."""
    words = content_security_policy()["style-src-attr"].split()
    digests = [
        base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
        for style in PLOTLY_STYLES
    ]
    assert words == ["'unsafe-hashes'", *(f"'sha256-{digest}'" for digest in digests)]
    library = plotly_script().read_text("utf-8")
    for value in re.findall(r"image-rendering: ([\w-]+);", "".join(PLOTLY_STYLES)):
        assert f'["image-rendering","{value}"]' in library
    for style in ("font-style:italic", "font-weight:bold", "font-size:70%"):
        assert f'"{style}"' in library


def test_the_page_has_no_script_and_no_style_of_its_own() -> None:
    """Law: the first file of the page refers to files of this server alone."""
    page = (assets_folder() / "index.html").read_text("utf-8")
    assert not re.findall(r"<style|\son\w+=|\sstyle=|javascript:", page)
    assert not re.findall(r"<script(?![^>]*\ssrc=\"/)", page)
    places = re.findall(r"(?:src|href)=\"([^\"]*)\"", page)
    assert places
    assert all(re.fullmatch(r"/[\w./-]+|#\w+", place) for place in places)
