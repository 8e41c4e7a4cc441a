"""Seeds decide what is drawn."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm
from remanent._errors import InputError
from remanent.studies.ensemble import memory
from remanent.studies.ensemble.checks import as_seed, require_actuator


def test_seeds() -> None:
    """Nothing is one fixed seed, a number is itself, a generator is asked and left as it is."""
    assert as_seed(None) == as_seed(None) == as_seed(0)
    assert as_seed(5) == 5
    generator = np.random.default_rng(1)
    assert as_seed(generator) == as_seed(generator) == as_seed(np.random.default_rng(1))
    generator.integers(2)
    assert as_seed(generator) != as_seed(np.random.default_rng(1))


def test_a_drive_in_the_place_of_an_actuator_is_told_apart_from_nonsense() -> None:
    """The order of arguments for a drive, an example of an actuator for anything else."""
    with pytest.raises(InputError, match="Pass the system first, then the drive"):
        require_actuator("actuator", rm.Constant(0.2))
    with pytest.raises(InputError, match=r"Pass for example rm\.Actuator\(\)"):
        require_actuator("actuator", "block")


def test_a_request_too_large_names_both_sizes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of eight GiB is allowed, and six GiB are asked for."""
    monkeypatch.setattr(memory, "available_memory_bytes", lambda: 8 * 2**30)
    with pytest.raises(InputError, match=r"at most 4\.0 GiB; got 6 states, about 6\.0 GiB"):
        memory.require_memory("times", 6 * 2**30, "6 states")
