"""The FMUs in Ecos, through ecospy.

Its fixed-step algorithm is Jacobi's (simulation.cpp). Times are sums of steps. In initialization mode all values are
passed on as often as there are FMUs, but what is passed on last arrives after that mode only. Enumerations are ignored.
After each step Ecos sets inputs and then gets outputs once more; they must be those of the step.
"""

from __future__ import annotations

import ctypes
import sys
from importlib import metadata
from pathlib import Path

import fmpy
import numpy as np
import pytest

from cosim.system.structure import System
from tests.importers.container import with_law_in_container
from tests.importers.loop import rounds, run, sums
from tests.importers.structure_files import PARAMETER_SET, write_ssp
from tests.importers.systems import OPEN_START, assert_same_bits, fmu_of, our_run, outputs, settings, system_of

if fmpy.platform_tuple not in ("x86_64-linux", "x86_64-windows"):
    pytest.skip("ecospy holds libraries for Linux and Windows on x86-64 only", allow_module_level=True)

if sys.platform == "linux":
    # ecospy needs the TBB library of the system; the one of the package tbb will do once it is loaded
    (_tbb,) = [file for file in metadata.files("tbb") or () if file.name == "libtbb.so.12"]
    ctypes.CDLL(str(_tbb.locate()), ctypes.RTLD_GLOBAL)

from ecospy import EcosLib, EcosSimulation, EcosSimulationStructure

pytestmark = pytest.mark.slow

EcosLib.set_log_level("warn")

FINE = 1.0 / 1024
"""A step [s] whose multiples are exact."""
TYPES = ("Real", "Integer", "Boolean")


def build(system: System) -> EcosSimulationStructure:
    """Build a system by the functions of the library."""
    structure = EcosSimulationStructure()
    for part in system.components:
        structure.add_model(part.name, str(fmu_of(system, part.name)))
    for connection in system.connections:
        structure.make_real_connection(connection.source.replace(".", "::"), connection.target.replace(".", "::"))
    values = {
        f"{setting.component}::{setting.variable.name}": setting.value
        for setting in settings(system)
        if setting.variable.type != "Enumeration"
    }
    structure.add_parameter_set(PARAMETER_SET, values)
    return structure


def observed(simulation: EcosSimulation, system: System, steps: int) -> dict[str, np.ndarray]:
    """Take steps and return all outputs, at the start and after each."""
    reads = {"Real": simulation.get_real, "Integer": simulation.get_integer, "Boolean": simulation.get_bool}
    watched = {
        f"{component}.{variable.name}": (reads[variable.type], f"{component}::{variable.name}")
        for component, variables in outputs(system).items()
        for variable in variables
    }
    simulation.init(0, PARAMETER_SET)
    rows = [[read(name) for read, name in watched.values()]]
    for _ in range(steps):
        simulation.step(1)
        rows.append([read(name) for read, name in watched.values()])
    simulation.terminate()
    simulation.free()
    return {name: np.array(column) for name, column in zip(watched, zip(*rows, strict=True), strict=True)}


@pytest.mark.parametrize(("scenario", "variant"), OPEN_START)
def test_ecos_repeats_our_master_where_times_are_exact(scenario: str, variant: str | None) -> None:
    system = system_of(scenario, variant)
    found = observed(EcosSimulation(FINE * 16, structure=build(system)), system, 1280)
    assert_same_bits(found, our_run(scenario, variant, FINE * 16, 1280))


@pytest.mark.parametrize(("scenario", "variant"), [*OPEN_START, ("dissipative-law", "printed")])
def test_times_and_exchange_at_the_start_are_all_that_differs(scenario: str, variant: str | None) -> None:
    system = system_of(scenario, variant)
    found = observed(EcosSimulation(0.001, structure=build(system)), system, 8000)
    assert_same_bits(found, run(system, sums(0.001, 8000), rounds(len(system.components) - 1)))


def test_an_ssp_archive_gives_the_same_bits_as_the_functions(tmp_path: Path) -> None:
    changes = {"law.K_w": 2500.0, "plant.c_b": 3.0, "plant.cells": 512, "plant.Omega": 12.0}
    system = system_of("wob-law", None).with_values(changes)
    built = observed(EcosSimulation(FINE, structure=build(system)), system, 4096)
    assert built["plant.cells_used"][0] == 512
    write_ssp(system, tmp_path / "system.ssp")
    read = observed(EcosSimulation(FINE, ssp_path=str(tmp_path / "system.ssp")), system, 4096)
    assert_same_bits(read, built)


def test_the_tracking_form_comes_in_a_container(tmp_path: Path) -> None:
    packed = with_law_in_container(system_of("dissipative-law", "tracking"), tmp_path, 0.001)
    found = observed(EcosSimulation(0.001, structure=build(packed)), packed, 60000)
    start = run(packed, sums(0.001, 8000), rounds(len(packed.components) - 1))
    assert_same_bits({name: values[:8001] for name, values in found.items()}, start)
    assert f"{found['plant.bit_speed'][-1]:.6f}" == "10.000000"
