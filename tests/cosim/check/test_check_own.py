"""The FMUs of dist/ pass every check and reproduce their references; an FMU of another maker is judged fairly."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from cosim.check import Group, Report, Verdict, check_fmu
from fmu_src.fmus import MODELS
from tests.reference.catalogue import folder_of

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[3]

SLAVE = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Lag(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y, self.tau, self.hidden = 1.0, 0.0, 0.5, 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("tau", causality=Fmi2Causality.parameter, variability=Fmi2Variability.fixed))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.hidden += step_size * (self.u - self.hidden) / self.tau
        self.y = self.hidden
        return True
"""


def chosen(report: Report, verdict: Verdict, group: Group | None = None) -> dict[str, str]:
    return {f.check: f.found for f in report.findings if f.verdict is verdict and group in (None, f.group)}


@pytest.mark.parametrize("model", MODELS)
def test_native_fmus_pass_every_check(model: str) -> None:
    report = check_fmu(ROOT / "dist" / "native" / f"{model}.fmu")
    assert chosen(report, Verdict.FAILED) == chosen(report, Verdict.NOTED) == {}
    experiments = {path.name.removesuffix("_ref.csv") for path in folder_of(model).glob("*_ref.csv")}
    assert bool(chosen(report, Verdict.NOT_CHECKED, Group.REFERENCE)) == (not experiments)
    assert set(chosen(report, Verdict.PASSED, Group.REFERENCE)) == experiments


@pytest.mark.parametrize("model", MODELS)
def test_python_fmus_pass_every_check_but_what_pythonfmu_cannot_refuse(model: str) -> None:
    report = check_fmu(ROOT / "dist" / "python" / f"{model}.fmu")
    assert chosen(report, Verdict.FAILED) == {}
    assert set(chosen(report, Verdict.NOTED)) == {"instantiation", "misuse"}
    if folder_of(model).is_dir():
        slopes = {"ramps"} if model == "DrillstringNeutral" else set()
        assert set(chosen(report, Verdict.NOT_CHECKED, Group.REFERENCE)) == slopes
        assert chosen(report, Verdict.PASSED, Group.REFERENCE)


def test_every_compared_variable_of_ours_has_a_stated_tolerance() -> None:
    report = check_fmu(ROOT / "dist" / "native" / "DrillstringNeutral.fmu")
    assert len({comparison.variable for comparison in report.comparisons}) == 18
    assert not any("none stated" in comparison.reason for comparison in report.comparisons)


def test_an_fmu_made_by_pythonfmu_alone_fails_where_it_breaks_a_rule(tmp_path: Path) -> None:
    (tmp_path / "lag.py").write_text(SLAVE)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "lag.py", "-d", str(tmp_path)]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    report = check_fmu(tmp_path / "Lag.fmu")
    assert set(chosen(report, Verdict.FAILED)) == {"rules"}
    assert "InitialUnknowns" in chosen(report, Verdict.FAILED)["rules"]
    assert "canGetAndSetFMUstate is not claimed" in chosen(report, Verdict.NOTED)["saved states"]


def test_a_state_that_pythonfmu_keeps_by_variables_alone_is_found_out(tmp_path: Path) -> None:
    """pythonfmu saves the variables that are registered; whatever else the slave holds is lost, without a word."""
    (tmp_path / "lag.py").write_text(SLAVE)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "lag.py", "-d", str(tmp_path), "--handle-state"]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    found = chosen(check_fmu(tmp_path / "Lag.fmu"), Verdict.FAILED)
    assert set(found) == {"rules", "saved states"}
    assert found["saved states"].startswith("restored after step 400: y at t = ")
