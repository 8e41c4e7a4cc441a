"""A number that a verb gives, as a function of numeric fields."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import as_float_array, require_mapping, shortened_repr
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from remanent.models.drives.waves import Constant
from remanent.models.system import System
from remanent.studies.ensemble.layout import lay_out_ensemble, numeric_fields
from remanent.studies.inference._measure_errors import propagated_error, stated_error

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
        Any verb of this package, or a function of a system (and more) that returns a Dataset,
        an array or a number.  Of a number no error is known; a Dataset may hold ``value`` and
        ``value_error``.
    *arguments : Any
        Of the verb.  The first system and the first drive among them have the fields.
    of : str or callable, optional
        The name of a variable of the verb's result, or a function of that Dataset, which must
        keep its dimension ``sample``.  The errors of the variables are carried through the
        function: they are moved by their errors, and the largest change is its error.
    **options : Any
        Of the verb, by name.

    Raises
    ------
    InputError
        Something that cannot be called, or options that the verb does not take.

    See Also
    --------
    sensitivity : Its derivatives by fields.
    design : Fields with which it takes a given value.
    uncertainty : What uncertain fields make of it.

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
                got=shortened_repr(verb),
                why="It is called with changed fields.",
                fix="Pass for example rm.frequency_response.",
            )
        if "over" in options:
            raise InputError(
                "over",
                must="be left out",
                got=shortened_repr(options["over"]),
                why="The fields that vary are chosen here.",
                fix="Ask for one grid point at a time.",
            )
        _require_signature(verb, arguments, options)
        for name, value in {
            "verb": verb, "arguments": arguments, "of": of, "options": MappingProxyType(options),
        }.items():  # fmt: skip
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        of = f", of={self.of!r}" if isinstance(self.of, str) else ""
        return f"Measure({getattr(self.verb, '__name__', 'function')}{of})"

    @property
    def variable_name(self) -> str | None:
        """The variable that it is; None for a function of the result."""
        return self.of if isinstance(self.of, str) else None

    @property
    def system(self) -> System:
        """The first system among the arguments."""
        system = next((a for a in self._all_arguments() if _is_system(a)), None)
        if system is None:
            raise InputError(
                "measure",
                must="have a system, such as an actuator, among its arguments",
                got=repr(self),
                why="Its fields are what varies.",
                fix="Pass it after the verb.",
            )
        found: System = system
        return found

    @property
    def drive(self) -> Drive | None:
        """The first drive among the arguments, if there is one."""
        return next((a for a in self._all_arguments() if isinstance(a, Drive)), None)

    def nominal_values(self) -> dict[str, float]:
        """Values that the parameters have where they do not vary, by name."""
        system, drive = self.system, self.drive
        fields = {**numeric_fields(system), **({} if drive is None else drive.parameter_values())}
        if not self._verb_takes_over or (drive is None and system.load_names != ("load",)):
            return fields
        ens = lay_out_ensemble(system, drive or Constant(0.0), None, self.options.get("initial"))
        start = {
            f"initial.{n}": float(v)
            for n, v in zip(ens.vector_field.state_names, ens.initial_states[0], strict=True)
        }
        return {**fields, **start}

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
            which the verb states, or what its stated errors make of the function `of`; NaN
            where it states none.
        """
        result = self._results_at(values)
        value = self._value_of(result)
        error = (
            propagated_error(self.of, result, value)
            if callable(self.of)
            else stated_error(result, str(value.name))
        )
        if error is None:
            error = xr.full_like(value, np.nan, dtype=np.float64)
        value = value.transpose(SAMPLE_DIMENSION, ...)
        return value, error.broadcast_like(value).transpose(*value.dims)

    def values_at(self, values: Mapping[str, Any]) -> xr.DataArray:
        """The measure alone at sets of parameters, see :meth:`at`."""
        return self._value_of(self._results_at(values)).transpose(SAMPLE_DIMENSION, ...)

    def _results_at(self, values: Mapping[str, Any]) -> xr.Dataset:
        """Results of the verb along ``sample``."""
        columns = _require_columns(values)
        if self._verb_takes_over:
            over = {name: xr.DataArray(v, dims=SAMPLE_DIMENSION) for name, v in columns.items()}
            result: xr.Dataset = self.verb(*self.arguments, **self.options, over=over)
            return result
        count = len(next(iter(columns.values())))
        rows = [{name: float(v[k]) for name, v in columns.items()} for k in range(count)]
        results = [_as_dataset(self._call_verb(row)) for row in rows]
        return xr.concat(results, dim=SAMPLE_DIMENSION, join="outer")

    @property
    def _verb_takes_over(self) -> bool:
        """Whether the verb computes many sets of parameters in one call."""
        signature = _signature_of(self.verb)
        return signature is not None and "over" in signature.parameters

    def _value_of(self, result: xr.Dataset) -> xr.DataArray:
        """The measure in a result of the verb."""
        of = self._function_of if callable(self.of) else self._measured_variable
        return self._require_samples(of(result))

    def _function_of(self, result: xr.Dataset) -> Any:
        """What the function `of` makes of a result."""
        assert callable(self.of)
        try:
            return self.of(result)
        except (IndexError, KeyError, ValueError, TypeError, AttributeError) as error:
            raise InputError(
                "of",
                must="be a function of the verb's result, also where that holds nothing",
                got=f"{type(error).__name__}: {error}",
                why="It was called with the result for the values that are asked for.",
                fix="Pass one that gives NaN there, or stay with values that have a result.",
            ) from error

    def _require_samples(self, value: Any) -> xr.DataArray:
        """What `of` made of a result, if it has a number for each sample."""
        if not isinstance(value, xr.DataArray) or SAMPLE_DIMENSION not in value.dims:
            raise InputError(
                "of",
                must=f"keep the dimension `{SAMPLE_DIMENSION}`",
                got=shortened_repr(self.of),
                why="The verb was asked for many values at once.",
                fix="Reduce other dimensions only.",
            )
        return value

    def _measured_variable(self, result: xr.Dataset) -> xr.DataArray:
        """The variable that `of` names; ``value`` where it names none."""
        name = self.of if isinstance(self.of, str) else "value"
        if name not in result:
            raise InputError(
                "of",
                must=f"be one of {', '.join(map(str, result.data_vars))}",
                got=shortened_repr(self.of),
                why="It is a variable of the verb's result.",
                fix="Pass its name.",
            )
        return result[name]

    def _all_arguments(self) -> list[Any]:
        return [*self.arguments, *self.options.values()]

    def _call_verb(self, values: Mapping[str, float]) -> Any:
        """The verb for one set of parameters, put into its actuator and its drive."""
        system, drive = self.system, self.drive
        known = self.nominal_values()
        changed_system, changed_drive = system, drive
        for name, value in values.items():
            if drive is not None and changed_drive is not None and name in drive.parameter_values():
                changed_drive = changed_drive.replace(**{name: value})
            elif name in known:
                changed_system = changed_system.with_parameter(name, value)
            else:
                raise _unknown_name_error("values", name, known)

        def changed(argument: Any) -> Any:
            if argument is system:
                return changed_system
            return changed_drive if argument is drive else argument

        options = {name: changed(value) for name, value in self.options.items()}
        return self.verb(*map(changed, self.arguments), **options)


