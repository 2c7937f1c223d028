"""A co-simulation master for FMI 2.0 FMUs, with scenarios of drillstring stick-slip to run on it.

>>> from cosim import load_scenario, simulate
>>> result = simulate(load_scenario("stick-slip"))
>>> bit_speed = result["plant.bit_speed"]  # rad/s, at result.time
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cosim.drilling.sensitivity import sobol_indices
    from cosim.errors import CosimError, InputError, LoopError, RunError, SlaveError
    from cosim.master.co_simulation import co_simulate
    from cosim.recording.figure import View, plot
    from cosim.recording.result import Result
    from cosim.run.opened import open_run, open_variants
    from cosim.run.options import RunOptions
    from cosim.run.simulation import simulate
    from cosim.run.stream import stream
    from cosim.run.trajectory import open_trajectory
    from cosim.scenario.file import load_scenario, scenario_names
    from cosim.scenario.scenario import Scenario, Variant
    from cosim.sweeps.reading import open_series, open_sweep, quantile_bands
    from cosim.sweeps.sweep import sweep
    from cosim.system.method import Method
    from cosim.system.signals import Constant, Ramp, Signal, Step, Table, ramp
    from cosim.system.structure import Component, Connection, PowerBond, System
    from cosim.system.table_file import read_column, read_table

    __version__: str

__all__ = [
    "Component",
    "Connection",
    "Constant",
    "CosimError",
    "InputError",
    "LoopError",
    "Method",
    "PowerBond",
    "Ramp",
    "Result",
    "RunError",
    "RunOptions",
    "Scenario",
    "Signal",
    "SlaveError",
    "Step",
    "System",
    "Table",
    "Variant",
    "View",
    "co_simulate",
    "load_scenario",
    "open_run",
    "open_series",
    "open_sweep",
    "open_trajectory",
    "open_variants",
    "plot",
    "quantile_bands",
    "ramp",
    "read_column",
    "read_table",
    "scenario_names",
    "simulate",
    "sobol_indices",
    "stream",
    "sweep",
]

# What type checkers see above is imported when it is first asked for (PEP 562), so that `import cosim` costs nothing.
_HOMES = {
    "Component": "cosim.system.structure",
    "Connection": "cosim.system.structure",
    "Constant": "cosim.system.signals",
    "CosimError": "cosim.errors",
    "InputError": "cosim.errors",
    "LoopError": "cosim.errors",
    "Method": "cosim.system.method",
    "PowerBond": "cosim.system.structure",
    "Ramp": "cosim.system.signals",
    "Result": "cosim.recording.result",
    "RunError": "cosim.errors",
    "RunOptions": "cosim.run.options",
    "Scenario": "cosim.scenario.scenario",
    "Signal": "cosim.system.signals",
    "SlaveError": "cosim.errors",
    "Step": "cosim.system.signals",
    "System": "cosim.system.structure",
    "Table": "cosim.system.signals",
    "Variant": "cosim.scenario.scenario",
    "View": "cosim.recording.figure",
    "co_simulate": "cosim.master.co_simulation",
    "load_scenario": "cosim.scenario.file",
    "open_run": "cosim.run.opened",
    "open_series": "cosim.sweeps.reading",
    "open_sweep": "cosim.sweeps.reading",
    "open_trajectory": "cosim.run.trajectory",
    "open_variants": "cosim.run.opened",
    "plot": "cosim.recording.figure",
    "quantile_bands": "cosim.sweeps.reading",
    "ramp": "cosim.system.signals",
    "read_column": "cosim.system.table_file",
    "read_table": "cosim.system.table_file",
    "scenario_names": "cosim.scenario.file",
    "simulate": "cosim.run.simulation",
    "sobol_indices": "cosim.drilling.sensitivity",
    "stream": "cosim.run.stream",
    "sweep": "cosim.sweeps.sweep",
}


def __getattr__(name: str) -> object:
    """Import what the package exports, from where it is defined; or tell the installed version."""
    if name == "__version__":
        from importlib.metadata import version

        value: object = version("drillstring-cosim")
    elif name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List what is imported already and what is not yet."""
    return sorted({*globals(), *_HOMES, "__version__"})
