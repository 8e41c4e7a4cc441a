"""Work is broken off at once, but within no import."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from remanent.web.worker import is_importing


def test_imports_are_seen_from_within(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: code that an import runs knows it, however deep; code around it does not."""
    (tmp_path / "asks_at_import.py").write_text(
        "import sys\n"
        "from remanent.web.worker import is_importing\n"
        "def ask():\n"
        "    return is_importing(sys._getframe())\n"
        "answer = ask()\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    asks = __import__("asks_at_import")
    assert asks.answer
    assert not asks.ask()
    assert not is_importing(sys._getframe())
    assert not is_importing(None)
