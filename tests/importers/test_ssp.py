"""Our .ssp files, unchanged, in libcosim and Ecos: same numbers as from our master.

Both step by Jacobi's algorithm and neither is told the step size by the file. A file of ours holds a program where a
scenario has signals, so its system is compared as the file has it.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim import load_scenario, simulate
from cosim.scenario.ssp.program import as_components
from cosim.scenario.ssp.writing import export_ssp
from tests.importers.loop import nanoseconds, rounds, run, sums
from tests.importers.systems import OPEN_START, assert_same_bits, our_run, system_of
from tests.importers.test_ecospy import EcosSimulation
from tests.importers.test_ecospy import observed as observed_by_ecos
from tests.importers.test_libcosimpy import CosimExecution
from tests.importers.test_libcosimpy import observed as observed_by_libcosim

pytestmark = pytest.mark.slow

STEP = 1.0 / 64
"""A step [s] whose multiples are exact and whole nanoseconds."""
STEPS = 640


@pytest.fixture
def file(scenario: str, variant: str | None, tmp_path: Path) -> str:
    """A scenario as an .ssp file."""
    export_ssp(load_scenario(scenario), tmp_path / "system.ssp", variant=variant)
    return str(tmp_path / "system.ssp")


@pytest.mark.parametrize(("scenario", "variant"), OPEN_START)
def test_libcosim_gives_the_bits_of_our_master(scenario: str, variant: str | None, file: str) -> None:
    execution = CosimExecution.from_ssp_file(file, round(STEP * 1e9))
    found = observed_by_libcosim(execution, system_of(scenario, variant), STEPS)
    assert_same_bits(found, our_run(scenario, variant, STEP, STEPS))


@pytest.mark.parametrize(("scenario", "variant"), [*OPEN_START, ("dissipative-law", "printed")])
def test_times_and_exchange_at_the_start_are_all_that_differs_in_libcosim(
    scenario: str, variant: str | None, file: str
) -> None:
    system, _ = as_components(system_of(scenario, variant))
    execution = CosimExecution.from_ssp_file(file, 1_000_000)
    found = observed_by_libcosim(execution, system, 4000)
    assert_same_bits(found, run(system, nanoseconds(0.001, 4000), rounds(len(system.components))))


@pytest.mark.parametrize(("scenario", "variant"), OPEN_START)
def test_ecos_gives_the_bits_of_our_master(scenario: str, variant: str | None, file: str) -> None:
    simulation = EcosSimulation(STEP, ssp_path=file)
    found = observed_by_ecos(simulation, system_of(scenario, variant), STEPS)
    assert_same_bits(found, our_run(scenario, variant, STEP, STEPS))


@pytest.mark.parametrize(("scenario", "variant"), [*OPEN_START, ("dissipative-law", "printed")])
def test_times_and_exchange_at_the_start_are_all_that_differs_in_ecos(
    scenario: str, variant: str | None, file: str
) -> None:
    system, _ = as_components(system_of(scenario, variant))
    found = observed_by_ecos(EcosSimulation(0.001, ssp_path=file), system, 4000)
    assert_same_bits(found, run(system, sums(0.001, 4000), rounds(len(system.components) - 1)))


def test_parameters_arrive(tmp_path: Path) -> None:
    changes = {"law.K_w": 2500.0, "plant.c_b": 3.0, "plant.cells": 512, "plant.Omega": 12.0}
    scenario, file = load_scenario("wob-law"), str(tmp_path / "system.ssp")
    export_ssp(scenario, tmp_path / "system.ssp", overrides=changes)
    system = scenario.system
    ours = simulate(scenario, overrides=changes, algorithm="jacobi", step_size=STEP, stop_time=STEPS * STEP)
    assert ours["plant.cells_used"][0] == 512
    execution = CosimExecution.from_ssp_file(file, round(STEP * 1e9))
    assert_same_bits(observed_by_libcosim(execution, system, STEPS), ours)
    assert_same_bits(observed_by_ecos(EcosSimulation(STEP, ssp_path=file), system, STEPS), ours)
