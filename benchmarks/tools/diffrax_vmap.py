"""diffrax: Dopri8 through jit and vmap, in double precision.

The form is the fastest of those tried with diffrax 0.7.2.  Groups of 64 or 1024, the load as a
cosine of twice the frequency, ``scan_kind="lax"`` and no limit of steps gained nothing.
"""

from __future__ import annotations

import numpy as np

from benchmarks.jobs import Job, thickness_stretch
from benchmarks.tools.tool import Package, Run, Tool, clocked
from remanent._typing import FloatArray

#: Neighbouring frequencies that step together; a batch takes as many steps as its slowest.
_BATCH = 256
#: Steps after which diffrax gives up: never here.
_MAX_STEPS = 1_000_000


def build(job: Job) -> Run:
    """The thickness stretch at the end, by groups of neighbouring frequencies."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def rates(tau: object, y: tuple[object, object], omega: object) -> tuple[object, object]:
        x, v = y
        load = job.b * jnp.sin(omega * tau)  # type: ignore[operator]
        return v, job.acceleration(load * load, x, v)

    def end(omega: object, tolerance: object) -> object:
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(rates), diffrax.Dopri8(), 0.0, job.window, None,
            (jnp.asarray(1.0), jnp.asarray(0.0)), omega,
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            saveat=diffrax.SaveAt(t1=True), max_steps=_MAX_STEPS, throw=False,
        )  # fmt: skip
        return thickness_stretch(solution.ys[0][-1])

    batch = jax.jit(jax.vmap(end, in_axes=(0, None)))

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        padded = np.append(omegas, np.full(-omegas.size % _BATCH, omegas[-1]))
        ends = [np.asarray(batch(group, tolerance)) for group in padded.reshape(-1, _BATCH)]
        return np.concatenate(ends)[: omegas.size, None]

    return clocked(run)


TOOL = Tool("diffrax", "diffrax Dopri8, vmap, end state only", Package("diffrax"), "end", build)
