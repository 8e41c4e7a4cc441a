"""Keeps states of the fine solution after every so many steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from llvmlite import ir

from remanent.integrate.kernel.lanes import Lanes, Writer


@dataclass(frozen=True)
class Recorder:
    """Writes states of one group into the array ``(record, group, state, lane)``.

    Attributes
    ----------
    record_pointer : ir.Value
        Pointer to the array.
    group_count, group_number : ir.Value
        How many groups there are, and the number of this one.
    record_interval_in_fine_steps : ir.Value
        Fine steps between records; 0 for none.
    """

    writer: Writer
    record_pointer: ir.Value
    group_count: ir.Value
    group_number: ir.Value
    record_interval_in_fine_steps: ir.Value

    def record_if_due(self, count: ir.Value, y: Sequence[Lanes]) -> None:
        """Record the state after `count` fine steps of this call, if it is due."""
        b, w = self.writer.builder, self.writer
        # The remainder of an integer division by zero is undefined, so that `every` is
        # compared with zero before.
        with b.if_then(
            b.icmp_signed("!=", self.record_interval_in_fine_steps, w.integer_constant(0)),
            likely=False,
        ):
            due = b.icmp_signed(
                "==", b.srem(count, self.record_interval_in_fine_steps), w.integer_constant(0)
            )
            with b.if_then(due, likely=False):
                self._write_record(
                    b.sub(b.sdiv(count, self.record_interval_in_fine_steps), w.integer_constant(1)),
                    y,
                )

    def _write_record(self, number: ir.Value, y: Sequence[Lanes]) -> None:
        b, w = self.writer.builder, self.writer
        base = b.add(b.mul(number, self.group_count), self.group_number)
        base = b.mul(base, w.integer_constant(len(y) * w.lane_count))
        for i, y_i in enumerate(y):
            w.store_lanes(
                y_i, self.record_pointer, b.add(base, w.integer_constant(i * w.lane_count))
            )
