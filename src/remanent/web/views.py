"""Results of verbs as plain data that the page draws: one pure function for each job.

A quantity is ``{"name", "text", "symbol", "unit", "values"}``: numbers as lists (of lists), with
null where one is not known, and words as they are.  Every result has

* ``kind``, the job, and ``settings``, the options that it was made with;
* ``x`` and, of charts, ``y``: quantities along the axes;
* ``series``: what is drawn, a list of tables of quantities by name, each series with its ``name``
  and ``text``, the error of what it shows under ``error``, and ``status``, a word for each value;
* ``reason``: why something is missing, empty where nothing is;
* ``statuses``: a sentence for each word of status that occurs.

| kind | x | series |
|---|---|---|
| ``frequency_response`` | omega | ``rest``, and ``up`` and ``down`` where asked: ``amplitude``, ``maximum``, ``minimum``, ``error``; beside them ``resonance`` |
| ``response_diagram`` | (in each series) | a branch each: ``omega``, ``amplitude``, ``maximum``, ``minimum``, ``stability``, ``error``; beside them ``special``, ``ends`` |
| ``classify`` | | one: ``regime``, ``period`` and the evidence, each a quantity of one value |
| ``basins`` | a state variable | one: ``regime``, ``basin``, along (y, x); beside them ``attractors`` |
| ``regime_chart`` | a parameter | one: ``regime``, ``period``, ``margin``, along (y, x) |
| ``equilibria`` | thickness stretch | one: ``potential``; beside it ``equilibria`` |
| ``store`` | a dimension | see :func:`store_view` |
"""  # noqa: E501  # the rows of a table

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._status import Status

#: What is told of every regime.
_EVIDENCE: Final = (
    "margin", "exponent", "exponent_error", "rotation_number", "rotation_number_error",
    "rotation_digits", "digits", "zero_one", "sali", "defect", "drive_period", "horizon",
    "local_error",
)  # fmt: skip
#: A result as plain data.
View = dict[str, Any]


def plain(values: Any) -> Any:
    """Numbers and words as JSON has them: null for what is not finite, complex by parts."""
    array = np.asarray(values)
    if array.dtype.kind == "c":
        return {"real": plain(array.real), "imaginary": plain(array.imag)}
    if array.dtype.kind != "f":
        return array.tolist()
    if np.isfinite(array).all():
        return array.tolist()
    told = array.astype(object)
    told[~np.isfinite(array)] = None
    return told.tolist()


def quantity(variable: xr.DataArray, values: Any = None) -> View:
    """A variable of a result with its unit, symbol and text.

    Parameters
    ----------
    variable : DataArray
    values : array_like, optional
        What is told of it; all of it by default.
    """
    attributes = variable.attrs
    return {
        "name": str(variable.name),
        "text": str(attributes.get("long_name", variable.name)),
        "symbol": str(attributes.get("symbol", "")),
        "unit": str(attributes.get("units", "")),
        "values": plain(variable.values if values is None else values),
    }


def status_words(codes: NDArray[Any]) -> Any:
    """Codes of status as words."""
    words = np.array([status.meaning for status in Status])
    return words[np.asarray(codes, dtype=np.int64)].tolist()


def frequency_response_view(
    responses: Mapping[str, xr.Dataset], settings: Mapping[str, Any]
) -> View:
    """Amplitudes over the frequency, from rest and, where asked, along sweeps.

    Parameters
    ----------
    responses : mapping of str to Dataset
        What :func:`remanent.frequency_response` gives, by ``rest``, ``up`` and ``down``.
    settings : mapping
    """
    rest = responses["rest"]
    return {
        "kind": "frequency_response",
        "settings": dict(settings),
        "x": quantity(rest.omega),
        "series": [_response(name, one) for name, one in responses.items()],
        "resonance": {
            name: quantity(rest[name])
            for name in (
                "resonance", "resonance_error", "resonance_amplitude", "resonance_amplitude_error"
            )
        } | {"status": status_words(rest.resonance_status.values)},
        "reason": str(rest.reason.values) if "reason" in rest else "",
        "statuses": _sentences(one.status.values for one in responses.values()),
    }  # fmt: skip


def response_diagram_view(diagram: xr.Dataset, settings: Mapping[str, Any]) -> View:
    """Branches of periodic orbits over the frequency, each with what is stable of it."""
    return {
        "kind": "response_diagram",
        "settings": dict(settings),
        "x": {**quantity(diagram.omega), "values": []},
        "series": [_branch(diagram.isel(branch=k)) for k in range(diagram.sizes["branch"])],
        "special": _table(
            diagram,
            ("special_kind", "special_branch", "special_orbit_period", "special_omega",
             "special_error", "special_amplitude", "special_amplitude_error"),
        ),
        "ends": [
            {
                "branch": k,
                "reasons": plain(diagram.end_reason.values[k]),
                "bounds": plain(diagram.end_bound.values[k]),
            }
            for k in range(diagram.sizes["branch"])
        ],
        "status": status_words(diagram.status.values),
        "reason": _reason(diagram),
        "statuses": _sentences([diagram.status.values]),
    }  # fmt: skip


