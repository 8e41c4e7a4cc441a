"""Several loads, each by a drive of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import lcm
from typing import Any, ClassVar, Self

import numpy as np

from remanent._checks import as_dict, require_real, shortened_repr
from remanent._errors import InputError
from remanent._load_schedule import LoadSchedule
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent.models.drives.base import Drive, Waveform, empty_waveforms, periodic_load_schedule
from remanent.models.drives.waves import Constant, Sine
from remanent.models.parts import EquationStructure, Part

#: Ratios of periods are fractions of whole numbers up to this.
_LARGEST_DENOMINATOR = 64
#: Relative difference of periods that count as equal.
_RATIO_TOLERANCE = 1e-12


@dataclass(frozen=True)
class Loads(Drive):
    """A drive for each of several loads of a system of one's own.

    Wherever a drive is asked for, the mapping itself may be passed.  Numeric fields have the
    name of the load before their own: ``voltage.omega``.

    Parameters
    ----------
    drives : mapping of str to Drive
        A drive for the name of each load, in the order of the system's ``loads``.  Periods
        of those that are periodic have to be in a ratio of small whole numbers; a load that
        is no constant and has no period may stand beside constants only.

    Raises
    ------
    InputError
        Drives whose loads have no common course in time.

    See Also
    --------
    LagrangianSystem : A system that may have several loads.

    Examples
    --------
    >>> both = Loads({"pressure": Constant(0.5), "voltage": Sine(0.1, 2.0, mean=0.2)})
    >>> both.load_names, round(both.period, 6)
    (('pressure', 'voltage'), 3.141593)
    """

    drives: Mapping[str, Drive] | Sequence[tuple[str, Drive]]

    mapping_fields: ClassVar[tuple[str, ...]] = ("drives",)

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls({"load": Sine(0.2, 0.7, mean=-0.1, phase=2.0)})

    def checked_fields(self) -> Mapping[str, Any]:
        """The drives as pairs, if they go together."""
        pairs = as_dict(self.drives)
        if not pairs or not all(
            isinstance(k, str) and isinstance(v, Drive) and not isinstance(v, Loads)
            for k, v in pairs.items()
        ):
            raise InputError(
                "drives",
                must="be a mapping of names of loads to drives",
                got=shortened_repr(self.drives),
                why="Each load has a law in time.",
                fix='Pass for example {"pressure": rm.Constant(0.5), "voltage": rm.Sine(1, 2)}.',
            )
        _require_one_course(pairs)
        return {"drives": tuple(pairs.items())}

    def parts(self) -> dict[str, Part]:
        """The drives by the names of their loads."""
        return dict(self.drives)

    def _drive_by_load(self) -> dict[str, Drive]:
        return dict(self.drives)

    @property
    def load_names(self) -> tuple[str, ...]:
        """Names of the loads."""
        return tuple(self._drive_by_load())

    @property
    def waveform_names(self) -> tuple[str, ...]:
        """Waveforms of all of them."""
        return self._joined(drive.waveform_names for drive in self._drive_by_load().values())

    @property
    def waveforms(self) -> tuple[Waveform, ...]:
        """Waveforms of all of them, in their common period."""
        repeats = self._repeats()
        return tuple(
            replace(one, repeats=one.repeats * repeats.get(name, 1))
            for name, drive in self._drive_by_load().items()
            for one in drive.waveforms
        )

    @property
    def period_field_name(self) -> str | None:
        """That of the first of them that has a period; the others keep their ratio to it."""
        names = ((load, d.period_field_name) for load, d in self._drive_by_load().items())
        return next((f"{load}.{name}" for load, name in names if name is not None), None)

    @property
    def last_change(self) -> float:
        """That of the one that has pieces."""
        return max(drive.last_change for drive in self._drive_by_load().values())

    @property
    def known_until(self) -> float:
        """The time after which one of them is not known."""
        return min(drive.known_until for drive in self._drive_by_load().values())

    @property
    def piece_parameter_names(self) -> tuple[str, ...]:
        """Piece parameters of all of them."""
        return self._joined(drive.piece_parameter_names for drive in self._drive_by_load().values())

    def _joined(self, names: Any) -> tuple[str, ...]:
        return tuple(
            f"{load}.{name}" for load, own in zip(self.load_names, names, strict=True)
            for name in own
        )  # fmt: skip

    @property
    def has_load_rate(self) -> bool:  # type: ignore[override]
        """Whether every load has a rate in closed form."""
        return all(drive.has_load_rate for drive in self._drive_by_load().values())

    def equation_structure(self) -> EquationStructure:
        """The class, and the structure of each drive with the name of its load."""
        kind = type(self)
        inner = ((name, d.equation_structure()) for name, d in self._drive_by_load().items())
        return (f"{kind.__module__}:{kind.__qualname__}", *inner)

    def replace(self, **changes: Any) -> Self:
        """A copy with some drives, or some of their fields, changed."""
        start = type(self)(changes.pop("drives")) if "drives" in changes else self
        pairs, rules = start._drive_by_load(), start.parameter_rules()
        for name, value in changes.items():
            load, _, field = name.partition(".")
            if name in rules:
                number = require_real(name, value, rules[name])
                pairs[load] = pairs[load].replace(**{field: number})
            elif name in pairs:
                pairs[name] = value
            else:
                raise InputError(
                    name,
                    must="be a field of Loads: a load, or a field of the drive of one",
                    got=shortened_repr(value),
                    why="Unknown fields are refused so that a misspelling does not go unnoticed.",
                    fix=f"Name one of its fields: {', '.join(self.parameter_values())}.",
                )
        return type(self)(pairs)

    def __call__(self, tau: ArrayLike) -> FloatArray:
        """The loads at times `tau`, array (load, *tau.shape)."""
        return np.stack([drive(tau) for drive in self._drive_by_load().values()])

    def load(self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any) -> Any:
        """The first of the loads; see :meth:`loads_by_name`."""
        return self.loads_by_name(p, u, phase, fn)[self.load_names[0]]

    def loads_by_name(
        self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any
    ) -> dict[str, Any]:
        """Every load by its name."""
        return {
            name: drive.load(_own(name, p), _own(name, u), phase, fn)
            for name, drive in self._drive_by_load().items()
        }

    def load_rates_by_name(
        self, p: Mapping[str, Any], u: Mapping[str, Any], phase: Any, fn: Any
    ) -> dict[str, Any]:
        """The rate of every load by its name."""
        return {
            name: drive.load_rate(_own(name, p), _own(name, u), phase, fn)
            for name, drive in self._drive_by_load().items()
        }

    def where_invalid(self, values: Mapping[str, ArrayLike]) -> BoolArray:
        """Where a value breaks a rule, or periods are in another ratio than those of the drives."""
        broken = super().where_invalid(values)
        arrays = {k: np.asarray(v, dtype=np.float64) for k, v in values.items()}
        own, given = self._periods({}), self._periods(arrays)
        with np.errstate(all="ignore"):
            for name, period in given.items():
                first = next(iter(given))
                ratio = period / given[first] * own[first] / own[name]
                broken = broken | ~(np.abs(ratio - 1.0) <= _RATIO_TOLERANCE)
        return np.asarray(broken)

    def periods(self, values: Mapping[str, FloatArray]) -> FloatArray | None:
        """The smallest common period, or None."""
        periods = self._periods(values)
        if not periods:
            return None
        name, period = next(iter(periods.items()))
        return np.asarray(period * self._repeats()[name])

    def _periods(self, values: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
        found = {
            name: drive.periods(_own(name, values)) for name, drive in self._drive_by_load().items()
        }
        return {name: period for name, period in found.items() if period is not None}

    def _repeats(self) -> dict[str, int]:
        """How often each periodic load repeats in their common period."""
        return _repeats({name: float(x) for name, x in self._periods({}).items()})

    def load_schedule(self, values: Mapping[str, FloatArray], duration: FloatArray) -> LoadSchedule:
        """One period of all of them, or the pieces of the one that has some."""
        drives, repeats = self._drive_by_load(), self._repeats()
        schedules = {
            name: drive.load_schedule(_own(name, values), duration)
            for name, drive in drives.items()
        }
        if not repeats:
            changing = next(
                (name for name, drive in drives.items() if not isinstance(drive, Constant)),
                self.load_names[0],
            )
            chosen = schedules[changing]
            return LoadSchedule(
                chosen.piece_lengths,
                periodic=False,
                piece_parameters={f"{changing}.{k}": v for k, v in chosen.piece_parameters.items()},
                waveforms_at_phase=chosen.waveforms_at_phase,
            )

        def waveforms(phase: FloatArray) -> FloatArray:
            parts = [empty_waveforms(phase)]
            for name, schedule in schedules.items():
                turns = repeats.get(name, 1) * np.asarray(phase, dtype=np.float64)
                # The end of a period is not the beginning of the next: waveforms may change sign.
                own_phase = np.where(turns == repeats.get(name, 1), 1.0, turns % 1.0)
                parts.append(schedule.waveforms_at_phase(own_phase))
            return np.concatenate(parts)

        period = self.periods(values)
        assert period is not None
        return periodic_load_schedule(period, duration, waveforms)


def _own(load: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """What belongs to one load, under the names that its drive knows."""
    start = f"{load}."
    return {name.removeprefix(start): v for name, v in values.items() if name.startswith(start)}


def _repeats(periods: Mapping[str, float]) -> dict[str, int]:
    """How often each of some periods fits into the smallest common one."""
    if not periods:
        return {}
    first = next(iter(periods.values()))
    ratios = {
        name: Fraction(first / period).limit_denominator(_LARGEST_DENOMINATOR)
        for name, period in periods.items()
    }
    common = lcm(*(ratio.denominator for ratio in ratios.values()))
    return {name: int(ratio * common) for name, ratio in ratios.items()}


def _require_one_course(drives: Mapping[str, Drive]) -> None:
    """Raise where loads have neither a common period nor common pieces."""
    with np.errstate(over="ignore"):
        periods = {name: drive.period for name, drive in drives.items()}
    known = {name: period for name, period in periods.items() if period is not None}
    others = [
        name
        for name, drive in drives.items()
        if name not in known and not isinstance(drive, Constant)
    ]
    message = {
        "got": shortened_repr(drives),
        "why": "All loads run through one period, or the pieces of one of them.",
    }
    if not np.isfinite([*known.values()]).all():
        raise InputError(
            "drive",
            must="have finite periods",
            fix="Use Constant for a load that does not change within any run.",
            **message,
        )
    if others and (len(others) > 1 or known):
        raise InputError(
            "drives",
            must="have at most one load that is no constant and has no period, beside constants",
            fix=f"Pass constants beside {others[0]}.",
            **message,
        )
    repeats = _repeats(known)
    for name, period in known.items():
        first = next(iter(known))
        product = period * repeats[name] / (known[first] * repeats[first])
        if not abs(product - 1.0) <= _RATIO_TOLERANCE:
            raise InputError(
                "drives",
                must="have periods in a ratio of small whole numbers",
                fix=f"Pass an omega of {name} that is a simple multiple of that of {first}.",
                **message,
            )
