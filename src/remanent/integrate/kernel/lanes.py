"""Numbers that write machine code: many trajectories side by side.

A :class:`Lanes` value stands for one double per trajectory of a group.  Its
arithmetic appends vector instructions to an LLVM function instead of computing,
so that formulas written for numbers of any kind (a Runge-Kutta step, a field's
program) become a kernel by being run once.  Every lane undergoes the same
instructions, so a result does not depend on the neighbours of its trajectory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from llvmlite import ir

DOUBLE_TYPE = ir.DoubleType()
INTEGER_TYPE = ir.IntType(64)
_LANE_INDEX_TYPE = ir.IntType(32)
#: Name in LLVM of the instruction that estimates reciprocals.
_RECIPROCAL_ESTIMATE_NAME = "llvm.x86.avx512.rcp14.pd.512"
#: Lanes of that instruction.
_RECIPROCAL_ESTIMATE_LANE_COUNT = 8
#: Fused multiply-add is allowed; nothing else that would change a result or a NaN.
_FLOAT_INSTRUCTION_FLAGS = ("contract",)


@dataclass(frozen=True)
class Writer:
    """Where instructions go: a function under construction.

    Attributes
    ----------
    lane_count
        Lanes.
    has_reciprocal_estimates
        The processor has an instruction for estimates of reciprocals.
    """

    builder: ir.IRBuilder
    lane_count: int
    has_reciprocal_estimates: bool = False

    @property
    def vector_type(self) -> ir.VectorType:
        return ir.VectorType(DOUBLE_TYPE, self.lane_count)

    def constant(self, value: float) -> Lanes:
        """The same number in every lane."""
        return Lanes(self, ir.Constant(self.vector_type, [float(value)] * self.lane_count))

    def integer_constant(self, value: int) -> ir.Constant:
        return ir.Constant(INTEGER_TYPE, value)

    def broadcast(self, scalar: ir.Value) -> Lanes:
        """A scalar double copied to every lane."""
        undefined = ir.Constant(self.vector_type, ir.Undefined)
        first_lane = self.builder.insert_element(
            undefined, scalar, ir.Constant(_LANE_INDEX_TYPE, 0)
        )
        zeros = ir.Constant(ir.VectorType(_LANE_INDEX_TYPE, self.lane_count), [0] * self.lane_count)
        return Lanes(self, self.builder.shuffle_vector(first_lane, undefined, zeros))

    def broadcast_integer(self, scalar: ir.Value) -> Lanes:
        """An integer, as a double, in every lane."""
        return self.broadcast(self.builder.sitofp(scalar, DOUBLE_TYPE))

    def load_lanes(self, pointer: ir.Value, index: ir.Value) -> Lanes:
        """Read the lanes that start at ``pointer[index]``."""
        value = self.builder.load(self._vector_address(pointer, index))
        value.align = 8
        return Lanes(self, value)

    def store_lanes(self, lanes: Lanes, pointer: ir.Value, index: ir.Value) -> None:
        """Write the lanes to ``pointer[index]`` and following."""
        self.builder.store(lanes.ir_value, self._vector_address(pointer, index)).align = 8

    def _vector_address(self, pointer: ir.Value, index: ir.Value) -> ir.Value:
        address = self.builder.gep(pointer, [index])
        return self.builder.bitcast(address, self.vector_type.as_pointer())

    def load_scalar(self, pointer: ir.Value, index: ir.Value) -> ir.Value:
        return self.builder.load(self.builder.gep(pointer, [index]))

    def load_rows(self, pointer: ir.Value, first: Lanes, columns: Sequence[int]) -> list[Lanes]:
        """For every lane some of the numbers from ``pointer[first]`` on."""
        b = self.builder
        index = b.fptosi(first.ir_value, ir.VectorType(INTEGER_TYPE, self.lane_count))
        numbers = [ir.Constant(_LANE_INDEX_TYPE, lane) for lane in range(self.lane_count)]
        rows = [b.gep(pointer, [b.extract_element(index, number)]) for number in numbers]
        values = []
        for k in columns:
            value = ir.Constant(self.vector_type, ir.Undefined)
            for number, row in zip(numbers, rows, strict=True):
                scalar = self.load_scalar(row, self.integer_constant(k))
                value = b.insert_element(value, scalar, number)
            values.append(Lanes(self, value))
        return values

    def new_cell(self) -> Cell:
        """A mutable cell without a value; the optimiser turns it into registers."""
        with self.builder.goto_entry_block():
            return Cell(self, self.builder.alloca(self.vector_type))

    def new_cell_with(self, initial: Lanes) -> Cell:
        """A mutable cell."""
        cell = self.new_cell()
        cell.set(initial)
        return cell

    def either(
        self,
        condition: ir.Value,
        if_true: Callable[[], Sequence[Lanes]],
        if_false: Callable[[], Sequence[Lanes]],
    ) -> list[Lanes]:
        """What one of two functions writes, whichever a scalar condition says when it runs."""
        ways = []
        with self.builder.if_else(condition) as branches:
            for branch, write in zip(branches, (if_true, if_false), strict=True):
                with branch:
                    ways.append((write(), self.builder.block))
        joined = []
        for values in zip(*(values for values, _ in ways), strict=True):
            phi = self.builder.phi(self.vector_type)
            for value, (_, block) in zip(values, ways, strict=True):
                phi.add_incoming(value.ir_value, block)
            joined.append(Lanes(self, phi))
        return joined

    @contextmanager
    def loop(self, count: ir.Value) -> Iterator[tuple[ir.Value, Callable[[ir.Value], None]]]:
        """Repeat for 0, 1 ... count - 1; yields the index and ``leave_if(condition)``."""
        b = self.builder
        before = b.block
        head, body, end = (b.append_basic_block(n) for n in ("head", "body", "end"))
        b.branch(head)
        b.position_at_end(head)
        index = b.phi(INTEGER_TYPE)
        index.add_incoming(self.integer_constant(0), before)
        b.cbranch(b.icmp_signed("<", index, count), body, end)
        b.position_at_end(body)

        def leave_if(condition: ir.Value) -> None:
            stay = b.append_basic_block("stay")
            b.cbranch(condition, end, stay)
            b.position_at_end(stay)

        yield index, leave_if
        index.add_incoming(b.add(index, self.integer_constant(1)), b.block)
        b.branch(head)
        b.position_at_end(end)

    def reciprocal(self, b: Lanes) -> Lanes:
        """1/b, to the last digit or so, where neither of them is near an end of the range.

        A division of eight lanes keeps the next waiting for sixteen cycles.  Four factors of
        1/(1 - d), with d = 1 - b r < 2**-13 for the estimate r, keep nothing waiting:
        1/b = r (1 + d) (1 + d^2) ...
        """
        if not self.has_reciprocal_estimates:
            return 1.0 / b
        r = self._reciprocal_estimate(b)
        defect = 1.0 - b * r
        r = r + r * defect
        return r + r * (defect * defect)

    def _reciprocal_estimate(self, b: Lanes) -> Lanes:
        builder, parts = self.builder, []
        native, mask = ir.VectorType(DOUBLE_TYPE, _RECIPROCAL_ESTIMATE_LANE_COUNT), ir.IntType(8)
        signature = ir.FunctionType(native, [native, native, mask])
        estimate = builder.module.globals.get(_RECIPROCAL_ESTIMATE_NAME)
        if estimate is None:
            estimate = ir.Function(builder.module, signature, _RECIPROCAL_ESTIMATE_NAME)
        nothing, every = ir.Constant(native, ir.Undefined), ir.Constant(mask, -1)
        for first in range(0, self.lane_count, _RECIPROCAL_ESTIMATE_LANE_COUNT):
            part = builder.shuffle_vector(
                b.ir_value, b.ir_value, _lane_numbers(first, _RECIPROCAL_ESTIMATE_LANE_COUNT)
            )
            parts.append(builder.call(estimate, [part, nothing, every]))
        while len(parts) > 1:  # halves, quarters ... of a power of 2
            joined_lanes = _lane_numbers(0, 2 * parts[0].type.count)
            pairs = zip(parts[::2], parts[1::2], strict=True)
            parts = [builder.shuffle_vector(low, high, joined_lanes) for low, high in pairs]
        return Lanes(self, parts[0])

    def call_math_function(self, name: str, argument: Lanes) -> Lanes:
        """A function of the mathematical library, lane by lane."""
        module = self.builder.module
        full = f"llvm.{name}.v{self.lane_count}f64"
        declared = module.globals.get(full)
        if declared is None:
            declared = ir.Function(
                module, ir.FunctionType(self.vector_type, [self.vector_type]), full
            )
        return Lanes(self, self.builder.call(declared, [argument.ir_value]))


@dataclass(frozen=True)
class Cell:
    """A mutable cell of lanes."""

    writer: Writer
    address: ir.Value

    def get(self) -> Lanes:
        return Lanes(self.writer, self.writer.builder.load(self.address))

    def set(self, value: Lanes) -> None:
        self.writer.builder.store(value.ir_value, self.address)

    def set_where(self, where: Mask, value: Lanes) -> None:
        """Replace the numbers of some lanes."""
        self.set(where.select(value, self.get()))


def begin_function(
    name: str, pointers: int, integers: int, lane_count: int, *, estimates: bool
) -> tuple[Writer, Sequence[ir.Value]]:
    """A module with a function of pointers to doubles and then integers: its writer and arguments.

    Cells are allocated in a block of their own, which is run once.
    """
    types = [DOUBLE_TYPE.as_pointer()] * pointers + [INTEGER_TYPE] * integers
    function = ir.Function(ir.Module(name="remanent"), ir.FunctionType(ir.VoidType(), types), name)
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    begin = function.append_basic_block("begin")
    builder.branch(begin)
    builder.position_at_end(begin)
    return Writer(builder, lane_count, estimates), function.args


@dataclass(frozen=True)
class Lanes:
    """One double per trajectory of a group."""

    writer: Writer
    ir_value: ir.Value

    def _ir_operand(self, other: Lanes | float) -> ir.Value:
        return other.ir_value if isinstance(other, Lanes) else self.writer.constant(other).ir_value

    def _append_instruction(self, name: str, left: ir.Value, right: ir.Value) -> Lanes:
        return Lanes(
            self.writer,
            getattr(self.writer.builder, name)(left, right, flags=_FLOAT_INSTRUCTION_FLAGS),
        )

    def __add__(self, other: Lanes | float) -> Lanes:
        return self._append_instruction("fadd", self.ir_value, self._ir_operand(other))

    __radd__ = __add__

    def __sub__(self, other: Lanes | float) -> Lanes:
        return self._append_instruction("fsub", self.ir_value, self._ir_operand(other))

    def __rsub__(self, other: float) -> Lanes:
        return self._append_instruction("fsub", self._ir_operand(other), self.ir_value)

    def __mul__(self, other: Lanes | float) -> Lanes:
        return self._append_instruction("fmul", self.ir_value, self._ir_operand(other))

    __rmul__ = __mul__

    def __truediv__(self, other: Lanes | float) -> Lanes:
        return self._append_instruction("fdiv", self.ir_value, self._ir_operand(other))

    def __rtruediv__(self, other: float) -> Lanes:
        return self._append_instruction("fdiv", self._ir_operand(other), self.ir_value)

    def __neg__(self) -> Lanes:
        return Lanes(self.writer, self.writer.builder.fneg(self.ir_value))

    def __abs__(self) -> Lanes:
        return self.writer.call_math_function("fabs", self)

    def _compare(self, sign: str, other: Lanes | float) -> Mask:
        compare = self.writer.builder.fcmp_ordered
        return Mask(self.writer, compare(sign, self.ir_value, self._ir_operand(other)))

    def is_nan(self) -> Mask:
        return Mask(
            self.writer, self.writer.builder.fcmp_unordered("uno", self.ir_value, self.ir_value)
        )

    def __lt__(self, other: Lanes | float) -> Mask:
        return self._compare("<", other)

    def __le__(self, other: Lanes | float) -> Mask:
        return self._compare("<=", other)

    def __gt__(self, other: Lanes | float) -> Mask:
        return self._compare(">", other)

    def __ge__(self, other: Lanes | float) -> Mask:
        return self._compare(">=", other)


@dataclass(frozen=True)
class Mask:
    """One truth value per trajectory; comparisons with NaN are false."""

    writer: Writer
    ir_value: ir.Value

    def __and__(self, other: Mask) -> Mask:
        return Mask(self.writer, self.writer.builder.and_(self.ir_value, other.ir_value))

    def __or__(self, other: Mask) -> Mask:
        return Mask(self.writer, self.writer.builder.or_(self.ir_value, other.ir_value))

    def without(self, other: Mask) -> Mask:
        """Where this mask holds and the other does not."""
        all_ones = ir.Constant(self.ir_value.type, [1] * self.writer.lane_count)
        b = self.writer.builder
        return Mask(self.writer, b.and_(self.ir_value, b.xor(other.ir_value, all_ones)))

    def select(self, true: Lanes, false: Lanes) -> Lanes:
        """`true` where the mask holds, else `false`."""
        return Lanes(
            self.writer, self.writer.builder.select(self.ir_value, true.ir_value, false.ir_value)
        )

    def any_lane(self) -> ir.Value:
        """Whether the mask holds in at least one lane, as a scalar."""
        b = self.writer.builder
        bits = b.bitcast(self.ir_value, ir.IntType(self.writer.lane_count))
        return b.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))


def _lane_numbers(first: int, count: int) -> ir.Constant:
    """The numbers of consecutive lanes, as instructions take them."""
    return ir.Constant(ir.VectorType(_LANE_INDEX_TYPE, count), list(range(first, first + count)))


def reciprocal_quotient(a: Lanes, b: Lanes) -> Lanes:
    """a/b by the reciprocal of b."""
    return a * b.writer.reciprocal(b)


def larger(a: Lanes, b: Lanes) -> Lanes:
    """The larger of two values, `b` where `a` is NaN."""
    return (a > b).select(a, b)


def smaller(a: Lanes, b: Lanes) -> Lanes:
    """The smaller of two values, `b` where `a` is NaN."""
    return (a < b).select(a, b)


def larger_or_nan(a: Lanes, b: Lanes) -> Lanes:
    """The larger of two values, NaN where either is: an error that is NaN must not be lost."""
    return ((b <= a) | a.is_nan()).select(a, b)


@dataclass(frozen=True)
class LaneFunctions:
    """Functions of lanes under the names that programs use."""

    writer: Writer

    def __getattr__(self, name: str) -> Any:
        return lambda argument: self.writer.call_math_function(name, argument)
