"""Which values a component is given before a step: the one thing in which explicit master algorithms differ.

Both step every component once from t to t + H. Jacobi gives each the outputs of the others at t. Gauss-Seidel steps the
components in order and gives each the outputs at t + H of those before it, and at t of itself and those after it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from cosim.errors import InputError, suggestion

Lag = Callable[[int, int], int]
"""From the places of source and target in the stepping order to how many steps old the passed value is."""


def jacobi(source: int, target: int) -> int:
    """Return 1: every value is from the beginning of the step."""
    del source, target
    return 1


def gauss_seidel(source: int, target: int) -> int:
    """Return 0 for a component that has been stepped already, 1 for the others."""
    return 0 if source < target else 1


ALGORITHMS: Mapping[str, Lag] = MappingProxyType({"jacobi": jacobi, "gauss-seidel": gauss_seidel})


def find_algorithm(name: str) -> Lag:
    """Return an algorithm by its name.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if name not in ALGORITHMS:
        raise InputError(f"there is no algorithm '{name}'{suggestion(name, ALGORITHMS)}")
    return ALGORITHMS[name]
