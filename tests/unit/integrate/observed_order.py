"""The order that errors show, and how far it may be from the theory."""

from __future__ import annotations

from typing import Any

import numpy as np

#: The largest distance between an observed order and that of the theory.
WITHIN = 0.2


def order(levels: Any, errors: Any) -> float:
    """Slope of the straight line through the logarithms."""
    return float(-np.polyfit(np.log(levels), np.log(np.array(errors, dtype=float)), 1)[0])
