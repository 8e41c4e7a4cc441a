"""The page as one file: its results are those of the engine, or say why there are none."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

import remanent as rm
from remanent.page.model import page_model
from remanent.web import saving
from remanent.web.explorer import Opened
from remanent.web.jobs import job_result
from remanent.web.limits import JOB_LIMITS
from remanent.web.subjects import Subject, read_subject
from tests.unit.web.server import SPEC


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Charts of a few cells."""
    monkeypatch.setattr(saving, "_CELLS", 3)


def states_of(subject: Subject) -> list[dict[str, Any]]:
    states: list[dict[str, Any]] = page_model(subject.system, subject.drive).description["state"]
    return states


def embedded(page: str) -> dict[str, Any]:
    """The data that a page holds."""
    found = re.search(r'<script type="application/json" id="start">(.*?)</script>', page, re.S)
    assert found is not None
    data: dict[str, Any] = json.loads(found[1])
    return data


def test_a_saved_page_holds_what_the_engine_finds(tmp_path: Path) -> None:
    """Law: the file has the results of every job, each that of the job itself, and its stages are
    told on the way."""
    stages: list[tuple[str, float]] = []
    path = saving.save_page(
        Opened(SPEC), tmp_path / "page.html", lambda stage, share: stages.append((stage, share))
    )
    results = embedded(path.read_text("utf-8"))["results"]
    assert results.keys() == JOB_LIMITS.keys()
    subject = read_subject(SPEC)
    for name in ("classify", "frequency_response"):
        assert results[name]["series"]
        settings = results[name]["settings"]
        assert results[name] == json.loads(json.dumps(job_result(name, subject, settings)))
    shares = [share for _, share in stages]
    assert shares == sorted(shares)
    assert stages[-1] == ("written", 1.0)


def test_what_cannot_be_computed_says_why() -> None:
    """Law: under a load without a period what needs one has a reason in place of a result."""
    subject = read_subject({**SPEC, "drive": {"kind": "Constant", "m": 0.1}})
    results = saving.results_of(subject, states_of(subject), lambda *_: None)
    for name in ("frequency_response", "response_diagram", "classify", "basins"):
        assert results[name]["series"] == []
        assert results[name]["reason"]
    assert results["equilibria"]["series"]
    assert "regime_chart" not in results


def test_a_file_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    """Law: a folder that is not there is told by the name of the file, before any work."""
    with pytest.raises(rm.RemanentError, match=r"page\.html cannot be written"):
        saving.save_page(Opened(SPEC), tmp_path / "none" / "page.html", lambda *_: None)
