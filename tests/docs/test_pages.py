"""The documentation is true: its blocks run, print what it shows, and name only what there is."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.docs import formats
from tests.docs.commands import wrong_on
from tests.docs.pages import Page, all_pages, read_page
from tests.docs.session import Session

PAGES = [read_page(path) for path in all_pages()]

QUICK = {f"docs/{name}.md" for name in ("energy", "tools", "untrusted")}
"""Pages that take a moment though they run something; all others that do are slow."""


def runs_something(page: Page) -> bool:
    return any(block.language in {"sh", "python", "text"} and block.told.not_run is None for block in page.blocks)


def costs(page: Page) -> tuple[pytest.MarkDecorator, ...]:
    return (pytest.mark.slow,) if runs_something(page) and page.name not in QUICK else ()


def named(page: Page) -> str:
    return page.name


TO_RUN = [pytest.param(page, marks=costs(page), id=page.name) for page in PAGES if page.blocks]


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_block_is_accounted_for(page: Page) -> None:
    assert "\n".join(formats.unaccounted(page)) == ""


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_commands_options_and_files_exist(page: Page) -> None:
    assert "\n".join(wrong_on(page)) == ""


@pytest.mark.skipif(sys.platform == "win32", reason="pages speak to the shell of Unix")
@pytest.mark.parametrize("page", TO_RUN)
def test_blocks_run_and_print_what_the_page_shows(page: Page, tmp_path: Path) -> None:
    with Session(page, tmp_path) as session:
        session.run()


def test_quick_pages_are_pages_that_run_something() -> None:
    assert {page.name for page in PAGES if runs_something(page)} >= QUICK
