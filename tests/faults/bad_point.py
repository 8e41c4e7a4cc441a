"""Preloaded by workers, and by processes that say so: one point of the grid is their undoing.

``REMANENT_TEST_BAD_POINT`` says how: ``crash`` kills the process, ``hang`` never comes back;
``REMANENT_TEST_BAD_OMEGA`` says at which point.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from remanent.studies.sweep.study import Study

#: The variables of the environment that say how, and at which omega; b is the first one.
VARIABLE, OMEGA = "REMANENT_TEST_BAD_POINT", "REMANENT_TEST_BAD_OMEGA"
B = 0.2

_result_over = Study.result_over


def _result_or_trouble(self: Study, over: Mapping[str, Any], progress: Any = None) -> xr.Dataset:
    bad = {"b": B, "omega": float(os.environ[OMEGA])}
    near = [np.isclose(over[name], value).any() for name, value in bad.items()]
    if all(near):
        _trouble(os.environ[VARIABLE])
    return _result_over(self, over, progress)


def _trouble(kind: str) -> None:
    while kind == "hang":
        time.sleep(1.0)
    os.kill(os.getpid(), signal.SIGKILL)


if VARIABLE in os.environ:  # not where tests are only collected
    Study.result_over = _result_or_trouble  # type: ignore[method-assign]
