"""Files for AUTO-07p in tests: of which systems, and their routines as they are compiled."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import remanent as rm
from remanent._typing import FloatArray
from tests.contracts.exported import (
    SINE,
    Cases,
    write,
)
from tests.contracts.tools import require_program, run_program
from tests.faults.own_systems import DUFFING, TWO_LOADS

#: Systems under loads with a period, which AUTO continues.
FORCED: Cases = {
    "actuator": (rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.4, 1.25, phase=0.3)),
    "undamped": (rm.Actuator(temperature=350.0), rm.SineSquared(0.4, 1.25)),
    "Zener": (rm.Actuator(dissipation=rm.Zener(0.4, 1.0)), SINE),
    "Duffing": (DUFFING, rm.Sines([0.2, -0.1], [1, 2], 0.7, phases=[0.3, 1.0])),
    "case of names": (
        rm.LagrangianSystem(coordinates="F", kinetic="F_rate**2/2", potential="f*F**2/2 - load*F",
                            dissipation="PAR*F_rate**2/2", parameters={"f": 2.0, "PAR": 0.3}), SINE,
    ),
    "two loads": (TWO_LOADS, rm.Loads({"pressure": rm.Sine(0.1, 1.3),
                                       "voltage": rm.SineSquared(0.3, 2.6, phase=0.1)})),
}  # fmt: skip
#: What AUTO has and a library of FUNC alone has not.
_GETP = """
      DOUBLE PRECISION FUNCTION GETP(CODE,IC,U)
      CHARACTER(*), INTENT(IN) :: CODE
      INTEGER, INTENT(IN) :: IC
      DOUBLE PRECISION, INTENT(IN) :: U(*)
      GETP = IC*U(1)*LEN(CODE)
      END FUNCTION GETP
"""
#: Parameters that AUTO has by default.
_PARAMETERS = 36


@cache
def exported(case: str) -> dict[str, str]:
    """The files of one of the cases."""
    return rm.export(*FORCED[case], "auto07p")


@dataclass(frozen=True)
class Compiled:
    """Routines of an equations file.

    Attributes
    ----------
    library
        With the routines.
    size
        Number of entries of U.
    """

    library: ctypes.CDLL
    size: int

    def over_period(self, u: FloatArray) -> FloatArray:
        """F at U, with the parameters that STPNT gives."""
        size, double = ctypes.c_int(self.size), ctypes.c_double
        par = (double * _PARAMETERS)(*[np.nan] * _PARAMETERS)
        state, rates = (double * self.size)(*u), (double * self.size)()
        derivatives = (double * (self.size * _PARAMETERS))()
        self.library.stpnt_(ctypes.byref(size), state, par, ctypes.byref(double(0.0)))
        zero = ctypes.byref(ctypes.c_int(0))
        self.library.func_(
            ctypes.byref(size), state, zero, par, zero, rates, derivatives, derivatives
        )
        return np.array(rates)

    def boundary_values(self, first: FloatArray, last: FloatArray) -> FloatArray:
        """FB at the ends of a solution."""
        size, double = ctypes.c_int(self.size), ctypes.c_double
        values, par = (double * self.size)(), (double * _PARAMETERS)()
        ends = ((double * self.size)(*first), (double * self.size)(*last))
        zero, count = ctypes.byref(ctypes.c_int(0)), ctypes.byref(size)
        derivatives = (double * (self.size * (2 * self.size + _PARAMETERS)))()
        self.library.bcnd_(count, par, zero, count, *ends, values, zero, derivatives)
        return np.array(values)


def compiled(text: str, size: int, folder: Path) -> Compiled:
    """The equations file as it is, compiled as AUTO compiles it."""
    write({"system.f90": text, "getp.f90": _GETP}, folder)
    command = [require_program("gfortran"), "-std=legacy", "-O0", "-fPIC", "-shared",
               "-ffp-contract=off", "system.f90", "getp.f90", "-o", "system.so"]  # fmt: skip
    run_program(command, folder)
    return Compiled(ctypes.CDLL(str(folder / "system.so")), size)
