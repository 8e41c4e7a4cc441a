"""From equal stretches to two of them: the same systems with both coordinates."""

from __future__ import annotations

from dataclasses import replace

from remanent.studies.ensemble.ensemble import Ensemble, ensemble


def two_coordinates(ens: Ensemble) -> tuple[Ensemble, dict[str, str]]:
    """An ensemble of one coordinate with two, and the second variable of each pair.

    The initial states stay those of one coordinate.
    """
    load = ens.system.prestress
    both = ensemble(ens.system.replace(prestress=(load, load)), ens.drive)
    names = both.field.state
    values = {name: v for name, v in ens.values.items() if name != "prestress"}
    values |= {f"prestress_{i}": ens.values["prestress"] for i in (1, 2)}
    pairs = {n: n.replace("_1", "_2") for n in names if n.replace("_1", "_2") in names}
    pairs = {one: two for one, two in pairs.items() if one != two}
    return replace(ens, system=both.system, field=both.field, values=values), pairs
