"""The command that opens the console: the page it finds, and what it says where there is none."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cosim.cli import console_page
from cosim.cli.app import app


def told(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["console", *arguments])
    return result.exit_code, result.output


@pytest.fixture
def page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The page of a checkout that lies elsewhere."""
    path = tmp_path / "build" / "console" / "console.html"
    path.parent.mkdir(parents=True)
    path.write_text("<!doctype html>", encoding="utf-8")
    monkeypatch.setattr(console_page, "build_script", lambda: tmp_path / "build_fmu.py")
    return path


def test_the_page_is_opened_and_its_place_written(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda address: not opened.append(address))
    assert told() == (0, f"{page}\n")
    assert opened == [page.as_uri()]


def test_its_place_alone_is_written_if_asked_for(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda _: pytest.fail("it opens a browser"))
    assert told("--path") == (0, f"{page}\n")


def test_without_a_browser_it_says_where_the_page_lies(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda _: False)
    code, text = told()
    assert code == 2
    assert text == f"error: no browser opens here; the console is the file {page}\n"


def test_a_checkout_without_it_says_what_builds_it(page: Path) -> None:
    page.unlink()
    assert told() == (2, "error: the console has not been built; `make console` builds it, with Node.js and npm\n")


def test_a_package_without_it_says_what_lacked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(console_page, "build_script", lambda: None)
    expected = "this package was built without the console, for want of Node.js; expected a wheel with it"
    assert told() == (2, f"error: {expected}\n")
