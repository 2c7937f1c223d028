"""The FMUs there are: one folder each, found and not listed.

A folder `<Name>` holds

- `interface.py`: the interface table of the FMU as `MODEL`, whose name is that of the folder;
- `model.c`: the functions of native/ds_model.h; a law writes less with native/ds_memoryless.h or native/ds_law.h;
- `slave.py`: the class `<Name>` of the python packaging; a short one may stand in `interface.py`;

and, if it has them, `page.py` with the text of its documentation page, other C files that `model.c` includes,
`icon.svg` and `icon.png`, and reference experiments in `reference/`.
"""

from __future__ import annotations

from importlib import import_module

from .. import project
from ..errors import BuildError
from ..schema import Model


def _find() -> dict[str, Model]:
    """Return the interface tables of all FMUs by name, in the order of the alphabet."""
    found: dict[str, Model] = {}
    for path in sorted(project.FMUS.glob("*/interface.py")):
        name = path.parent.name
        model = getattr(import_module(f"{__name__}.{name}.interface"), "MODEL", None)
        if not isinstance(model, Model) or model.name != name:
            raise BuildError(f"{path} defines no MODEL with the name of its folder, {name}")
        found[name] = model
    return found


MODELS = _find()
