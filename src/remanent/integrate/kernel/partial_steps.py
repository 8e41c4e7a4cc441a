"""Single steps, each of a state of its own, under a load of its own and of its own length.

A kernel advances many trajectories through the same steps.  States at given times lie between
them: each is reached by one shorter step from the end of the last whole one.
"""

from __future__ import annotations

from llvmlite import ir

from remanent._field import Field
from remanent.integrate.kernel.lanes import begin_function
from remanent.integrate.kernel.outline import OutlinedField
from remanent.integrate.methods.runge_kutta import RungeKuttaMethod

#: Name of the function in the object code.
PARTIAL_STEPS_FUNCTION_NAME = "partial_steps"


def partial_steps_source(
    field: Field, method: RungeKuttaMethod, lane_count: int, *, estimates: bool
) -> str:
    """LLVM assembly of ``void partial_steps(double *starts, double *ends, int64_t groups)``.

    The arrays are ``(number, step)``, with a step in every lane of every group.  The numbers of a
    start are the length of the step, the load at every node (phase and waveforms), the state and
    the parameters; those of an end are the state.

    Parameters
    ----------
    field : Field
        What moves.
    method : RungeKuttaMethod
        What it is integrated with.
    lane_count : int
        Steps per group.
    estimates : bool
        The code is for a processor that estimates reciprocals of eight numbers at once.
    """
    writer, (starts, ends, group_count) = begin_function(
        PARTIAL_STEPS_FUNCTION_NAME, 2, 1, lane_count, estimates=estimates
    )
    builder = writer.builder
    states, load_size = len(field.variables), 1 + len(field.waveform_names)
    step_function = OutlinedField(field, method, writer, states)
    counts = (1, *(load_size for _ in method.nodes), states, len(field.parameter_names))
    with writer.loop(group_count) as (group, _):
        number = iter(range(sum(counts)))

        def place(k: int) -> ir.Value:
            row = builder.mul(group_count, writer.integer_constant(k))
            return builder.mul(builder.add(row, group), writer.integer_constant(lane_count))

        (h,), *loads, state, parameters = (
            [writer.load_lanes(starts, place(next(number))) for _ in range(count)]
            for count in counts
        )
        step_function.prepare_parameters(parameters)
        _, change = step_function.step(state, h, loads)
        for k, (y, added) in enumerate(zip(state, change, strict=True)):
            writer.store_lanes(y + added, ends, place(k))
    builder.ret_void()
    return str(builder.module)
