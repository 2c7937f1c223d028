"""The reference experiments that travel inside an FMU, so that whoever has it can check it.

They are data: the folder reference/<model> is what goes into extra/org.fmi-standard.fmi-ls-ref (FMI-LS-REF
1.0.0-alpha.1, https://github.com/modelica/fmi-ls-ref). Their results come from independent solutions, not from the
code they judge; ``python -m tests.reference`` makes them anew.
"""

from __future__ import annotations

from ..schema import Model
from . import project

FOLDER = project.SOURCES / "reference"
NOTE = "fmi-ls-ref.txt"
"""The page on the experiments, which the layered standard wants among the documentation."""


def reference_files(model: Model) -> dict[str, bytes]:
    """Return the reference experiments of a model by path inside the FMU; none if it has none."""
    files: dict[str, bytes] = {}
    for path in sorted((FOLDER / model.name).glob("*")):
        folder = "documentation" if path.name == NOTE else "extra/org.fmi-standard.fmi-ls-ref"
        # read as text, so that line ends are the same on every platform
        files[f"{folder}/{path.name}"] = path.read_text(encoding="utf-8").encode("utf-8")
    return files
