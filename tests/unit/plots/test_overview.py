"""Every verb that takes `over` has a figure of its result on a grid."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from matplotlib import pyplot as plt

import remanent as rm
from remanent.studies.sweep.study import Study, verbs_of_studies
from tests.contracts.sound_calls import SOUND


@pytest.mark.parametrize(
    "verb",
    [
        pytest.param(verb, marks=[pytest.mark.slow] if verb == "locate_bifurcation" else [])
        for verb in verbs_of_studies()
    ],
)
@pytest.mark.filterwarnings("ignore::remanent.InputWarning")
def test_every_result_on_a_grid_is_drawn(verb: str) -> None:
    """One parameter and two; something is seen in the axes."""
    arguments = {k: v for k, v in SOUND[verb]().items() if k not in ("over", "progress")}
    system = arguments.pop(next(iter(arguments)))
    drive = arguments.pop("drive", None)
    temperatures = np.array([280.0, 350.0])
    grids = [{"c": np.array([0.8, 1.0]), "temperature": temperatures}]
    if verb != "regime_chart":
        grids.append({"temperature": temperatures})
    for over in grids:
        result = Study(verb, system, drive, over, arguments).result_over(over)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            rm.plot.overview(result)
        axes = plt.gcf().axes[0]
        assert axes.lines or axes.collections
        plt.close("all")
