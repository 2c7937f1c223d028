"""What an FMU does beside what it claims: an honest one passes every check, one with a fault fails the check for it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.check import Finding, Group, Report, Verdict, check_fmu
from cosim.check.examination.behaviour import BEHAVIOUR

pytestmark = pytest.mark.slow

Maker = Callable[..., Path]


def behaviour(report: Report) -> dict[str, Finding]:
    return {finding.check: finding for finding in report.findings if finding.group is Group.BEHAVIOUR}


def ended(report: Report, verdict: Verdict) -> set[str]:
    return {finding.check for finding in report.findings if finding.verdict is verdict}


def test_an_honest_fmu_passes_every_check(make_suspect: Maker) -> None:
    report = check_fmu(make_suspect())
    assert list(behaviour(report)) == [check.name for check in BEHAVIOUR]
    assert {name for name, finding in behaviour(report).items() if finding.verdict is not Verdict.PASSED} == set()
    assert report.passed


FAULTS = [
    ("no instance", "instantiation", "not for you"),
    ("wrong start", "start values", "gain is 2.0; declared is 1.0"),
    ("unreadable", "value references", "z: fmi2GetReal returned fmi2Error"),
    ("null string", "value references", "name: fmi2GetString gave a null pointer"),
    ("not a number", "run", "y is nan at t = 0.51 s"),
    ("shared state", "several instances", "y at t = "),
    ("half a reset", "reset", "y at t = "),
    ("crash when freed", "ending", "crashed in fmi2FreeInstance (SIGABRT)"),
    ("starts at 0 only", "start time", "the start is not 0"),
    ("exact times", "added-up time", "s: rounded time"),
    ("fixed step", "step sizes", "fmi2DoStep returned fmi2Error at t = 0.00 s: another step size"),
    ("ignores the step size", "step sizes", "off by"),
    ("forgetful state", "saved states", "restored after step 80: y at t = 0.81 s"),
    ("crash when saved", "saved states", "crashed in fmi2GetFMUstate (SIGABRT)"),
    ("refuses states", "saved states", "fmi2GetFMUstate returned fmi2Error at t = 0.20 s: no states here"),
    ("one process only", "other process", "fmi2DeSerializeFMUstate returned fmi2Error"),
    ("ignores derivatives", "input derivatives", "u: accepted, and not used"),
    ("wrong output derivative", "output derivatives", "right at 0 % of points"),
    ("wrong partial derivative", "directional derivatives", "z by u: 2; difference quotients 1"),
    ("partial derivative nan", "directional derivatives", "z by u: nan; difference quotients 1"),
    ("undeclared category", "debug logging", "messages of undeclared category 'logGossip'"),
    ("chatter", "debug logging", "100 messages though logging is off, such as 'a step'"),
    ("crash in a step", "run", "crashed in fmi2DoStep (SIGABRT)"),
    ("end of the process", "run", "ended the process in fmi2DoStep (exit code 0)"),
]
ALSO = {
    "unreadable": {"run"},
    "forgetful state": {"serialised states"},
    "crash when saved": {"serialised states"},
    "refuses states": {"serialised states"},
}


@pytest.mark.parametrize(("fault", "check", "words"), FAULTS, ids=[fault for fault, _, _ in FAULTS])
def test_each_fault_fails_its_own_check(make_suspect: Maker, fault: str, check: str, words: str) -> None:
    report = check_fmu(make_suspect(fault))
    assert ended(report, Verdict.FAILED) == {check} | ALSO.get(fault, set())
    assert words in behaviour(report)[check].found
    assert not report.passed


@pytest.mark.parametrize(
    ("fault", "check", "words"),
    [
        ("any guid", "instantiation", "with a wrong GUID as well"),
        ("any value", "bounds", "6 of 6 accepted: u = 110.0; u = -110.0; u = nan; and 3 more"),
        ("accepts damage", "damaged states", "of 9 damaged states are accepted"),
        ("crash when damaged", "damaged states", "crashed in fmi2DeSerializeFMUstate (SIGABRT)"),
    ],
)
def test_what_no_standard_asks_is_noted_and_fails_nothing(
    make_suspect: Maker, fault: str, check: str, words: str
) -> None:
    report = check_fmu(make_suspect(fault))
    assert ended(report, Verdict.NOTED) == {check}
    assert words in behaviour(report)[check].found
    assert report.passed


@pytest.mark.parametrize(
    ("claim", "check"),
    [
        ('canGetAndSetFMUstate="true"', "saved states"),
        ('canSerializeFMUstate="true"', "serialised states"),
        ('canInterpolateInputs="true"', "input derivatives"),
        ('maxOutputDerivativeOrder="1"', "output derivatives"),
        ('providesDirectionalDerivative="true"', "directional derivatives"),
    ],
)
def test_what_works_though_it_is_not_claimed_is_noted(make_suspect: Maker, claim: str, check: str) -> None:
    report = check_fmu(make_suspect(replace={claim: ""}))
    assert check in ended(report, Verdict.NOTED)
    assert behaviour(report)[check].found == f"{claim.split('=')[0]} is not claimed, yet the call is accepted"
    assert report.passed


def test_a_state_that_is_neither_claimed_nor_given_is_as_it_should_be(make_suspect: Maker) -> None:
    claims = {'canGetAndSetFMUstate="true" canSerializeFMUstate="true"': ""}
    found = behaviour(check_fmu(make_suspect("refuses states", claims)))
    assert found["saved states"].found == found["serialised states"].found == "not claimed, and refused"
    assert found["other process"].verdict is found["damaged states"].verdict is Verdict.NOT_CHECKED


def test_steps_are_not_varied_unless_claimed(make_suspect: Maker) -> None:
    claim = {'canHandleVariableCommunicationStepSize="true"': ""}
    report = check_fmu(make_suspect("fixed step", claim))
    assert behaviour(report)["step sizes"].verdict is Verdict.NOT_CHECKED
    assert report.passed


def test_one_instance_alone_is_run_if_the_fmu_claims_no_more(make_suspect: Maker) -> None:
    claim = {'canInterpolateInputs="true"': 'canInterpolateInputs="true" canBeInstantiatedOnlyOncePerProcess="true"'}
    report = check_fmu(make_suspect("shared state", claim))
    assert ended(report, Verdict.NOT_CHECKED) >= {"several instances", "threads"}
    assert report.passed


def test_a_hanging_fmu_is_stopped_and_what_needs_it_is_not_checked(make_suspect: Maker) -> None:
    report = check_fmu(make_suspect("hang in a step"), time_limit=10.0)
    assert ended(report, Verdict.FAILED) == {"run"}
    assert behaviour(report)["run"].found == "hung in fmi2DoStep, stopped after 10 s"
    skipped = ended(report, Verdict.NOT_CHECKED)
    assert {"reset", "saved states", "misuse"} <= skipped
    assert behaviour(report)["reset"].found == "needs 'run', which has not passed"


def test_a_library_without_a_function_is_not_loaded(make_suspect: Maker) -> None:
    report = check_fmu(make_suspect(definitions=("WITHOUT_RESET",)))
    assert ended(report, Verdict.FAILED) == {"library"}
    assert "fmi2Reset" in behaviour(report)["library"].found


def test_every_check_reports_though_many_crash(make_suspect: Maker) -> None:
    report = check_fmu(make_suspect("crash when saved"))
    assert set(behaviour(report)) == {check.name for check in BEHAVIOUR}
    assert behaviour(report)["misuse"].verdict is Verdict.PASSED


def test_names_of_checks_are_told_as_they_begin(make_suspect: Maker) -> None:
    told: list[str] = []
    check_fmu(make_suspect(), tell=told.append)
    assert told[0] == "archive"
    assert "saved states" in told


def test_output_derivatives_are_not_compared_without_states_to_go_back_to(make_suspect: Maker) -> None:
    claim = {'canGetAndSetFMUstate="true"': ""}
    found = behaviour(check_fmu(make_suspect("wrong output derivative", claim)))["output derivatives"]
    assert found.verdict is Verdict.NOT_CHECKED
    assert "differences need states" in found.found


def test_an_fmu_is_told_the_tolerance_of_its_default_experiment(make_suspect: Maker) -> None:
    tolerant = {'stepSize="0.01"/>': 'stepSize="0.01" tolerance="1e-4"/>'}
    assert check_fmu(make_suspect("tolerance of 1e-4", replace=tolerant)).passed
    assert not check_fmu(make_suspect("tolerance of 1e-4")).passed
