"""Seeds decide what is drawn."""

from __future__ import annotations

import numpy as np

from remanent.studies.ensemble.checks import as_seed


def test_seeds() -> None:
    """Nothing is one fixed seed, a number is itself, a generator is asked and left as it is."""
    assert as_seed(None) == as_seed(None) == as_seed(0)
    assert as_seed(5) == 5
    generator = np.random.default_rng(1)
    assert as_seed(generator) == as_seed(generator) == as_seed(np.random.default_rng(1))
    generator.integers(2)
    assert as_seed(generator) != as_seed(np.random.default_rng(1))
