"""What may be chosen for a run of a scenario."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from cosim.fmi2.isolation import Limits
from cosim.system.signals import Value


@dataclass(frozen=True)
class Choices:
    """Choices for a run; None leaves the scenario's own.

    Parameters
    ----------
    packaging : str
        ``"native"`` or ``"python"``: which build of the FMUs that are given by name.
    algorithm : str, optional
        ``"jacobi"``, ``"gauss-seidel"`` or ``"implicit"``.
    tolerance : float, optional
        Of the error of a step; the step size varies then, and `step_size` is the greatest.
    on_failure : str, optional
        ``"fail"``, ``"halve"`` or ``"explicit"``, where a loop has no solution.
    step_size, stop_time : float, optional
        In s.
    overrides : mapping of str to value, optional
        Parameters and input values by ``component.variable``, on top of the variant's.
    variant : str, optional
        Name of the variant; by default the first.
    isolate : bool or collection of str
        Run all components, or those of these names, in processes of their own, as well as those that the scenario
        isolates.
    limits : Limits, optional
        Of time and memory, for the isolated components.
    """

    packaging: str = "native"
    algorithm: str | None = None
    tolerance: float | None = None
    on_failure: str | None = None
    step_size: float | None = None
    stop_time: float | None = None
    overrides: Mapping[str, Value] | None = None
    variant: str | None = None
    isolate: bool | Collection[str] = False
    limits: Limits | None = None
