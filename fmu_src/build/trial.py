"""Try an FMU before it is put in place: initialise, step, save, step again from the saved state, end.

Run as a script in a process of its own, with the path of the FMU; it needs nothing but fmpy.
"""

# pyright: basic, reportMissingTypeStubs=false

from __future__ import annotations

import shutil
import sys
from math import isfinite

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.model_description import ModelDescription


def try_fmu(path: str) -> list[str]:
    """Return what is wrong with the FMU, as sentences; an empty list if it runs.

    fmpy raises on every status worse than a warning; that ends the process with its traceback.
    """
    description: ModelDescription = fmpy.read_model_description(path)
    folder = fmpy.extract(path)
    try:
        slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.modelName,
            instanceName="trial",
        )
        slave.instantiate(loggingOn=True)
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        problems = _walk(slave, description)
        slave.terminate()
        slave.freeInstance()
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return problems


def _walk(slave: FMU2Slave, description: ModelDescription) -> list[str]:
    step = float(getattr(description.defaultExperiment, "stepSize", None) or 1.0)
    problems = _not_finite("after initialisation", _outputs(slave, description))
    slave.doStep(0.0, step)
    state = slave.getFMUstate()
    slave.doStep(step, step)
    first = _outputs(slave, description)
    problems += _not_finite(f"at t = {2 * step!r} s", first)
    restored = slave.deSerializeFMUstate(slave.serializeFMUstate(state))
    slave.setFMUstate(restored)
    slave.doStep(step, step)
    if _outputs(slave, description) != first:
        problems.append("a step repeated from a saved state gives other outputs")
    for saved in (state, restored):
        slave.freeFMUstate(saved)
    return problems


def _outputs(slave: FMU2Slave, description: ModelDescription) -> dict[str, float | int | bool | bytes]:
    readers = {"Real": slave.getReal, "Boolean": slave.getBoolean, "String": slave.getString}
    values: dict[str, float | int | bool | bytes] = {}
    for variable in description.modelVariables:
        if variable.causality == "output":
            read = readers.get(variable.type, slave.getInteger)
            values[variable.name] = read([variable.valueReference])[0]
    return values


def _not_finite(when: str, outputs: dict[str, float | int | bool | bytes]) -> list[str]:
    return [
        f"{when} output {name} is {value}; expected a finite value"
        for name, value in outputs.items()
        if not isinstance(value, bytes) and not isfinite(value)
    ]


if __name__ == "__main__":
    sys.exit("\n".join(try_fmu(sys.argv[1])) or 0)
