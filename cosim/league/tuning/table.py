"""Show a tuning: tables to read, the parameter file that runs and leagues take, all candidates, and a figure."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from cosim.errors import printable
from cosim.files import replace_file
from cosim.league.score import Score
from cosim.league.table import cell
from cosim.league.tuning.gains import Gain
from cosim.league.tuning.search import Candidate, Tuned
from cosim.league.tuning.severity import severity
from cosim.provenance import commit
from cosim.recording.figure import blank_figure, save_figure
from cosim.scenario.parameters import write_toml

PARAMETERS, CANDIDATES, FIGURE = "parameters.toml", "candidates.csv", "tuning.png"
_TRIED, _BEFORE, _AFTER = "#9aa7b5", "#b45309", "#0b5394"


def title_of(tuned: Tuned) -> str:
    """Return a title of what has come of a tuning."""
    return f"{tuned.tuning.law.title}, gains by search"


def gain_rows(tuned: Tuned) -> Iterable[tuple[str, ...]]:
    """Return a row for each gain: what it was, what it is, and the range that was searched."""
    for gain in tuned.tuning.gains:
        after = tuned.after.values.get(gain.name, gain.start)
        yield gain.title, f"{gain.start:.4g}", f"{after:.4g}", f"{gain.low:.4g}", f"{gain.high:.4g}"


def condition_rows(tuned: Tuned) -> Iterable[tuple[str, ...]]:
    """Return a row for each condition, before and after, and one each for the severity and the margins."""
    league = tuned.tuning.league
    for condition, before, after in zip(league.conditions, tuned.before.scores, tuned.after.scores, strict=True):
        title = f"{condition.title} *" if condition.hard else condition.title
        yield title, *map(_outcome, (before, after))
    both = tuned.before, tuned.after
    yield "severity", *(f"{trial.severity:.4g}" for trial in both)
    yield "greatest reflection", *(_margin(trial, "reflection") for trial in both)
    yield "least damping [1/s]", *(_margin(trial, "damping") for trial in both)


def _outcome(score: Score) -> str:
    """Write what became of the string, and how much its bit still swings."""
    return f"{cell(score)}, SSI {score.ssi:.2g}" if score.free else cell(score)


def _margin(trial: Candidate, name: str) -> str:
    """Write a margin; a dash where none is known."""
    value = math.nan if trial.margin is None else getattr(trial.margin, name)
    return "-" if math.isnan(value) else f"{value:.4g}"


def explanations(tuned: Tuned) -> list[str]:
    """Say what the tables show, and what is to be known of them."""
    tuning, run = tuned.tuning, sum(1 for trial in tuned.trials if trial.scores)
    conditions = len(tuning.league.conditions)
    under = "1 condition" if conditions == 1 else f"{conditions} conditions"
    said = [f"{len(tuned.trials)} candidates, {run} of them run under {under}"]
    if not tuning.linear:
        said.append(f"the linear model does not know {tuning.model} with this drive: no margin was kept to")
    elif not tuned.before.kept:
        said.append("the law as it is does not keep the margin that was asked for")
    if tuned.after is tuned.before:
        said.append("no candidate is better than the law as it is")
    for gain in tuning.gains:
        value = tuned.after.values.get(gain.name)
        if value in (gain.low, gain.high):
            said.append(f"{gain.name} is at the end of its range: a wider one may give more")
    return said


def write(tuned: Tuned, folder: Path) -> list[Path]:
    """Write the parameter file, all candidates as CSV, and a figure, into a folder that is there; return the files.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    content = {PARAMETERS: _parameters(tuned).encode(), CANDIDATES: _candidates(tuned)}
    for name, written in content.items():
        replace_file(folder / name, written)
    save_figure(folder / FIGURE, lambda: _compose(tuned))
    return [folder / name for name in (*content, FIGURE)]


