"""The site of the documentation: made without a complaint, twice to the same bytes, asking nobody."""

from __future__ import annotations

import inspect
import os
import re
import shutil
import subprocess
import sys
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

import pytest
import typer
from lxml import html

from cosim.cli.app import app
from docs.site.__main__ import make
from docs.site.python_pages import PUBLIC, public_names
from fmu_src.console.page import PAGE, build_page
from fmu_src.errors import BuildError
from fmu_src.fmus import MODELS
from tests.once import built_once

if TYPE_CHECKING:
    from playwright.sync_api import Browser

ROOT = Path(__file__).parents[2]
LOOKED_AT = ("index", "model", "gallery", "tutorials/first-map", "reference/fmus/SoftTorque", "reference/python/cosim")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not shutil.which("npm") and "CI" not in os.environ, reason="npm is missing"),
]


@pytest.fixture(scope="module")
def sites(run_folder: Path) -> tuple[Path, Path]:
    """The site, made twice: in two places, and with two orders of all that hashing orders."""
    console = built_once(run_folder / "console", build_page) / PAGE

    def make(folder: Path) -> None:
        for name, seed in (("once", "1"), ("again", "2")):
            command = [sys.executable, "-m", "docs.site", str(folder / name), str(console)]
            run = subprocess.run(
                command,
                cwd=ROOT,
                env={**os.environ, "PYTHONHASHSEED": seed},
                capture_output=True,
                text=True,
                check=False,
            )
            assert run.returncode == 0, run.stdout + run.stderr

    folder = built_once(run_folder / "site", make)
    return folder / "once" / "html", folder / "again" / "html"


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "html").mkdir()
    (tmp_path / "letter.txt").write_text("dear reader")
    with pytest.raises(BuildError, match=r"holds letter\.txt, which is no part of a site; expected"):
        make(tmp_path)
    assert (tmp_path / "letter.txt").read_text() == "dear reader"


@pytest.fixture(scope="module")
def site(sites: tuple[Path, Path]) -> Path:
    return sites[0]


@cache
def tree(page: Path) -> html.HtmlElement:
    return html.document_fromstring(page.read_bytes())


def pages(site: Path) -> list[Path]:
    return sorted(path for path in site.rglob("*.html") if path.parent.name not in ("console", "_static"))


def files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_site_is_made_twice_to_the_same_bytes(sites: tuple[Path, Path]) -> None:
    once, again = map(files, sites)
    assert once.keys() == again.keys()
    assert [name for name in once if once[name] != again[name]] == []


def test_no_link_is_dead(site: Path) -> None:
    dead: list[str] = []
    for page in pages(site):
        for element, _, link, _ in tree(page).iterlinks():
            parts = urlsplit(link)
            if parts.scheme or link.startswith("//"):
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            target = target / "index.html" if target.is_dir() else target
            found = target.is_file() and (
                not parts.fragment
                or target.suffix != ".html"
                or target.parent.name == "console"
                or bool(tree(target).xpath("//*[@id=$id or @name=$id]", id=unquote(parts.fragment)))
            )
            if not found and element.get("href") != "#":
                dead.append(f"{page.relative_to(site)}: {link}")
    assert not dead, "\n".join(dead)


def test_nothing_is_fetched_from_elsewhere(site: Path) -> None:
    asked: list[str] = []
    for page in pages(site):
        asked += [
            f"{page.name}: {link}"
            for element, _, link, _ in tree(page).iterlinks()
            if element.tag != "a" and re.match(r"(https?:)?//", link)
        ]
    for path in site.rglob("*.css"):
        asked += re.findall(r"url\(['\"]?(?:https?:)?//[^)]*", path.read_text(encoding="utf-8"))
    assert not asked, "\n".join(asked)


def test_no_page_tells_where_it_was_made(site: Path) -> None:
    assert [page.name for page in pages(site) if str(ROOT) in page.read_text(encoding="utf-8")] == []


def test_every_fmu_variable_command_and_function_has_its_place(site: Path) -> None:
    for name, model in MODELS.items():
        page = tree(site / "reference" / "fmus" / f"{name}.html")
        assert {each.name for each in model.variables} <= set(page.xpath("//tr/@id"))
    commands = tree(site / "reference" / "commands.html")
    told = commands.text_content()
    for command, details in typer.main.get_command(app).commands.items():  # type: ignore[attr-defined]
        assert f"cosim-{command}" in commands.xpath("//section/@id")
        options = [option for each in details.params for option in each.opts if option.startswith("-")]
        assert [option for option in options if option not in told] == []
    for module in (module for group in PUBLIC.values() for module in group):
        page = tree(site / "reference" / "python" / f"{module}.html")
        ids = set(page.xpath("//dt/@id"))
        assert {f"{module}.{name}" for name in public_names(import_module(module))} <= ids


def test_all_that_the_package_exports_is_public() -> None:
    module = import_module("cosim")
    exported = {
        name
        for name in module.__all__
        if inspect.isroutine(getattr(module, name)) or inspect.isclass(getattr(module, name))
    }
    assert exported == set(public_names(module))


def test_equations_of_the_manuals_lead_to_their_numbers(site: Path) -> None:
    links = {
        link for name in MODELS for link in tree(site / "reference" / "fmus" / f"{name}.html").xpath("//a/@href")
        if "#equation-" in link
    }  # fmt: skip
    assert {"model.html", "SoftTorque.html"} <= {link.partition("#")[0].rpartition("/")[2] for link in links}


@pytest.mark.parametrize("width", [1400, 390])
def test_pages_open_from_disk_without_a_complaint(browser: Browser, site: Path, width: int) -> None:
    page = browser.new_context(viewport={"width": width, "height": 900}).new_page()
    complaints: list[str] = []
    elsewhere: list[str] = []
    page.on("console", lambda said: complaints.append(said.text) if said.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on(
        "request",
        lambda asked: elsewhere.append(asked.url) if not asked.url.startswith(("file:", "data:", "blob:")) else None,
    )
    for name in LOOKED_AT:
        page.goto((site / f"{name}.html").as_uri())
        page.wait_for_function("() => document.readyState === 'complete'")
        wide: Any = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert wide <= 0, f"{name} is {wide} px wider than the window"
        if name == "model":
            page.wait_for_selector("mjx-container")
    assert (complaints, elsewhere) == ([], [])


def test_the_console_runs_on_the_first_page(browser: Browser, site: Path) -> None:
    page = browser.new_context(viewport={"width": 1400, "height": 900}).new_page()
    page.goto((site / "index.html").as_uri())
    page.locator("iframe.console-frame").scroll_into_view_if_needed()
    frame = next(each for each in page.frames if each.url.endswith("console/index.html?embed"))
    frame.wait_for_function("() => /Time\\s+[1-9]/.test(document.body.innerText)", timeout=30_000)
