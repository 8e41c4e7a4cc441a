"""Every error that a result carries is in a row of the study of errors, or said to need none."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

import pytest
import xarray as xr

import remanent as rm
from benchmarks.errors.row import all_rows
from remanent.studies.orbits.period_map import PeriodMapImages
from tests.contracts.sound_calls import SOUND, verbs

#: Verbs whose numbers are made by another one's functions, from the same kind of motion.
MADE_AS = {
    "response_diagram": "continue_orbit",
    "switch_branch": "continue_orbit",
    "regime_chart": "classify",
    "basins": "classify",
    "rescale": "simulate",
    "to_si": "simulate",
}
#: Errors without a row of their own, and why.
WITHOUT_ROW = {
    "backbone: error": "of a state that is not told; the amplitude's is made of it",
    "classify: local_error": "as bifurcation_diagram's, of states that are not told",
    "lyapunov: local_error": "as bifurcation_diagram's, of states that are not told",
    "symmetry_check: local_error": "as bifurcation_diagram's, of states that are not told",
    "crossings: error": "as simulate's, of the run; the states that are told have state_error",
    "cycle_losses: error": "as simulate's, of states that are not told",
    "energy_balance: error": "as simulate's, of states that are not told",
    "step_response: error": "as simulate's, of states that are not told",
}
#: A system of the user's own, whose equilibria carry other errors than an actuator's.
TWO_MASSES = rm.LagrangianSystem(
    coordinates=("x", "y"),
    kinetic="(x_rate**2 + y_rate**2)/2",
    potential="x**2 + y**2 + x*y/2 - load*x",
)
#: One with a single coordinate, of which dynamic thresholds are told.
ONE_MASS = rm.LagrangianSystem(
    coordinates="x", kinetic="x_rate**2/2", potential="x**2/2 - x**4/4 - load*x",
    observable="exp(x)",
)  # fmt: skip
#: Names that follow the measure or the parameter of a call, or are told of other points by the same
#: function, and the one whose row stands for all.
OF_A_MEASURE = {
    "uncertainty: turning_upper_error": "uncertainty: stretch_error",
    "snap_through: branch_point_m_error": "snap_through: branch_point_k_error",
    "snap_through: branch_point_observable_error": "snap_through: snap_observable_error",
    "snap_through: fold_observable_error": "snap_through: snap_observable_error",
}


def shown() -> frozenset[str]:
    return frozenset().union(*(row.errors for row in all_rows()))


def carried() -> Iterator[str]:
    """Errors of the results of sound calls, of the period map and of Sobol's indices."""
    for verb, call in verbs().items():
        result = call(**SOUND[verb]())
        if isinstance(result, xr.Dataset):
            for name in map(str, result.variables):
                if name == "error" or name.endswith("_error"):
                    yield f"{verb}: {name}"
    at_rest = rm.equilibria(TWO_MASSES, 0.1, state_box={"x": (-2.0, 2.0), "y": (-2.0, 2.0)})
    yield from (f"equilibria: {k}" for k in map(str, at_rest.variables) if k.endswith("_error"))
    for system, box in (
        (TWO_MASSES, {"x": (-2.0, 2.0), "y": (-2.0, 2.0)}),
        (ONE_MASS, {"x": (-2.0, 2.0)}),
    ):
        lost = rm.snap_through(system, "m", (-1.0, 1.0), state_box=box)
        names = (str(name) for name in lost.variables)
        yield from (f"snap_through: {k}" for k in names if k.endswith("_error"))
    yield from (
        f"period_map: {field.name}"
        for field in fields(PeriodMapImages)
        if field.name.endswith("_error")
    )
    yield from ("uncertainty: first_index_error", "uncertainty: total_index_error")
    yield "Measure: error"


@pytest.fixture(scope="module")
def errors() -> set[str]:
    return {OF_A_MEASURE.get(error, error) for error in carried()}


def has_row(error: str) -> bool:
    verb, name = error.split(": ")
    same = {error, f"{MADE_AS.get(verb, verb)}: {name}"}
    return bool(same & (shown() | WITHOUT_ROW.keys()))


def test_every_error_is_shown_or_said_to_need_no_row(errors: set[str]) -> None:
    """Rows of errors: what any verb's result carries is measured, or stands in the list."""
    assert sorted(error for error in errors if not has_row(error)) == []


def test_the_list_of_errors_without_a_row_holds_nothing_else(errors: set[str]) -> None:
    """Rows of errors: a listed one is carried, and has no row."""
    assert sorted(WITHOUT_ROW.keys() - errors) == []
    assert sorted(WITHOUT_ROW.keys() & shown()) == []


def test_rows_judge_errors_that_results_carry(errors: set[str]) -> None:
    """Rows of errors: a row names a variable that its verb's result has."""
    assert sorted(shown() - errors) == []
