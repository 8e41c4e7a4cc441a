"""Examples are run in this process, each in a folder of its own, without drawing pixels."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib.pyplot as plt
import pytest
from matplotlib.figure import Figure

from docs.make_gallery import run_example


@pytest.fixture
def example(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], Any]]:
    """Run an example by its name and return its variables, when it saved its one figure."""
    saved: list[str] = []
    monkeypatch.setattr(
        Figure, "savefig", lambda _figure, name, **_options: saved.append(os.fspath(name))
    )

    def run(name: str) -> Any:
        variables = run_example(name, tmp_path)
        assert saved == [f"{name}.png"]
        assert len(plt.get_fignums()) == 1
        return SimpleNamespace(**variables)

    yield run
    plt.close("all")
