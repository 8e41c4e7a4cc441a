"""States of rest of one body, and tables of equilibria and folds that have none."""

from __future__ import annotations

import numpy as np

import remanent as rm
from remanent.studies.ensemble.constant_drive import constant_drive
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.statics._rest_states import rest_states_of_cases
from remanent.studies.statics._static_ensemble import StaticEnsemble


def test_what_is_stable_lies_lowest() -> None:
    """Law (Lagrange-Dirichlet): rest is stable where the potential energy has a minimum.

    The second derivatives of the energy are taken by differences.
    """
    film = rm.Actuator(prestress=(2.2, 2.2))
    static = StaticEnsemble(lay_out_ensemble(film, constant_drive(film, 2.0), {}, None))
    (rests,) = rest_states_of_cases(static, np.array([0]))
    case, h = np.zeros(1, dtype=np.int64), 1e-4

    def energy(x: np.ndarray) -> float:
        return float(static.potential(case, x[:1], x[1:])[0])

    steps = h * np.eye(2)
    minima = []
    for x in rests.stretches:
        hessian = [
            [
                energy(x + a + b) - energy(x + a - b) - energy(x - a + b) + energy(x - a - b)
                for a in steps
            ]
            for b in steps
        ]
        minima.append(bool((np.linalg.eigvalsh(np.array(hessian) / (4.0 * h * h)) > 0.0).all()))
    assert rests.is_stable.tolist() == minima
    assert set(minima) == {True, False}


def test_bodies_that_do_not_exist_rest_nowhere() -> None:
    """Invariant: where no point is valid a table has no equilibrium and no snap."""
    film = rm.Actuator(prestress=(0.3, 0.2))
    assert rm.equilibria(film, 0.1, over={"c": [-1.0, 0.0]}).sizes["equilibrium"] == 0
    none = rm.snap_through(rm.Actuator(prestress=2.2), "m", (0.0, 8.0), over={"c": [-1.0, 0.0]})
    assert none.sizes["snap"] == 0
