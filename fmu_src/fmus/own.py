"""A law of one's own: one Python file anywhere, with the interface table and the slave, that becomes a python FMU.

The file is named for the law, and imports what it needs of this project by its names in the checkout, `fmu_src` and
`models`. An installed package knows them as `cosim.fmu_src` and `cosim.models`, so there they are given both names, in
the process that builds and nowhere else.
"""

from __future__ import annotations

import ast
import keyword
import sys
import traceback
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

from ..errors import BuildError
from ..python.slave import TableSlave
from ..schema import Model
from . import MODELS

OWN = ("fmu_src", "models")
_ABOVE = __name__.partition("fmu_src")[0]
"""What the packages stand below: nothing in a checkout, `cosim.` where they are installed."""


@dataclass(frozen=True)
class OwnLaw:
    """A law from a file: its interface table, and the source of its slave."""

    model: Model
    source: str

    @property
    def module(self) -> str:
        """The name of its module in the FMU."""
        return f"fmu_src.fmus.{self.model.name}.interface"


def read_law(path: Path) -> OwnLaw:
    """Read a law from its file, which is run for it.

    Raises
    ------
    BuildError
        If there is no such file, it is none of a law, or it fails.
    """
    name = path.stem
    if not name.isidentifier() or keyword.iskeyword(name) or not name.isascii():
        raise BuildError(f"{path}: '{name}' is no name of an FMU; expected letters, digits and _")
    if name in MODELS:
        raise BuildError(f"{path}: {name} is an FMU of this project; expected another name")
    try:
        source = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BuildError(f"{path} cannot be read: {error}") from error
    _refuse_foreign(path, source)
    module = _run(path, source)
    model = getattr(module, "MODEL", None)
    if not isinstance(model, Model) or model.name != name:
        raise BuildError(f"{path} defines no MODEL with the name of the file, {name}")
    law = getattr(module, name, None)
    if not isinstance(law, type) or not issubclass(law, TableSlave) or getattr(law, "model", None) is not model:
        raise BuildError(f"{path} defines no class {name} of a law, with model = MODEL")
    _take_a_step(path, law)
    return OwnLaw(model, source)


def _refuse_foreign(path: Path, source: str) -> None:
    """Refuse what the FMU could not bring: packages of others, and other files."""
    try:
        tree = ast.parse(source)
    except SyntaxError as error:
        raise BuildError(f"{path}, line {error.lineno}: {error.msg}") from error
    for node in (node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            names = ["." * node.level + (node.module or "")]
        for name in names:
            top = name.split(".")[0]
            if top not in OWN and top not in sys.stdlib_module_names:
                raise BuildError(
                    f"{path}, line {node.lineno}: an FMU brings no other package or file, so {name} cannot be "
                    f"imported; expected the standard library, {' or '.join(OWN)}"
                )


def _run(path: Path, source: str) -> ModuleType:
    """Return the module that a file defines."""
    if _ABOVE and not any(isinstance(finder, _SecondName) for finder in sys.meta_path):
        sys.meta_path.insert(0, _SecondName())  # before who would find modules of these packages a second time
    module = ModuleType(path.stem)
    module.__file__ = str(path)
    with _told(path):
        exec(compile(source, str(path), "exec"), module.__dict__)  # the user's own file, at the user's word
    return module


def _take_a_step(path: Path, law: type[TableSlave]) -> None:
    """Let a law answer and go on, so that what fails there is told by its line and not by an FMU."""
    with _told(path):
        slave = law(instance_name=path.stem)
        slave.start(slave.values, 0.0)
        slave.step(slave.values, 0.0, slave.model.step_size)
        slave.restore(slave.state())


@contextmanager
def _told(path: Path) -> Generator[None]:
    """Say in a sentence what a user's code raises, and on which line."""
    try:
        yield
    except Exception as error:  # whatever it raises
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        where = f", line {lines[-1]}" if lines else ""
        raise BuildError(f"{path}{where}: {type(error).__name__}: {error}") from error


class _SecondName(MetaPathFinder, Loader):
    """Find `fmu_src` and `models` where they are installed, and give them by both names as one."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return that it is to be had here, if it is one of them."""
        del path, target
        return ModuleSpec(fullname, self) if fullname.split(".")[0] in OWN else None

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Leave it to Python to make a module that is about to be replaced."""
        del spec
        return None

    def exec_module(self, module: ModuleType) -> None:
        """Put the installed module in the place of an empty one."""
        try:
            sys.modules[module.__name__] = import_module(f"{_ABOVE}{module.__name__}")
        except ModuleNotFoundError as error:
            raise ModuleNotFoundError(f"No module named '{module.__name__}'", name=module.__name__) from error
