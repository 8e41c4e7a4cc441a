"""Equilibria and their folds over grids of parameters."""

from __future__ import annotations

from typing import Any

import numpy as np

import remanent as rm


def test_folds_are_found_for_each_of_the_other_fields() -> None:
    """Folds over one field are those of each set of the other fields alone."""
    loads = np.linspace(0.5, 6.0, 4)
    over: dict[str, Any] = {"m": loads, "prestress": [1.0, 1.9, 2.2], "temperature": [293.0]}
    ds = rm.equilibria(rm.Actuator(), over=over)
    assert ds.fold_m.dims == ("prestress", "temperature", "fold")
    single = rm.equilibria(rm.Actuator(prestress=2.2), over={"m": loads})
    np.testing.assert_array_equal(ds.fold_m.values[2, 0], single.fold_m.values)
    assert np.isnan(ds.fold_m.values[0]).all()
