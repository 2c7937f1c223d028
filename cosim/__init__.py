"""A co-simulation master for FMI 2.0 FMUs, with scenarios of drillstring stick-slip to run on it.

>>> from cosim import load_scenario, simulate
>>> result = simulate(load_scenario("stick-slip"))
>>> bit_speed = result["plant.bit_speed"]  # rad/s, at result.time
"""

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
