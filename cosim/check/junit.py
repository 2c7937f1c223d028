"""A report as JUnit XML, which CI servers show."""

from __future__ import annotations

from pathlib import Path

from junitparser.junitparser import Failure, JUnitXml, Skipped, TestCase, TestSuite

from cosim.check.verdict import Comparison, Finding, Group, Report, Verdict
from cosim.errors import OutputError


def write_junit(report: Report, path: Path) -> None:
    """Write a suite for each group of checks, and a case for each finding and each compared variable.

    Parameters
    ----------
    report : Report
        What was found.
    path : Path
        The file; its folder is made if need be.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    document = JUnitXml("cosim check")
    for group in Group:
        suite = TestSuite(f"{report.path.name}: {group.value}")
        owner = f"{report.path.stem}.{group.value}"
        suite.add_testcases([_case(finding, owner) for finding in report.findings if finding.group is group])
        if group is Group.REFERENCE:
            suite.add_testcases([_comparison(each, owner) for each in report.comparisons])
        document.add_testsuite(suite)
    document.update_statistics()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        document.write(str(path), pretty=True)  # pyright: ignore[reportUnknownMemberType]
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from None


def _case(finding: Finding, owner: str) -> TestCase:
    case = TestCase(finding.check, owner, round(finding.seconds, 3))
    sentence = _legal(f"{finding.done}: {finding.found}" + (f"; allowed: {finding.allowed}" if finding.allowed else ""))
    match finding.verdict:
        case Verdict.FAILED:
            case.result = Failure(sentence, "FAILED")
        case Verdict.NOT_CHECKED:
            case.result = Skipped(sentence, "not checked")
        case Verdict.NOTED:
            case.system_out = f"noted: {sentence}"
        case Verdict.PASSED:
            case.system_out = sentence
    return case


def _comparison(comparison: Comparison, owner: str) -> TestCase:
    case = TestCase(f"{comparison.experiment}: {comparison.variable}", owner, 0.0)
    sentence = (
        f"off by {comparison.difference:.3g} {comparison.unit} at t = {comparison.time:g} s: {comparison.result!r}, "
        f"reference {comparison.reference!r}; allowed: {comparison.allowed:.3g} ({comparison.reason}); "
        f"{comparison.points} times compared"
    )
    if comparison.verdict is Verdict.FAILED:
        case.result = Failure(_legal(sentence), "FAILED")
    else:
        case.system_out = _legal(sentence)
    return case


def _legal(text: str) -> str:
    """Replace what XML cannot hold."""
    return "".join(character if character.isprintable() or character in "\n\t" else " " for character in text)
