"""The equations of a study, written by the command."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

import remanent as rm
from remanent.cli import main

STUDY = """
verb = "poincare_section"
[actuator]
temperature = 350.0
[drive]
kind = "SineSquared"
b = 0.4
omega = 1.25
[over]
omega = [1.0, 1.25]
[options]
periods = 3
"""


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A study in a file, in the current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(STUDY)
    return tmp_path


def run(*arguments: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["remanent", "export", *arguments])
    main()


def test_the_files_are_those_of_the_function(study: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: one file has the name given, several go to a folder, and a folder holds one too."""
    system, drive = rm.Actuator(temperature=350.0), rm.SineSquared(0.4, 1.25)
    run("mine.toml", "--to", "python", monkeypatch=monkeypatch)
    run("mine.toml", "--to", "python", "--out", "deep/mine.py", monkeypatch=monkeypatch)
    run("mine.toml", "--to", "c", "--out", ".", monkeypatch=monkeypatch)
    run("mine.toml", "--to", "matlab", "--out", "matlab", monkeypatch=monkeypatch)
    python = rm.export(system, drive, "python")["system.py"]
    assert (study / "system.py").read_text() == (study / "deep" / "mine.py").read_text() == python
    assert (study / "system.c").read_text() == rm.export(system, drive, "c")["system.c"]
    for name, text in rm.export(system, drive, "matlab").items():
        assert (study / "matlab" / name).read_text() == text
    assert runpy.run_path("system.py")["parameters"]["temperature"] == 350.0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--to", "python", "--out", "taken.py"), "nothing is written over"),
        (("--to", "matlab", "--out", "taken.py"), "several files"),
        (("--to", "fortran"), "`language` must be one of"),
        ((), "--to"),
    ],
)
def test_refusals(
    study: Path,
    arguments: tuple[str, ...],
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Law: files that are there stay as they are, and a message says what is wrong."""
    (study / "taken.py").write_text("mine")
    with pytest.raises(SystemExit) as ended:
        run("mine.toml", *arguments, monkeypatch=monkeypatch)
    assert ended.value.code != 0
    assert said.lower() in capsys.readouterr().err.lower()
    assert (study / "taken.py").read_text() == "mine"
    assert sorted(path.name for path in study.iterdir()) == ["mine.toml", "taken.py"]


def test_a_study_without_a_drive_is_refused(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Law: without a load there are no equations in time."""
    text = STUDY.replace("poincare_section", "equilibria").split("[drive]")[0]
    (study / "free.toml").write_text(text + "[over]\ntemperature = [300.0, 350.0]\n")
    with pytest.raises(SystemExit):
        run("free.toml", "--to", "python", monkeypatch=monkeypatch)
    assert "[drive]" in capsys.readouterr().err
    assert not (study / "system.py").exists()