def _parameters(tuned: Tuned) -> str:
    """Return the parameter file, which says where its values come from."""
    tuning, law = tuned.tuning, tuned.tuning.law
    identity = tuning.identity()
    conditions = tuning.league.conditions
    where = {
        "law": law.name,
        "seed": tuning.seed,
        "budget": tuning.budget,
        "conditions": [condition.name for condition in conditions],
        "severity": {"before": tuned.before.severity, "after": tuned.after.severity},
        "ranges": {gain.name: [gain.low, gain.high] for gain in tuning.gains},
        "margin": _margins(tuned),
        "time_to_free": {
            condition.name: [_number(before.time_to_free), _number(after.time_to_free)]
            for condition, before, after in zip(conditions, tuned.before.scores, tuned.after.scores, strict=True)
        },
        "versions": {name: identity[name] for name in ("drillstring-cosim", "numpy", "scipy")},
        "commit": commit() or "unknown",
        "sha256": identity["FMUs"],
    }
    content: dict[str, Any] = {
        "name": f"{law.name}-tuned",
        "title": title_of(tuned),
        "fmu": law.fmu,
        "parameters": tuned.values,
        **({"drive": dict(law.drive)} if law.drive else {}),
        "provenance": where,
    }
    comment = (
        "Written by `cosim tune`; for `cosim run SCENARIO --parameters FILE` and `cosim league --parameters FILE`.",
        "In provenance, pairs are before and after; a time is inf where the string stays stuck.",
    )
    return write_toml(content, comment)


def _margins(tuned: Tuned) -> dict[str, Any]:
    """Return what was asked of margins, and those of the law before and after."""
    tuning = tuned.tuning
    asked: dict[str, Any] = {"most_reflection": tuning.reflection, "least_damping": tuning.damping}
    if tuned.before.margin is None or tuned.after.margin is None:
        return {"known": False}
    pair = tuned.before.margin, tuned.after.margin
    reflection, damping = [each.reflection for each in pair], [each.damping for each in pair]
    return {"known": True, **asked, "reflection": reflection, "damping": damping}


def _number(value: float) -> float:
    """Return a number as it was measured, infinite where there is none."""
    return math.inf if math.isnan(value) else value


def _candidates(tuned: Tuned) -> bytes:
    """Return all candidates as CSV, the law as it is first; nothing stands where there is no number."""
    tuning = tuned.tuning
    conditions, text = tuning.league.conditions, io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [gain.name for gain in tuning.gains]
    runs = [f"{part} {condition.name}" for condition in conditions for part in ("severity", "time_to_free")]
    writer.writerow(["candidate", *names, "reflection", "damping", "kept", "severity", *runs])
    for number, trial in enumerate((tuned.before, *tuned.trials)):
        values = [trial.values.get(gain.name, gain.start) for gain in tuning.gains]
        margin = ["", ""] if trial.margin is None else [trial.margin.reflection, trial.margin.damping]
        judge = tuning.league.judge
        each = [number for score in trial.scores for number in (severity(score, judge), score.time_to_free)]
        row = [number, *values, *margin, trial.kept, trial.severity if trial.scores else "", *each]
        writer.writerow(row)
    return text.getvalue().encode()


def _compose(tuned: Tuned) -> Any:
    """Draw the severity over each gain: what was tried, what the law had, and what it has."""
    gains = tuned.tuning.gains
    figure = blank_figure(0.6 + 3.0 * max(2, len(gains)), 3.2)
    run = [trial for trial in tuned.trials if trial.scores]
    marks = (("as it was", tuned.before, _BEFORE, "D"), ("tuned", tuned.after, _AFTER, "o"))
    for column, gain in enumerate(gains):
        panel = figure.add_subplot(1, len(gains), column + 1)
        places = [trial.values[gain.name] for trial in run]
        panel.plot(places, [trial.severity for trial in run], ".", color=_TRIED, markersize=4.0, label="tried")
        for label, trial, colour, mark in marks:
            place = trial.values.get(gain.name, gain.start)
            panel.plot([place], [trial.severity], mark, color=colour, markersize=6.0, label=label)
        _scale(panel, gain)
        panel.set_xlabel(printable(gain.title), fontsize=8)
        panel.tick_params(labelsize=7)
        panel.grid(visible=True, color="#d9d9d9", linewidth=0.5)
        panel.spines[["top", "right"]].set_visible(False)
        if column == 0:
            panel.set_ylabel("severity", fontsize=8)
            panel.legend(fontsize=7, frameon=False)
    figure.suptitle(printable(title_of(tuned)), fontsize=11, x=0.01, ha="left")
    return figure


def _scale(panel: Any, gain: Gain) -> None:
    """Show the range of a gain as it was searched, with numbers as they are written in files."""
    ends = min(gain.low, gain.start), max(gain.high, gain.start)
    if gain.low > 0.0 and ends[0] > 0.0:
        panel.set_xscale("log")
        panel.minorticks_off()
    ticks = [gain.at(part / 4.0) for part in range(5)]
    panel.set_xticks(ticks, [f"{tick:.4g}" for tick in ticks])
    panel.set_xlim(*ends)
