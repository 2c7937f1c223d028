"""How a system is stepped: the master algorithm and its settings."""

from __future__ import annotations

from dataclasses import dataclass

from cosim.algorithms import ALGORITHMS
from cosim.errors import InputError, suggestion


@dataclass(frozen=True)
class Method:
    """A master algorithm and its settings.

    Parameters
    ----------
    algorithm : str
        One of `cosim.algorithms.ALGORITHMS`.
    order : tuple of str
        Names of all components in the order in which Gauss-Seidel steps them; by default derived from what depends on
        what. Other algorithms do not need it.
    compiled : bool
        Whether steps of FMUs in this process are taken by the compiled loop, where it can be had; the loop in Python
        gives the same bits.

    Raises
    ------
    InputError
        If there is no such algorithm.
    """

    algorithm: str = "jacobi"
    order: tuple[str, ...] = ()
    compiled: bool = True

    def __post_init__(self) -> None:
        if self.algorithm not in ALGORITHMS:
            raise InputError(f"there is no algorithm '{self.algorithm}'{suggestion(self.algorithm, ALGORITHMS)}")
