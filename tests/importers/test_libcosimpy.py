"""The FMUs in libcosim, through libcosimpy.

Its fixed-step algorithm is Jacobi's: all FMUs step from t to t + H, then all outputs are passed on
(fixed_step_algorithm.cpp). Times are whole nanoseconds. In initialization mode all values are passed on as often as
there are FMUs, settled or not. Enumerations are ignored.
"""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest

from cosim.system.description import Variable
from cosim.system.structure import System
from tests.importers.container import with_law_in_container
from tests.importers.loop import nanoseconds, rounds, run
from tests.importers.structure_files import write_osp, write_ssp
from tests.importers.systems import (
    OPEN_START,
    Setting,
    assert_same_bits,
    fmu_of,
    our_run,
    outputs,
    settings,
    system_of,
)

if fmpy.platform_tuple not in ("x86_64-linux", "x86_64-windows"):
    pytest.skip("libcosimpy is built for Linux and Windows on x86-64 only", allow_module_level=True)

from libcosimpy.CosimEnums import CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

pytestmark = pytest.mark.slow

log_output_level(CosimLogLevel.WARNING)

FINE = 1.0 / 512
"""A step [s] whose multiples are exact, and a whole number of nanoseconds."""
TYPES = {"Real": CosimVariableType.REAL, "Integer": CosimVariableType.INTEGER}


def build(system: System, step_size: float) -> CosimExecution:
    """Build a system by the functions of the library."""
    execution = CosimExecution.from_step_size(round(step_size * 1e9))
    files = {part.name: str(fmu_of(system, part.name)) for part in system.components}
    places = {name: execution.add_local_slave(CosimLocalSlave(path, name)) for name, path in files.items()}
    for setting in settings(system):
        if setting.variable.type != "Enumeration":
            assert set_start(execution, places[setting.component], setting), setting
    numbers = {name: references(execution, place) for name, place in places.items()}
    for connection in system.connections:
        ends = [
            number
            for port in (connection.source, connection.target)
            for number in (places[port.component], numbers[port.component][port.variable])
        ]
        assert execution.connect_real_variables(*ends) == 0
    return execution


def set_start(execution: CosimExecution, place: int, setting: Setting) -> bool:
    """Set a value before the start; return whether the library took it."""
    reference, value = setting.variable.reference, setting.value
    match setting.variable.type:
        case "Real":
            return execution.real_initial_value(place, reference, float(value))
        case "Boolean":
            return execution.boolean_initial_value(place, reference, bool(value))
        case "String":
            return execution.string_initial_value(place, reference, str(value))
        case _:
            return execution.integer_initial_value(place, reference, int(value))


def references(execution: CosimExecution, place: int) -> dict[str, int]:
    return {variable.name.decode(): variable.reference for variable in execution.slave_variables(place)}


def observed(execution: CosimExecution, system: System, steps: int) -> dict[str, np.ndarray]:
    """Take steps and return the Real and Integer outputs, at the start and after each."""
    observer = CosimObserver.create_time_series(steps + 2)
    assert execution.add_observer(observer)
    watched: dict[str, tuple[int, Variable]] = {}
    for component, variables in outputs(system, tuple(TYPES)).items():
        place = execution.slave_index_from_instance_name(component)
        for variable in variables:
            watched[f"{component}.{variable.name}"] = place, variable
            assert observer.start_time_series(place, variable.reference, TYPES[variable.type])
    assert execution.step(steps), execution.status()
    return {name: samples(observer, place, variable, steps) for name, (place, variable) in watched.items()}


def samples(observer: CosimObserver, place: int, variable: Variable, steps: int) -> np.ndarray:
    """Return what was observed; the library takes step 0 for a missing one and drops a sample, so it is asked twice."""
    read = observer.time_series_real_samples if variable.type == "Real" else observer.time_series_integer_samples
    times, _, first = read(place, variable.reference, 0, 2)
    assert list(times) == [0]
    _, numbers, others = read(place, variable.reference, 1, steps)
    assert list(numbers) == list(range(1, steps + 1))
    return np.array([*first, *others])


@pytest.mark.parametrize(("scenario", "variant"), OPEN_START)
def test_libcosim_repeats_our_master_where_times_are_exact(scenario: str, variant: str | None) -> None:
    system = system_of(scenario, variant)
    found = observed(build(system, FINE * 8), system, 1280)
    assert_same_bits(found, our_run(scenario, variant, FINE * 8, 1280))


@pytest.mark.parametrize(("scenario", "variant"), [*OPEN_START, ("dissipative-law", "printed")])
def test_times_and_exchange_at_the_start_are_all_that_differs(scenario: str, variant: str | None) -> None:
    system = system_of(scenario, variant)
    found = observed(build(system, 0.001), system, 8000)
    assert_same_bits(found, run(system, nanoseconds(0.001, 8000), rounds(len(system.components))))


def test_systems_read_from_files_are_those_built_by_functions(tmp_path: Path) -> None:
    changes = {"law.K_w": 2500.0, "plant.c_b": 3.0, "plant.cells": 512, "plant.Omega": 12.0}
    system = system_of("wob-law", None).with_values(changes)
    built = observed(build(system, FINE), system, 4096)
    assert built["plant.cells_used"][0] == 512
    osp = write_osp(system, FINE, tmp_path)
    assert_same_bits(observed(CosimExecution.from_osp_config_file(str(osp)), system, 4096), built)
    write_ssp(system, tmp_path / "system.ssp")
    ssp = CosimExecution.from_ssp_file(str(tmp_path / "system.ssp"), round(FINE * 1e9))
    assert_same_bits(observed(ssp, system, 4096), built)


def test_enumerations_are_ignored() -> None:
    system = system_of("dissipative-law", "tracking")
    execution = build(system, 0.001)
    (form,) = [setting for setting in settings(system) if setting.variable.type == "Enumeration"]
    place = execution.slave_index_from_instance_name(form.component)
    assert not set_start(execution, place, form)
    assert form.variable.name not in references(execution, place)


def test_the_tracking_form_comes_in_a_container(tmp_path: Path) -> None:
    packed = with_law_in_container(system_of("dissipative-law", "tracking"), tmp_path, 0.001)
    found = observed(build(packed, 0.001), packed, 60000)
    start = run(packed, nanoseconds(0.001, 8000), rounds(len(packed.components)))
    assert_same_bits({name: values[:8001] for name, values in found.items()}, start)
    assert f"{found['plant.bit_speed'][-1]:.6f}" == "10.000000"
