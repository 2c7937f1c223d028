"""Examine blocks that are not run: files of every format, differences of files, formulas, and what is in no format."""

from __future__ import annotations

import csv
import json
import re
import tomllib
from pathlib import Path
from xml.etree import ElementTree

import yaml
from lxml import etree

from cosim import load_scenario
from cosim.errors import CosimError
from cosim.league.entries import load_league
from cosim.scenario.parameters import load_parameters
from tests.docs.pages import Block, Page

RUN = {"sh", "python", "text"}
FILES = {"toml", "csv", "xml", "yaml", "json", "html", "diff"}
LOOKED_AT = {"math", "bibtex"}
NEVER_RUN = {"bat"}
"""Languages that nothing here runs: their blocks say why."""


def unaccounted(page: Page) -> list[str]:
    """Return what blocks of a page nothing would run, compare or examine, each with its line."""
    found: list[str] = []
    producer: Block | None = None
    for block in page.blocks:
        if not block.language:
            found.append(str(block.error("a block without a language: `text` is what shows an output")))
        elif block.language.startswith("{"):
            continue  # a directive of the site's builder
        elif block.language not in RUN | FILES | LOOKED_AT | NEVER_RUN:
            found.append(str(block.error(f"a block in {block.language}, which nothing here runs or examines")))
        elif block.language in NEVER_RUN and block.told.not_run is None:
            found.append(str(block.error(f"a block in {block.language}, which runs nowhere here, and no reason why")))
        elif block.language == "text":
            found += [str(error) for error in _of_text(block, producer)]
            producer = None
        if block.language in {"sh", "python"} and (block.language == "sh" or block.file is None):
            producer = block
    return found


def _of_text(block: Block, producer: Block | None) -> list[Exception]:
    shows_commands = block.content.startswith("$ ")
    if block.told.not_run is not None or shows_commands:
        return []
    if producer is None or producer.section != block.section:
        return [block.error("a text that no block of its section prints; what begins with `$ ` shows its own command")]
    return []


def examine(block: Block) -> None:
    """Read a block as what its language says.

    Raises
    ------
    PageError
        If it cannot be read.
    """
    reader = _READERS.get(block.language)
    if reader is None:
        return
    try:
        reader(block.content)
    except (ValueError, SyntaxError, yaml.YAMLError) as error:
        raise block.error(f"no {block.language}: {error}") from error


def examine_file(block: Block, path: Path) -> None:
    """Load a file that was written, if it is one of ours: then it names only what there is."""
    if block.language != "toml":
        return
    known = tomllib.loads(block.content)
    loaders = {"components": load_scenario, "tunes": load_league, "laws": load_league, "parameters": load_parameters}
    try:
        for key in known.keys() & loaders:
            loaders[key](path)
    except CosimError as error:
        raise block.error(str(error)) from error


def apply_diff(block: Block, folder: Path) -> None:
    """Change a file as a block says, at each place that `@@` begins: what is there before stands in the file once."""
    if block.file is None:
        raise block.error("a difference of no file: a comment `file: NAME` above it says of which")
    path = folder / block.file
    text = path.read_text(encoding="utf-8")
    for place in re.split(r"(?m)^@@.*\n", block.content):
        lines = place.splitlines()
        if any(line[:1] not in {"+", "-", " "} for line in lines):
            raise block.error(f"a line that begins with none of '+', '-' and a blank:\n{place}")
        before = "".join(f"{line[1:]}\n" for line in lines if line[0] != "+")
        after = "".join(f"{line[1:]}\n" for line in lines if line[0] != "-")
        if lines and text.count(before) != 1:
            raise block.error(f"stands {text.count(before)} times in {block.file}, not once:\n{before}")
        text = text.replace(before, after) if lines else text
    path.write_text(text, encoding="utf-8")


def _csv(text: str) -> None:
    rows = list(csv.reader(text.splitlines(), strict=True))
    widths = {len(row) for row in rows}
    if len(widths) != 1:
        raise ValueError(f"rows of {sorted(widths)} columns")


def _formula(text: str) -> None:
    """Count what has to be closed."""
    for opens, closes in ((r"\{", r"\}"), (r"\\left\b", r"\\right\b"), (r"\\begin\b", r"\\end\b")):
        if len(re.findall(opens, text)) != len(re.findall(closes, text)):
            raise ValueError(f"{opens} and {closes} are not as many")


def _html(text: str) -> None:
    """Read a fragment; what is not HTML is a SyntaxError."""
    etree.fromstring(text, etree.HTMLParser(recover=False))


def _entry(text: str) -> None:
    if not re.fullmatch(r"(?s)@\w+\{\w+,\n(  \w+ += \{.*?\},?\n)+\}\n", text):
        raise ValueError("expected an entry @kind{key, fields in braces}")
    _formula(text)


_READERS = {
    "toml": tomllib.loads,
    "csv": _csv,
    "xml": ElementTree.fromstring,
    "yaml": yaml.safe_load,
    "json": json.loads,
    "html": _html,
    "python": lambda text: compile(text, "block", "exec"),
    "math": _formula,
    "bibtex": _entry,
}
