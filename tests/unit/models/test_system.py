"""What makes a system: its parameters, its derivation, and the loads of its drive."""

from __future__ import annotations

import pytest

import remanent as rm
from remanent.codegen.field import vector_field_for
from remanent.derivation.derive import derive
from remanent.models.system import System

DRIVE = rm.Constant(0.0)


def test_an_actuator_is_a_system() -> None:
    """It has all that verbs ask for; a drive, a material and a number do not."""
    assert isinstance(rm.Actuator(), System)
    assert not any(isinstance(x, System) for x in (DRIVE, rm.Steps([0.0], [0.1]), rm.Gent(9.0), 1))


def test_a_system_without_a_derivation_is_refused() -> None:
    """The message says which kind has none."""
    with pytest.raises(rm.InputError, match="How equations follow from object is not known"):
        derive(object(), DRIVE)


class TwoLoads(rm.Constant):
    """A drive that gives loads which an actuator does not have."""

    @property
    def load_names(self) -> tuple[str, ...]:
        """Two names."""
        return ("left", "right")


def test_a_drive_gives_the_loads_of_its_system() -> None:
    """Their names are compared, before anything is derived."""
    with pytest.raises(rm.InputError, match=r"give the loads of the system: load; got left, right"):
        vector_field_for(rm.Actuator(), TwoLoads(0.1))
