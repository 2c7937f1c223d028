"""Packages that only a part of the work needs: imported when it begins, and named in a sentence if they are absent."""

from __future__ import annotations

import importlib
from typing import Any

from cosim.errors import MissingPackageError


def require(module: str, *, extra: str, purpose: str) -> Any:
    """Return a module of a package that an extra of this one brings.

    Parameters
    ----------
    module : str
        Its full name, such as ``"fmu_manipulation_toolbox.container"``.
    extra : str
        Which of the extras in pyproject.toml has the package.
    purpose : str
        What needs it, as the beginning of a sentence, such as ``"writing Zarr"``.

    Raises
    ------
    MissingPackageError
        If the package, or one that it needs in turn, is not installed.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        package = (error.name or module).partition(".")[0].replace("_", "-")
        how = f'pip install "drillstring-cosim[{extra}]" brings it'
        raise MissingPackageError(f"{purpose} needs the package {package}; {how}") from error
