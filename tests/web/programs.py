"""Runs of the plant that the console's core and the native FMU have to give the same bits for."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

from fmu_src.fmus import MODELS

ROOT = Path(__file__).parents[2]
FMU = ROOT / "dist" / "native" / "DrillstringNeutral.fmu"
OUTPUTS = tuple(variable.name for variable in MODELS["DrillstringNeutral"].select("output"))

FIGURE_2 = {
    "parameters": {},
    "step_size": 0.01,
    "steps": 10000,
    "changes": [{"step": -1, "values": {"Omega": 10.0, "WOB": 97347.0}, "slopes": {}}],
    "outputs": OUTPUTS,
}
JUMPS = {
    "parameters": {"L": 1503.5, "c_b": 0.8, "I_B": 120.0, "initial_speed": 9.0, "initial_torque": 5000.0},
    "step_size": 0.0137,
    "steps": 7300,
    "changes": [
        {"step": -1, "values": {"Omega": 9.0, "WOB": 60000.0}, "slopes": {}},
        {"step": 700, "values": {"WOB": 97347.0}, "slopes": {}},
        {"step": 1500, "values": {"Omega": 14.0}, "slopes": {"WOB": 3000.0}},
        {"step": 1501, "values": {"WOB": 98000.0}, "slopes": {"WOB": -2000.0, "Omega": 30.0}},
        {"step": 1800, "values": {"WOB": 90000.0}, "slopes": {"Omega": -0.75}},
        {"step": 2100, "values": {"Omega": -4.0}, "slopes": {}},
        {"step": 3300, "values": {"Omega": 10.0, "WOB": 0.0}, "slopes": {}},
        {"step": 4400, "values": {"Omega": 6.0, "WOB": 120000.0}, "slopes": {}},
    ],
    "outputs": OUTPUTS,
}
PROGRAMS = {"figure 2": FIGURE_2, "jumps": JUMPS}


@contextmanager
def _slave(program: dict) -> Iterator[tuple[FMU2Slave, dict[str, int]]]:
    description = read_model_description(FMU)
    references = {variable.name: variable.valueReference for variable in description.modelVariables}
    folder = extract(FMU)
    slave = FMU2Slave(
        guid=description.guid, unzipDirectory=folder, modelIdentifier="DrillstringNeutral", instanceName="plant"
    )
    try:
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        yield slave, references
        slave.terminate()
        slave.freeInstance()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def native(program: dict) -> np.ndarray:
    """Return what the native FMU gives for a program through fmpy: a row at the start and after every step."""
    kinds = {variable.name: variable.kind for variable in MODELS["DrillstringNeutral"].variables}
    rows = []
    with _slave(program) as (slave, references):
        getters = {"Real": slave.getReal, "Integer": slave.getInteger, "Boolean": slave.getBoolean}
        reals = [references[name] for name in OUTPUTS if kinds[name] == "Real"]
        others = [(getters[kinds[name]], references[name]) for name in OUTPUTS if kinds[name] != "Real"]

        def change(step: int) -> None:
            for each in (each for each in program["changes"] if each["step"] == step):
                for name, value in each["values"].items():
                    slave.setReal([references[name]], [value])
                for name, slope in each["slopes"].items():
                    slave.setRealInputDerivatives([references[name]], [1], [slope])

        def row() -> list[float]:
            found = dict(zip(reals, slave.getReal(reals), strict=True))
            found |= {reference: float(getter([reference])[0]) for getter, reference in others}
            return [found[references[name]] for name in OUTPUTS]

        for name, value in program["parameters"].items():
            slave.setReal([references[name]], [value])
        change(-1)
        slave.exitInitializationMode()
        rows.append(row())
        for step in range(program["steps"]):
            change(step)
            slave.doStep(step * program["step_size"], program["step_size"])
            rows.append(row())
    return np.array(rows)


def bits(rows: np.ndarray) -> bytes:
    return rows.astype("<f8").tobytes()


def as_json() -> str:
    return json.dumps(PROGRAMS)
