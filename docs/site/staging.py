"""Bring together what Sphinx is to read: pages of docs/, those at the top of the repository, and those made here."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
NOT_PAGES = ("README.md",)  # the index for those who read the sources
FOR_THE_PROJECT = {"CONTRIBUTING.md": "contributing", "CHANGELOG.md": "changelog", "SECURITY.md": "security"}
_NAMED = re.compile(r"\[(?:docs/)?[a-z-]+\.md\](?=\((?!http))")
"""A link that shows the name of a page: in the site it shows its title."""
_COMMENT = re.compile(r"(?m)^<!-- .* -->\n")
"""What is for the tests that run the pages."""
_LINK = re.compile(r"\]\(([^)\s#:]+\.(?:md|txt|cff|yml)|LICENSE)(#[^)\s]*)?\)")


def stage(folder: Path) -> None:
    """Copy pages and pictures to a folder that is not there yet, with links that lead where things are in the site."""
    for path in sorted([*DOCS.rglob("*.md"), *DOCS.rglob("*.png")]):
        place = path.relative_to(DOCS)
        if "node_modules" in place.parts or place.name in NOT_PAGES:
            continue
        target = folder / place
        target.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".md":
            target.write_text(_led(path, target.relative_to(folder)), encoding="utf-8")
        else:
            shutil.copyfile(path, target)
    for name, stem in FOR_THE_PROJECT.items():
        target = folder / "project" / f"{stem}.md"
        target.parent.mkdir(exist_ok=True)
        target.write_text(_led(ROOT / name, target.relative_to(folder)), encoding="utf-8")


def _led(path: Path, place: Path) -> str:
    """Return a page whose links to other files of the repository lead to their places in the site."""

    def there(found: re.Match[str]) -> str:
        target = (path.parent / found[1]).resolve()
        if target.parent == ROOT and target.name in FOR_THE_PROJECT:
            site = Path("project", f"{FOR_THE_PROJECT[target.name]}.md")
        elif target.is_relative_to(DOCS):
            site = target.relative_to(DOCS)
        else:
            return f"]({found[1]})"
        up = [".."] * len(place.parent.parts)
        return f"]({Path(*up, site).as_posix()}{found[2] or ''})"

    text = _COMMENT.sub("", path.read_text(encoding="utf-8"))
    return _NAMED.sub("[]", _LINK.sub(there, text))
