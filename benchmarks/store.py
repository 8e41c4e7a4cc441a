"""Results as JSON, with what is needed to judge them and nothing that names a place."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from benchmarks.machine import environment

#: Where results are kept, a file a row.
FOLDER = Path(__file__).with_name("results")


def described(data: dict[str, Any], *, quick: bool, busy: float) -> dict[str, Any]:
    """Results with versions, hardware, and how busy the machine was before."""
    return {
        "quick": quick,
        "environment": environment(),
        "busy": round(busy, 2),
        "data": _plain(data),
    }


def save(row: str, result: dict[str, Any]) -> None:
    """Write the results of a row over those saved before."""
    path = FOLDER / f"{row}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(result, indent=1, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def load(row: str) -> dict[str, Any] | None:
    """What was saved last, or None."""
    path = FOLDER / f"{row}.json"
    return json.loads(path.read_text("utf-8")) if path.exists() else None


def _plain(value: Any) -> Any:
    """Five digits are more than a clock gives; JSON has no infinities."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float):
        return float(f"{value:.5g}") if math.isfinite(value) else None
    return value
