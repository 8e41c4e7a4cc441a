"""What the README and the pages of the site show is true: every name is there, every block runs."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import remanent

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
CODE = {str(page.relative_to(ROOT)): BLOCK.findall(page.read_text("utf-8")) for page in PAGES}


@pytest.mark.parametrize("page", [page for page, blocks in CODE.items() if blocks])
def test_code_runs(page: str, tmp_path: Path) -> None:
    """The Python blocks of a page run in order, in a fresh interpreter, without a warning."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", "\n".join(CODE[page])],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_reference_lists_every_public_name() -> None:
    """The reference has each name of ``__all__`` once, and no other."""
    text = (ROOT / "docs" / "reference.md").read_text("utf-8")
    listed = re.findall(r"^\.\. auto(?:class|function|exception):: remanent\.(\w+)$", text, re.M)
    assert sorted(listed) == sorted(set(remanent.__all__) - {"plot", "__version__"})
    assert ".. automodule:: remanent.plots" in text


def test_makefile_commands_of_the_readme_exist() -> None:
    """Every ``make`` target that the README names is in the Makefile."""
    readme = (ROOT / "README.md").read_text("utf-8")
    named = set(re.findall(r"(?:^|`)make ([a-z-]+)", readme, re.M))
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text("utf-8"), re.M))
    assert named
    assert named <= targets
