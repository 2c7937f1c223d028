"""The page of the console: one file made of the core and the sources in web/, by node and packages of npm."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from pathlib import Path

from .. import project
from ..build.licenses import zig_text
from ..node import install_packages, run_node
from .core import compile_core, core_tables

PAGE = "console.html"
BUILT = project.ROOT / "build" / "console"
_WEB = project.ROOT / "web"
_NEEDED_BY = "the console"
_MADE_FROM = re.compile(r'<meta name="made-from" content="([0-9a-f]{64})">')


def build_page(folder: Path = BUILT) -> Path:
    """Build the page into a folder, with the packages that web/package-lock.json names; return its path.

    Raises
    ------
    BuildError
        Node or npm lacks, a package cannot be had, or the sources do not compile.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_core(folder)
    (folder / "licenses.txt").write_text(_licenses(), encoding="utf-8")
    install_packages(_WEB, _NEEDED_BY)
    run_node("npm", "run", "--silent", "check", folder=_WEB, needed_by=_NEEDED_BY)
    run_node("node", "build.mjs", str(folder.resolve()), _sources_digest(folder), folder=_WEB, needed_by=_NEEDED_BY)
    return folder / PAGE


def is_built() -> bool:
    """Return whether the page has been built, and from the sources as they are now."""
    built = BUILT / PAGE
    if not built.is_file():
        return False
    _write_core(BUILT)  # the C code may have changed since
    found = _MADE_FROM.search(built.read_text(encoding="utf-8"))
    return found is not None and found[1] == _sources_digest(BUILT)


def take_page(folder: Path) -> bool:
    """Copy the page that has been built to a folder, if it is there and made from the sources as they are now.

    So a wheel can be built where there is no node: it then goes without the page.
    """
    if not is_built():
        return False
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(BUILT / PAGE, folder / PAGE)
    return True


def _write_core(folder: Path) -> None:
    (folder / "core.wasm").write_bytes(compile_core())
    (folder / "tables.json").write_text(json.dumps(core_tables()), encoding="utf-8")


def _licenses() -> str:
    """Return whose work is in the core, and their licences; uPlot's is added where the page is put together."""
    parts = {
        "The driller's console": project.license_text(),
        "Run-time functions of the Zig compiler in the core": zig_text("LICENSE"),
        "Functions of wasi-libc in the core": zig_text("lib/libc/wasi/LICENSE-MIT"),
        "Functions of musl in the core": zig_text("lib/libc/musl/COPYRIGHT"),
    }
    return "\n\n".join(f"{title}\n\n{text.strip()}" for title, text in parts.items())


def _sources_digest(folder: Path) -> str:
    """Return what the page is made from in short: the core, the tables, and all in web/ that is ours."""
    digest = hashlib.sha256()
    ours = [*_WEB.glob("*.*"), *(_WEB / "src").glob("*.*")]
    for path in [folder / "core.wasm", folder / "tables.json", *sorted(path for path in ours if path.is_file())]:
        content = path.read_bytes()
        digest.update(f"{path.name} {len(content)}\n".encode() + content)
    return digest.hexdigest()
