"""The page as one file: it asks nobody for anything, and no text in it can become a script."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from html.parser import HTMLParser
from typing import Any

import pytest

import remanent as rm
from remanent.page import assemble
from remanent.page.assemble import data_text, saved_page
from remanent.page.model import page_model, page_model_of_spec
from remanent.page.presets import presets

HOSTILE = '</script><script>alert(1)</script><!-- <script> \u2028 &amp; "'


class Parts(HTMLParser):
    """Scripts, styles and addresses of a page, as a browser takes it apart."""

    def __init__(self) -> None:
        super().__init__()
        self.scripts: list[tuple[dict[str, str | None], str]] = []
        self.styles: list[str] = []
        self.addresses: list[str] = []
        self.policy = ""
        self._open: tuple[str, dict[str, str | None]] | None = None
        self._text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.addresses += [str(given[name]) for name in ("src", "href") if name in given]
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = str(given["content"])
        if tag in ("script", "style"):
            self._open, self._text = (tag, given), []

    def handle_data(self, data: str) -> None:
        self._text.append(data)

    def handle_endtag(self, tag: str) -> None:
        if self._open is not None and self._open[0] == tag:
            text = "".join(self._text)
            if tag == "script":
                self.scripts.append((self._open[1], text))
            else:
                self.styles.append(text)
            self._open = None


@pytest.fixture(scope="module")
def page() -> Parts:
    system = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential="x**2/2 - load*x",
        units={"x": "mm </script>"}, symbols={"x": "<img src=x>"},
    )  # fmt: skip
    model = page_model(system, rm.Constant(0.1))
    parts = Parts()
    parts.feed(saved_page(model, {"classify": {"kind": "classify", "regime": HOSTILE}}))
    return parts


def digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def test_the_policy_allows_its_own_scripts_only(page: Parts) -> None:
    """Law: nothing by default; scripts and styles by the digests of what is there."""
    rules = dict(rule.split(" ", 1) for rule in page.policy.split("; "))
    assert rules["default-src"] == "'none'"
    runs = [text for given, text in page.scripts if given.get("type") != "application/json"]
    assert rules["script-src"].split() == [digest(text) for text in runs]
    assert len(runs) == 2
    assert {digest(text) for text in page.styles} <= set(rules["style-src"].split())
    assert "unsafe-inline" not in page.policy


def test_nothing_is_asked_for(page: Parts) -> None:
    """Law: every address is within the page, or is its own data."""
    assert all(one.startswith(("#", "data:")) for one in page.addresses), page.addresses


def test_text_of_a_system_stays_text(page: Parts) -> None:
    """Law: units, symbols and results of any text end no script, and come back as they were."""
    (start,) = [text for given, text in page.scripts if given.get("type") == "application/json"]
    assert not set("<>&") & set(start)
    data: dict[str, Any] = json.loads(start)
    assert data["results"]["classify"]["regime"] == HOSTILE
    assert data["model"]["state"][0]["unit"] == "mm </script>"
    assert data["field"] == f"/fields/{data['model']['id']}.js"
    assert set(data["exports"]) == {"python", "matlab", "julia", "c", "javascript"}
    assert "rm.LagrangianSystem" in data["reproduction"]["python"]


def test_equal_models_make_equal_pages() -> None:
    """Law: no clock, no chance."""
    model = page_model(rm.Actuator(), rm.SineSquared(0.4, 1.25))
    assert saved_page(model) == saved_page(model)


def test_numbers_that_are_none_are_refused() -> None:
    """Law: JSON has no NaN; results say null."""
    with pytest.raises(ValueError, match="JSON"):
        data_text({"x": float("nan")})


def test_without_plotly_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: the remedy is in the message."""
    monkeypatch.setattr("remanent.page.files.find_spec", lambda _: None)
    model = page_model(rm.Actuator(), rm.Constant(0.1))
    with pytest.raises(rm.RemanentError, match=re.escape("pip install 'remanent[web]'")):
        saved_page(model)


def test_a_script_that_would_end_early_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: the page is not written where its own code would be cut."""
    monkeypatch.setattr(assemble, "joined_modules", lambda *_: 'const x = "</script>";')
    model = page_model(rm.Actuator(), rm.Constant(0.1))
    with pytest.raises(rm.RemanentError, match="end of a script"):
        saved_page(model)


def test_presets_come_with_their_equations() -> None:
    """Law: what can be chosen in the file is in it, with what makes it again; results are not."""
    model = page_model(rm.Actuator(), rm.SineSquared(0.4, 1.25))
    chosen = [one for one in presets() if one["id"] in ("two-wells", "figure-2a")]
    page = Parts()
    page.feed(saved_page(model, presets=chosen, languages=()))
    (data, (_, script)) = (page.scripts[0][1], page.scripts[-1])
    start = json.loads(data)
    assert [one["id"] for one in start["presets"]] == [one["id"] for one in chosen]
    for one, preset in zip(start["presets"], chosen, strict=True):
        other = page_model_of_spec(preset["spec"])
        assert one["model"] == json.loads(json.dumps(other.description))
        assert one["spec"] == one["model"]["spec"]
        assert one["field"] == f"/fields/{other.id}.js"
        assert one["field"] in script
        assert "simulate" in one["reproduction"]["python"]
    assert start["results"] == {}
