"""FMUs to test with, and a way to call them that keeps what they log."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)

from fmu_src.build import python_packaging
from fmu_src.build.building import build
from fmu_src.schema import Packaging
from tests.fmu_src.gauge import GAUGE
from tests.once import built_once

Message = tuple[str, int, str, str]


class Instance:
    """An instance of an FMU: what fmpy offers, and `logged`, which holds (instance, status, category, message)."""

    def __init__(self, folder: str, name: str) -> None:
        description = fmpy.read_model_description(folder)
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.logged: list[Message] = []
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(self._log)
        callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self.slave.instantiate(callbacks=callbacks, loggingOn=True)

    def _log(self, _: Any, name: bytes, status: int, category: bytes, message: bytes) -> None:
        self.logged.append((name.decode(), status, category.decode(), message.decode()))

    def initialize(self, start: float = 0.0) -> None:
        self.slave.setupExperiment(startTime=start)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.slave, name)


@pytest.fixture
def instantiate() -> Iterator[Callable[..., Instance]]:
    """Make instances of an FMU file: instantiate(path, name); all are freed at the end."""
    folders: dict[Path, str] = {}
    instances: list[Instance] = []

    def make(path: Path, name: str = "instance") -> Instance:
        if path not in folders:
            folders[path] = fmpy.extract(str(path))
        instances.append(Instance(folders[path], name))
        return instances[-1]

    yield make
    for instance in instances:
        instance.fmi2FreeInstance(instance.component)
    for folder in folders.values():
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def gauge_fmu(run_folder: Path) -> Path:
    """Build the gauge in the python packaging."""
    source = Path(__file__).with_name("gauge.py")
    (built,) = built_once(run_folder / "gauge", lambda to: build_gauge(to, source)).rglob("*.fmu")
    return built


def build_gauge(output: Path, source: Path) -> Path:
    """Build the gauge from a source of its own."""
    locate = python_packaging.locate_module
    with pytest.MonkeyPatch.context() as patch:
        slave = "fmu_src.fmus.Gauge.slave"
        patch.setattr(python_packaging, "locate_module", lambda name: source if name == slave else locate(name))
        return build(GAUGE, Packaging.PYTHON, [], output)
