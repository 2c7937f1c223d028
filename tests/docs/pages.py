"""Read a page of the documentation: its blocks of code, what is said of them, and the code within its prose."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from markdown_it import MarkdownIt
from markdown_it.token import Token

ROOT = Path(__file__).parents[2]
CONTAINERS = {"note", "tip", "hint", "important", "warning", "admonition", "dropdown", "details", "tab-item", "tab-set"}
"""Directives of the site's builder that hold Markdown, in which there may be blocks of code again."""


class PageError(Exception):
    """Say where a page is wrong, and how."""

    def __init__(self, path: Path, line: int, what: str) -> None:
        within = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else path.name
        super().__init__(f"{within}:{line}: {what}")


@dataclass(frozen=True)
class Told:
    """What the comments above a block tell of it; CONTRIBUTING.md has their grammar."""

    not_run: str | None = None
    left_out: tuple[str, ...] = ()
    replaced: tuple[tuple[str, str], ...] = ()
    file: str | None = None
    figures_differ: str | None = None
    interrupted_once: str | None = None


@dataclass(frozen=True)
class Block:
    """A block of code: where it begins, in which language, and what stands in it."""

    path: Path
    line: int
    language: str
    content: str
    told: Told
    section: int
    named: str | None
    """The file that the paragraph above ends with, if it does."""

    @property
    def file(self) -> str | None:
        return self.told.file or self.named

    def error(self, what: str) -> PageError:
        return PageError(self.path, self.line, what)


@dataclass(frozen=True)
class Page:
    path: Path
    blocks: tuple[Block, ...]
    inline: tuple[tuple[int, str], ...] = field(repr=False)
    """Code within the prose, with the line its paragraph begins at."""

    @property
    def name(self) -> str:
        return self.path.relative_to(ROOT).as_posix()


def all_pages() -> list[Path]:
    """Return every page there is, of the checkout's top and below docs/, but for what others have put or made there."""
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    inside = {page: page.relative_to(ROOT).parts for page in pages}
    return sorted(page for page, parts in inside.items() if not any(p[0] in "._" or p == "node_modules" for p in parts))


def read_page(path: Path) -> Page:
    reading = _Reading(path)
    reading.read(path.read_text(encoding="utf-8"), 1)
    return Page(path, tuple(reading.blocks), tuple(reading.inline))


class _Reading:
    """One pass over a page, which remembers what stood directly above."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.blocks: list[Block] = []
        self.inline: list[tuple[int, str]] = []
        self.section = 0
        self.comments: list[tuple[int, str]] = []
        self.paragraph: Token | None = None

    def read(self, text: str, first_line: int) -> None:
        for token in MarkdownIt("commonmark").enable("table").parse(text):
            line = first_line + (token.map[0] if token.map else 0)
            match token.type:
                case "html_block":
                    self.comments += [(line, comment) for comment in re.findall(r"(?s)<!--(.*?)-->", token.content)]
                case "fence" | "code_block":
                    self._block(token, line)
                case "inline":
                    self.paragraph, self.comments = token, []
                    codes = (child.content for child in token.children or () if child.type == "code_inline")
                    self.inline += [(line, code) for code in codes]
                case "heading_open":
                    self.section += 1
                    self.paragraph = None
                case _:
                    pass

    def _block(self, token: Token, line: int) -> None:
        language, _, rest = token.info.strip().partition(" ")
        if re.fullmatch(r"\{[\w:-]+\}", language):
            language = language[1:-1]
            if language in CONTAINERS:
                self.read(token.content, line + 1)
                return
            language = {"code-block": rest.strip(), "code-cell": "python"}.get(language, f"{{{language}}}")
        told = _told(self.path, self.comments)
        block = Block(self.path, line, language, token.content, told, self.section, self._named(language))
        self.blocks.append(block)
        self.paragraph, self.comments = None, []

    def _named(self, language: str) -> str | None:
        """Return the file that the paragraph above ends with, as in "`law.py`:"."""
        children: Sequence[Token] = (self.paragraph and self.paragraph.children) or ()
        children = [child for child in children if child.content.strip() not in {"", ":", "."}]
        last = children[-1] if children else None
        suffix = {"python": ".py"}.get(language, f".{language}")
        named = last is not None and last.type == "code_inline" and re.fullmatch(r"[\w./-]+", last.content)
        return last.content if named and last and last.content.endswith(suffix) else None


def _told(path: Path, comments: Sequence[tuple[int, str]]) -> Told:
    """Read the comments above a block.

    Raises
    ------
    PageError
        If one of them says nothing that is known.
    """
    known: dict[str, object] = {}
    left_out: list[str] = []
    for line, comment in comments:
        text = " ".join(comment.split())
        if found := re.fullmatch(r'not run "([^"]+)": (.+)', text):
            left_out.append(found[1])
        elif found := re.fullmatch(r"not run: (.+)", text):
            known["not_run"] = found[1]
        elif found := re.fullmatch(r"run with (.+)", text):
            known["replaced"] = tuple(_replacements(path, line, found[1]))
        elif found := re.fullmatch(r"file: (\S+)", text):
            known["file"] = found[1]
        elif found := re.fullmatch(r"figures differ: (.+)", text):
            known["figures_differ"] = found[1]
        elif found := re.fullmatch(r"interrupted once (\S+) is there", text):
            known["interrupted_once"] = found[1]
        else:
            raise PageError(path, line, f"the comment {text!r} above a block says nothing that is known")
    return Told(left_out=tuple(left_out), **known)  # type: ignore[arg-type]


def _replacements(path: Path, line: int, text: str) -> Iterator[tuple[str, str]]:
    for part in text.split("; "):
        shown, found, run = part.partition(" as ")
        if not found:
            raise PageError(path, line, f"expected `run with SHOWN as RUN; ...`, got {part!r}")
        yield shown, run
