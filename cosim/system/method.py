"""State how a system is stepped: the master algorithm and its settings.

FMI 2.0 allows no reading between setting and stepping, so explicit algorithms pass on a value through one component a
step, and how old it is there is the algorithm's choice, its lag. The implicit algorithm repeats steps instead.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from cosim.errors import InputError, suggestion

Lag = Callable[[int, int], int]
"""From the places of source and target in the stepping order to how many steps old the passed value is."""


def _jacobi(source: int, target: int) -> int:
    """Give every component what the others put out at the beginning of the step: always one step old."""
    del source, target
    return 1


def _gauss_seidel(source: int, target: int) -> int:
    """Give every component what those before it in the order put out at the end of the step; the rest is a step old."""
    return 0 if source < target else 1


EXPLICIT: Mapping[str, Lag] = MappingProxyType({"jacobi": _jacobi, "gauss-seidel": _gauss_seidel})
"""Explicit algorithms; what is added here can be run, in C, in Python, and with steps of variable size."""
ALGORITHMS = (*EXPLICIT, "implicit")
ON_FAILURE = ("fail", "halve", "explicit")


@dataclass(frozen=True)
class Method:
    """A master algorithm and its settings.

    Parameters
    ----------
    algorithm : str
        One of `cosim.system.method.ALGORITHMS`.
    order : tuple of str
        Names of all components in the order in which Gauss-Seidel steps them; by default derived from what depends on
        what. Other algorithms do not need it.
    tolerance : float, optional
        Of the error of a step, relative to the greater of value and nominal value. With it, the communication step size
        varies; without it, nothing is known of the error.
    on_failure : str
        What to do when a loop of the implicit algorithm has no solution: ``"fail"``, ``"halve"`` the step, or go on
        with an ``"explicit"`` one.
    iteration_tolerance : float
        How well the values of a loop agree in the end, relative to the greater of value and nominal value.
    compiled : bool
        Whether explicit steps of given size are taken by the compiled loop, where it can be had and every component is
        an FMU in this process; the loop in Python gives the same bits.

    Raises
    ------
    InputError
        If there is no such algorithm, or a setting makes no sense.
    """

    algorithm: str = "jacobi"
    order: tuple[str, ...] = ()
    tolerance: float | None = None
    on_failure: str = "fail"
    iteration_tolerance: float = 1e-9
    compiled: bool = True

    def __post_init__(self) -> None:
        if self.algorithm not in ALGORITHMS:
            raise InputError(f"there is no algorithm '{self.algorithm}'{suggestion(self.algorithm, ALGORITHMS)}")
        if self.on_failure not in ON_FAILURE:
            raise InputError(f"on_failure is '{self.on_failure}'{suggestion(self.on_failure, ON_FAILURE)}")
        for name in ("tolerance", "iteration_tolerance"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < 1.0:
                raise InputError(f"{name} is {value:g}; expected a number > 0 and < 1")

    @property
    def lag(self) -> Lag | None:
        """The lag of an explicit algorithm; None for one that repeats steps until values agree."""
        return EXPLICIT.get(self.algorithm)

    @property
    def implicit(self) -> bool:
        """Tell whether steps are repeated until values agree."""
        return self.lag is None

    @property
    def takes_back(self) -> bool:
        """Tell whether a whole step may be rejected to try a smaller one."""
        return self.tolerance is not None or (self.implicit and self.on_failure == "halve")
