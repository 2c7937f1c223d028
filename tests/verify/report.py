"""What is shown of laws and claims: tables for a terminal or a page, and the claims as a document."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from rich.console import Console
from rich.table import Table
from rich.text import Text

from tests.verify.claim import Verdict
from tests.verify.examination import Examined, Tried

COLORS = {Verdict.HOLDS: "green", Verdict.CONDITIONS: "yellow", Verdict.FAILS: "red"}
PREFACE = """\
# The paper's claims

What Saldivar et al. (2011) claim, what was run to see, and what came out. A claim **holds** if every trial came out as
claimed, **holds with conditions** if some did, and **does not hold** if none did. `make verify` makes this page, and a
test compares it; the laws that the computations themselves are held to are in its report.

The paper leaves $I_B$, $K_w$ and the start open. They are shown for the values tried; $I_B = 89$ kg m² and a start from
rest where nothing is said. "From the cycle" is after stick-slip has lasted for 60 s.
Periods and thresholds are explained in [theory.md](theory.md), law (9) and Proposition 1 in [energy.md](energy.md).
"""
NOT_JUDGED = """\
## Not judged

That the model is "validated" since the simulations "reflect experimental results", and what drillers' experience and
field data are said to show: the paper gives no measured data to compare with. That greater speeds at the surface may
lead to lateral vibrations: there are none in the model.
"""


def show_laws(console: Console, examined: Sequence[Examined]) -> None:
    """Print a table of laws for each section."""
    for section, group in groupby(examined, key=lambda one: one.law.section):
        table = Table(title=section, title_justify="left", title_style="bold", show_lines=True)
        for heading, ratio in (("law", 5), ("compared", 5)):
            table.add_column(heading, ratio=ratio, overflow="fold")
        for heading in ("found", "allowed"):
            table.add_column(heading, justify="right", no_wrap=True)
        table.add_column("allowed because", ratio=4, overflow="fold")
        table.add_column("verdict", no_wrap=True)
        for one in group:
            finding = one.finding
            mark = Text("holds", "green") if finding.holds else Text("BROKEN", "bold red")
            allowed = f"{number(finding.allowed)} {finding.unit}".strip()
            row = (one.law.statement, finding.compared, number(finding.found), allowed, finding.reason)
            table.add_row(*map(Text, row), mark)
        console.print(table)


def show_claims(console: Console, tried: Sequence[Tried]) -> None:
    """Print a table of the claims and their verdicts."""
    table = Table(title="Claims of the paper", title_justify="left", title_style="bold", show_lines=True)
    table.add_column("paper", no_wrap=True)
    table.add_column("claim", ratio=1, overflow="fold")
    table.add_column("as claimed", justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for one in tried:
        count = f"{sum(trial.as_claimed for trial in one.trials)} of {len(one.trials)}"
        verdict = Text(one.verdict.value, COLORS[one.verdict])
        table.add_row(Text(one.claim.source), Text(one.claim.statement), count, verdict)
    console.print(table)


def number(value: float) -> str:
    """Write an error in two digits."""
    return f"{value:.2g}"


def claims_page(tried: Sequence[Tried]) -> str:
    """Return the claims as Markdown: all verdicts, then the trials of each claim."""
    lines = [PREFACE, "| paper | claim | verdict |", "|---|---|---|"]
    for one in tried:
        link = f"[{_cell(one.claim.statement)}](#{one.claim.name.replace('_', '-')})"
        lines.append(f"| {one.claim.source} | {link} | **{one.verdict.value}** |")
    for one in tried:
        title = one.claim.name.replace("_", " ")
        lines += ["", f"## {title[0].upper()}{title[1:]}", "", f"{one.claim.source}: {one.claim.statement}.", ""]
        lines += ["| run | came out | as claimed |", "|---|---|---|"]
        for trial in one.trials:
            lines.append(
                f"| {_cell(trial.ran)} | {_cell(trial.came_out)} | {'yes' if trial.as_claimed else '**no**'} |"
            )
        lines += ["", f"**{one.verdict.value[0].upper()}{one.verdict.value[1:]}.** {one.claim.remark}".rstrip()]
    return "\n".join([*lines, "", NOT_JUDGED])


def _cell(text: str) -> str:
    """Write what would end a cell of a table as text."""
    return text.replace("|", "\\|")
