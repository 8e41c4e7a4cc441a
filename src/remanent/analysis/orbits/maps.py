"""What orbits and branches are made of: a map with its derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from remanent._typing import FloatArray


@dataclass(frozen=True)
class MapImage:
    """Images of some points under an iterate of a map.

    Attributes
    ----------
    state : array (point, state)
    jacobian : array (point, state, state)
        ``jacobian[k, i, j]`` is the derivative of component i by initial component j.
    parameter_jacobian : array (point, state, parameter)
        Derivatives by the parameters.
    error : array (point,)
        Estimated error of the state, and of the derivatives relative to their largest.
    state_error : array (point, state), optional
        Estimated error of each variable of the state, with its sign, of one iterate.
    jacobian_error : array (point, state, state), optional
        The same of the entries of the Jacobian.
    """

    state: FloatArray
    jacobian: FloatArray
    parameter_jacobian: FloatArray
    error: FloatArray
    state_error: FloatArray | None = None
    jacobian_error: FloatArray | None = None


class Map(Protocol):
    """A map of states that depends on parameters: the period map of a flow, or any other."""

    @property
    def dimension(self) -> int:
        """Number of state variables."""

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        """Apply the map `iterate` times to each of many points.

        Parameters
        ----------
        states : array (point, state)
        parameters : array (point, parameter)
        """
