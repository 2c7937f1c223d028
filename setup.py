"""Put folders into packages; all else stands in pyproject.toml.

The folders `models` and `fmu_src` are installed as `cosim.models` and `cosim.fmu_src`: names at the top level of an
environment are everybody's, and many a project has a package `models` of its own. An FMU's folder is a package without
`__init__.py`, found by its interface table.
"""

from pathlib import Path

from setuptools import find_packages, setup

HOUSED = ("models", "fmu_src")
FMUS = [f"cosim.fmu_src.fmus.{path.parent.name}" for path in Path("fmu_src", "fmus").glob("*/interface.py")]

setup(
    packages=[
        *find_packages(include=["cosim", "cosim.*"]),
        *(f"cosim.{name}" for name in find_packages(include=[part for top in HOUSED for part in (top, f"{top}.*")])),
        *sorted(FMUS),
    ],
    package_dir={f"cosim.{name}": name for name in HOUSED},
)
