"""Master algorithms by name: which values a component is given for a step.

FMI 2.0 allows no reading between setting and stepping, so explicit algorithms pass on a value through one component a
step, and how old it is there is the algorithm's choice, its lag. The implicit algorithm repeats steps instead.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from cosim.system.algorithms import gauss_seidel, jacobi

Lag = Callable[[int, int], int]
"""From the places of source and target in the stepping order to how many steps old the passed value is."""

EXPLICIT: Mapping[str, Lag] = MappingProxyType({"jacobi": jacobi.lag, "gauss-seidel": gauss_seidel.lag})
ALGORITHMS = (*EXPLICIT, "implicit")
