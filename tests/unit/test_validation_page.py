"""The page about validation is what the tests and the measured results say."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

from benchmarks import store, validation

PAGE = validation.TARGET.read_text("utf-8")


def test_the_page_is_what_its_sources_make() -> None:
    """`python -m benchmarks.validation` writes it anew, where a test or a result has changed."""
    assert validation.text() == PAGE


def test_a_changed_result_changes_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers come from the files: another coverage is another page."""
    folder = tmp_path / "results"
    shutil.copytree(store.FOLDER, folder)
    file = folder / "errors" / "rotation-numbers.json"
    row = json.loads(file.read_text("utf-8"))
    row["total"]["coverage"] = 0.5
    file.write_text(json.dumps(row), encoding="utf-8")
    monkeypatch.setattr(store, "FOLDER", folder)
    assert "at 50.00 %; below 99.5 %: rotation numbers." in validation.text()


def test_the_page_says_what_the_tests_see(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Shares of lines from their file; a score of mutants where there is one."""
    lines = json.loads((store.FOLDER / "tests" / "lines.json").read_text("utf-8"))
    share = lines["packages"]["numeric core"]["share"]
    assert re.search(rf"^\| \*\*numeric core\*\* \| .* \| {100.0 * share:.2f} % \|$", PAGE, re.M)
    score = {"mutants": 300, "equivalent": 10, "score": 0.8125, "interval": [0.76, 0.85]}
    mutants = {"at first": score, "packages": {"in all": {**score, "score": 0.9375}}}
    (tmp_path / "tests").mkdir()
    for name, saved in (("lines", lines), ("mutants", mutants)):
        (tmp_path / "tests" / f"{name}.json").write_text(json.dumps(saved), encoding="utf-8")
    monkeypatch.setattr(store, "FOLDER", tmp_path)
    said = "".join(validation._of_tests())
    assert "Of 300 random changes" in said
    assert "noticed 81.25 % when these were drawn (76.00 % to 85.00 %" in said
    assert "and 93.75 % with the tests" in said


def test_every_law_and_every_kind_of_error_is_there() -> None:
    """A law each with the tests that hold it; the kinds of errors add up."""
    for law in validation.laws():
        row = re.search(rf"^\| \[{law.name}\].*\| (\d+) \| (\d+) \|$", PAGE, re.M)
        assert row
        assert int(row[1]) >= int(row[2]) == len(law.files) > 0
    assert len(validation.laws()) > 15
    counts = re.findall(r"^\| \{py:obj\}`~remanent\.\w+` \| (\d+) \| (\d+) \|", PAGE, re.M)
    files = [json.loads(p.read_text("utf-8")) for p in (store.FOLDER / "errors").glob("*.json")]
    bounds = [row for row in files if row["promise"] == "bound"]
    assert sum(int(kinds) for kinds, _ in counts) == len(bounds)
    assert sum(int(cases) for _, cases in counts) == sum(r["total"]["cases"] for r in bounds)


def test_engines_are_used_by_tests() -> None:
    """Each program that the page names has a version and test files."""
    for engine in validation.ENGINES:
        assert re.fullmatch(r"[\d.]+", engine.version(validation.pinned_versions()))
        assert validation.files_with(engine.sign)
