"""A number that a verb gives, as a function of numeric fields."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.waves import Constant
from remanent.studies.ensemble.ensemble import ensemble
from remanent.studies.ensemble.physical_scales import PHYSICAL

#: The dimension along which values of the fields are laid out.
SAMPLE = "sample"
#: A variable of a result, or what to make of the whole of it.
Of = str | Callable[[xr.Dataset], Any]


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Measure:
    """A quantity that a verb computes: what is asked to be derived, placed or bounded.

    Parameters
    ----------
    verb
        Any verb of this package, or a function of an actuator (and more) that returns a
        Dataset, an array or a number.
    *arguments, **options
        Of the verb.  The first actuator and the first drive among them have the fields.
    of
        The name of a variable of the verb's result, or a function of that Dataset, which must
        keep its dimension ``sample``.

    Examples
    --------
    >>> import remanent as rm
    >>> switch = Measure(rm.shape_commands, rm.Actuator(), 1.5, of="switch_time")
    >>> values, errors = switch.at({"temperature": [293.0, 300.0]})
    >>> values.values.round(4).tolist()
    [1.4239, 1.4072]
    """

    verb: Callable[..., Any]
    arguments: tuple[Any, ...]
    of: Of | None
    options: Mapping[str, Any]

    def __init__(
        self, verb: Callable[..., Any], *arguments: Any, of: Of | None = None, **options: Any
    ) -> None:
        if not callable(verb):
            raise InputError(
                "measure", "be a verb", repr(verb)[:80],
                "It is called with changed fields.", "Pass for example rm.frequency_response.",
            )  # fmt: skip
        if "over" in options:
            raise InputError(
                "over", "be left out", repr(options["over"])[:80],
                "The fields that vary are chosen here.", "Ask for one grid point at a time.",
            )  # fmt: skip
        for name, value in {
            "verb": verb, "arguments": arguments, "of": of, "options": MappingProxyType(options),
        }.items():  # fmt: skip
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        of = f", of={self.of!r}" if isinstance(self.of, str) else ""
        return f"Measure({getattr(self.verb, '__name__', 'function')}{of})"

    @property
    def actuator(self) -> Actuator:
        """The first actuator among the arguments."""
        found = next((a for a in self._given() if isinstance(a, Actuator)), None)
        if found is None:
            raise InputError(
                "measure", "have an actuator among its arguments", repr(self),
                "Its fields are what varies.", "Pass it after the verb.",
            )  # fmt: skip
        return found

    @property
    def drive(self) -> Drive | None:
        """The first drive among the arguments, if there is one."""
        return next((a for a in self._given() if isinstance(a, Drive)), None)

    def own(self) -> dict[str, float]:
        """Values of all fields that may vary."""
        drive = self.drive
        ens = ensemble(self.actuator, drive or Constant(0.0), None, self.options.get("initial"))
        own = {name: float(v[0]) for name, v in ens.values.items() if drive or name != "m"}
        start = {
            f"initial.{n}": float(v) for n, v in zip(ens.field.state, ens.initial[0], strict=True)
        }
        return {**own, **start, **dict.fromkeys(PHYSICAL, 1.0)}

    def require(self, names: Sequence[str]) -> None:
        """Raise unless all names are fields."""
        known = self.own()
        for name in names:
            if name not in known:
                raise InputError(
                    "fields", "be numeric fields of the actuator or the drive", repr(name),
                    "Nothing else can vary.", f"Its fields are: {', '.join(known)}.",
                )  # fmt: skip

    def at(self, values: Mapping[str, Any]) -> tuple[xr.DataArray, xr.DataArray]:
        """The measure and its error at some values of fields, along ``sample``.

        Parameters
        ----------
        values : mapping of name to array (sample,)
            They go together, one with one.
        """
        rows = {name: np.asarray(v, dtype=np.float64) for name, v in values.items()}
        if "over" in inspect.signature(self.verb).parameters:
            over = {name: xr.DataArray(v, dims=SAMPLE) for name, v in rows.items()}
            result = self.verb(*self.arguments, **self.options, over=over)
        else:
            count = len(next(iter(rows.values())))
            each = [self._single({n: float(v[k]) for n, v in rows.items()}) for k in range(count)]
            result = xr.concat([_dataset(x) for x in each], dim=SAMPLE, join="outer")
        return self._chosen(result)

    def _chosen(self, result: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
        if callable(self.of):
            value = self.of(result)
        elif (self.of or "value") in result:
            value = result[self.of or "value"]
        else:
            raise InputError(
                "of", f"be one of {', '.join(map(str, result.data_vars))}", repr(self.of),
                "It is a variable of the verb's result.", "Pass its name.",
            )  # fmt: skip
        if not isinstance(value, xr.DataArray) or SAMPLE not in value.dims:
            raise InputError(
                "of", f"keep the dimension `{SAMPLE}`", repr(self.of),
                "The verb was asked for many values at once.", "Reduce other dimensions only.",
            )  # fmt: skip
        named = f"{self.of}_error" if isinstance(self.of, str) else ""
        error = result.get(named, result.get("error", xr.zeros_like(value)))
        error = error if set(error.dims) <= set(value.dims) else xr.zeros_like(value)
        value = value.transpose(SAMPLE, ...)
        return value, error.broadcast_like(value).transpose(*value.dims)

    def _given(self) -> list[Any]:
        return [*self.arguments, *self.options.values()]

    def _single(self, values: Mapping[str, float]) -> Any:
        """The verb for one set of values, put into its actuator and its drive."""
        actuator, drive = self.actuator, self.drive
        new_actuator, new_drive = actuator, drive
        for name, value in values.items():
            if name in actuator.parameters():
                new_actuator = new_actuator.with_parameter(name, value)
            elif new_drive is not None and name in new_drive.parameters():
                new_drive = new_drive.replace(**{name: value})
            else:
                raise InputError(
                    "fields", "be fields of the actuator or the drive for this verb", repr(name),
                    "It takes no `over`.", "Leave it out.",
                )  # fmt: skip

        def swapped(x: Any) -> Any:
            return new_actuator if x is actuator else new_drive if x is drive else x

        options = {name: swapped(x) for name, x in self.options.items()}
        return self.verb(*map(swapped, self.arguments), **options)


def listed(fields: str | Iterable[str]) -> list[str]:
    """Names of fields, of which a single one may stand by itself."""
    return [fields] if isinstance(fields, str) else list(fields)


def chosen(
    fields: str | Sequence[str] | Mapping[str, float], own: Mapping[str, float]
) -> dict[str, float]:
    """Fields by name, with the values given, or else with those they have."""
    given = fields if isinstance(fields, Mapping) else own
    return {name: float(given[name]) for name in listed(fields)}


def as_measure(
    measure: Measure | Callable[..., Any], arguments: tuple[Any, ...], of: Of | None, **options: Any
) -> Measure:
    """A measure as it is, or made of a verb and its arguments."""
    if isinstance(measure, Measure):
        if arguments or of is not None or options:
            raise InputError(
                "measure", "come alone", repr(measure),
                "It holds its arguments already.", "Pass them to rm.Measure.",
            )  # fmt: skip
        return measure
    return Measure(measure, *arguments, of=of, **options)


def together(
    measures: Sequence[Measure], names: Sequence[str], rows: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values and errors (candidate, number) of measures at candidates (candidate, field)."""
    values = dict(zip(names, rows.T, strict=True))
    found = [measure.at(values) for measure in measures]
    flat = [[np.reshape(part.values, (len(rows), -1)) for part in pair] for pair in found]
    value, error = (np.concatenate(parts, axis=1) for parts in zip(*flat, strict=True))
    return value, error


def _dataset(result: Any) -> xr.Dataset:
    if isinstance(result, xr.Dataset):
        return result
    if isinstance(result, xr.DataArray):
        return result.to_dataset(name="value")
    return xr.Dataset({"value": ((), float(result))})
