"""The folder documentation/licenses/ of an FMU: the licence of this project, and of what else is in the file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from .. import project
from ..errors import BuildError
from ..schema import Packaging
from .native import FMI_HEADERS, Target

FOLDER = "documentation/licenses"
ENTRY = f"{FOLDER}/license.txt"
"""The file with which FMI 2.0.4, section 2.3, has a reader begin."""

_OTHERS = """
Parts of this FMU are the work of others, under licences whose texts are beside this file:

"""
_FMI_HEADERS = "fmi-headers.txt", "the FMI headers, with which the libraries in binaries/ are compiled"
_ZIG = "zig.txt", "run-time functions of the Zig compiler in the libraries in binaries/"
_MINGW = "mingw-w64.txt", "run-time functions of mingw-w64 in the library in binaries/win64/"
_PYTHONFMU = "pythonfmu.txt", "PythonFMU: the libraries in binaries/, and the modules pythonfmu in resources/"


def license_files(packaging: Packaging, targets: Sequence[Target]) -> dict[str, bytes]:
    """Return the licence texts of an FMU by path inside it.

    Raises
    ------
    BuildError
        An installed package does not bring its licence.
    """
    texts: dict[tuple[str, str], str]
    if packaging is Packaging.PYTHON:
        texts = {_PYTHONFMU: project.license_text("pythonfmu")}
    else:
        texts = {_FMI_HEADERS: _header_license(), _ZIG: zig_text("LICENSE")}
        if any("windows" in triple for target in targets for triple in target.triples):
            texts[_MINGW] = zig_text("lib/libc/mingw/COPYING")
    listed = "".join(f"  {name}: {what}\n" for name, what in texts)
    files = {ENTRY: project.license_text() + _OTHERS + listed}
    files |= {f"{FOLDER}/{name}": text for (name, _), text in texts.items()}
    return {name: text.encode("utf-8") for name, text in files.items()}


def _header_license() -> str:
    """Return what the FMI headers say of their copyright and licence, from the first of the lines to the last."""
    header = FMI_HEADERS / "fmi2Functions.h"
    text = header.read_text(encoding="utf-8")
    found = re.search(r"^ *Copyright \(C\).*?POSSIBILITY OF SUCH DAMAGE\.$", text, re.MULTILINE | re.DOTALL)
    if found is None:
        raise BuildError(f"{header} does not state its licence; install the fmpy pinned in requirements/run.txt")
    return "\n".join(line.strip() for line in found[0].splitlines()) + "\n"


def zig_text(name: str) -> str:
    """Return a text that the installed zig brings, by its path; BuildError if it brings none."""
    spec = find_spec("ziglang")
    path = Path(spec.origin).parent / name if spec and spec.origin else None
    if path is None or not path.is_file():
        raise BuildError(f"the installed ziglang brings no {name}; install the version pinned in requirements/run.txt")
    return path.read_text(encoding="utf-8")
