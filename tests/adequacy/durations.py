"""A plugin of pytest that notes how long each test takes: ``-p tests.adequacy.durations``."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path

import pytest

from tests.adequacy.core import ROOT

#: Where what is measured about the tests is kept.
MEASURED = ROOT / ".adequacy"
DURATIONS = MEASURED / "durations.json"


def pytest_configure(config: pytest.Config) -> None:
    """Only the process that collects the reports of all others notes anything."""
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(_Durations(DURATIONS))


class _Durations:
    def __init__(self, file: Path) -> None:
        self._file = file
        self._seconds: dict[str, float] = defaultdict(float)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Set-up, call and end of a test come one after the other."""
        self._seconds[report.nodeid] += report.duration

    def pytest_sessionfinish(self) -> None:
        """Write all of them at the end."""
        self._file.parent.mkdir(exist_ok=True)
        self._file.write_text(json.dumps(self._seconds, indent=0), encoding="utf-8")
