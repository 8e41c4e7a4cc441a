"""The code behind the figure on the limits of the model."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import remanent as rm

FILE = Path(__file__).parents[2] / "docs" / "breathing.py"
SPEC = importlib.util.spec_from_file_location("breathing", FILE)
assert SPEC is not None
assert SPEC.loader is not None
MODULE = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(MODULE)


@pytest.mark.parametrize("slenderness", [0.1, 0.5, 1.0])
def test_homogeneous_deformation_is_the_model(slenderness: float) -> None:
    """Degree 1 has one motion, whose frequency is that of the package: ω² = 18/(1 + 2c)."""
    (frequency,) = MODULE.breathing_frequencies(slenderness, 1)
    model = rm.equilibria(rm.Actuator(c=slenderness**2), 0.0).natural_frequency[0]
    assert frequency == pytest.approx(float(model), rel=1e-12)


def test_a_cube_has_lames_motion() -> None:
    """Its exact frequency is π/√2, from above, in units of the shear wave over half an edge."""
    coarse, fine = (MODULE.breathing_frequencies(1.0, degree)[0] for degree in (5, 7))
    assert np.pi / np.sqrt(2.0) < fine < coarse
    assert fine == pytest.approx(np.pi / np.sqrt(2.0), rel=1e-6)
