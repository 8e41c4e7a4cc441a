"""From a system and its drive to a first-order system: the one place that knows every kind.

A new kind of system is a class in ``models``, its derivation a function here, registered for
that class; nothing else below the verbs asks what kind a system is.
"""

from __future__ import annotations

from functools import singledispatch

from remanent._errors import InputError, shortened_repr
from remanent.derivation import block, lagrange, written_equations
from remanent.derivation.motion import FirstOrderForm
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.own_systems.first_order_system import FirstOrderSystem
from remanent.models.own_systems.lagrangian_system import LagrangianSystem


@singledispatch
def derive(system: object, drive: Drive) -> FirstOrderForm:  # noqa: ARG001
    """The first-order system of a system under a drive.

    Only the structure of both is used, never a numeric value.

    Parameters
    ----------
    system : remanent.models.system.System
        Of a kind that is registered here.
    drive : Drive
        What gives its loads.

    Raises
    ------
    InputError
        Where no derivation is registered for this kind of system.
    """
    raise InputError(
        "system",
        must="be of a kind whose equations of motion can be derived",
        got=shortened_repr(system),
        why=f"How equations follow from {type(system).__name__} is not known.",
        fix="Pass for example rm.Actuator().",
    )


@derive.register
def _(system: Actuator, drive: Drive) -> FirstOrderForm:
    return lagrange.build_first_order_form(block.build_motion(system, drive))


@derive.register
def _(system: LagrangianSystem, drive: Drive) -> FirstOrderForm:
    return written_equations.first_order_form_of_energies(system, drive)


@derive.register
def _(system: FirstOrderSystem, drive: Drive) -> FirstOrderForm:
    return written_equations.first_order_form_of_rates(system, drive)
