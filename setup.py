"""Put folders into packages; all else stands in pyproject.toml.

The folders `models` and `fmu_src` are installed as `cosim.models` and `cosim.fmu_src`: names at the top level of an
environment are everybody's, and many a project has a package `models` of its own.
"""

from setuptools import find_packages, setup

HOUSED = ("models", "fmu_src")

setup(
    packages=[
        *find_packages(include=["cosim", "cosim.*"]),
        *(f"cosim.{name}" for name in find_packages(include=[part for top in HOUSED for part in (top, f"{top}.*")])),
    ],
    package_dir={f"cosim.{name}": name for name in HOUSED},
)
