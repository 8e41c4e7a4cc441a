"""A program in three stages: what parameters alone decide, what time decides, what moves."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from remanent._field import Program

#: Values that depend on parameters only, on time too, and on the state.
CONSTANT, DRIVEN, MOVING = range(3)
_STAGE_COUNT: Final = 3


@dataclass(frozen=True)
class StagedProgram:
    """A program cut where its values stop depending on fewer things.

    Attributes
    ----------
    constants
        From parameters: the values of which the others have need.
    driven
        From time and `constants`: the values of which the others have need.
    moving
        Programs by name, from the state, `constants` and `driven`.
    """

    constants: Program
    driven: Program
    moving: Mapping[str, Program]

    @property
    def constant_names(self) -> tuple[str, ...]:
        """Names of the outputs of `constants`, in order."""
        return _needed_by((self.driven, *self.moving.values()), "constant.")

    @property
    def driven_names(self) -> tuple[str, ...]:
        """Names of the outputs of `driven`, in order."""
        return _needed_by(tuple(self.moving.values()), "driven.")


def staged_program(
    program: Program,
    outputs: Mapping[str, Sequence[int]],
    constant: Collection[str],
    driven: Collection[str],
) -> StagedProgram:
    """Cut a program into stages.

    Parameters
    ----------
    program : Program
        The whole.
    outputs : mapping of str to sequence of int
        For each of the last programs the numbers of the outputs of the whole that it has.
    constant, driven : collection of str
        Names of inputs that are parameters, and of those that time decides; all others are
        the state.
    """
    stages = _stage_of_each_slot(program, constant, driven)
    moving = {
        name: _cut(program, [program.output_slots[k] for k in numbers], stages, MOVING)
        for name, numbers in outputs.items()
    }
    wanted = _slots_of(_needed_by(tuple(moving.values()), "driven."))
    driven_program = _cut(program, wanted, stages, DRIVEN)
    wanted = _slots_of(_needed_by((driven_program, *moving.values()), "constant."))
    return StagedProgram(_cut(program, wanted, stages, CONSTANT), driven_program, moving)


def _stage_of_each_slot(
    program: Program, constant: Collection[str], driven: Collection[str]
) -> list[int]:
    stages = [
        CONSTANT if name in constant else DRIVEN if name in driven else MOVING
        for name in program.input_names
    ]
    stages += [CONSTANT] * len(program.constants)
    for _, *operands in program.instructions:
        stages.append(max(stages[k] for k in operands))
    return stages


def _needed_by(programs: Sequence[Program], prefix: str) -> tuple[str, ...]:
    """Inputs of programs that an earlier stage has to give, by number."""
    names = {name for one in programs for name in one.input_names if name.startswith(prefix)}
    return tuple(f"{prefix}{slot}" for slot in sorted(_slots_of(tuple(names))))


def _slots_of(names: Sequence[str]) -> list[int]:
    return [int(name.rpartition(".")[2]) for name in names]


def _cut(program: Program, wanted: Sequence[int], stages: Sequence[int], stage: int) -> Program:
    """The part of a program that computes some slots from inputs and from earlier stages."""
    input_count = len(program.input_names)
    first = input_count + len(program.constants)
    needed: set[int] = set()
    waiting = list(wanted)
    while waiting:
        slot = waiting.pop()
        if slot not in needed:
            needed.add(slot)
            if slot >= first and stages[slot] == stage:
                waiting += program.instructions[slot - first][1:]
    number: dict[int, int] = {}
    names: list[str] = []
    for slot in sorted(needed):
        if stages[slot] < stage and not input_count <= slot < first:
            names.append(f"{('constant', 'driven')[stages[slot]]}.{slot}")
        elif slot < input_count:
            names.append(program.input_names[slot])
        else:
            continue
        number[slot] = len(number)
    numbers = [slot for slot in sorted(needed) if input_count <= slot < first]
    number |= {slot: len(number) + k for k, slot in enumerate(numbers)}
    steps = [slot for slot in sorted(needed) if slot not in number]
    number |= {slot: len(number) + k for k, slot in enumerate(steps)}
    instructions = [program.instructions[slot - first] for slot in steps]
    return Program(
        tuple(names),
        tuple(program.constants[slot - input_count] for slot in numbers),
        tuple((name, *(number[k] for k in operands)) for name, *operands in instructions),  # type: ignore[misc]
        tuple(number[slot] for slot in wanted),
    )
