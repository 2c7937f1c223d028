"""Runs of scenarios that fit into memory."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from cosim.assembly import assembled
from cosim.choices import Choices
from cosim.isolation.limits import Limits
from cosim.master import collect_rows
from cosim.result import Result
from cosim.scenario import Scenario
from cosim.signals import Value
from cosim.stepping.run import Progress


def simulate(
    scenario: Scenario,
    *,
    packaging: str = "native",
    algorithm: str | None = None,
    tolerance: float | None = None,
    on_failure: str | None = None,
    step_size: float | None = None,
    stop_time: float | None = None,
    overrides: Mapping[str, Value] | None = None,
    variant: str | None = None,
    progress: Progress | None = None,
    isolate: bool | Collection[str] = False,
    limits: Limits | None = None,
) -> Result:
    """Run one variant of a scenario.

    Parameters
    ----------
    scenario : Scenario
        From `cosim.load_scenario`, or made in Python.
    packaging : str
        ``"native"`` or ``"python"``: which build of the FMUs that are given by name.
    algorithm : str, optional
        ``"jacobi"``, ``"gauss-seidel"`` or ``"implicit"`` instead of the scenario's.
    tolerance : float, optional
        Of the error of a step, instead of the scenario's; the step size varies then, and `step_size` is the greatest.
    on_failure : str, optional
        ``"fail"``, ``"halve"`` or ``"explicit"``, where a loop has no solution, instead of the scenario's.
    step_size, stop_time : float, optional
        In s, instead of the scenario's.
    overrides : mapping of str to value, optional
        Parameters and input values by ``component.variable``, on top of the variant's.
    variant : str, optional
        Name of the variant; by default the first.
    progress : callable, optional
        Called now and then with the part of the run that is done, from 0 to 1.
    isolate : bool or collection of str
        Run all components, or those of these names, in processes of their own, as well as those that the scenario
        isolates. A crash there is a `LostSlaveError` here.
    limits : Limits, optional
        Of time and memory, for the isolated components.

    Returns
    -------
    Result
        Every input and output of every component: ``result["plant.bit_speed"]`` over ``result.time``.

    Raises
    ------
    InputError
        If something asked for does not exist or does not fit; no component has been initialised then.
    RunError
        If a component fails on the way.
    """
    choices = Choices(
        packaging, algorithm, tolerance, on_failure, step_size, stop_time, overrides, variant, isolate, limits
    )
    return run(scenario, choices, progress)


def run(scenario: Scenario, choices: Choices, progress: Progress | None = None) -> Result:
    """Run one variant of a scenario; as `simulate`, with the choices in one."""
    with assembled(scenario, choices) as assembly:
        result = collect_rows(assembly.master, progress)
        return Result(result.time, result.columns, result.units, assembly.record(result.record))
