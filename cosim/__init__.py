"""A co-simulation master for FMI 2.0 FMUs, with scenarios of drillstring stick-slip to run on it.

>>> from cosim import load_scenario, simulate
>>> result = simulate(load_scenario("stick-slip"))
>>> bit_speed = result["plant.bit_speed"]  # rad/s, at result.time
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cosim.errors import CosimError, InputError, LoopError, RunError, SlaveError
    from cosim.master import co_simulate
    from cosim.method import Method
    from cosim.result import Result
    from cosim.scenario import Scenario, Variant
    from cosim.scenario_file import load_scenario, scenario_names
    from cosim.signals import Constant, Signal, Step, Table, ramp, read_table
    from cosim.simulation import simulate
    from cosim.streaming.reading import open_trajectory
    from cosim.streaming.stream import stream
    from cosim.system import Component, Connection, PowerBond, System

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
    "Result",
    "RunError",
    "Scenario",
    "Signal",
    "SlaveError",
    "Step",
    "System",
    "Table",
    "Variant",
    "co_simulate",
    "load_scenario",
    "open_trajectory",
    "ramp",
    "read_table",
    "scenario_names",
    "simulate",
    "stream",
]

# What type checkers see above is imported when it is first asked for (PEP 562), so that `import cosim` costs nothing.
_HOMES = {
    "Component": "cosim.system",
    "Connection": "cosim.system",
    "Constant": "cosim.signals",
    "CosimError": "cosim.errors",
    "InputError": "cosim.errors",
    "LoopError": "cosim.errors",
    "Method": "cosim.method",
    "PowerBond": "cosim.system",
    "Result": "cosim.result",
    "RunError": "cosim.errors",
    "Scenario": "cosim.scenario",
    "Signal": "cosim.signals",
    "SlaveError": "cosim.errors",
    "Step": "cosim.signals",
    "System": "cosim.system",
    "Table": "cosim.signals",
    "Variant": "cosim.scenario",
    "co_simulate": "cosim.master",
    "load_scenario": "cosim.scenario_file",
    "open_trajectory": "cosim.streaming.reading",
    "ramp": "cosim.signals",
    "read_table": "cosim.signals",
    "scenario_names": "cosim.scenario_file",
    "simulate": "cosim.simulation",
    "stream": "cosim.streaming.stream",
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
