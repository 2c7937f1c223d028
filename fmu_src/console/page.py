"""The page of the console: one file made of the core and the sources in web/, by node and packages of npm."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
from pathlib import Path

from .. import project
from ..build.licenses import zig_text
from ..errors import BuildError
from .core import compile_core, core_tables

PAGE = "console.html"
BUILT = project.ROOT / "build" / "console"
_WEB = project.ROOT / "web"
_LOCK = _WEB / "package-lock.json"
_INSTALLED = _WEB / "node_modules" / ".made-from.json"
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
    if not _installed():
        _run("npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund")
    _run("npm", "run", "--silent", "check")
    _run("node", "build.mjs", str(folder.resolve()), _sources_digest(folder))
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


def _installed() -> bool:
    """Return whether the packages are there that the lock names: a copy of it is left with them."""
    return _INSTALLED.is_file() and _INSTALLED.read_bytes() == _LOCK.read_bytes()


def _run(program: str, *arguments: str) -> None:
    path = shutil.which(program)
    if path is None:
        raise BuildError(f"{program} is missing, which builds the console; install Node.js 18 or later with npm")
    run = subprocess.run(
        [path, *arguments], cwd=_WEB, capture_output=True, text=True, encoding="utf-8", errors="replace", check=False
    )
    if run.returncode != 0:
        messages = (run.stderr + run.stdout).strip()
        raise BuildError(
            f"the console cannot be built: {program} {arguments[0]} ended with {run.returncode}:\n{messages}"
        )
    if arguments[0] == "ci":
        shutil.copyfile(_LOCK, _INSTALLED)


def _sources_digest(folder: Path) -> str:
    """Return what the page is made from in short: the core, the tables, and all in web/ that is ours."""
    digest = hashlib.sha256()
    ours = [*_WEB.glob("*.*"), *(_WEB / "src").glob("*.*")]
    for path in [folder / "core.wasm", folder / "tables.json", *sorted(path for path in ours if path.is_file())]:
        content = path.read_bytes()
        digest.update(f"{path.name} {len(content)}\n".encode() + content)
    return digest.hexdigest()
