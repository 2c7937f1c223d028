"""Find FMUs: a file beside the scenario, or a promised name among the built ones."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from cosim.errors import FmuFileError, InputError, suggestion

PACKAGINGS = ("native", "python")
ENVIRONMENT_VARIABLE = "COSIM_FMU_PATH"
_PACKAGE = Path(__file__).resolve().parents[1]
_CHECKOUT = _PACKAGE.parent if (_PACKAGE.parent / "build_fmu.py").is_file() else None
"""Folder of the sources; None where the package is installed from a wheel."""


def locate_fmu(fmu: str | Path | Callable[..., object], packaging: str, beside: Path | None = None) -> Path:
    """Find the file of an FMU.

    Parameters
    ----------
    fmu : str or Path
        A path that ends in ``.fmu``, or a name such as ``"DrillstringNeutral"``. A name is looked up in the folders of
        the environment variable COSIM_FMU_PATH, then in ``dist`` in the working directory, then in the ``dist`` of the
        checkout that this package runs from, then among those that came with the package; in each, in the subfolder of
        the packaging first. A Python function, which a component may be as well, has no file.
    packaging : str
        ``"native"`` or ``"python"``; matters for names only.
    beside : Path, optional
        Folder that a relative path starts from; by default the working directory.

    Raises
    ------
    FmuFileError
        If there is no such file.
    InputError
        If there is no such packaging.
    """
    if packaging not in PACKAGINGS:
        raise InputError(f"there is no packaging '{packaging}'{suggestion(packaging, PACKAGINGS)}")
    if callable(fmu):
        raise FmuFileError(
            f"{getattr(fmu, '__qualname__', fmu)} is a Python function; expected an FMU, which is a file"
        )
    if Path(fmu).suffix == ".fmu":
        path = (beside or Path()) / fmu
        if not path.is_file():
            raise FmuFileError(f"{path}: there is no such file")
        return path.resolve()
    folders = fmu_folders(packaging)
    for folder in folders:
        if (path := folder / f"{fmu}.fmu").is_file():
            return path.resolve()
    where = ", ".join(str(folder) for folder in folders)
    built = {path.stem for folder in folders for path in folder.glob("*.fmu")}
    raise FmuFileError(f"{fmu}.fmu is not in {where}{suggestion(str(fmu), built) or how_to_build(packaging)}")


def promised_fmus(packaging: str) -> dict[str, Path]:
    """Return the FMUs that can be had by name, by name: of each the file that `locate_fmu` finds."""
    found: dict[str, Path] = {}
    for folder in fmu_folders(packaging):
        for path in sorted(folder.glob("*.fmu")):
            found.setdefault(path.stem, path.resolve())
    return dict(sorted(found.items()))


def build_script() -> Path | None:
    """Return the script that builds FMUs in a checkout; None where the package is installed."""
    return None if _CHECKOUT is None else _CHECKOUT / "build_fmu.py"


def how_to_build(packaging: str) -> str:
    """Return the end of a sentence that says how to make FMUs that are not there."""
    if _CHECKOUT is not None:
        return "; `python build_fmu.py` makes the FMUs of this project"
    return f"; `cosim build --packaging {packaging}` makes the FMUs of that packaging in dist"


def fmu_folders(packaging: str) -> list[Path]:
    """Return the folders to search, without repetition."""
    given = [Path(part) for part in os.environ.get(ENVIRONMENT_VARIABLE, "").split(os.pathsep) if part]
    folders = [folder for part in given for folder in (part / packaging, part)]
    folders.append(Path("dist", packaging))
    if _CHECKOUT is not None:
        folders.append(_CHECKOUT / "dist" / packaging)
    folders.append(_PACKAGE / "built" / packaging)
    return list({folder.resolve(): folder for folder in folders}.values())
