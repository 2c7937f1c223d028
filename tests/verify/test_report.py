"""The command: what it prints, and what its exit code says."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from tests.verify import __main__ as command
from tests.verify.claim import Claim, Trial
from tests.verify.finding import Finding, Law, greatest


def app() -> typer.Typer:
    made = typer.Typer()
    made.command()(command.main)
    return made


def law(found: float) -> Law:
    return Law("a_law", "Things are as they are", "Things", lambda: Finding("two things", found, 1.0, "rounding", "m"))


CLAIM = Claim("a_claim", "All is |well|", "Fig. 1", "It depends.", lambda: [Trial("this", "so", True)])


@pytest.fixture(autouse=True)
def page(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    (tmp_path / "docs").mkdir()
    monkeypatch.setattr(command, "PAGE", tmp_path / "docs" / "claims.md")
    monkeypatch.setattr(command, "CLAIMS", [CLAIM])
    monkeypatch.setattr(command, "LAWS", [law(0.5)])
    assert CliRunner().invoke(app(), ["--write-claims"]).exit_code == 0
    return command.PAGE


def test_all_laws_hold_and_the_page_is_current(page: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(app(), ["--html", str(tmp_path / "report.html")])
    assert result.exit_code == 0, result.output
    for text in ("Things are as they are", "two things", "0.5", "1 m", "rounding", "holds", "1 of 1 laws hold"):
        assert text in result.output
    assert "Things are as they are" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert r"| Fig. 1 | [All is \|well\|](#a-claim) | **holds** |" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("found", [1.5, math.nan, math.inf])
def test_a_broken_law_is_told_and_fails_the_command(found: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "LAWS", [law(0.5), law(found)])
    result = CliRunner().invoke(app(), [])
    assert result.exit_code == 1
    assert "BROKEN" in result.output
    assert "1 of 2 laws hold" in result.output


def unfinished() -> list[Trial]:
    raise ArithmeticError("bit neither sticks nor slips")


def test_a_law_that_raises_is_broken_and_the_others_are_examined(monkeypatch: pytest.MonkeyPatch) -> None:
    raising = Law("a_law", "Nothing is lost", "Things", unfinished)  # pyright: ignore[reportArgumentType]
    monkeypatch.setattr(command, "LAWS", [raising, law(0.5)])
    result = CliRunner().invoke(app(), [])
    assert result.exit_code == 1
    assert isinstance(result.exception, SystemExit)
    assert "BROKEN" in result.output
    assert "1 of 2 laws hold" in result.output
    assert "ArithmeticError: bit neither sticks nor slips" in " ".join(
        cell.strip() for line in result.output.splitlines() for cell in line.split("│")[2:3]
    )


def test_a_claim_that_raises_came_out_as_nothing_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(command, "CLAIMS", [replace(CLAIM, try_it=unfinished)])
    result = CliRunner().invoke(app(), [])
    assert result.exit_code == 1
    assert "does not hold" in result.output
    assert "docs/claims.md is not what came out" in result.output


def test_claims_that_came_out_differently_fail_the_command(page: Path) -> None:
    page.write_text(page.read_text(encoding="utf-8").replace("| so |", "| otherwise |"), encoding="utf-8")
    result = CliRunner().invoke(app(), [])
    assert result.exit_code == 1
    assert "docs/claims.md is not what came out" in result.output


def test_no_number_is_the_greatest_error() -> None:
    assert math.isnan(greatest([0.0, [1.0, math.nan], 2.0]))
    assert greatest([[-3.0, 2.0], 1.0]) == 3.0