def _require_columns(values: object) -> dict[str, FloatArray]:
    """Sets of parameters as arrays of one length."""
    fix = 'Pass for example {"temperature": [290.0, 300.0]}.'
    given = require_mapping("values", values, what="names to numbers, at least one", fix=fix)
    columns = {
        name: as_float_array(
            f"values[{name!r}]" if isinstance(name, str) else "values", column, ndim=1,
            what="values of a field", why="Each set of parameters has one.", fix=fix,
        )
        for name, column in given.items()
    }  # fmt: skip
    if len({len(column) for column in columns.values()}) != 1:
        raise InputError(
            "values",
            must="have as many entries for each of its names, and at least one name",
            got=shortened_repr({name: len(column) for name, column in columns.items()}),
            why="They go together, one with one.",
            fix=fix,
        )
    return columns


def _is_system(argument: object) -> bool:
    return isinstance(argument, System) and not isinstance(argument, type)


def _signature_of(verb: Callable[..., Any]) -> inspect.Signature | None:
    """The arguments of a function; None where some written in C do not tell."""
    try:
        return inspect.signature(verb)
    except ValueError:
        return None


def _require_signature(
    verb: Callable[..., Any], arguments: Any, options: Mapping[str, Any]
) -> None:
    """Refuse arguments that the verb does not have, and a call without those that it needs."""
    signature = _signature_of(verb)
    if signature is None:
        return
    try:
        signature.bind(*arguments, **options)
    except TypeError as error:
        name = getattr(verb, "__name__", "the function")
        raise InputError(
            "measure",
            must=f"have arguments that {name} takes",
            got=shortened_repr({"arguments": arguments, **options}),
            why=f"Python says: {error}.",
            fix=f"Pass some of its arguments: {', '.join(signature.parameters)}.",
        ) from error


def _unknown_name_error(argument: str, name: str, nominal: Mapping[str, float]) -> InputError:
    return InputError(
        argument,
        must="name numeric fields of the system or the drive",
        got=shortened_repr(name),
        why="Nothing else can vary.",
        fix=f"Name some of its fields: {', '.join(nominal)}.",
    )


def _as_dataset(result: Any) -> xr.Dataset:
    if isinstance(result, xr.Dataset):
        return result
    if isinstance(result, xr.DataArray):
        return result.to_dataset(name="value")
    return xr.Dataset({"value": ((), float(result))})
