"""The content of an FMU in the python packaging: pythonfmu's library, and a slave over the readable models.

The Python modules a slave needs are gathered under a package name that no other FMU and no importer has.

Every FMU loaded by a process shares that process's modules: two FMUs that bundle a module of the same name run the
code of whichever came first, and an importer that has itself imported `models` makes the FMU run the importer's. So
the name of the bundle is made from its content, and all imports inside point at it.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType

from .. import project
from ..errors import BuildError
from ..fmus.own import OwnLaw
from ..schema import Model
from . import packing

OWN = ("fmu_src", "models", "pythonfmu")
_NOTHING: Mapping[str, str] = MappingProxyType({})
MAIN = '''\
"""The script that pythonfmu's library runs: once to import it, and once more for every instance."""

from {package}.fmu_src.python import library
from {package}.{slave} import {model}

library.keep(globals())
'''


def python_files(model: Model, own: OwnLaw | None = None) -> dict[str, bytes]:
    """Return resources and binaries of the FMU by path; BuildError if a module or the library is missing."""
    slave = slave_module(model) if own is None else own.module
    package, modules = bundle(slave, {} if own is None else {own.module: own.source})
    script = f"{package}_main"
    files = {f"resources/{path}": content for path, content in modules.items()}
    files[f"resources/{script}.py"] = MAIN.format(package=package, slave=slave, model=model.name).encode()
    files["resources/slavemodule.txt"] = script.encode()
    return files | _libraries(model)


def slave_module(model: Model) -> str:
    """Return the module that holds the slave of a model."""
    room = f"fmu_src.fmus.{model.name}"
    return f"{room}.slave" if locate_module(f"{room}.slave") else f"{room}.interface"


def _libraries(model: Model) -> dict[str, bytes]:
    spec = find_spec("pythonfmu")
    folder = Path(spec.origin).parent / "resources" / "binaries" if spec and spec.origin else None
    paths = sorted(path for path in folder.glob("*/*") if path.suffix in (".so", ".dll", ".dylib")) if folder else []
    if not paths:
        raise BuildError(
            "the installed pythonfmu brings no libraries; install the version pinned in requirements/run.txt"
        )
    return {f"binaries/{path.parent.name}/{model.name}{path.suffix}": path.read_bytes() for path in paths}


def bundle(module: str, given: Mapping[str, str] = _NOTHING) -> tuple[str, dict[str, bytes]]:
    """Return the bundle of a module and all it imports from `OWN`: its package name, and its files by path.

    Sources of modules that stand elsewhere are given. Packages are bundled with an empty `__init__`, so a module
    imports what it needs from the module that defines it.

    Raises
    ------
    BuildError
        A module does not exist, or imports in a way that cannot be pointed at the bundle.
    """
    sources: dict[str, str] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name not in sources:
            sources[name] = given[name] if name in given else _read(name)
            waiting += [used for node in _imports(sources[name]) for used in _modules(name, node)]
    original = {_path(name): source.encode() for name, source in sources.items()}
    package = f"drillstring_{packing.digest(original)[:16]}"
    files = {f"{package}/{_path(name)}": _redirect(source, package).encode() for name, source in sources.items()}
    for path in list(files):
        for folder in list(Path(path).parents)[:-1]:
            files.setdefault(f"{folder.as_posix()}/__init__.py", b"")
    return package, files


def _path(module: str) -> str:
    return module.replace(".", "/") + ".py"


def locate_module(module: str) -> Path | None:
    """Return the file of a module, without running its code; None if there is no such file."""
    top, *rest = module.split(".")
    if top == "pythonfmu":
        spec = find_spec(top)
        base = Path(spec.origin).parent.parent if spec and spec.origin else None
    else:
        base = project.ROOT
    path = base.joinpath(top, *rest).with_suffix(".py") if base else None
    return path if path and path.is_file() else None


def _read(module: str) -> str:
    path = locate_module(module)
    if path is None:
        raise BuildError(f"the module {module} is missing; a python FMU cannot be built without it")
    return path.read_text(encoding="utf-8")


def _imports(source: str) -> list[ast.Import | ast.ImportFrom]:
    return [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Import | ast.ImportFrom)]


def _modules(importer: str, node: ast.Import | ast.ImportFrom) -> list[str]:
    """Return the modules of `OWN` that one import statement needs."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names if alias.name.split(".")[0] in OWN]
    parts = importer.split(".")[: -node.level] if node.level else []
    origin = ".".join([*parts, *([node.module] if node.module else [])])
    if origin.split(".")[0] not in OWN:
        return []
    if locate_module(origin) is not None:
        return [origin]
    return [f"{origin}.{alias.name}" for alias in node.names]


def _redirect(source: str, package: str) -> str:
    """Return a module's source with its absolute imports from `OWN` pointed at the bundle."""
    lines = source.split("\n")
    for node in _imports(source):
        if isinstance(node, ast.ImportFrom):
            if not node.level and (node.module or "").split(".")[0] in OWN:
                _insert(lines, node, "from ", package)
        elif any(alias.name.split(".")[0] in OWN for alias in node.names):
            if len(node.names) > 1 or node.names[0].asname is None:
                statement = ast.unparse(node)
                raise BuildError(f"cannot bundle {statement!r}; write 'from package import module' instead")
            _insert(lines, node, "import ", package)
    return "\n".join(lines)


def _insert(lines: list[str], node: ast.stmt, keyword: str, package: str) -> None:
    line = lines[node.lineno - 1]
    # columns of the syntax tree count bytes, and an import may follow on text that is not ASCII
    start = len(line.encode()[: node.col_offset].decode()) + len(keyword)
    if line[start - len(keyword) : start] != keyword:
        raise BuildError(f"cannot bundle {line.strip()!r}; write one space after {keyword.strip()!r}")
    lines[node.lineno - 1] = f"{line[:start]}{package}.{line[start:]}"
