"""The folder sources/ of a native FMU: the C files its model needs, and one that includes them all.

FMI 2.0.4, section 2.3: everything that is needed to compile the FMU but the FMI headers, which are the importer's.
"""

from __future__ import annotations

import re
from pathlib import Path, PurePath
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from .. import project
from ..errors import BuildError
from ..schema import Model
from .header import table_header, table_source
from .native import NATIVE

TABLE_HEADER = "ds_table.h"
TABLE_SOURCE = "ds_table.c"
_MODEL = "model.c"
_ADAPTER = "fmi2*.c"
_ARITHMETIC = "ds_arithmetic.h"
_INCLUDE = re.compile(rb'^#include "([^"]+)"', re.MULTILINE)


def source_code(model: Model) -> dict[str, bytes]:
    """Return the files of sources/ by name, all but ds_table.h, which holds the GUID that is made from them.

    Returns
    -------
    dict of str to bytes
        The one named after the model is to be compiled. Of the hand-written files there are the FMI adapter, the
        model's own file, and what these include.

    Raises
    ------
    BuildError
        A file is missing.
    """
    files = {TABLE_SOURCE: table_source(model).encode()}
    waiting = [_MODEL, _ARITHMETIC, *(path.name for path in NATIVE.glob(_ADAPTER))]
    waiting += _included(model, table_header(model, "").encode())
    while waiting:
        name = waiting.pop()
        if name not in files:
            files[name] = _read(model, name)
            waiting += _included(model, files[name])
    parts = sorted(name for name in files if name.endswith(".c"))
    return files | {f"{model.name}.c": _whole(model, parts), "buildDescription.xml": _build_description(model)}


def source_path(model: Model, name: str) -> Path | None:
    """Return where a hand-written C file of a model lies, in its own folder or in native/; None if in neither."""
    paths = (project.FMUS / model.name / name, NATIVE / name)
    return next((path for path in paths if path.is_file()), None)


def _read(model: Model, name: str) -> bytes:
    path = source_path(model, name)
    if path is None:
        missing = project.FMUS / model.name / name
        raise BuildError(f"{model.name}: {missing} is missing; a native FMU cannot be built without it")
    return path.read_bytes()


def _included(model: Model, source: bytes) -> list[str]:
    """Return the hand-written files a source includes, and with a header the source that defines what it declares."""
    found = (match.decode() for match in _INCLUDE.findall(source))
    headers = [name for name in found if name != TABLE_HEADER and source_path(model, name)]
    sources = [str(PurePath(name).with_suffix(".c")) for name in headers]
    return [*headers, *(name for name in sources if source_path(model, name))]


def _whole(model: Model, parts: list[str]) -> bytes:
    includes = "\n".join(f'#include "{name}"' for name in parts)
    text = f"""\
/* {model.name}, all of it: the one file to compile. documentation/index.html tells how. */
#define FMI2_FUNCTION_PREFIX {model.name}_
#include "fmi2Functions.h"

#define DS_ONE_FILE
#include "{_ARITHMETIC}"

{includes}
"""
    return text.encode()


def _build_description(model: Model) -> bytes:
    """Return buildDescription.xml (FMI 3.0, section 2.4.10, taken over by FMI 2.0.4, section 2.3)."""
    root = Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    configuration = SubElement(root, "BuildConfiguration", {"modelIdentifier": model.name})
    files = SubElement(configuration, "SourceFileSet", {"language": "C99"})
    SubElement(files, "SourceFile", {"name": f"{model.name}.c"})
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"
