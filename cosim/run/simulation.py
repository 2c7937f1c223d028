"""Run scenarios whose trajectories fit into memory."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from cosim.master.co_simulation import collect_rows
from cosim.master.run import Progress
from cosim.progress import part_shown
from cosim.recording.result import Result
from cosim.run.assembly import assembled
from cosim.run.options import OptionKeywords, RunOptions, chosen
from cosim.scenario.file import opened_scenario
from cosim.scenario.scenario import Scenario


def simulate(
    scenario: Scenario | str | Path,
    *,
    options: RunOptions | None = None,
    progress: Progress | bool | None = None,
    **keywords: Unpack[OptionKeywords],
) -> Result:
    """Run one variant of a scenario.

    Parameters
    ----------
    scenario : Scenario, str or Path
        From `cosim.load_scenario`, or made in Python; or the name of one, or the path of a .toml or .ssp file.
    options : RunOptions, optional
        How to run it.
    progress : callable or bool, optional
        Called now and then with the part of the run that is done, from 0 to 1; True: a bar is shown, False: none. By
        default there is one in notebooks and in IPython, after two seconds.
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
    isolate : bool or collection of str
        Run all components, or those of these names, in processes of their own, as well as those that the scenario
        isolates. A crash there is a `LostSlaveError` here.
    limits : Limits, optional
        Of time and memory, for the isolated components.
    components : mapping of str to function, optional
        Python functions by name of component: in place of one of the scenario's, or a new one that `connections` name.
        Inputs are its parameters by name (`time` receives the communication point that its outputs belong to), outputs
        what it returns: a mapping by name, or a number where one output is connected. It must remember nothing.
    connections : collection of Connection, optional
        In addition to the scenario's; each replaces what else drives its target.

    Returns
    -------
    Result
        Every input and output of every component: ``result["plant.bit_speed"]`` over ``result.time``. Where a component
        has asked to end the simulation, its record's ``ended`` tells which, when and why.

    Raises
    ------
    InputError
        If something asked for does not exist or does not fit; no component has been initialised then.
    RunError
        If a component fails on the way.
    """
    choice = chosen(options, keywords)
    with (
        opened_scenario(scenario, choice.stop_time, choice.step_size) as opened,
        part_shown(progress, f"simulating {opened.name}") as told,
    ):
        return run(opened, choice, told)


def run(scenario: Scenario, options: RunOptions, progress: Progress | None = None) -> Result:
    """Run one variant of a scenario; as `simulate`, with all options in one."""
    with assembled(scenario, options) as assembly:
        with assembly.undisturbed() if progress is None else nullcontext():
            result = collect_rows(assembly.master, progress)
        return replace(result, record=assembly.report(result.record).record())
