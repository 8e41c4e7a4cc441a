"""Progress is told by a bar, by a function, or not at all."""

from __future__ import annotations

import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.integrate.ensemble.progress import report_part_of_whole
from remanent.studies.ensemble.progress import as_progress

BODY, DRIVE = rm.Actuator(), rm.SineSquared(0.4, 1.25)
DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.2))


def test_a_function_is_told_the_share_that_is_done() -> None:
    """Shares rise to 1."""
    shares: list[float] = []
    over = {"omega": np.linspace(1.0, 2.0, 50)}
    rm.simulate(BODY, DRIVE, duration=2.0, over=over, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_bar_is_drawn_on_standard_error(capsys: pytest.CaptureFixture[str]) -> None:
    """It ends its line, and says nothing on standard output."""
    rm.simulate(BODY, DRIVE, duration=2.0, progress=True)
    out, err = capsys.readouterr()
    assert out == ""
    assert "100%" in err
    assert err.endswith("\n")


def test_a_bar_needs_no_rich(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without it the bar is plain text."""
    monkeypatch.setitem(sys.modules, "rich.console", None)
    bar = as_progress(True)
    assert bar is not None
    for share in (0.0, 0.25, 0.25, 1.0):
        bar(share)
    half = "#" * 10 + "-" * 30
    assert f"[{half}]  25%\r" in capsys.readouterr().err


def test_silence() -> None:
    """None and False do nothing."""
    assert as_progress(None) is None
    assert as_progress(False) is None


def test_a_part_of_the_work_reports_its_share_of_the_whole() -> None:
    """The last part ends at 1 exactly, so that a bar ends."""
    shares: list[float] = []
    for part in (slice(0, 37), slice(37, 100)):
        report = report_part_of_whole(shares.append, part, 100)
        assert report is not None
        report(0.5)
        report(1.0)
    np.testing.assert_allclose(shares, [0.185, 0.37, 0.685, 1.0])
    assert shares[-1] == 1.0
    assert report_part_of_whole(None, slice(0, 1), 1) is None


def test_verbs_of_long_runs_tell_their_progress_up_to_the_end() -> None:
    """Shares grow and the last of them is 1, for every verb of long runs."""
    over = {"omega": [1.25, 1.3]}
    calls: dict[str, Any] = {
        "lyapunov": lambda f: rm.lyapunov(DAMPED, DRIVE, periods=100, over=over, progress=f),
        "classify": lambda f: rm.classify(DAMPED, DRIVE, periods=100, over=over, progress=f),
        "symmetry_check": lambda f: rm.symmetry_check(
            DAMPED, DRIVE, periods=50, over=over, progress=f
        ),
        "bifurcation_diagram": lambda f: rm.bifurcation_diagram(
            DAMPED, DRIVE, "b", [0.3, 0.4], discard=10, keep=1, progress=f
        ),
    }
    for name, call in calls.items():
        shares: list[float] = []
        call(shares.append)
        assert shares == sorted(shares), name
        assert shares[-1] == 1.0, name


class Cell:
    """What a cell of a notebook shows, by IPython's own functions."""

    def __init__(self) -> None:
        self.shown: list[dict[str, str]] = []

    def display(self, data: dict[str, str], *, raw: bool, display_id: bool) -> Cell:
        assert raw
        assert display_id
        self.shown.append(data)
        return self

    def update(self, data: dict[str, str], *, raw: bool) -> None:
        assert raw
        self.shown[-1] = data


@pytest.mark.parametrize("kernel", [object(), None])
def test_a_notebook_has_one_bar_below_the_cell(
    kernel: object, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One display is updated; a shell in a terminal, without a kernel, has the usual bar."""
    cell, shell = Cell(), SimpleNamespace(kernel=kernel)
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=cell.display))
    bar = as_progress(True)
    assert bar is not None
    for share in (0.0, 0.25, 1.0):
        bar(share)
    in_terminal = capsys.readouterr().err
    if kernel is None:
        assert "100%" in in_terminal
        assert cell.shown == []
    else:
        assert in_terminal == ""
        assert [one["text/html"] for one in cell.shown] == [
            '<progress value="1.00" max="1"></progress> 100%'
        ]
        assert cell.shown[0]["text/plain"].endswith("100%")
