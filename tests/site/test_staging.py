"""Pages written for those who read the sources lead where things are in the site."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from docs.site import staging


@pytest.fixture
def staged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository of a few pages, staged."""
    root = tmp_path / "repository"
    pages = {
        "CONTRIBUTING.md": "[docs/model.md](docs/model.md#waves) and [a licence](LICENSE)",
        "CHANGELOG.md": "[x](https://example.org/docs/model.md)",
        "SECURITY.md": "nothing",
        "docs/README.md": "the index of the sources",
        "docs/model.md": "<!-- not run: why -->\n"
        "[how to work on it](../CONTRIBUTING.md#set-up), [theory.md](theory.md), [here](#waves)",
        "docs/howto/fmpy.md": "[model.md](../model.md), [to work](../../CONTRIBUTING.md)",
    }
    for name, text in pages.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    monkeypatch.setattr(staging, "ROOT", root)
    monkeypatch.setattr(staging, "DOCS", root / "docs")
    staging.stage(tmp_path / "source")
    return tmp_path / "source"


def links(page: Path) -> list[str]:
    return re.findall(r"\[.*?\]\(.*?\)", page.read_text(encoding="utf-8"))


def test_links_to_what_is_beside_docs_lead_to_its_place_in_the_site(staged: Path) -> None:
    assert links(staged / "model.md")[0] == "[how to work on it](project/contributing.md#set-up)"
    assert links(staged / "howto" / "fmpy.md")[1] == "[to work](../project/contributing.md)"


def test_links_from_what_is_beside_docs_lead_into_it(staged: Path) -> None:
    assert links(staged / "project" / "contributing.md") == ["[](../model.md#waves)", "[a licence](LICENSE)"]


def test_a_link_that_shows_the_name_of_a_page_shows_its_title(staged: Path) -> None:
    assert links(staged / "model.md")[1:] == ["[](theory.md)", "[here](#waves)"]
    assert links(staged / "howto" / "fmpy.md")[0] == "[](../model.md)"


def test_comments_for_the_tests_stay_out_of_the_site(staged: Path) -> None:
    assert "not run" not in (staged / "model.md").read_text(encoding="utf-8")


def test_links_elsewhere_and_the_index_of_the_sources_are_left(staged: Path) -> None:
    assert links(staged / "project" / "changelog.md") == ["[x](https://example.org/docs/model.md)"]
    assert not (staged / "README.md").exists()
