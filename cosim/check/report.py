"""Show a report: as tables for the terminal, and as JUnit XML for CI servers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from junitparser.junitparser import Failure, JUnitXml, Skipped, TestCase, TestSuite
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from cosim.check.verdict import Comparison, Finding, Group, Report, Verdict
from cosim.errors import OutputError

WIDE = 110
"""Columns from which on there is room for what was done and what is allowed."""

INDENT = "  "
_MANY = 2

_STYLES = {
    Verdict.PASSED: "green",
    Verdict.FAILED: "bold red",
    Verdict.NOTED: "yellow",
    Verdict.NOT_CHECKED: "dim",
}
_TITLES = {
    Group.FILE: "File",
    Group.DESCRIPTION: "modelDescription.xml",
    Group.BEHAVIOUR: "What the FMU does",
    Group.REFERENCE: "Reference experiments",
}


def print_report(console: Console, report: Report) -> None:
    """Print a report: every finding, every compared variable where it is worst, and the verdict.

    Parameters
    ----------
    console : rich.console.Console
        Its width decides the layout.
    report : Report
        From `cosim.check.check_fmu`.
    """
    console.print(Text.assemble((str(report.path), "bold"), f"\n{_clean(report.title)}"))
    console.print(_findings(report.findings, wide=console.width >= WIDE))
    if report.comparisons:
        worst = _worst(report.comparisons)
        console.print(_comparisons(worst))
        console.print(_reasons(worst))
    console.print(_summary(report))


def _findings(findings: Iterable[Finding], *, wide: bool) -> Table:
    table = _table()
    table.add_column("check", no_wrap=True)
    if wide:
        table.add_column("done", ratio=29, overflow="fold")
    table.add_column("found", ratio=36, overflow="fold")
    if wide:
        table.add_column("allowed", ratio=19, overflow="fold")
    table.add_column("verdict", no_wrap=True)
    for group, title in _TITLES.items():
        chosen = [finding for finding in findings if finding.group is group]
        if chosen:
            table.add_row()
            table.add_row(Text(title, style="bold cyan"))
        for finding in _gathered(chosen):
            table.add_row(*_row(finding, wide=wide), _verdict(finding.verdict))
    table.add_row()
    return table


def _gathered(findings: Sequence[Finding]) -> list[Finding]:
    """Put what was not checked for one and the same reason into one row."""
    alike: dict[str, list[Finding]] = {}
    for finding in findings:
        if finding.verdict is Verdict.NOT_CHECKED:
            alike.setdefault(finding.found, []).append(finding)
    rows: list[Finding] = []
    for finding in findings:
        same = alike.get(finding.found, []) if finding.verdict is Verdict.NOT_CHECKED else []
        if len(same) <= _MANY:
            rows.append(finding)
        elif finding is same[0]:
            rows.append(replace(finding, check=f"{len(same)} checks", done=f"{finding.check} to {same[-1].check}"))
    return rows


def _table() -> Table:
    return Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0), expand=True)


def _row(finding: Finding, *, wide: bool) -> list[Text]:
    found, allowed = Text(_clean(finding.found)), _clean(finding.allowed)
    if finding.verdict is Verdict.NOT_CHECKED:
        found.stylize("dim")
    check = Text(f"{INDENT}{_clean(finding.check)}")
    if wide:
        return [check, Text(_clean(finding.done), style="dim"), found, Text(allowed, style="dim")]
    if finding.verdict is Verdict.PASSED:
        return [check, found]
    beyond = "".join(f"\n{what}: {text}" for what, text in (("done", finding.done), ("allowed", allowed)) if text)
    return [check, Text.assemble(found, (beyond, "dim"))]


def _verdict(verdict: Verdict) -> Text:
    text = verdict.value.upper() if verdict is Verdict.FAILED else verdict.value
    return Text(text, style=_STYLES[verdict])


def _worst(comparisons: Iterable[Comparison]) -> list[Comparison]:
    """Return for each variable where it is worst."""
    worst: dict[str, Comparison] = {}
    for comparison in comparisons:
        before = worst.get(comparison.variable)
        if before is None or comparison.share > before.share:
            worst[comparison.variable] = comparison
    return list(worst.values())


def _comparisons(comparisons: Iterable[Comparison]) -> Table:
    table = _table()
    for heading in ("variable", "off by", "allowed"):
        table.add_column(heading, no_wrap=True)
    table.add_column("where", ratio=1, overflow="fold")
    table.add_column("verdict", no_wrap=True)
    for each in comparisons:
        amounts = (_amount(each.difference, each.unit), _amount(each.allowed, each.unit))
        row = (INDENT + each.variable, *amounts, f"{each.experiment}, t = {each.time:g} s")
        table.add_row(*map(Text, row), _verdict(each.verdict))
    table.add_row()
    return table


def _reasons(comparisons: Iterable[Comparison]) -> Table:
    """Tabulate why so much is allowed, variables with the same reason together."""
    together: dict[str, list[str]] = {}
    for each in comparisons:
        together.setdefault(_clean(each.reason), []).append(each.variable)
    table = _table()
    table.add_column("variables", overflow="fold", ratio=2)
    table.add_column("why so much is allowed", overflow="fold", ratio=3)
    for reason, variables in together.items():
        table.add_row(Padding(", ".join(variables), (0, 0, 0, len(INDENT))), Text(reason, style="dim"))
    table.add_row()
    return table


def _amount(number: float, unit: str) -> str:
    return f"{number:.2g} {unit}".rstrip() if number else "0"


def _summary(report: Report) -> Text:
    counts = ", ".join(f"{report.count(verdict)} {verdict.value}" for verdict in Verdict if report.count(verdict))
    verdict = Verdict.PASSED if report.passed else Verdict.FAILED
    return Text.assemble((verdict.value.upper(), _STYLES[verdict]), f"  {report.path.name}: {counts}")


def _clean(text: str) -> str:
    """Keep what an FMU says from steering the terminal."""
    return "".join(character if character.isprintable() else " " for character in text)


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
