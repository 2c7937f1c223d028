"""The content of an FMU in the python packaging: pythonfmu's library, and a slave over the readable models."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from ..schema import Model
from .bundle import bundle
from .errors import BuildError

MAIN = '''\
"""The script that pythonfmu's library runs: once to import it, and once more for every instance."""

from {package}.fmu_src.python import library
from {package}.fmu_src.python.{model} import {model}

library.keep(globals())
'''


def python_files(model: Model) -> dict[str, bytes]:
    """Return resources and binaries of the FMU by path; BuildError if a module or the library is missing."""
    package, modules = bundle(f"fmu_src.python.{model.name}")
    script = f"{package}_main"
    files = {f"resources/{path}": content for path, content in modules.items()}
    files[f"resources/{script}.py"] = MAIN.format(package=package, model=model.name).encode()
    files["resources/slavemodule.txt"] = script.encode()
    return files | _libraries(model)


def _libraries(model: Model) -> dict[str, bytes]:
    spec = find_spec("pythonfmu")
    folder = Path(spec.origin).parent / "resources" / "binaries" if spec and spec.origin else None
    paths = sorted(path for path in folder.glob("*/*") if path.suffix in (".so", ".dll", ".dylib")) if folder else []
    if not paths:
        raise BuildError(
            "the installed pythonfmu brings no libraries; install the version pinned in requirements/run.txt"
        )
    return {f"binaries/{path.parent.name}/{model.name}{path.suffix}": path.read_bytes() for path in paths}
