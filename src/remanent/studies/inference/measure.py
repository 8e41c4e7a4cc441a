"""A number that a verb gives, as a function of numeric fields."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.waves import Constant
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.physical_scales import PHYSICAL_SIZES

#: The dimension along which sets of parameters are laid out.
SAMPLE_DIMENSION = "sample"
#: A variable of a result, or what to make of the whole of it.
OfArgument = str | Callable[[xr.Dataset], Any]


@dataclass(frozen=True, init=False, eq=False, repr=False)
class Measure:
    """A quantity that a verb computes, as a function of numeric fields.

    It is what :func:`remanent.sensitivity` differentiates, :func:`remanent.design` places and
    :func:`remanent.uncertainty` bounds.

    Parameters
    ----------
    verb : callable
        Any verb of this package, or a function of an actuator (and more) that returns a
        Dataset, an array or a number.
    *arguments, **options
        Of the verb.  The first actuator and the first drive among them have the fields.
    of : str or callable, optional
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
    of: OfArgument | None
    options: Mapping[str, Any]

    def __init__(
        self,
        verb: Callable[..., Any],
        *arguments: Any,
        of: OfArgument | None = None,
        **options: Any,
    ) -> None:
        if not callable(verb):
            raise InputError(
                "measure",
                must="be a verb",
                got=repr(verb)[:80],
                why="It is called with changed fields.",
                fix="Pass for example rm.frequency_response.",
            )
        if "over" in options:
            raise InputError(
                "over",
                must="be left out",
                got=repr(options["over"])[:80],
                why="The fields that vary are chosen here.",
                fix="Ask for one grid point at a time.",
            )
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
        actuator = next((a for a in self._all_arguments() if isinstance(a, Actuator)), None)
        if actuator is None:
            raise InputError(
                "measure",
                must="have an actuator among its arguments",
                got=repr(self),
                why="Its fields are what varies.",
                fix="Pass it after the verb.",
            )
        return actuator

    @property
    def drive(self) -> Drive | None:
        """The first drive among the arguments, if there is one."""
        return next((a for a in self._all_arguments() if isinstance(a, Drive)), None)

    def nominal_values(self) -> dict[str, float]:
        """Values that the parameters have where they do not vary, by name."""
        drive = self.drive
        ens = lay_out_ensemble(
            self.actuator, drive or Constant(0.0), None, self.options.get("initial")
        )
        fields = {
            name: float(v[0]) for name, v in ens.parameter_values.items() if drive or name != "m"
        }
        if not self._verb_takes_over:
            return fields
        start = {
            f"initial.{n}": float(v)
            for n, v in zip(ens.vector_field.state_names, ens.initial_states[0], strict=True)
        }
        return {**fields, **start, **dict.fromkeys(PHYSICAL_SIZES, 1.0)}

    def require_parameters(self, argument: str, names: Sequence[str]) -> None:
        """Raise, about the verb's own argument, unless all names are parameters."""
        nominal = self.nominal_values()
        for name in names:
            if name not in nominal:
                raise _unknown_name_error(argument, name, nominal)

    def at(self, values: Mapping[str, Any]) -> tuple[xr.DataArray, xr.DataArray]:
        """The measure and its error at sets of parameters.

        Parameters
        ----------
        values : mapping of str to array (sample,)
            Of parameters, by name.  They go together, one with one.

        Returns
        -------
        value, error : xarray.DataArray
            Along ``sample`` first, then the measure's own dimensions.  The error is that
            which the verb states, 0 where it states none.
        """
        columns = {name: np.asarray(v, dtype=np.float64) for name, v in values.items()}
        if self._verb_takes_over:
            over = {name: xr.DataArray(v, dims=SAMPLE_DIMENSION) for name, v in columns.items()}
            return self._read_measure_and_error(
                self.verb(*self.arguments, **self.options, over=over)
            )
        count = len(next(iter(columns.values())))
        rows = [{name: float(v[k]) for name, v in columns.items()} for k in range(count)]
        results = [_as_dataset(self._call_verb(row)) for row in rows]
        return self._read_measure_and_error(xr.concat(results, dim=SAMPLE_DIMENSION, join="outer"))

    @property
    def _verb_takes_over(self) -> bool:
        """Whether the verb computes many sets of parameters in one call."""
        return "over" in inspect.signature(self.verb).parameters

    def _read_measure_and_error(self, result: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
        """The measure and its error in a result of the verb."""
        value = self.of(result) if callable(self.of) else self._measured_variable(result)
        if not isinstance(value, xr.DataArray) or SAMPLE_DIMENSION not in value.dims:
            raise InputError(
                "of",
                must=f"keep the dimension `{SAMPLE_DIMENSION}`",
                got=repr(self.of),
                why="The verb was asked for many values at once.",
                fix="Reduce other dimensions only.",
            )
        name = f"{self.of}_error" if isinstance(self.of, str) else ""
        error = result.get(name, result.get("error", xr.zeros_like(value)))
        error = error if set(error.dims) <= set(value.dims) else xr.zeros_like(value)
        value = value.transpose(SAMPLE_DIMENSION, ...)
        return value, error.broadcast_like(value).transpose(*value.dims)

    def _measured_variable(self, result: xr.Dataset) -> xr.DataArray:
        """The variable that `of` names; ``value`` where it names none."""
        name = self.of if isinstance(self.of, str) else "value"
        if name not in result:
            raise InputError(
                "of",
                must=f"be one of {', '.join(map(str, result.data_vars))}",
                got=repr(self.of),
                why="It is a variable of the verb's result.",
                fix="Pass its name.",
            )
        return result[name]

    def _all_arguments(self) -> list[Any]:
        return [*self.arguments, *self.options.values()]

    def _call_verb(self, values: Mapping[str, float]) -> Any:
        """The verb for one set of parameters, put into its actuator and its drive."""
        actuator, drive = self.actuator, self.drive
        changed_actuator, changed_drive = actuator, drive
        for name, value in values.items():
            if name in actuator.parameters():
                changed_actuator = changed_actuator.with_parameter(name, value)
            elif changed_drive is not None and name in changed_drive.parameters():
                changed_drive = changed_drive.replace(**{name: value})
            else:
                raise _unknown_name_error("values", name, self.nominal_values())

        def changed(argument: Any) -> Any:
            if argument is actuator:
                return changed_actuator
            return changed_drive if argument is drive else argument

        options = {name: changed(value) for name, value in self.options.items()}
        return self.verb(*map(changed, self.arguments), **options)


def _unknown_name_error(argument: str, name: str, nominal: Mapping[str, float]) -> InputError:
    return InputError(
        argument,
        must="name numeric fields of the actuator or the drive",
        got=repr(name),
        why="Nothing else can vary.",
        fix=f"Its fields are: {', '.join(nominal)}.",
    )


def _as_dataset(result: Any) -> xr.Dataset:
    if isinstance(result, xr.Dataset):
        return result
    if isinstance(result, xr.DataArray):
        return result.to_dataset(name="value")
    return xr.Dataset({"value": ((), float(result))})
