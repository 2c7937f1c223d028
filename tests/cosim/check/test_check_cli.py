"""The command `cosim check`: what it prints, what it writes, how it exits."""

from __future__ import annotations

from collections.abc import Callable
from io import StringIO
from pathlib import Path

import pytest
from junitparser import Failure, JUnitXml, Skipped
from rich.console import Console
from typer.testing import CliRunner, Result

from cosim.check import Comparison, Finding, Group, Report, Verdict
from cosim.check.report import print_report, write_junit
from cosim.cli.app import app
from cosim.errors import OutputError

Maker = Callable[..., Path]

ROOT = Path(__file__).parents[3]


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["check", *map(str, arguments)])


def printed(report: Report, width: int) -> str:
    output = StringIO()
    print_report(Console(file=output, width=width, highlight=False), report)
    return output.getvalue()


def a_report() -> Report:
    def finding(check: str, found: str, verdict: Verdict, group: Group = Group.BEHAVIOUR) -> Finding:
        return Finding(group, check, "what was done", found, "what is allowed", verdict, 0.25)

    def comparison(experiment: str, difference: float) -> Comparison:
        return Comparison(
            experiment, "bit_speed", "rad/s", 1.5, 3.0, 3.0 - difference, difference, 1e-6, 30, "promised"
        )

    findings = (
        finding("archive", "3 files", Verdict.PASSED, Group.FILE),
        finding("run", "crashed\x1b[31m in fmi2DoStep", Verdict.FAILED),
        *(finding(f"number {n}", "needs 'run', which has not passed", Verdict.NOT_CHECKED) for n in range(5)),
        finding("bounds", "accepted: a long list of values that goes on and on and on", Verdict.NOTED),
        finding("fast", "1 of 1 variables wrong", Verdict.FAILED, Group.REFERENCE),
    )
    return Report(Path("plant.fmu"), "Plant, FMI 2.0", findings, (comparison("slow", 1e-9), comparison("fast", 2e-6)))


def test_what_passes_exits_with_0_and_shows_every_check(make_suspect: Maker) -> None:
    result = run(make_suspect())
    assert result.exit_code == 0
    for words in ("archive", "schema", "saved states", "Reference experiments", "PASSED  suspect.fmu: 3"):
        assert words in result.stdout
    assert result.stderr == ""


def test_what_fails_exits_with_1(make_suspect: Maker) -> None:
    result = run(make_suspect("forgetful state"))
    assert result.exit_code == 1
    assert "restored after step 80" in result.stdout
    assert "FAILED  suspect.fmu" in result.stdout


@pytest.mark.parametrize("arguments", [["nothing.fmu"], ["suspect.fmu", "--reference", "nowhere"]])
def test_what_is_not_there_exits_with_2_and_one_sentence(
    make_suspect: Maker, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    monkeypatch.chdir(make_suspect().parent)
    result = run(*arguments)
    assert result.exit_code == 2
    assert result.stderr.startswith("error: ")
    assert len(result.stderr.strip().splitlines()) == 1


def test_options_reach_the_check(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    asked: list[tuple[object, ...]] = []

    def check(fmu: Path, reference: Path | None, *, time_limit: float, tell: object) -> Report:
        asked.append((fmu, reference, time_limit))
        return a_report()

    monkeypatch.setattr("cosim.check.check_fmu", check)
    assert run("plant.fmu", "--reference", tmp_path, "--time-limit", "1.5").exit_code == 1
    assert asked == [(Path("plant.fmu"), tmp_path, 1.5)]


def test_a_reference_folder_takes_the_place_of_what_the_fmu_holds() -> None:
    plant, folder = ROOT / "dist" / "native" / "WeightOnBitLaw.fmu", ROOT / "fmu_src" / "fmus"
    assert run(plant, "--reference", folder / "WeightOnBitLaw" / "reference").exit_code == 0
    other = run(plant, "--reference", folder / "DrillingProgram" / "reference")
    assert other.exit_code == 1
    assert "speed_initial" in other.stdout


def test_junit_file_holds_every_finding_and_every_comparison(make_suspect: Maker, tmp_path: Path) -> None:
    path = tmp_path / "reports" / "junit.xml"
    result = run(make_suspect("chatter"), "--junit", path)
    assert result.exit_code == 1
    assert f"wrote {path}" in result.stdout
    cases = {case.name: case for suite in JUnitXml.fromfile(str(path)) for case in suite}
    failed = [name for name, case in cases.items() if any(isinstance(each, Failure) for each in case.result)]
    skipped = [name for name, case in cases.items() if any(isinstance(each, Skipped) for each in case.result)]
    assert failed == ["debug logging"]
    assert "though logging is off" in cases["debug logging"].result[0].message
    assert skipped == ["sources", "experiments"]


def test_junit_file_names_experiment_variable_difference_and_reason(tmp_path: Path) -> None:
    path = tmp_path / "junit.xml"
    write_junit(a_report(), path)
    document = JUnitXml.fromfile(str(path))
    assert (document.tests, document.failures, document.skipped) == (11, 3, 5)
    case = next(case for suite in document for case in suite if case.name == "fast: bit_speed")
    message = case.result[0].message
    assert "off by 2e-06 rad/s at t = 1.5 s" in message
    assert "allowed: 1e-06 (promised)" in message
    assert "\x1b" not in path.read_text()


def test_junit_file_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        write_junit(a_report(), tmp_path / "file" / "junit.xml")


@pytest.mark.parametrize("width", [80, 109, 110, 120, 200])
def test_tables_fit_the_terminal_and_lose_nothing(width: int) -> None:
    text = printed(a_report(), width)
    assert max(map(len, text.splitlines())) <= width
    assert "\x1b" not in text
    words = " ".join(text.split())
    for found in ("3 files", "crashed [31m in fmi2DoStep", "FAILED plant.fmu: 1 passed, 2 failed, 1 noted"):
        assert found in words


def test_wide_tables_say_what_was_done_and_what_is_allowed_in_columns() -> None:
    wide = printed(a_report(), 120)
    assert wide.splitlines()[2].split() == ["check", "done", "found", "allowed", "verdict"]
    assert "what is allowed" in wide
    narrow = printed(a_report(), 80)
    assert narrow.splitlines()[2].split() == ["check", "found", "verdict"]
    assert "allowed: what is allowed" in narrow


def test_what_was_not_checked_for_one_reason_is_one_row() -> None:
    text = printed(a_report(), 120)
    assert text.count("needs 'run', which has not passed") == 1
    assert "5 checks" in text


def test_a_variable_is_shown_where_it_is_worst() -> None:
    text = printed(a_report(), 120)
    assert "fast, t = 1.5 s" in text
    assert "slow, t = 1.5 s" not in text