def classify_view(regime: xr.Dataset, settings: Mapping[str, Any]) -> View:
    """The regime of one motion with its evidence."""
    return {
        "kind": "classify",
        "settings": dict(settings),
        "series": [
            {
                "name": "regime",
                "text": str(regime.regime.values),
                **_table(regime, ("regime", "period", *_EVIDENCE)),
                "status": status_words(regime.status.values),
            }
        ],
        "reason": _reason(regime),
        "statuses": _sentences([regime.status.values]),
    }


def basins_view(basins: xr.Dataset, settings: Mapping[str, Any], axes: tuple[str, str]) -> View:
    """Where motions from a grid of states end.

    Parameters
    ----------
    basins : Dataset
    settings : mapping
    axes : (str, str)
        The variables along x and y.
    """
    chart = _chart(basins, axes, ("regime", "period", "basin", "margin"))
    attractors = _table(
        basins,
        ("attractor_regime", "attractor_period", "attractor_state", "attractor_state_error",
         "fraction", "fraction_error"),
    )  # fmt: skip
    return {
        "kind": "basins",
        "settings": dict(settings),
        **chart,
        "attractors": attractors | {"state": plain(basins.state.values)} if attractors else {},
    }


def regime_chart_view(
    chart: xr.Dataset, settings: Mapping[str, Any], axes: tuple[str, str]
) -> View:
    """Regimes over two parameters, of which `axes` names those along x and y."""
    names = ("regime", "period", "margin", "exponent", "exponent_error", "rotation_number",
             "rotation_number_error")  # fmt: skip
    return {"kind": "regime_chart", "settings": dict(settings), **_chart(chart, axes, names)}


def equilibria_view(rest: xr.Dataset, settings: Mapping[str, Any]) -> View:
    """Where nothing moves under a constant load, and the potential around it."""
    names = [
        str(name) for name, variable in rest.data_vars.items() if "equilibrium" in variable.dims
    ]
    landscape = "potential" in rest
    return {
        "kind": "equilibria",
        "settings": dict(settings),
        "x": quantity(rest.thickness_stretch) if landscape else None,
        "series": [
            {"name": "potential", "text": "potential", "potential": quantity(rest.potential)}
        ] if landscape else [],
        "equilibria": _table(rest, names),
        "level": quantity(rest.level) if "level" in rest else None,
        "status": status_words(rest.status.values),
        "reason": _reason(rest),
        "statuses": _sentences([rest.status.values]),
    }  # fmt: skip


def _response(name: str, response: xr.Dataset) -> View:
    texts = {"rest": "from rest", "up": "frequency rising", "down": "frequency falling"}
    return {
        "name": name,
        "text": texts[name],
        "omega": quantity(response.omega),
        **_table(response, ("amplitude", "maximum", "minimum")),
        "error": quantity(response.amplitude_error),
        "status": status_words(response.status.values),
    }


def _branch(branch: xr.Dataset) -> View:
    known = np.isfinite(branch.omega.values)
    shown = branch.isel(point=np.flatnonzero(known))
    number = int(branch.branch)
    names = ("omega", "amplitude", "maximum", "minimum", "stability")
    return {
        "name": f"branch {number}",
        "text": f"branch {number + 1}",
        **_table(shown, names),
        "error": quantity(shown.amplitude_error),
    }


def _chart(dataset: xr.Dataset, axes: tuple[str, str], names: Iterable[str]) -> View:
    x, y = axes
    turned = dataset.transpose(y, x, ...)
    return {
        "x": quantity(turned[x]),
        "y": quantity(turned[y]),
        "series": [
            {
                "name": "regime",
                "text": "regime",
                **_table(turned, names),
                "status": status_words(turned.status.values),
            }
        ],
        "reason": _reason(turned),
        "statuses": _sentences([turned.status.values]),
    }


def _table(dataset: xr.Dataset, names: Iterable[str]) -> View:
    """The variables of these names that there are."""
    return {name: quantity(dataset[name]) for name in names if name in dataset}


def _reason(dataset: xr.Dataset) -> str:
    """The reasons that are given, each once."""
    if "reason" not in dataset:
        return ""
    return "; ".join(dict.fromkeys(word for word in dataset.reason.values.ravel().tolist() if word))


def _sentences(codes: Iterable[Any]) -> dict[str, str]:
    """What the words of status that occur mean."""
    found = {int(code) for each in codes for code in np.ravel(each)}
    return {Status(code).meaning: Status(code).explanation for code in sorted(found)}
