"""Which names the states and numbers of one's own system may have."""

from __future__ import annotations

import keyword
from collections.abc import Iterable
from typing import Final

from remanent._errors import InputError, shortened_repr
from remanent.models import formula

#: What follows the name of a coordinate in that of its rate.
RATE_SUFFIX: Final = "_rate"
#: Names that drives, results and verbs give to something of their own, as text.
_RESERVED_TEXT: Final = """
    amplitude attractor attractor_period attractor_regime attractor_state average b balance band
    basin bound branch branch_point case chi_square confidence correlation covariance crossing
    crossing_time crossings cycle decrement defect degrees derivative detuning deviation digits
    direction
    dissipated_energy drive drive_period drive_phase drive_work duration eigenvalue eigenvalues
    elasticity end end_bound end_reason energy energy_drift entropy entropy_balance
    entropy_given_off entropy_produced equilibrium equilibrium_potential equilibrium_stretch error
    estimate exponent exponent_history exponent_number farthest field field_unit final first_index
    fold fraction free_frequency frequency guess harmonic harmonics heat_given_off horizon initial
    interval known_share law level load loads local_error m margin maximum maximum_time mean
    mean_thickness_stretch measure measure_unit minimum minimum_time misfit mode multiples
    multiplier multipliers natural_frequency noise observable observation observation_unit
    observed omega orbit orbit_period orbits order_p order_q other_parameter over overshoot
    parameter parameter_unit peak period phase phase_lag phases point potential predicted
    profile_interval published quantile quantity reached reason regime residual residual_amplitude
    residual_energy resonance resonance_amplitude resonance_kind resonance_status rise_time
    rotation_digits rotation_number run_periods sali section section_phase settled_period
    settling_time share smallest snap snap_direction solution solver special special_kind
    stability start state state_unit status step step_load step_time stop stored_energy sweep
    switch_time symmetry target tau time times tolerance total_index transverse_exponent
    transverse_growth transverse_multipliers transverse_stiffness turning_lower turning_upper
    unbounded value window zero_one
"""
#: These names.
RESERVED_NAMES: Final = frozenset(_RESERVED_TEXT.split())
#: What results put before a name of the user's, or after it.
_RESERVED_PREFIXES: Final = ("special_", "fold_", "snap_", "branch_point_", "initial_")
_RESERVED_SUFFIXES: Final = ("_error",)


def require_names(argument: str, names: Iterable[object], *, taken: Iterable[str] = ()) -> None:
    """Raise unless each is a name that is free, and no name comes twice.

    Parameters
    ----------
    argument : str
        The argument that holds them.
    names : iterable of object
        What was passed.
    taken : iterable of str
        Names that the system has already.
    """
    seen = set(taken)
    for name in names:
        problem = _problem_with(name, seen)
        if problem is not None:
            must, why, fix = problem
            raise InputError(argument, must=must, got=shortened_repr(name), why=why, fix=fix)
        seen.add(str(name))


def _problem_with(name: object, taken: set[str]) -> tuple[str, str, str] | None:
    """The rule that a name breaks, its reason and the remedy; None where it breaks none."""
    plain = isinstance(name, str) and name.isascii() and name.isidentifier()
    if not plain or str(name).startswith("_") or len(str(name)) > 40:
        return (
            "hold names of letters, digits and _ that begin with a letter",
            "Formulas, `over` and results use them.",
            "Pass for example 'x' or 'theta_1'.",
        )
    word = str(name)
    if word in formula.FUNCTION_NAMES or word == formula.PI_NAME:
        return (
            "have names of their own",
            "It is a function or a number in formulas.",
            "Rename it.",
        )
    if keyword.iskeyword(word):
        return (
            "hold no keywords of Python",
            "Formulas are read in Python's notation.",
            f"Rename it, for example to {word}_1.",
        )
    if word in taken:
        return (
            "have names of their own",
            f"The name of a coordinate with {RATE_SUFFIX} after it is that of its rate, and every "
            "name means one thing.",
            "Rename one of them.",
        )
    if (
        word in RESERVED_NAMES
        or word.startswith(_RESERVED_PREFIXES)
        or word.endswith(_RESERVED_SUFFIXES)
    ):
        return (
            "have names that drives, results and verbs do not use",
            f"These are {', '.join(sorted(RESERVED_NAMES))}, and names that begin with "
            f"{', '.join(_RESERVED_PREFIXES)} or end with {', '.join(_RESERVED_SUFFIXES)}.",
            f"Rename it, for example to {word}_1.",
        )
    return None
