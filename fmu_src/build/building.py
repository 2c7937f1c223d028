"""One FMU from start to end: its files, its identity, its place."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .. import project
from ..errors import BuildError
from ..fmus.own import OwnLaw
from ..page.page import documentation_page
from ..schema import Model, Packaging
from . import native as native_build
from . import packing
from .description import model_description
from .header import table_header
from .licenses import license_files
from .native import Target
from .python_packaging import python_files
from .source_code import TABLE_HEADER, source_code
from .terminals import appearance

NOTE = "fmi-ls-ref.txt"
"""The page on the reference experiments, which their layered standard wants among the documentation."""


def build(model: Model, packaging: Packaging, targets: Sequence[Target], output: Path) -> Path:
    """Build one FMU and put it in its place below a folder, once it is known to be good.

    Parameters
    ----------
    model : Model
        The interface table.
    packaging : Packaging
        Native or python.
    targets : sequence of Target
        The platforms a native FMU is compiled for; pythonfmu's libraries are what they are.
    output : Path
        The FMU goes to <output>/<packaging>/<model name>.fmu.

    Returns
    -------
    Path
        Of the FMU.

    Raises
    ------
    BuildError
        Nothing has been put in place.
    """
    documents = {
        "documentation/index.html": documentation_page(model, packaging),
        **license_files(packaging, targets),
        **appearance(model),
        **reference_files(model),
    }
    files = _native(model, targets, documents) if packaging is Packaging.NATIVE else _python(model, documents)
    here = f"binaries/{native_build.host_target().folder}/"
    runs_here = any(name.startswith(here) for name in files)
    path = output / packaging.value / f"{model.name}.fmu"
    packing.place(files, path, runs_here=runs_here)
    return path


def build_own(law: OwnLaw, folder: Path) -> Path:
    """Build the FMU of a law of one's own as <folder>/<model name>.fmu; BuildError: nothing has been put in place."""
    model = law.model
    documents = {
        "documentation/index.html": documentation_page(model, Packaging.PYTHON),
        **license_files(Packaging.PYTHON, ()),
        **appearance(model),
    }
    try:
        files = _python(model, documents, law)
    except ValueError as error:  # of a row that cannot be described
        raise BuildError(str(error)) from error
    path = folder / f"{model.name}.fmu"
    packing.place(files, path)
    return path


def reference_files(model: Model) -> dict[str, bytes]:
    """Return the reference experiments that travel in an FMU, by path inside it; none if it has none.

    Whoever has the FMU can check it with them. They are data: what lies in reference/ goes into
    extra/org.fmi-standard.fmi-ls-ref (FMI-LS-REF 1.0.0-alpha.1, https://github.com/modelica/fmi-ls-ref). The results
    come from independent solutions, not from the code they judge; ``python -m tests.reference`` makes them anew.
    """
    files: dict[str, bytes] = {}
    for path in sorted((project.FMUS / model.name / "reference").glob("*")):
        folder = "documentation" if path.name == NOTE else "extra/org.fmi-standard.fmi-ls-ref"
        # read as text, so that line ends are the same on every platform
        files[f"{folder}/{path.name}"] = path.read_text(encoding="utf-8").encode("utf-8")
    return files


def _native(model: Model, targets: Sequence[Target], documents: dict[str, bytes]) -> dict[str, bytes]:
    # The identity is that of the description, the sources and the way they are compiled: the libraries follow from
    # them, and hold it. So a library is the same whatever others are beside it.
    sources = source_code(model)
    identity = sources | {"recipe": native_build.recipe().encode()}
    guid = packing.guid(identity | {"description": model_description(model, Packaging.NATIVE, "")})
    sources[TABLE_HEADER] = table_header(model, guid).encode()
    libraries = {
        f"binaries/{target.folder}/{model.name}{target.extension}": native_build.compile_library(
            model.name, sources, target
        )
        for target in targets
    }
    shipped = {f"sources/{name}": content for name, content in sources.items()}
    description = model_description(model, Packaging.NATIVE, guid)
    return documents | libraries | shipped | {"modelDescription.xml": description}


def _python(model: Model, documents: dict[str, bytes], own: OwnLaw | None = None) -> dict[str, bytes]:
    files = python_files(model, own)
    guid = packing.guid(files | {"description": model_description(model, Packaging.PYTHON, "")})
    return documents | files | {"modelDescription.xml": model_description(model, Packaging.PYTHON, guid)}
